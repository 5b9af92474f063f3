//! The frustum keeps every box that can reach a pixel, and drops what is clearly outside.

mod oracle;
mod worlds;

use antumbra::glam::{DAffine3, DVec3};
use antumbra::raster::ObjectAssembler;
use antumbra::scene::{Aabb, Scene};
use antumbra::view::{Camera, Containment, Frustum, PictureSize, Planes, Projection};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES, Shape};

/// How far a point lies inside each bound of the view, as parts of its distance; none where the projection has no such
/// bound. Angles and distances, not planes.
fn inside_by(camera: &Camera, size: PictureSize, p: DVec3) -> f64 {
    let d = p - camera.eye();
    let (x, y, z) = (
        d.dot(camera.right()),
        d.dot(camera.up()),
        d.dot(camera.forward()),
    );
    let projection = camera.projection();
    let (half_width, half_height) = match *projection {
        Projection::Perspective { fov_y, .. } => {
            let t = (fov_y * 0.5).tan();
            (z * t * size.aspect(), z * t)
        }
        Projection::Orthographic { height, .. } => (height * 0.5 * size.aspect(), height * 0.5),
    };
    let far = projection.far().map_or(f64::INFINITY, |far| far - z);
    [
        half_width - x.abs(),
        half_height - y.abs(),
        z - projection.near(),
        far,
    ]
    .into_iter()
    .fold(f64::INFINITY, f64::min)
        / d.length().max(half_height.abs())
}

fn is_outside(frustum: &Frustum, bounds: &Aabb) -> bool {
    frustum.contains(bounds, Planes::ALL) == Containment::Outside
}

#[test]
fn a_box_around_a_point_in_view_is_never_outside() {
    let mut chance = Chance::seeded(71);
    let (mut inside, mut outside) = (0, 0);
    for _ in 0..40_000 {
        let size =
            PictureSize::new(chance.whole(1, 900) as u32, chance.whole(1, 900) as u32).unwrap();
        let home = worlds::home(&mut chance);
        let camera = worlds::camera(&mut chance, home, 10.0);
        let frustum = Frustum::new(&camera, size);
        let reach = chance.real(0.0, 60.0);
        let p = home + worlds::direction(&mut chance) * reach;
        let half = DVec3::new(
            chance.real(0.0, 3.0),
            chance.real(0.0, 3.0),
            chance.real(0.0, 3.0),
        );
        let shift = half
            * DVec3::new(
                chance.real(-1.0, 1.0),
                chance.real(-1.0, 1.0),
                chance.real(-1.0, 1.0),
            );
        let bounds = Aabb {
            min: p + shift - half,
            max: p + shift + half,
        };
        if inside_by(&camera, size, p) > 1e-9 {
            assert!(!is_outside(&frustum, &bounds));
            inside += 1;
        }
        // A point is dropped as soon as it is out of view: for points the six planes are the frustum.
        let point = Aabb { min: p, max: p };
        if inside_by(&camera, size, p) < -1e-9 {
            assert!(is_outside(&frustum, &point), "{p} {camera:?}");
            outside += 1;
        }
    }
    assert!(
        inside > 5_000 && outside > 5_000,
        "{inside} inside, {outside} outside"
    );
}

/// What a node passes its children need not be asked.
#[test]
fn a_box_in_a_box_is_judged_alike_with_the_planes_left_over() {
    let mut chance = Chance::seeded(72);
    let size = PictureSize::new(160, 90).unwrap();
    let (mut all, mut dropped) = (0, 0);
    for _ in 0..40_000 {
        let home = worlds::home(&mut chance);
        let camera = worlds::camera(&mut chance, home, 10.0);
        let frustum = Frustum::new(&camera, size);
        let mut span = |reach: f64| {
            let (a, b) = (chance.real(-reach, reach), chance.real(-reach, reach));
            [a.min(b), a.max(b)]
        };
        let outer = [span(9.0), span(9.0), span(9.0)];
        let inner = outer.map(|[low, high]| {
            let (a, b) = (chance.real(low, high), chance.real(low, high));
            [a.min(b), a.max(b)]
        });
        let aabb = |s: [[f64; 2]; 3]| Aabb {
            min: home + DVec3::new(s[0][0], s[1][0], s[2][0]),
            max: home + DVec3::new(s[0][1], s[1][1], s[2][1]),
        };
        let (outer, inner) = (aabb(outer), aabb(inner));
        match frustum.contains(&outer, Planes::ALL) {
            Containment::Outside => assert!(is_outside(&frustum, &inner)),
            Containment::Meets(left) => {
                all += 1;
                let within = frustum.contains(&inner, left) == Containment::Outside;
                assert_eq!(within, is_outside(&frustum, &inner));
                dropped += usize::from(left != Planes::ALL);
            }
        }
    }
    assert!(
        all > 5_000 && dropped > 1_000,
        "{all} met, {dropped} with planes dropped"
    );
}

