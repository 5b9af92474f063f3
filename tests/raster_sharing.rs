//! The same bits however a draw is split up, and for any number of threads.

mod oracle;
mod worlds;

use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::final_pass::draw_objects;
use antumbra::glam::{DAffine3, DVec3};
use antumbra::occlusion::{Occluder, OcclusionBuffer};
use antumbra::raster::{
    CullMode, Geometry, GeometryError, ObjectAssembler, Positions, TileBuffer, for_each_sample,
    for_each_tile,
};
use antumbra::scene::{Aabb, Scene};
use antumbra::view::{Camera, PictureSize, Projection};
use antumbra_simd::triangle::Triangle;
use oracle::{Chance, vertex};
use worlds::{DOUBLE_SIDED, SHAPES, Shape};

fn soup(chance: &mut Chance, count: usize, size: PictureSize) -> Vec<Triangle> {
    let (w, h) = (size.width() as i32, size.height() as i32);
    let mut triangles = Vec::new();
    while triangles.len() < count {
        let middle = (chance.whole(0, 256 * w), chance.whole(0, 256 * h));
        let reach = [500, 3_000, 60_000][chance.whole(0, 2) as usize];
        let mut corner = || {
            let at = (
                middle.0 + chance.whole(-reach, reach),
                middle.1 + chance.whole(-reach, reach),
            );
            vertex(at, chance.real(0.0, 1.0))
        };
        let corners = [corner(), corner(), corner()];
        triangles.extend(Triangle::new(corners, CullMode::None).and_then(|t| t.within(w, h)));
    }
    triangles
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
}

#[test]
fn same_bits_for_any_thread_count_and_any_split() {
    let mut chance = Chance::seeded(91);
    for (w, h) in [(257, 193), (64, 64), (9, 700), (700, 9), (1_283, 771)] {
        let size = PictureSize::new(w, h).unwrap();
        let triangles = soup(&mut chance, 3_000, size);
        let mut one_by_one = TileBuffer::new(size);
        for t in &triangles {
            one_by_one.fill(std::slice::from_ref(t));
        }
        for threads in [1, 2, 3, 5] {
            pool(threads).install(|| {
                let mut whole = TileBuffer::new(size);
                whole.fill(&triangles);
                assert!(whole == one_by_one, "{w}x{h}, {threads} threads");
                assert_eq!(whole.hash(), one_by_one.hash());
                let mut split = TileBuffer::new(size);
                let mut rest = &triangles[..];
                while !rest.is_empty() {
                    let count = chance.whole(1, 900).min(rest.len() as i32) as usize;
                    split.fill(&rest[..count]);
                    rest = &rest[count..];
                }
                assert!(split == one_by_one, "{w}x{h}, {threads} threads, split");
            });
        }
    }
}

/// Rows of tiles are what threads share out: the tiles of a triangle in some rows are those of all rows, cut to them.
#[test]
fn rows_of_tiles_are_filled_alike_whoever_fills_them() {
    let mut chance = Chance::seeded(92);
    let size = PictureSize::new(200, 120).unwrap();
    for t in soup(&mut chance, 2_000, size) {
        let mut all = Vec::new();
        for_each_tile(&t, 0..15, |x, y, mask| all.push((x, y, mask)));
        let cut = chance.whole(0, 15);
        let mut parts = Vec::new();
        for rows in [0..cut, cut..15] {
            for_each_tile(&t, rows, |x, y, mask| parts.push((x, y, mask)));
        }
        assert_eq!(parts, all);
        let covered: u32 = all.iter().map(|(_, _, mask)| mask.count_ones()).sum();
        let mut samples = 0;
        for_each_sample(&t, 0..120, |_, _, _| samples += 1);
        assert_eq!(samples, covered);
    }
}

fn ball(chance: &mut Chance) -> (Vec<[f32; 3]>, Vec<u32>) {
    let (points, triangles) = worlds::shape(chance, Shape::Ball(4));
    let positions = points
        .iter()
        .map(|p| p.to_array().map(|v| v as f32))
        .collect();
    (positions, triangles.into_flattened())
}

fn camera() -> Camera {
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.1,
        far: None,
    };
    Camera::look_at(DVec3::new(0.0, 0.5, 3.0), DVec3::ZERO, DVec3::Y, projection).unwrap()
}

