//! What owns a pixel is never hidden: boxes, oriented boxes, balls and rectangles around drawn objects.

mod oracle;
mod worlds;

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::occlusion::{Occluder, OcclusionBuffer};
use antumbra::raster::{CullMode, Geometry, ObjectAssembler, Positions, for_each_sample};
use antumbra::scene::Scene;
use antumbra::view::{Camera, PictureSize};
use antumbra_simd::triangle::Triangle;
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES, SINGLE_SIDED, Shape};

fn triangles_of(scene: &Scene, object: usize, camera: &Camera, size: PictureSize) -> Vec<Triangle> {
    let placed = &scene.objects()[object];
    let mut triangles = Vec::new();
    ObjectAssembler::new(*camera, size).assemble(
        &scene.meshes()[placed.mesh],
        &placed.world_from_local,
        |_| true,
        |t| triangles.push(t.triangle),
    );
    triangles
}

/// The object that owns each pixel: the nearer keeps it, the first drawn at equal depth.
fn id_picture(
    scene: &Scene,
    order: &[usize],
    camera: &Camera,
    size: PictureSize,
) -> Vec<Option<usize>> {
    let mut pixels: Vec<(Option<usize>, f32)> = vec![(None, 0.0); size.width() * size.height()];
    for &object in order {
        for t in triangles_of(scene, object, camera, size) {
            for_each_sample(&t, 0..size.height() as i32, |x, y, depth| {
                let pixel = &mut pixels[y as usize * size.width() + x as usize];
                if pixel.0.is_none() || depth > pixel.1 {
                    *pixel = (Some(object), depth);
                }
            });
        }
    }
    pixels.into_iter().map(|(owner, _)| owner).collect()
}

fn draw(buffer: &mut OcclusionBuffer, scene: &Scene, object: usize) {
    let placed = &scene.objects()[object];
    let mesh = &scene.meshes()[placed.mesh];
    let indices = mesh.triangles.as_flattened();
    buffer.draw(&Occluder {
        geometry: Geometry::new(Positions::packed(&mesh.positions), indices).unwrap(),
        world_from_local: placed.world_from_local,
        cull_mode: if mesh.surfaces[0].material.double_sided {
            CullMode::None
        } else {
            CullMode::Back
        },
    });
}

/// What each sort of question says of an object; true is hidden.
fn answers(buffer: &OcclusionBuffer, scene: &Scene, object: usize) -> [bool; 3] {
    let placed = &scene.objects()[object];
    let (oriented, ball) = worlds::around(&scene.meshes()[placed.mesh], &placed.world_from_local);
    [
        buffer.test_aabb(&scene.bounds()[object]).is_hidden(),
        buffer.test_oriented_box(&oriented).is_hidden(),
        buffer.test_sphere(&ball).is_hidden(),
    ]
}

#[test]
fn an_object_never_hides_itself() {
    let mut chance = Chance::seeded(31);
    let size = PictureSize::new(83, 61).unwrap();
    let (mut seen, mut bounded) = (0, 0);
    for round in 0..4_000 {
        let home = worlds::home(&mut chance);
        let kind = SHAPES[round % SHAPES.len()];
        let material = if round % 3 == 0 {
            SINGLE_SIDED
        } else {
            DOUBLE_SIDED
        };
        let radius = [0.05, 1.0, 30.0][round / 8 % 3];
        let (mesh, place) = worlds::placed(&mut chance, kind, material, home, radius);
        let scene = Scene::new(vec![mesh], vec![worlds::object(0, place)]).unwrap();
        let distance = radius * chance.real(0.5, 8.0);
        let camera = worlds::camera(&mut chance, home, distance);
        let owners = id_picture(&scene, &[0], &camera, size);
        if owners.iter().all(Option::is_none) {
            continue;
        }
        seen += 1;
        let mut buffer = OcclusionBuffer::new(size, camera);
        draw(&mut buffer, &scene, 0);
        assert_eq!(
            answers(&buffer, &scene, 0),
            [false; 3],
            "round {round}, {kind:?}, unfinished"
        );
        buffer.finish();
        assert_eq!(
            answers(&buffer, &scene, 0),
            [false; 3],
            "round {round}, {kind:?}"
        );
        let footprint = buffer.screen().footprint_of_aabb(&scene.bounds()[0]);
        bounded += usize::from(matches!(
            footprint,
            antumbra::occlusion::Footprint::Within(_)
        ));
    }
    assert!(
        seen > 2_000 && bounded > 1_000,
        "{seen} seen, {bounded} with a rectangle"
    );
}

