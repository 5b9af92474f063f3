//! A town that grows as it is asked to: in objects or in triangles, one without the other.

use std::f64::consts::TAU;
use std::sync::Arc;

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::scene::{Mesh, Scene};
use antumbra::view::{Camera, Projection};

use super::{Chance, Stage, mesh, object};

/// From the middle of a block to the middle of the next, metres.
const PITCH: f64 = 20.0;

/// A square town of `side` × `side` blocks, each an object of 12·`fineness`² triangles, seen from a crossing in its
/// middle. With `shared`, all are one mesh.
pub fn town(side: u32, fineness: u32, shared: bool) -> Stage {
    let mut chance = Chance(1);
    let block = block(fineness);
    let count = (side * side) as usize;
    let meshes = vec![block; if shared { 1 } else { count }];
    let middle = f64::from(side / 2) * PITCH;
    let objects = (0..count).map(|index| {
        let (column, row) = (index as u32 % side, index as u32 / side);
        let size = chance.point(DVec3::new(12.0, 6.0, 12.0), DVec3::new(17.0, 40.0, 17.0));
        let place = DVec3::new(f64::from(column), 0.0, f64::from(row)) * PITCH;
        let origin = DVec3::new(middle, 0.0, middle) - DVec3::new(0.5, 0.0, 0.5) * PITCH;
        object(
            index % meshes.len(),
            DAffine3::from_mat3_translation(DMat3::from_diagonal(size), place - origin),
        )
    });
    let objects = objects.collect();
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.1,
        far: None,
    };
    let eye = DVec3::new(0.3, 1.7, 0.2);
    let cameras = (0..8).map(|eighth| {
        let (sin, cos) = (f64::from(eighth) / 8.0 * TAU).sin_cos();
        let target = eye + DVec3::new(cos, 0.05, sin);
        Camera::look_at(eye, target, DVec3::Y, projection).expect("a camera")
    });
    Stage {
        cameras: cameras.collect(),
        scene: Arc::new(Scene::new(meshes, objects).expect("a sound scene")),
    }
}

/// A box a metre wide that stands on the origin, `fineness`² squares of two triangles on each side.
fn block(fineness: u32) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let step = |i: u32| i as f32 / fineness as f32 - 0.5;
    for side in 0..6 {
        let (axis, far) = (side / 2, side % 2 == 1);
        let first = positions.len() as u32;
        let across = fineness + 1;
        for v in 0..across {
            for u in 0..across {
                let mut p = [0.0; 3];
                p[axis] = if far { 0.5 } else { -0.5 };
                p[(axis + 1) % 3] = step(u);
                p[(axis + 2) % 3] = step(v);
                p[1] += 0.5;
                positions.push(p);
            }
        }
        for v in 0..fineness {
            for u in 0..fineness {
                let a = first + v * across + u;
                let corners = [a, a + 1, a + across + 1, a + across];
                let [a, b, c, d] = if far {
                    corners
                } else {
                    [corners[0], corners[3], corners[2], corners[1]]
                };
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh(positions, triangles)
}
