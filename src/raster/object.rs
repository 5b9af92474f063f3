//! The triangles of a scene's object, surface by surface.

use antumbra_simd::triangle::{CullMode, Triangle};
use glam::DAffine3;

use super::{Assembler, Positions};
use crate::scene::{Material, Mesh, is_mirroring};
use crate::view::{Camera, PictureSize};

/// A triangle of an object, ready to be filled, and where it comes from.
#[derive(Clone, Copy, Debug)]
pub struct ObjectTriangle<'a> {
    /// The triangle.
    pub triangle: Triangle,
    /// Its index in the mesh's triangles. Clipping can make several of one.
    pub index: usize,
    /// Its surface's material.
    pub material: &'a Material,
}

/// Assembles objects for one camera and picture size.
#[derive(Clone, Debug)]
pub struct ObjectAssembler {
    camera: Camera,
    size: PictureSize,
    assembler: Assembler,
}

impl ObjectAssembler {
    /// An assembler for a camera and a picture.
    pub fn new(camera: Camera, size: PictureSize) -> ObjectAssembler {
        ObjectAssembler {
            camera,
            size,
            assembler: Assembler::default(),
        }
    }

    /// Changes the camera; the buffers stay.
    pub fn set_camera(&mut self, camera: Camera) {
        self.camera = camera;
    }

    /// Hands the triangles of a placed mesh to `emit`, those of the surfaces that `wanted` says, in the mesh's order.
    /// Single-sided surfaces give their front faces only, mirrored placements too.
    pub fn assemble<'a>(
        &mut self,
        mesh: &'a Mesh,
        world_from_local: &DAffine3,
        wanted: impl Fn(&Material) -> bool,
        mut emit: impl FnMut(ObjectTriangle<'a>),
    ) {
        if !mesh.surfaces.iter().any(|s| wanted(&s.material)) {
            return;
        }
        let screen = self.camera.screen_from_local(self.size, world_from_local);
        let mirrored = is_mirroring(world_from_local);
        self.assembler
            .transform(Positions::packed(&mesh.positions), &screen);
        for surface in mesh.surfaces.iter().filter(|s| wanted(&s.material)) {
            let cull = match (surface.material.double_sided, mirrored) {
                (true, _) => CullMode::None,
                (false, false) => CullMode::Back,
                (false, true) => CullMode::Front,
            };
            let first = surface.triangles.start;
            let triangles = &mesh.triangles[surface.triangles.clone()];
            self.assembler
                .set_up(triangles, &screen, self.size, cull, |triangle, index| {
                    emit(ObjectTriangle {
                        triangle,
                        index: first + index,
                        material: &surface.material,
                    });
                });
        }
    }
}
