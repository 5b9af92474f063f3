//! Random boxes, and triangles inside them.
#![allow(dead_code)] // Each test file uses its own share.

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::occlusion::{OrientedBox, ProjectedBox, Screen};
use antumbra::scene::{Aabb, Mesh};
use antumbra::view::Camera;

use crate::oracle::Chance;
use crate::worlds::{self, DOUBLE_SIDED, Shape};

/// A box and the matrix that carries the cube from −1 to 1 into it.
pub struct Placed {
    /// The box.
    pub shape: OrientedBox,
    /// The matrix.
    pub world_from_cube: DAffine3,
    /// Its axes are the world's.
    pub aligned: bool,
}

impl Placed {
    pub fn aabb(&self) -> Aabb {
        let half = self
            .shape
            .half_axes
            .iter()
            .fold(DVec3::ZERO, |sum, axis| sum + axis.abs());
        Aabb {
            min: self.shape.center - half,
            max: self.shape.center + half,
        }
    }

    pub fn on(&self, screen: &Screen) -> ProjectedBox {
        if self.aligned {
            screen.project_aabb(&self.aabb())
        } else {
            screen.project_oriented_box(&self.shape, 0.0)
        }
    }
}

/// Boxes of all proportions, flat and thin and without volume, turned, mirrored, sheared.
pub fn any_box(chance: &mut Chance, center: DVec3, radius: f64) -> Placed {
    let aligned = chance.one_in(2);
    let turned = if aligned {
        DMat3::IDENTITY
    } else {
        worlds::rotation(chance)
    };
    let mut half = || radius * [chance.real(0.2, 1.0), 0.5, 1e-3, 0.0][chance.whole(0, 3) as usize];
    let scales = DVec3::new(half(), half(), half());
    let mut matrix3 = turned * DMat3::from_diagonal(scales);
    if !aligned && chance.one_in(2) {
        matrix3.x_axis = -matrix3.x_axis;
    }
    if !aligned && chance.one_in(4) {
        matrix3.y_axis += matrix3.z_axis * 0.5;
    }
    Placed {
        shape: OrientedBox {
            center,
            half_axes: [matrix3.x_axis, matrix3.y_axis, matrix3.z_axis],
        },
        world_from_cube: DAffine3 {
            matrix3,
            translation: center,
        },
        aligned,
    }
}

/// Triangles inside the cube from −1 to 1: on its corners and faces, and anywhere.
pub fn mesh_in_cube(chance: &mut Chance) -> Mesh {
    if chance.one_in(3) {
        let (points, triangles) = worlds::shape(chance, Shape::Cube);
        let positions = points
            .iter()
            .map(|p| p.to_array().map(|v| v as f32))
            .collect();
        return worlds::mesh(positions, triangles, DOUBLE_SIDED);
    }
    let mut coordinate = || match chance.whole(0, 4) {
        0 | 1 => -1.0,
        2 | 3 => 1.0,
        _ => chance.real(-1.0, 1.0) as f32,
    };
    let positions = (0..36)
        .map(|_| [coordinate(), coordinate(), coordinate()])
        .collect();
    let triangles = (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    worlds::mesh(positions, triangles, DOUBLE_SIDED)
}

/// A box in view of a camera, from far away and from close by.
pub fn any_view(chance: &mut Chance) -> (Placed, Camera) {
    let home = worlds::home(chance);
    let radius = [0.05, 1.0, 30.0][chance.whole(0, 2) as usize];
    let placed = any_box(chance, home, radius);
    let distance = radius * chance.real(0.3, 1.0) * [2.0, 10.0, 50.0][chance.whole(0, 2) as usize];
    let camera = worlds::camera(chance, home, distance);
    (placed, camera)
}
