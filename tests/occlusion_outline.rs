//! A box is hidden if and only if its outline is covered and its faces are behind what covers it.

mod boxes;
mod oracle;
mod worlds;

use antumbra::glam::{DAffine3, DVec3};
use antumbra::occlusion::{Footprint, Occluder, OcclusionBuffer, OrientedBox, ProjectedBox};
use antumbra::raster::{
    CullMode, Geometry, ObjectAssembler, Positions, TileBuffer, for_each_sample,
};
use antumbra::scene::Mesh;
use antumbra::view::{Camera, PictureSize, Projection};
use antumbra_simd::coverage::PART_MASKS;
use boxes::{any_box, mesh_in_cube};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES};

fn draw(buffer: &mut OcclusionBuffer, mesh: &Mesh, place: &DAffine3) {
    let indices = mesh.triangles.as_flattened();
    buffer.draw(&Occluder {
        geometry: Geometry::new(Positions::packed(&mesh.positions), indices).unwrap(),
        world_from_local: *place,
        cull_mode: CullMode::None,
    });
}

/// The question of a box by its definition: every sample of the outline is covered, and in each layer of each tile part the bound over the rectangle of its samples is strictly farther than the layer.
fn is_hidden(tiles: &TileBuffer, projected: &ProjectedBox) -> bool {
    let rect = match projected.footprint() {
        Footprint::Unbounded => return false,
        Footprint::Nowhere => return true,
        Footprint::Within(rect) => rect,
    };
    let (outline, faces) = (projected.outline(&rect), projected.faces(&rect));
    let size = tiles.size();
    // Of every part its far and its near layer: columns and rows.
    let none = ([i32::MAX, i32::MIN], [i32::MAX, i32::MIN]);
    let mut of_layers = vec![[[none; 2]; 2]; tiles.coverage().len()];
    let mut is_covered = true;
    for y in rect.y[0]..=rect.y[1] {
        let [first, last] = outline.columns(y);
        for x in first..=last {
            let tile = y as usize / 8 * size.tiles_across() + x as usize / 8;
            let bit = 1_u64 << (y % 8 * 8 + x % 8);
            is_covered &= tiles.coverage()[tile] & bit != 0;
            let part = usize::from(PART_MASKS[1] & bit != 0);
            let layer = usize::from(tiles.near_samples()[tile] & bit != 0);
            let (columns, rows) = &mut of_layers[tile][part][layer];
            *columns = [columns[0].min(x), columns[1].max(x)];
            *rows = [rows[0].min(y), rows[1].max(y)];
        }
    }
    let mut of_layers = of_layers.iter().enumerate();
    let is_behind = of_layers.all(|(tile, parts)| {
        (0..2).all(|part| {
            let depths = [tiles.depths()[tile][part], tiles.near_depths()[tile][part]];
            parts[part]
                .iter()
                .zip(depths)
                .all(|(&(x, y), depth)| x[0] > x[1] || faces.nearest_over(x, y) < depth)
        })
    });
    is_covered && is_behind
}