/// Every object that is drawn on some sample is kept, even if it only just touches the view: flat walls at the near
/// plane's and the far plane's very distance, and along the sides.
#[test]
fn what_is_drawn_at_the_very_border_is_kept() {
    let mut chance = Chance::seeded(0x7e20_52c6_ee33_fa2f);
    let size = PictureSize::new(64, 48).unwrap();
    let mut drawn = 0;
    for round in 0..20_000 {
        let home = worlds::home(&mut chance);
        let axis = round / 3 % 3;
        let mut aim = DVec3::ZERO;
        aim[axis] = if chance.one_in(2) { 1.0 } else { -1.0 };
        // From afar the eye's own coordinates are the largest, and their rounding too.
        let scale = [1.0, 1e3, 1e6][chance.whole(0, 2) as usize];
        let distance = chance.real(0.1, 20.0) * scale;
        let eye = home - aim * distance + DVec3::new(chance.real(-0.5, 0.5), 0.0, 0.0);
        // The planes go through the wall, as nearly as f64 can say.
        let to_wall = (home - eye).dot(aim) * (1.0 + f64::EPSILON * f64::from(chance.whole(-2, 2)));
        if to_wall <= 0.01 {
            continue;
        }
        let [near, far] = [[to_wall, to_wall * 3.0], [to_wall * 0.5, to_wall]][round % 2];
        let projection = if chance.one_in(2) {
            Projection::Perspective {
                fov_y: chance.real(2.0, 3.0) / (1.0 + scale),
                near,
                far: Some(far),
            }
        } else {
            Projection::Orthographic {
                height: chance.real(0.5, 5.0),
                near,
                far: Some(far),
            }
        };
        let up = if axis == 1 {
            DVec3::new(0.6, 0.0, 0.8)
        } else {
            DVec3::Y
        };
        // Not quite along the axis, so that no product is exact.
        let tilt = worlds::direction(&mut chance) * [0.0, 1e-10, 1e-8][chance.whole(0, 2) as usize];
        let camera = Camera::look_at(eye, eye + aim * distance + tilt, up, projection).unwrap();
        // A wall across the axis, partly placed by its matrix and partly by its positions.
        let split = chance.real(-9.0, 9.0) as f32;
        let mut place = DAffine3::from_translation(home - aim.abs() * f64::from(split));
        place.matrix3 = match axis {
            0 => antumbra::glam::DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
            1 => antumbra::glam::DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
            _ => antumbra::glam::DMat3::IDENTITY,
        };
        let (points, triangles) = worlds::shape(&mut chance, Shape::Wall(2));
        let positions = points
            .iter()
            .map(|p| [p.x as f32 * 9.0, p.y as f32 * 9.0, split])
            .collect();
        let mesh = worlds::mesh(positions, triangles, DOUBLE_SIDED);
        check(
            Scene::new(vec![mesh], vec![worlds::object(0, place)]).unwrap(),
            &camera,
            size,
            &mut drawn,
        );
    }
    assert!(drawn > 2_000, "{drawn} drawn");
    // And anything anywhere.
    for _ in 0..3_000 {
        let home = worlds::home(&mut chance);
        let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
        let (mesh, place) = worlds::placed(&mut chance, kind, DOUBLE_SIDED, home, 1.0);
        let aside = home + worlds::direction(&mut chance) * 4.0;
        let camera = worlds::camera(&mut chance, aside, 5.0);
        check(
            Scene::new(vec![mesh], vec![worlds::object(0, place)]).unwrap(),
            &camera,
            size,
            &mut drawn,
        );
    }
}

fn check(scene: Scene, camera: &Camera, size: PictureSize, drawn: &mut usize) {
    let mut any = false;
    let object = &scene.objects()[0];
    ObjectAssembler::new(*camera, size).assemble(
        &scene.meshes()[0],
        &object.world_from_local,
        |_| true,
        |t| {
            antumbra::raster::for_each_sample(&t.triangle, 0..size.height() as i32, |_, _, _| {
                any = true;
            });
        },
    );
    if any {
        *drawn += 1;
        let frustum = Frustum::new(camera, size);
        assert!(
            !is_outside(&frustum, &scene.bounds()[0]),
            "{:?} {camera:?}",
            scene.bounds()[0]
        );
    }
}

#[test]
fn a_box_that_is_not_finite_is_never_outside() {
    let camera = Camera::look_at(
        DVec3::ZERO,
        DVec3::NEG_Z,
        DVec3::Y,
        Projection::Perspective {
            fov_y: 1.0,
            near: 0.1,
            far: None,
        },
    )
    .unwrap();
    let frustum = Frustum::new(&camera, PictureSize::new(64, 48).unwrap());
    assert!(is_outside(
        &frustum,
        &Aabb {
            min: DVec3::splat(5.0),
            max: DVec3::splat(6.0)
        }
    ));
    let nan = DVec3::NAN;
    assert!(!is_outside(&frustum, &Aabb { min: nan, max: nan }));
    assert!(!is_outside(
        &frustum,
        &Aabb {
            min: DVec3::NEG_INFINITY,
            max: DVec3::INFINITY
        }
    ));
}
