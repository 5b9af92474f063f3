//! From positions to tiles: walls, slots and clipped fans, at any size of picture.

mod oracle;

use antumbra::glam::{DAffine3, DVec3};
use antumbra::occlusion::{Occluder, OcclusionBuffer};
use antumbra::raster::{Assembler, CullMode, Geometry, Positions, TileBuffer, for_each_sample};
use antumbra::scene::Aabb;
use antumbra::view::{Camera, PictureSize, Projection};
use antumbra_simd::triangle::Triangle;
use antumbra_simd::vertex::{ClipVertex, ScreenTransform, transform};
use oracle::Chance;

fn size(width: u32, height: u32) -> PictureSize {
    PictureSize::new(width, height).unwrap()
}

/// One unit is one pixel, x to the right and y down from the picture's upper left corner; z is the depth.
const PIXELS: ScreenTransform = ScreenTransform {
    x: [256.0, 0.0, 0.0, 0.0],
    y: [0.0, 256.0, 0.0, 0.0],
    depth: [0.0, 0.0, 1.0, 0.0],
    w: [0.0, 0.0, 0.0, 1.0],
    near_depth: 1.0,
    far_depth: f64::NEG_INFINITY,
};

fn assembled(
    positions: &[[f32; 3]],
    indices: &[u32],
    screen: &ScreenTransform,
    size: PictureSize,
) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    let geometry = Geometry::new(Positions::packed(positions), indices).unwrap();
    Assembler::default().assemble(geometry, screen, size, CullMode::None, |t, _| {
        triangles.push(t);
    });
    triangles
}

fn filled(triangles: &[Triangle], size: PictureSize) -> TileBuffer {
    let mut tiles = TileBuffer::new(size);
    tiles.fill(triangles);
    tiles
}

fn hits(triangles: &[Triangle], size: PictureSize) -> Vec<u32> {
    let mut hits = vec![0; size.width() * size.height()];
    for t in triangles {
        for_each_sample(t, 0..size.height() as i32, |x, y, _| {
            hits[y as usize * size.width() + x as usize] += 1;
        });
    }
    hits
}

fn is_covered(tiles: &TileBuffer, x: usize, y: usize) -> bool {
    let tile = y / 8 * tiles.size().tiles_across() + x / 8;
    tiles.coverage()[tile] >> (y % 8 * 8 + x % 8) & 1 == 1
}

/// A grid of `columns` × `rows` cells over a rectangle given in sub-pixels, each cell two triangles with a diagonal
/// either way. Lines stand on the sub-pixel grid.
fn wall(
    chance: &mut Chance,
    x: [i32; 2],
    y: [i32; 2],
    depth: f32,
    columns: usize,
    rows: usize,
) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut lines = |[first, last]: [i32; 2], count: usize| {
        let mut lines: Vec<i32> = (1..count).map(|_| chance.whole(first, last)).collect();
        lines.extend([first, last]);
        lines.sort_unstable();
        lines
    };
    let (xs, ys) = (lines(x, columns), lines(y, rows));
    let positions = ys
        .iter()
        .flat_map(|&y| {
            xs.iter()
                .map(move |&x| [x as f32 / 256.0, y as f32 / 256.0, depth])
        })
        .collect();
    let mut indices = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let a = (row * (columns + 1) + column) as u32;
            let (b, c, d) = (a + 1, a + columns as u32 + 1, a + columns as u32 + 2);
            if chance.one_in(2) {
                indices.extend([a, b, d, a, d, c]);
            } else {
                indices.extend([a, b, c, b, d, c]);
            }
        }
    }
    (positions, indices)
}

