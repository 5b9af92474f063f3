//! A world for one picture: a camera, and things that are drawn before it, or only asked about.
#![allow(dead_code)] // Each program uses its own share.

use antumbra::glam::DAffine3;
use antumbra::occlusion::{Occluder, OcclusionBuffer};
use antumbra::raster::{Assembler, CullMode, Geometry, Positions};
use antumbra::scene::{Mesh, Scene, SceneError};
use antumbra::view::{Camera, PictureSize};
use antumbra_simd::triangle::Triangle;

use crate::oracle::Point;
use crate::worlds::{self, DOUBLE_SIDED, SINGLE_SIDED};

/// A placed mesh.
#[derive(Clone, Debug)]
pub struct Thing {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub double_sided: bool,
    pub place: DAffine3,
    /// Whether it is an occluder.
    pub drawn: bool,
}

impl Thing {
    pub fn new(mesh: &Mesh, place: DAffine3, drawn: bool) -> Thing {
        Thing {
            positions: mesh.positions.to_vec(),
            triangles: mesh.triangles.to_vec(),
            double_sided: mesh.surfaces[0].material.double_sided,
            place,
            drawn,
        }
    }

    pub fn mesh(&self) -> Mesh {
        let material = if self.double_sided {
            DOUBLE_SIDED
        } else {
            SINGLE_SIDED
        };
        worlds::mesh(self.positions.clone(), self.triangles.clone(), material)
    }

    /// How far a point of it may be off, in scene units: 2⁻⁴⁰ of the terms that make it, as `src/occlusion/footprint.rs` has it.
    pub fn terms(&self, position: [f32; 3]) -> f64 {
        let m = self.place.matrix3;
        let p = position.map(|v| f64::from(v.abs()));
        let terms = m.x_axis.abs() * p[0]
            + m.y_axis.abs() * p[1]
            + m.z_axis.abs() * p[2]
            + self.place.translation.abs();
        terms.max_element()
    }
}

/// What the library draws of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    pub triangle: Triangle,
    /// The triangle it is of.
    pub index: usize,
    pub points: [Point; 3],
}

/// The corners of a triangle that is ready to be filled: its first one, and the edges from there.
fn points_of(t: &Triangle) -> [Point; 3] {
    let grid = |samples: f64| (samples * 256.0) as i32 + 128;
    let first = (grid(t.depth.origin_x), grid(t.depth.origin_y));
    let [out, _, back] = t.edges.map(|e| (e.a as i32, e.b as i32));
    [
        first,
        (first.0 + out.1, first.1 - out.0),
        (first.0 - back.1, first.1 + back.0),
    ]
}

pub struct World {
    pub camera: Camera,
    pub size: PictureSize,
    pub things: Vec<Thing>,
}

impl World {
    /// The things as a scene; those that are not drawn never occlude.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        let meshes = self.things.iter().map(Thing::mesh).collect();
        let object = |(i, thing): (usize, &Thing)| {
            let mut object = worlds::object(i, thing.place);
            object.never_occlude = !thing.drawn;
            object
        };
        Scene::new(meshes, self.things.iter().enumerate().map(object).collect())
    }

    /// What is drawn of a thing, with both sides if it has them.
    pub fn drawn(&self, thing: &Thing, mirrored: bool) -> Vec<Drawn> {
        let cull = match (thing.double_sided, mirrored) {
            (true, _) => CullMode::None,
            (false, false) => CullMode::Back,
            (false, true) => CullMode::Front,
        };
        let indices = thing.triangles.as_flattened();
        let geometry = Geometry::new(Positions::packed(&thing.positions), indices);
        let screen = self.camera.screen_from_local(self.size, &thing.place);
        let mut drawn = Vec::new();
        Assembler::default().assemble(
            geometry.expect("sound"),
            &screen,
            self.size,
            cull,
            |triangle, index| {
                drawn.push(Drawn {
                    triangle,
                    index,
                    points: points_of(&triangle),
                });
            },
        );
        drawn
    }

    /// Draws a thing into a buffer.
    pub fn draw(&self, buffer: &mut OcclusionBuffer, thing: &Thing) {
        let indices = thing.triangles.as_flattened();
        buffer.draw(&Occluder {
            geometry: Geometry::new(Positions::packed(&thing.positions), indices).expect("sound"),
            world_from_local: thing.place,
            cull_mode: if thing.double_sided {
                CullMode::None
            } else {
                CullMode::Back
            },
        });
    }
}