#[test]
fn a_box_is_hidden_where_each_sample_of_it_is_and_only_there() {
    let mut chance = Chance::seeded(53);
    let (mut hidden, mut visible, mut gained) = (0, 0, 0);
    for round in 0..400 {
        let size =
            PictureSize::new(chance.whole(1, 150) as u32, chance.whole(1, 110) as u32).unwrap();
        let home = worlds::home(&mut chance);
        let camera = worlds::camera(&mut chance, home, 14.0);
        let mut buffer = OcclusionBuffer::new(size, camera);
        for _ in 0..chance.whole(1, 12) {
            let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
            let place = home + worlds::direction(&mut chance) * chance.real(0.0, 8.0);
            let radius = chance.real(1.0, 9.0);
            let (mesh, place) = worlds::placed(&mut chance, kind, DOUBLE_SIDED, place, radius);
            draw(&mut buffer, &mesh, &place);
        }
        let finished = chance.one_in(2);
        if finished {
            buffer.finish();
        }
        for _ in 0..60 {
            let center = home + worlds::direction(&mut chance) * chance.real(0.0, 12.0);
            let radius = chance.real(0.05, 3.0);
            let placed = any_box(&mut chance, center, radius);
            let projected = placed.on(buffer.screen());
            let expected = is_hidden(buffer.tiles(), &projected);
            let answer = buffer.test_box(&projected).is_hidden();
            let by_rectangle = buffer.test(projected.footprint()).is_hidden();
            // The rectangle takes parts whole: it never hides what the outline does not.
            assert!(expected || !by_rectangle, "round {round}");
            assert_eq!(answer, expected, "round {round}, finished: {finished}");
            let same = if placed.aligned {
                buffer.test_aabb(&placed.aabb())
            } else {
                buffer.test_oriented_box(&placed.shape)
            };
            assert_eq!(same.is_hidden(), answer);
            if answer {
                hidden += 1;
                gained += i32::from(!by_rectangle);
                // Nothing drawn inside it is before what the buffer shows.
                ObjectAssembler::new(camera, size).assemble(
                    &mesh_in_cube(&mut chance),
                    &placed.world_from_cube,
                    |_| true,
                    |drawn| {
                        for_each_sample(&drawn.triangle, 0..size.height() as i32, |x, y, depth| {
                            let tile = y as usize / 8 * size.tiles_across() + x as usize / 8;
                            let bit = y % 8 * 8 + x % 8;
                            let tiles = buffer.tiles();
                            let shown = if tiles.near_samples()[tile] >> bit & 1 == 1 {
                                Some(tiles.near_depths()[tile][bit as usize / 32])
                            } else {
                                buffer.pixel(x as usize, y as usize)
                            };
                            assert!(shown.is_some_and(|shown| depth < shown), "round {round}");
                        });
                    },
                );
            } else {
                visible += 1;
            }
        }
    }
    assert!(
        hidden > 5_000 && visible > 2_000 && gained > 500,
        "{hidden} hidden, {gained} of them by outline and faces, {visible} visible"
    );
}

/// A buffer that is covered all over by a wall far in front of everything asked.
fn behind_a_wall(projection: Projection) -> OcclusionBuffer {
    let size = PictureSize::new(64, 48).unwrap();
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).unwrap();
    let mut buffer = OcclusionBuffer::new(size, camera);
    let far = 1e3;
    let wall = [
        [-far, -far, -1.0],
        [far, -far, -1.0],
        [far, far, -1.0],
        [-far, far, -1.0],
    ];
    let wall = worlds::mesh(wall.to_vec(), vec![[0, 1, 2], [0, 2, 3]], DOUBLE_SIDED);
    draw(&mut buffer, &wall, &DAffine3::IDENTITY);
    buffer.finish();
    buffer
}

fn projections() -> [Projection; 2] {
    [
        Projection::Perspective {
            fov_y: 1.2,
            near: 0.1,
            far: None,
        },
        Projection::Orthographic {
            height: 20.0,
            near: 0.1,
            far: None,
        },
    ]
}

#[test]
fn a_box_that_is_not_finite_is_visible_and_one_without_volume_is_a_box() {
    for buffer in projections().map(behind_a_wall) {
        let whole = OrientedBox {
            center: DVec3::new(0.3, -0.2, -5.0),
            half_axes: [
                DVec3::X,
                DVec3::new(0.0, 0.6, 0.2),
                DVec3::new(0.1, -0.1, 0.4),
            ],
        };
        assert!(buffer.test_oriented_box(&whole).is_hidden());
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
            for at in 0..3 {
                let mut spoilt = whole;
                spoilt.center[at] = bad;
                assert!(!buffer.test_oriented_box(&spoilt).is_hidden(), "{spoilt:?}");
                for axis in 0..3 {
                    let mut spoilt = whole;
                    spoilt.half_axes[axis][at] = bad;
                    assert!(!buffer.test_oriented_box(&spoilt).is_hidden(), "{spoilt:?}");
                }
            }
        }
        for without in 0..8 {
            let mut flat = whole;
            for axis in 0..3 {
                if without >> axis & 1 == 1 {
                    flat.half_axes[axis] = DVec3::ZERO;
                }
            }
            assert!(buffer.test_oriented_box(&flat).is_hidden(), "{flat:?}");
        }
        let before = OrientedBox {
            center: DVec3::new(0.3, -0.2, -0.9),
            ..whole
        };
        assert!(!buffer.test_oriented_box(&before).is_hidden());
    }
}