/// With all vertices on the grid nothing is rounded: the cells tile the very same rectangle. At one depth they must
/// also write the same depth, so the whole buffer is the same.
#[test]
fn a_tessellated_wall_equals_one_quad() {
    let mut chance = Chance::seeded(11);
    for (w, h) in [
        (1, 1),
        (7, 9),
        (8, 8),
        (13, 1),
        (64, 48),
        (1_283, 771),
        (333, 17),
    ] {
        for round in 0..8 {
            let picture = size(w, h);
            let mut span = |pixels: u32| {
                let edge = 256 * pixels as i32;
                if round == 0 {
                    return [0, edge];
                }
                let ends = [chance.whole(-999, edge), chance.whole(0, edge + 999)];
                [ends[0].min(ends[1]), ends[0].max(ends[1])]
            };
            let (x, y) = (span(w), span(h));
            let (positions, indices) = wall(&mut chance, x, y, 0.25, 1, 1);
            let quad = filled(&assembled(&positions, &indices, &PIXELS, picture), picture);
            let (positions, indices) = wall(&mut chance, x, y, 0.25, 23, 14);
            let cells = assembled(&positions, &indices, &PIXELS, picture);
            assert!(hits(&cells, picture).iter().all(|&n| n <= 1));
            assert_eq!(filled(&cells, picture), quad, "{w}x{h}, x {x:?}, y {y:?}");
            if round == 0 {
                assert_eq!(hits(&cells, picture), vec![1; (w * h) as usize]);
            }
        }
    }
}

#[test]
fn no_sample_outside_the_picture_is_ever_covered_and_the_border_is() {
    let mut chance = Chance::seeded(12);
    for (w, h) in [
        (1, 1),
        (7, 9),
        (8, 8),
        (9, 7),
        (13, 1),
        (1, 13),
        (16, 24),
        (1_283, 771),
        (16_384, 1),
        (1, 16_384),
        (16_383, 3),
    ] {
        let picture = size(w, h);
        // A triangle far larger than the picture, and one with a border of the picture inside it.
        let (w32, h32) = (w as f32, h as f32);
        let large = [
            [-9.0, -9.0, 0.5],
            [2.0 * w32 + 99.0, -9.0, 0.5],
            [-9.0, 2.0 * h32 + 99.0, 0.5],
        ];
        let tiles = filled(&assembled(&large, &[0, 1, 2], &PIXELS, picture), picture);
        for tile_y in 0..picture.tiles_down() {
            for tile_x in 0..picture.tiles_across() {
                let tile = tile_y * picture.tiles_across() + tile_x;
                let mut inside = 0_u64;
                for bit in 0..64 {
                    let (x, y) = (8 * tile_x + bit % 8, 8 * tile_y + bit / 8);
                    inside |= u64::from(x < picture.width() && y < picture.height()) << bit;
                }
                assert_eq!(tiles.picture_mask(tile_x, tile_y), inside);
                assert_eq!(
                    tiles.coverage()[tile],
                    inside,
                    "{w}x{h}, tile {tile_x}, {tile_y}"
                );
            }
        }
        for _ in 0..50 {
            let mut at = || {
                let x = chance.real(-20.0, f64::from(w) + 20.0) as f32;
                [x, chance.real(-20.0, f64::from(h) + 20.0) as f32, 0.5]
            };
            let triangles = assembled(&[at(), at(), at()], &[0, 1, 2], &PIXELS, picture);
            let tiles = filled(&triangles, picture);
            let hits = hits(&triangles, picture);
            let covered: u32 = tiles.coverage().iter().map(|c| c.count_ones()).sum();
            assert_eq!(covered, hits.iter().sum::<u32>());
            for (i, &n) in hits.iter().enumerate() {
                let (x, y) = (i % picture.width(), i / picture.width());
                assert_eq!(is_covered(&tiles, x, y), n == 1);
            }
        }
    }
}

/// An orthographic camera for which one unit is one pixel, y up, the picture's middle at the origin.
fn pixel_camera(picture: PictureSize) -> Camera {
    let projection = Projection::Orthographic {
        height: picture.height() as f64,
        near: 1.0,
        far: None,
    };
    Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).unwrap()
}

fn rectangle(x: [f32; 2], y: [f32; 2], z: f32) -> [[f32; 3]; 4] {
    [
        [x[0], y[0], z],
        [x[1], y[0], z],
        [x[1], y[1], z],
        [x[0], y[1], z],
    ]
}

const RECTANGLE: [u32; 6] = [0, 1, 2, 0, 2, 3];

fn draw(buffer: &mut OcclusionBuffer, positions: &[[f32; 3]], indices: &[u32]) {
    buffer.draw(&Occluder {
        geometry: Geometry::new(Positions::packed(positions), indices).unwrap(),
        world_from_local: DAffine3::IDENTITY,
        cull_mode: CullMode::Back,
    });
}