#[test]
fn same_bits_for_any_stride_and_any_order_of_submission() {
    let mut chance = Chance::seeded(93);
    let size = PictureSize::new(203, 151).unwrap();
    let (positions, indices) = ball(&mut chance);
    let drawn = |draws: &[Geometry<'_>]| {
        let mut buffer = OcclusionBuffer::new(size, camera());
        for &geometry in draws {
            buffer.draw(&Occluder {
                geometry,
                world_from_local: DAffine3::IDENTITY,
                cull_mode: CullMode::Back,
            });
        }
        buffer.finish();
        buffer.tiles().clone()
    };
    let whole = drawn(&[Geometry::new(Positions::packed(&positions), &indices).unwrap()]);
    assert!(whole.coverage().contains(&u64::MAX));
    for stride in [3, 4, 8, 11] {
        // Other attributes between the positions; the last position may lack what follows it.
        let mut floats: Vec<f32> = Vec::new();
        for p in &positions {
            floats.extend(p);
            floats.extend(vec![f32::NAN; stride - 3]);
        }
        floats.truncate(floats.len() - (stride - 3));
        let strided = Positions::strided(&floats, stride).unwrap();
        assert_eq!(strided.len(), positions.len());
        assert!(
            drawn(&[Geometry::new(strided, &indices).unwrap()]) == whole,
            "stride {stride}"
        );
    }
    for triangles in [1, 7, 300, 1_000] {
        let parts: Vec<Geometry<'_>> = indices
            .chunks(3 * triangles)
            .map(|part| Geometry::new(Positions::packed(&positions), part).unwrap())
            .collect();
        assert!(drawn(&parts) == whole, "{triangles} triangles a draw");
    }
}

#[test]
fn geometry_that_is_not_triangles_is_an_error() {
    let positions = [[0.0; 3]; 4];
    let packed = Positions::packed(&positions);
    let error = |indices: &[u32]| Geometry::new(packed, indices).unwrap_err();
    assert_eq!(error(&[0, 1]), GeometryError::PartialTriangle { count: 2 });
    assert_eq!(
        error(&[0, 1, 4]),
        GeometryError::IndexOutOfRange {
            index: 4,
            positions: 4
        }
    );
    assert_eq!(
        Positions::strided(&[0.0; 9], 2).unwrap_err(),
        GeometryError::Stride { stride: 2 }
    );
    for (floats, stride, len) in [
        (0, 3, 0),
        (2, 5, 0),
        (3, 5, 1),
        (7, 5, 1),
        (8, 5, 2),
        (10, 5, 2),
    ] {
        let floats = vec![0.0; floats];
        let positions = Positions::strided(&floats, stride).unwrap();
        assert_eq!((positions.len(), positions.is_empty()), (len, len == 0));
        let last = [len as u32; 3];
        assert!(Geometry::new(positions, &last).is_err());
    }
}

#[test]
fn clear_forgets_everything() {
    let mut chance = Chance::seeded(94);
    let size = PictureSize::new(77, 55).unwrap();
    let (positions, indices) = ball(&mut chance);
    let occluder = Occluder {
        geometry: Geometry::new(Positions::packed(&positions), &indices).unwrap(),
        world_from_local: DAffine3::IDENTITY,
        cull_mode: CullMode::Back,
    };
    let mut buffer = OcclusionBuffer::new(size, camera());
    let behind = Aabb {
        min: DVec3::new(-0.1, -0.1, -4.0),
        max: DVec3::new(0.1, 0.1, -3.0),
    };
    for _ in 0..3 {
        assert!(!buffer.test_aabb(&behind).is_hidden());
        buffer.draw(&occluder);
        assert!(buffer.test_aabb(&behind).is_hidden());
        buffer.finish();
        assert!(buffer.test_aabb(&behind).is_hidden());
        buffer.clear(&camera());
        assert_eq!(*buffer.tiles(), TileBuffer::new(size));
        assert!(!buffer.test_aabb(&behind).is_hidden());
        buffer.finish();
        assert!(!buffer.test_aabb(&behind).is_hidden());
        buffer.clear(&camera());
    }
}