/// Some objects hide, so that the tests below are not about nothing.
#[derive(Default)]
struct Tally {
    owners: usize,
    hidden: usize,
}

fn check_owners(scene: &Scene, camera: &Camera, size: PictureSize, what: &str, tally: &mut Tally) {
    let forwards: Vec<usize> = (0..scene.objects().len()).collect();
    let backwards: Vec<usize> = forwards.iter().rev().copied().collect();
    for order in [&forwards, &backwards] {
        let mut owns = vec![false; order.len()];
        id_picture(scene, order, camera, size)
            .into_iter()
            .flatten()
            .for_each(|o| owns[o] = true);
        let mut buffer = OcclusionBuffer::new(size, *camera);
        for &object in order {
            draw(&mut buffer, scene, object);
        }
        buffer.finish();
        for &object in order {
            let hidden = answers(&buffer, scene, object);
            if owns[object] {
                assert_eq!(hidden, [false; 3], "{what}, object {object} of {order:?}");
                tally.owners += 1;
            } else {
                tally.hidden += usize::from(hidden[0]);
            }
        }
    }
}

#[test]
fn nothing_that_owns_a_pixel_is_hidden() {
    let mut chance = Chance::seeded(32);
    let mut tally = Tally::default();
    for round in 0..250 {
        let size =
            PictureSize::new(chance.whole(1, 150) as u32, chance.whole(1, 110) as u32).unwrap();
        let home = worlds::home(&mut chance);
        let count = chance.whole(2, 40);
        let (mut meshes, mut objects) = (Vec::new(), Vec::new());
        for i in 0..count {
            let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
            let material = if chance.one_in(3) {
                SINGLE_SIDED
            } else {
                DOUBLE_SIDED
            };
            let place = home + worlds::direction(&mut chance) * chance.real(0.0, 10.0);
            let radius = chance.real(0.2, 6.0);
            let (mesh, place) = worlds::placed(&mut chance, kind, material, place, radius);
            meshes.push(mesh);
            objects.push(worlds::object(i as usize, place));
        }
        let scene = Scene::new(meshes, objects).unwrap();
        let camera = worlds::camera(&mut chance, home, 14.0);
        check_owners(&scene, &camera, size, &format!("round {round}"), &mut tally);
    }
    assert!(
        tally.owners > 2_000 && tally.hidden > 1_000,
        "{} own, {} hidden",
        tally.owners,
        tally.hidden
    );
}