/// A slot one pixel wide holds exactly one column of centres, wherever between two pixels it stands.
#[test]
fn a_one_pixel_slot_stays_visible_at_all_sub_pixel_phases() {
    let picture = size(45, 37);
    let camera = pixel_camera(picture);
    let far = 99.0;
    for upright in [true, false] {
        for phase in 0..256 {
            for pixel in [-22.5_f32, -4.0, 0.0, 3.0, 11.5] {
                if !upright && pixel < -18.5 {
                    continue;
                }
                for slot in [1.0_f32, 0.0] {
                    let from = pixel + phase as f32 / 256.0;
                    let side = |s: [f32; 2], z: f32| {
                        let all = [-far, far];
                        if upright {
                            rectangle(s, all, z)
                        } else {
                            rectangle(all, s, z)
                        }
                    };
                    let mut buffer = OcclusionBuffer::new(picture, camera);
                    draw(&mut buffer, &side([-far, from], -5.0), &RECTANGLE);
                    draw(&mut buffer, &side([from + slot, far], -5.0), &RECTANGLE);
                    let middle = from + 0.5;
                    let [min, max] = if upright {
                        [
                            DVec3::new(f64::from(middle) - 0.75, -3.0, -9.0),
                            DVec3::new(f64::from(middle) + 0.75, 3.0, -7.0),
                        ]
                    } else {
                        [
                            DVec3::new(-3.0, f64::from(middle) - 0.75, -9.0),
                            DVec3::new(3.0, f64::from(middle) + 0.75, -7.0),
                        ]
                    };
                    let behind = Aabb { min, max };
                    for finished in [false, true] {
                        if finished {
                            buffer.finish();
                        }
                        assert_eq!(
                            buffer.test_aabb(&behind).is_hidden(),
                            slot == 0.0,
                            "pixel {pixel}, phase {phase}, slot {slot}, upright {upright}, finished {finished}"
                        );
                    }
                }
            }
        }
    }
}

/// A closed fan in a plane that passes below the eye: near plane and guard band cut it in every way. Rotating it moves
/// the cuts. Each sample below the horizon is hit once, wherever the cuts fall, and none is hit twice.
#[test]
fn a_fan_clipped_by_near_plane_and_guard_band_stays_watertight() {
    let mut chance = Chance::seeded(13);
    let picture = size(61, 47);
    let (mut clipped, mut sure) = (0, 0);
    for round in 0..400 {
        let near = [0.001, 0.1, 2.0, 30.0][round % 4];
        let far = [None, Some(1e5), Some(near * 1.5)][round % 3];
        let projection = Projection::Perspective {
            fov_y: chance.real(0.2, 2.5),
            near,
            far,
        };
        let height = chance.real(0.01, 3.0);
        let aim = DVec3::new(
            chance.real(-1.0, 1.0),
            chance.real(-1.0, 0.2),
            chance.real(-1.0, 1.0),
        );
        let eye = DVec3::new(chance.real(-5.0, 5.0), height, chance.real(-5.0, 5.0));
        let Ok(camera) = Camera::look_at(eye, eye + aim, DVec3::Y, projection) else {
            continue;
        };
        // The rim is far away, or so far that clipping by the guard band is certain.
        let reach = [30.0, 3e3, 1e6, 1e8][(round / 4) % 4];
        let blades = 24;
        let mut positions = vec![[eye.x as f32, 0.0, eye.z as f32]];
        if round % 5 == 0 {
            positions[0] = [
                chance.real(-9.0, 9.0) as f32,
                0.0,
                chance.real(-9.0, 9.0) as f32,
            ];
        }
        for i in 0..blades {
            let angle =
                std::f64::consts::TAU * (f64::from(i) + chance.real(0.1, 0.9)) / f64::from(blades);
            let far = reach * chance.real(0.9, 1.1);
            positions.push([(far * angle.cos()) as f32, 0.0, (far * angle.sin()) as f32]);
        }
        let indices: Vec<u32> = (0..blades)
            .flat_map(|i| [0, 1 + (i + 1) % blades, 1 + i])
            .collect();
        let screen = camera.screen_from_local(picture, &DAffine3::IDENTITY);
        let triangles = assembled(&positions, &indices, &screen, picture);
        clipped += usize::from(triangles.len() != blades as usize);
        for (i, n) in hits(&triangles, picture).into_iter().enumerate() {
            let (x, y) = ((i % picture.width()) as f64, (i / picture.width()) as f64);
            assert!(n <= 1, "round {round}: sample ({x}, {y}) is hit {n} times");
            // Where a ray through the centre, and rays a pixel around it, meet the plane well inside the fan.
            let surely = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
                .iter()
                .all(|(dx, dy)| {
                    let Projection::Perspective { fov_y, .. } = projection else {
                        unreachable!()
                    };
                    let t = (fov_y * 0.5).tan();
                    let right = (2.0 * (x + 0.5 + dx) / picture.width() as f64 - 1.0)
                        * t
                        * picture.aspect();
                    let up = (1.0 - 2.0 * (y + 0.5 + dy) / picture.height() as f64) * t;
                    let ray = camera.forward() + camera.right() * right + camera.up() * up;
                    let distance = -eye.y / ray.y;
                    let at = eye + ray * distance;
                    ray.y < 0.0
                        && distance > near * 1.001
                        && far.is_none_or(|far| distance < far * 0.999)
                        && at.x.hypot(at.z) < reach * 0.85
                });
            assert!(
                !surely || n == 1,
                "round {round}: sample ({x}, {y}) is missed"
            );
            sure += usize::from(surely);
        }
    }
    assert!(
        clipped > 200 && sure > 100_000,
        "{clipped} were clipped, {sure} samples sure"
    );
}