#[test]
fn any_number_of_threads_may_ask_at_once() {
    let mut chance = Chance::seeded(95);
    let size = PictureSize::new(160, 120).unwrap();
    let (positions, indices) = ball(&mut chance);
    let mut buffer = OcclusionBuffer::new(size, camera());
    buffer.draw(&Occluder {
        geometry: Geometry::new(Positions::packed(&positions), &indices).unwrap(),
        world_from_local: DAffine3::IDENTITY,
        cull_mode: CullMode::Back,
    });
    buffer.finish();
    let boxes: Vec<Aabb> = (0..2_000)
        .map(|_| {
            let p = worlds::direction(&mut chance) * chance.real(0.0, 3.0);
            Aabb {
                min: p - DVec3::splat(0.1),
                max: p + DVec3::splat(0.1),
            }
        })
        .collect();
    let ask = || {
        boxes
            .iter()
            .map(|b| buffer.test_aabb(b))
            .collect::<Vec<_>>()
    };
    let alone = ask();
    assert!(alone.iter().any(|a| a.is_hidden()) && alone.iter().any(|a| !a.is_hidden()));
    std::thread::scope(|scope| {
        let asked: Vec<_> = (0..4).map(|_| scope.spawn(ask)).collect();
        asked
            .into_iter()
            .for_each(|a| assert_eq!(a.join().unwrap(), alone));
    });
}

/// The picture's own pass, on any number of threads, writes what a plain loop over objects and triangles writes.
#[test]
fn the_final_pass_draws_what_a_plain_loop_draws() {
    let mut chance = Chance::seeded(96);
    for _ in 0..12 {
        let size =
            PictureSize::new(chance.whole(1, 200) as u32, chance.whole(1, 200) as u32).unwrap();
        let home = worlds::home(&mut chance);
        let (mut meshes, mut objects) = (Vec::new(), Vec::new());
        for i in 0..50 {
            let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
            let place = home + worlds::direction(&mut chance) * 6.0;
            let (mesh, place) = worlds::placed(&mut chance, kind, DOUBLE_SIDED, place, 2.0);
            meshes.push(mesh);
            objects.push(worlds::object(i, place));
        }
        let scene = Arc::new(Scene::new(meshes, objects).unwrap());
        let camera = worlds::camera(&mut chance, home, 12.0);
        let order: Vec<u32> = (0..50).collect();
        let mut plain = vec![(u32::MAX, 0.0_f32, 0_u32); size.width() * size.height()];
        let mut assembler = ObjectAssembler::new(camera, size);
        let write = |pixel: &mut (u32, f32, u32), object: u32, depth: f32| {
            pixel.2 += 1;
            if pixel.0 == u32::MAX || depth > pixel.1 {
                (pixel.0, pixel.1) = (object, depth);
            }
        };
        for &object in &order {
            let placed = &scene.objects()[object as usize];
            let mesh = &scene.meshes()[placed.mesh];
            assembler.assemble(
                mesh,
                &placed.world_from_local,
                |_| true,
                |t| {
                    for_each_sample(&t.triangle, 0..size.height() as i32, |x, y, depth| {
                        write(
                            &mut plain[y as usize * size.width() + x as usize],
                            object,
                            depth,
                        );
                    });
                },
            );
        }
        for threads in [1, 2, 5] {
            let mut shared = vec![(u32::MAX, 0.0_f32, 0_u32); plain.len()];
            pool(threads).install(|| {
                draw_objects(
                    &scene,
                    &camera,
                    size,
                    &order,
                    |_| true,
                    &mut shared,
                    |pixel, f| {
                        write(pixel, f.object, f.depth);
                    },
                );
            });
            assert!(shared == plain, "{threads} threads");
        }
        // And a culler of the same scene has the same surfaces in its buffer: no part is nearer than its pixels.
        let mut culler = Culler::new(
            scene.clone(),
            Settings {
                threads: 2,
                ..Settings::new(size)
            },
        )
        .unwrap();
        culler.cull(&camera);
        let buffer = culler.buffer().unwrap();
        for (i, pixel) in plain.iter().enumerate() {
            if let Some(depth) = buffer.pixel(i % size.width(), i / size.width()) {
                assert!(pixel.0 != u32::MAX && depth <= pixel.1);
            }
        }
    }
}