/// Walls one behind the other, so close that f32 depths, f64 depths or even the world's coordinates cannot tell them
/// apart.
#[test]
fn depths_less_than_an_f32_step_apart_lose_no_pixel() {
    let mut chance = Chance::seeded(33);
    let mut tally = Tally::default();
    let size = PictureSize::new(40, 32).unwrap();
    for round in 0..400 {
        let home = worlds::home(&mut chance);
        let step = [0.0, 1e-13, 1e-9, 1e-7, 1e-5][round % 5];
        let turned = if round % 2 == 0 {
            DMat3::IDENTITY
        } else {
            worlds::rotation(&mut chance)
        };
        let camera = worlds::camera(&mut chance, home, 4.0);
        let (mut meshes, mut objects) = (Vec::new(), Vec::new());
        for i in 0..6 {
            let kind = if chance.one_in(2) {
                Shape::Wall(1)
            } else {
                Shape::Wall(4)
            };
            let (points, triangles) = worlds::shape(&mut chance, kind);
            let scale = chance.real(0.5, 3.0);
            let positions = points
                .iter()
                .map(|p| (*p * scale).to_array().map(|v| v as f32))
                .collect();
            meshes.push(worlds::mesh(positions, triangles, DOUBLE_SIDED));
            let back = camera.forward() * (step * f64::from(chance.whole(0, 3)));
            let across = turned.x_axis * chance.real(-1.0, 1.0);
            let place = DAffine3 {
                matrix3: turned,
                translation: home + back + across,
            };
            objects.push(worlds::object(i, place));
        }
        let scene = Scene::new(meshes, objects).unwrap();
        check_owners(&scene, &camera, size, &format!("round {round}"), &mut tally);
    }
    assert!(tally.owners > 1_000, "{} own", tally.owners);
}

/// A buffer covered all over, but for one pixel: whatever is strictly behind and reaches that pixel is visible, and
/// what does not is hidden, in both tests' order of things.
#[test]
fn an_empty_pixel_beside_a_near_occluder_is_seen_through() {
    let size = PictureSize::new(21, 19).unwrap();
    let projection = antumbra::view::Projection::Orthographic {
        height: 19.0,
        near: 1.0,
        far: None,
    };
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).unwrap();
    // Pixel (x, y) to world coordinates: the picture's middle is the origin.
    let world = |x: f64, y: f64| (x - 10.5, 9.5 - y);
    for hole in [
        (0, 0),
        (7, 7),
        (8, 8),
        (10, 3),
        (20, 18),
        (20, 0),
        (3, 18),
        (16, 16),
    ] {
        let (hx, hy) = (f64::from(hole.0), f64::from(hole.1));
        let mut buffer = OcclusionBuffer::new(size, camera);
        let frames = [
            ([-9.0, hx], [-9.0, 40.0]),
            ([hx + 1.0, 40.0], [-9.0, 40.0]),
            ([hx, hx + 1.0], [-9.0, hy]),
            ([hx, hx + 1.0], [hy + 1.0, 40.0]),
        ];
        for (x, y) in frames {
            let (left, top) = world(x[0], y[0]);
            let (right, bottom) = world(x[1], y[1]);
            let corner = |x: f64, y: f64| [x as f32, y as f32, -2.0];
            let positions = [
                corner(left, bottom),
                corner(right, bottom),
                corner(right, top),
                corner(left, top),
            ];
            buffer.draw(&Occluder {
                geometry: Geometry::new(Positions::packed(&positions), &[0, 1, 2, 0, 2, 3])
                    .unwrap(),
                world_from_local: DAffine3::IDENTITY,
                cull_mode: CullMode::Back,
            });
        }
        for finished in [false, true] {
            if finished {
                buffer.finish();
            }
            for y in 0..19 {
                for x in 0..21 {
                    assert_eq!(buffer.pixel(x, y).is_none(), (x as i32, y as i32) == hole);
                }
            }
            for x in 0..21 {
                for y in 0..19 {
                    for (width, height) in [(1, 1), (2, 5), (9, 3), (30, 30)] {
                        let span =
                            |at: i32, n: i32| [f64::from(at) + 0.25, f64::from(at + n) - 0.25];
                        let sees =
                            x <= hole.0 && hole.0 < x + width && y <= hole.1 && hole.1 < y + height;
                        let (xs, ys) = (span(x, width), span(y, height));
                        assert_eq!(!buffer.test_rectangle(xs, ys, 3.0).is_hidden(), sees);
                        // In front of the occluders everything is visible.
                        assert!(!buffer.test_rectangle(xs, ys, 1.5).is_hidden());
                        // At their very depth, too: hidden means strictly farther.
                        assert!(!buffer.test_rectangle(xs, ys, 2.0).is_hidden());
                    }
                }
            }
        }
    }
}