/// Neighbours with and without a cut, through a real camera: triangles of a random height field close to the eye.
#[test]
fn clipped_neighbours_never_share_a_sample_or_leave_one_out() {
    let mut chance = Chance::seeded(14);
    let picture = size(57, 39);
    for round in 0..300 {
        // A sheet that faces the camera, folded in depth but not on screen: positions are made from screen positions
        // and distances, so no two triangles overlap in front of the near plane.
        let near = 1.0;
        let far = (round % 2 == 1).then_some(40.0);
        let projection = Projection::Perspective {
            fov_y: 1.0,
            near,
            far,
        };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).unwrap();
        let screen = camera.screen_from_local(picture, &DAffine3::IDENTITY);
        let (columns, rows) = (9_u32, 7_u32);
        let reach = [1.5, 40.0, 2_000.0][round % 3];
        let mut positions = Vec::new();
        for row in 0..=rows {
            for column in 0..=columns {
                let mut at = |i: u32, n: u32| {
                    (f64::from(i) + 0.2 * chance.real(-1.0, 1.0)) / f64::from(n) * 2.0 - 1.0
                };
                let (x, y) = (at(column, columns) * reach, at(row, rows) * reach);
                // No vertex is behind the near plane but some are before the far plane's other side; those behind
                // the near plane are tried by the fans.
                let distance = if chance.one_in(3) {
                    chance.real(1.0, 60.0)
                } else {
                    chance.real(1.0, 3.0)
                };
                positions.push([
                    (x * distance) as f32,
                    (y * distance) as f32,
                    -distance as f32,
                ]);
            }
        }
        let mut indices = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let a = row * (columns + 1) + column;
                let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
                indices.extend([a, b, d, a, d, c]);
            }
        }
        let triangles = assembled(&positions, &indices, &screen, picture);
        let hits = hits(&triangles, picture);
        assert!(hits.iter().all(|&n| n <= 1), "round {round}");
        if far.is_none() {
            assert!(hits.iter().all(|&n| n == 1), "round {round}");
        }
    }
}

/// What a ray through a point of the picture, in sub-pixels, meets of a triangle in homogeneous coordinates: the depth,
/// if it lies between the planes. Cramer's rule: no clipping, no projection, no winding.
fn seen_by_ray(t: &ScreenTransform, corners: &[ClipVertex; 3], px: f64, py: f64) -> Option<f64> {
    let a = corners.map(|v| v.x - px * v.w);
    let b = corners.map(|v| v.y - py * v.w);
    let weights = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    let sum = |of: [f64; 3]| weights[0] * of[0] + weights[1] * of[1] + weights[2] * of[2];
    let w = sum(corners.map(|v| v.w));
    let inside = weights.iter().all(|&weight| weight * w > 0.0);
    let depth = sum(corners.map(|v| v.depth)) / w;
    (inside && depth <= t.near_depth && depth >= t.far_depth).then_some(depth)
}

