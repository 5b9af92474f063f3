//! Cameras that strain numbers: far from the origin, with all that depth can range over, with the narrowest and the widest angles,
//! and with the eye's plane through what they see.

use antumbra::glam::{DAffine3, DVec3};
use antumbra::view::{Camera, Projection};
use num_rational::BigRational;

use crate::exact::f64_step;
use crate::oracle::Chance;
use crate::scatter::*;
use crate::world::{Thing, World};
use crate::worlds::{self, DOUBLE_SIDED, SHAPES, SINGLE_SIDED};

fn perspective(fov_y: f64, near: f64, far: Option<f64>) -> Projection {
    Projection::Perspective { fov_y, near, far }
}

/// A world 10⁷ units away from the origin, in each direction; positions hold their place there, or matrices do, or both are far
/// off and cancel.
pub fn far_away(chance: &mut Chance) -> World {
    let sign = |chance: &mut Chance| one_of(chance, &[-1.0, 1.0]);
    let reach = one_of(chance, &[1e7, 1.0e7 + 1.0 / 3.0, 1.6e7]);
    let home = DVec3::new(sign(chance), sign(chance), sign(chance)) * reach;
    let radius = one_of(chance, &[0.5, 5.0, 50.0]);
    let mut things = Vec::new();
    for _ in 0..chance.whole(2, 9) {
        let kind = one_of(chance, &SHAPES);
        let material = one_of(chance, &[SINGLE_SIDED, DOUBLE_SIDED, DOUBLE_SIDED]);
        let place = home + worlds::direction(chance) * radius * chance.real(0.0, 4.0);
        let own = radius * chance.real(0.2, 2.0);
        let (mesh, place) = worlds::placed(chance, kind, material, place, own);
        things.push(Thing::new(&mesh, place, !chance.one_in(4)));
    }
    // What is nearer than coordinates of this size tell apart is no honest test.
    let near = radius * one_of(chance, &[1e-3, 1e-2, 0.5]);
    let fov_y = chance.real(0.2, 1.8);
    let eye = home + worlds::direction(chance) * radius * chance.real(2.0, 9.0);
    let up = worlds::direction(chance);
    let camera = Camera::look_at(eye, home, up, perspective(fov_y, near, None));
    World {
        camera: camera.expect("a camera"),
        size: small(chance),
        things,
    }
}

/// Near planes of 10⁻³ and far ones of 10⁹, and things at any distance between.
pub fn long_range(chance: &mut Chance, far: Option<f64>) -> World {
    let near = 1e-3;
    let fov_y = chance.real(0.3, 1.8);
    let eye = worlds::direction(chance) * one_of(chance, &[0.0, 1.0, 1e3]);
    let camera = camera_at(chance, eye, perspective(fov_y, near, far));
    let size = small(chance);
    // What is nearer than the coordinates of the eye can tell apart is no honest test of depth.
    let least = near.max(eye.length() * 1e-6);
    let most = far.map_or(1e12, |far| far * 1.2);
    let things = scattered(chance, &camera, size, |chance| power(chance, least, most));
    World {
        camera,
        size,
        things,
    }
}

/// Things so close to the near plane or to the far one that depth all but reaches 1, or the least there is.
pub fn ends_of_depth(chance: &mut Chance) -> World {
    let near = one_of(chance, &[1e-3, 1.0, 1e6]);
    let far = near * one_of(chance, &[1.0 + 1e-6, 2.0, 1e6, 1e12]);
    let fov_y = chance.real(0.3, 1.8);
    let camera = camera_at(chance, DVec3::ZERO, perspective(fov_y, near, Some(far)));
    let size = small(chance);
    let mut things = scattered(chance, &camera, size, |chance| {
        let close = power(chance, 1e-12, 1e-2) * one_of(chance, &[-1.0, 1.0, 1.0]);
        let end = one_of(chance, &[near, far]);
        end * (1.0 + if end == near { close } else { -close })
    });
    for thing in &mut things {
        // So flat that all of it stays at its distance.
        if chance.one_in(2) {
            let (axes, along) = (&mut thing.place.matrix3, camera.forward());
            let squash = |v: DVec3| v - along * v.dot(along) * (1.0 - 1e-9);
            axes.x_axis = squash(axes.x_axis);
            axes.y_axis = squash(axes.y_axis);
            axes.z_axis = squash(axes.z_axis);
            thing.double_sided = true;
        }
    }
    World {
        camera,
        size,
        things,
    }
}

