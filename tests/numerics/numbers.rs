//! Coordinates and matrices at the ends of what floats hold, and matrices that mirror or flatten.

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::view::Projection;

use crate::oracle::Chance;
use crate::scatter::*;
use crate::world::World;
use crate::worlds;

fn perspective(chance: &mut Chance, near: f64) -> Projection {
    Projection::Perspective {
        fov_y: chance.real(0.3, 2.0),
        near,
        far: None,
    }
}

/// Positions that are subnormal f32, or a few steps from the largest; the matrix brings them to the size that is seen. A scene takes
/// matrices up to 2¹⁰⁰ only; a buffer takes any.
pub fn extreme_positions(chance: &mut Chance) -> World {
    let scale = one_of(chance, &[1e-40, 3e-42, 1e-38, 1e30, 3e38]);
    // What is seen is ordinary, or of a size that a scene's matrices reach.
    let unit = one_of(chance, &[1.0, if scale < 1.0 { scale * 1e29 } else { 1e5 }]);
    let projection = perspective(chance, unit * 0.05);
    let camera = camera_at(chance, DVec3::ZERO, projection);
    let size = small(chance);
    let mut things = scattered(chance, &camera, size, |chance| {
        unit * chance.real(1.0, 12.0)
    });
    for thing in &mut things {
        // The same thing, but for the rounding of its positions.
        for position in &mut thing.positions {
            *position = position.map(|v| (f64::from(v) * scale) as f32);
        }
        thing.place.matrix3 *= 1.0 / scale;
    }
    World {
        camera,
        size,
        things,
    }
}

/// Worlds at the largest coordinates that a scene and a camera may have, and at the smallest that leave a near plane.
pub fn extreme_worlds(chance: &mut Chance) -> World {
    let unit = one_of(chance, &[1e-28, 1e-20, 1e12, 1e20, 1e27]);
    let projection = if chance.one_in(3) {
        Projection::Orthographic {
            height: unit * chance.real(1.0, 9.0),
            near: unit * one_of(chance, &[-1.0, 0.01]),
            far: chance.one_in(2).then_some(unit * 20.0),
        }
    } else {
        perspective(chance, unit * 0.05)
    };
    let eye = worlds::direction(chance) * unit * one_of(chance, &[0.0, 1.0, 100.0]);
    let camera = camera_at(chance, eye, projection);
    let size = small(chance);
    let mut things = scattered(chance, &camera, size, |chance| {
        unit * chance.real(0.02, 12.0)
    });
    for thing in &mut things {
        // Half of them with their place and size in the positions, which hold up to 3·10³⁸.
        if chance.one_in(2) {
            let place = std::mem::replace(&mut thing.place, DAffine3::IDENTITY);
            for position in &mut thing.positions {
                let p = place.transform_point3(DVec3::from_array(position.map(f64::from)));
                *position = p.to_array().map(|v| v as f32);
            }
            // Turned over, if the matrix did it.
            thing.double_sided = true;
        }
    }
    World {
        camera,
        size,
        things,
    }
}

/// Mirrored in one, two or three axes, sheared, and stretched ten thousand times more one way than another.
pub fn mirrored(chance: &mut Chance) -> World {
    let projection = perspective(chance, 0.05);
    let camera = camera_at(chance, DVec3::ZERO, projection);
    let size = small(chance);
    let mut things = scattered(chance, &camera, size, |chance| chance.real(1.0, 12.0));
    for thing in &mut things {
        let mut sign = || one_of(chance, &[-1.0, 1.0]);
        let mut sizes = DVec3::new(sign(), sign(), sign());
        if chance.one_in(3) {
            sizes.y *= 1e-4;
        }
        thing.place.matrix3 *= DMat3::from_diagonal(sizes);
        if chance.one_in(3) {
            thing.place.matrix3.x_axis += thing.place.matrix3.z_axis * chance.real(-2.0, 2.0);
        }
        thing.double_sided = chance.one_in(4);
    }
    World {
        camera,
        size,
        things,
    }
}

/// Matrices that flatten things into a plane, a line or a point, along an axis or aslant.
pub fn singular(chance: &mut Chance) -> World {
    let projection = perspective(chance, 0.05);
    let camera = camera_at(chance, DVec3::ZERO, projection);
    let size = small(chance);
    let mut things = scattered(chance, &camera, size, |chance| chance.real(1.0, 12.0));
    for thing in &mut things {
        let m = &mut thing.place.matrix3;
        match chance.whole(0, 5) {
            0 => m.z_axis = DVec3::ZERO,
            1 => (m.y_axis, m.z_axis) = (DVec3::ZERO, DVec3::ZERO),
            2 => *m = DMat3::ZERO,
            // Which side is the front of these hangs on how the determinant, 0, is rounded.
            3 => (m.y_axis, thing.double_sided) = (m.x_axis, true),
            4 => (m.y_axis, thing.double_sided) = (m.x_axis * chance.real(-2.0, 2.0), true),
            _ => (m.z_axis, thing.double_sided) = (m.x_axis + m.y_axis, true),
        }
    }
    World {
        camera,
        size,
        things,
    }
}