/// Triangles through the near plane, the far plane, the guard band and several of them at once. A sample is covered
/// where all rays within a sub-pixel and a half meet the triangle, not where none does, and at a depth that one of them
/// sees: a vertex snaps by ¾ of a sub-pixel at most, and a sample's depth errs as its vertices do, no more.
#[test]
fn a_clipped_triangle_is_drawn_where_rays_meet_it() {
    let mut chance = Chance::seeded(15);
    let picture = size(37, 31);
    let (mut sure, mut sure_not, mut cut) = (0, 0, 0);
    for round in 0..500 {
        let far = (round % 3 == 0).then(|| chance.real(1.0, 30.0));
        let projection = if round % 5 == 0 {
            Projection::Orthographic {
                height: chance.real(0.01, 9.0),
                near: 0.5,
                far: far.map(|f| f + 0.5),
            }
        } else {
            Projection::Perspective {
                fov_y: chance.real(0.01, 2.8),
                near: 0.5,
                far: far.map(|f| f + 0.5),
            }
        };
        let eye = DVec3::new(
            chance.real(-9.0, 9.0),
            chance.real(-9.0, 9.0),
            chance.real(-9.0, 9.0),
        );
        let target = DVec3::new(chance.real(-9.0, 9.0), chance.real(-9.0, 9.0), 20.0);
        let camera = Camera::look_at(eye, target, DVec3::Y, projection).unwrap();
        let screen = camera.screen_from_local(picture, &DAffine3::IDENTITY);
        let mut position = || {
            let reach = [2.0, 30.0, 1e3, 1e5][chance.whole(0, 3) as usize];
            let p = eye
                + DVec3::new(
                    chance.real(-reach, reach),
                    chance.real(-reach, reach),
                    chance.real(-reach, reach),
                );
            p.to_array().map(|v| v as f32)
        };
        let positions = [position(), position(), position()];
        let corners = positions.map(|p| transform(&screen, p));
        cut += usize::from(corners.iter().any(|v| !v.is_inside(&screen)));
        let triangles = assembled(&positions, &[0, 1, 2], &screen, picture);
        let mut drawn: Vec<Vec<f32>> = vec![Vec::new(); 37 * 31];
        for t in &triangles {
            for_each_sample(t, 0..31, |x, y, depth| {
                drawn[(y * 37 + x) as usize].push(depth);
            });
        }
        for (i, drawn) in drawn.iter().enumerate() {
            let centre = [
                256.0 * (i % 37) as f64 + 128.0,
                256.0 * (i / 37) as f64 + 128.0,
            ];
            let around = |radius: f64, k: usize| {
                let angle = std::f64::consts::TAU * k as f64 / 16.0;
                let (x, y) = (
                    centre[0] + radius * angle.cos(),
                    centre[1] + radius * angle.sin(),
                );
                seen_by_ray(&screen, &corners, x, y)
            };
            let rays: Vec<Option<f64>> = [0.0, 0.4, 0.8, 1.2, 1.6]
                .iter()
                .flat_map(|&r| (0..16).map(move |k| around(r, k)))
                .collect();
            assert!(
                drawn.len() <= 1,
                "round {round}: drawn {} times at {centre:?}",
                drawn.len()
            );
            if rays.iter().all(Option::is_some) {
                sure += 1;
                assert!(drawn.len() == 1, "round {round}: missed at {centre:?}");
                let least = rays.iter().flatten().copied().fold(f64::INFINITY, f64::min);
                let largest = rays
                    .iter()
                    .flatten()
                    .copied()
                    .fold(f64::NEG_INFINITY, f64::max);
                let spare = 1e-7 * least.abs().max(largest.abs());
                let depth = f64::from(drawn[0]);
                assert!(
                    least - spare <= depth && depth <= largest + spare,
                    "round {round}: {depth} not in {least} to {largest}"
                );
            } else if rays.iter().all(Option::is_none) {
                sure_not += 1;
                assert!(drawn.is_empty(), "round {round}: drawn at {centre:?}");
            }
        }
    }
    assert!(
        sure > 10_000 && sure_not > 10_000 && cut > 250,
        "{sure} {sure_not} {cut}"
    );
}