/// Orthographic views from microscopic to geographic, whose near plane may lie behind the eye, with a far plane and without.
pub fn orthographic(chance: &mut Chance) -> World {
    let height = power(chance, 1e-6, 1e9);
    let depth = height * power(chance, 1e-3, 1e6);
    let near = one_of(chance, &[0.0, -depth, depth * 0.01, -depth * 1e-9]);
    let far = chance.one_in(2).then_some(depth);
    let projection = Projection::Orthographic { height, near, far };
    let eye = worlds::direction(chance) * height * one_of(chance, &[0.0, 1.0, 1e4]);
    let camera = camera_at(chance, eye, projection);
    let size = small(chance);
    let things = scattered(chance, &camera, size, |chance| {
        near + (depth * 1.1 - near) * power(chance, 1e-3, 1.0)
    });
    World {
        camera,
        size,
        things,
    }
}

/// A field of view of so many degrees.
pub fn field_of_view(chance: &mut Chance, degrees: f64) -> World {
    let near = power(chance, 1e-3, 1.0);
    let eye = worlds::direction(chance) * one_of(chance, &[0.0, 10.0, 1e3]);
    let far = chance.one_in(3).then_some(near * 1e5);
    let camera = camera_at(chance, eye, perspective(degrees.to_radians(), near, far));
    let size = small(chance);
    let things = scattered(chance, &camera, size, |chance| {
        near * power(chance, 0.9, 1e5)
    });
    World {
        camera,
        size,
        things,
    }
}

/// Things around the eye, through its plane and within a hair of it, with near planes down to 10⁻³⁰.
pub fn eye_plane(chance: &mut Chance) -> World {
    let near = one_of(chance, &[1e-30, 1e-12, 1e-6, 1e-2]);
    let fov_y = chance.real(0.3, 2.6);
    let eye = worlds::direction(chance) * one_of(chance, &[0.0, 0.0, 1.0, 1e3]);
    let camera = camera_at(chance, eye, perspective(fov_y, near, None));
    let size = small(chance);
    let mut things = scattered(chance, &camera, size, |chance| power(chance, 1e-2, 10.0));
    for _ in 0..chance.whole(1, 4) {
        // Relative to the eye: along the view all but nothing, aside anything.
        let mut point = || {
            let along = one_of(chance, &[0.0, 1e-30, 1e-9, 1e-4, near, 1.0, -1e-9, -1.0]);
            let (x, y) = (chance.real(-2.0, 2.0), chance.real(-2.0, 2.0));
            let scale = one_of(chance, &[1e-6, 1.0, 1e3]);
            camera.forward() * along + (camera.right() * x + camera.up() * y) * scale
        };
        let points: Vec<DVec3> = (0..6).map(|_| point()).collect();
        let mut thing = of_world(&points, vec![[0, 1, 2], [3, 4, 5]], !chance.one_in(3));
        thing.place = DAffine3::from_translation(eye);
        things.push(thing);
    }
    World {
        camera,
        size,
        things,
    }
}

/// The tangent of half an angle, above 0 and below π, from a hundred terms of the series of its sine and cosine: good to 2⁻²⁰⁰.
fn tangent_of_half(angle: f64) -> BigRational {
    let half =
        BigRational::from_float(angle).expect("finite") / BigRational::from_integer(2.into());
    let square = &half * &half;
    let series = |mut term: BigRational, first: u32| {
        let mut sum = term.clone();
        for i in (first..).step_by(2).take(30) {
            term = -term * &square / BigRational::from_integer((i * (i + 1)).into());
            sum += &term;
        }
        sum
    };
    let one = BigRational::from_integer(1.into());
    series(half.clone(), 2) / series(one, 1)
}

/// How far an element of a camera's rows may be off that holds the tangent, in f64 steps.
pub fn error_of_tangent(fov_y: f64) -> f64 {
    let camera = Camera::look_at(
        DVec3::ZERO,
        DVec3::NEG_Z,
        DVec3::Y,
        perspective(fov_y, 1.0, None),
    );
    // 256 sub-pixels a pixel, and half of two pixels: y is 256·(1 − Y/t).
    let row = camera.expect("a camera").screen_from_eye(size(2, 2)).y;
    let exact = -BigRational::from_integer(256.into()) / tangent_of_half(fov_y);
    let off = BigRational::from_float(row[1]).expect("finite") - exact;
    let steps = off / BigRational::from_float(f64_step(row[1])).expect("finite");
    let thousandths = (steps * BigRational::from_integer(1000.into()))
        .round()
        .to_integer();
    thousandths
        .to_string()
        .parse::<f64>()
        .expect("a number")
        .abs()
        / 1000.0
}
