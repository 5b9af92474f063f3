//! Which objects to draw as occluders this frame, and in which order.

mod nearest;

use crate::scene::{Material, Mesh, Object, Scene};

pub use nearest::nearest_first;

/// How many triangles may be drawn as occluders in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Budget {
    /// Every candidate's.
    #[default]
    All,
    /// Candidates are drawn in order for as long as they fit (HOM §7.3.2).
    Triangles(u64),
}

impl Budget {
    /// Whether `triangles` in all are within the budget.
    pub fn allows(self, triangles: u64) -> bool {
        match self {
            Budget::All => true,
            Budget::Triangles(most) => triangles <= most,
        }
    }
}

/// Whether a surface of this material hides what is behind it.
pub fn occludes(material: &Material) -> bool {
    material.occludes()
}

/// The mesh to draw for an object as an occluder: its proxy, or its own.
pub fn occluder_mesh<'a>(scene: &'a Scene, object: &Object) -> &'a Mesh {
    &scene.meshes()[object.occluder_proxy.unwrap_or(object.mesh)]
}

/// How many triangles an object puts in the way as an occluder; 0 if it is none.
pub fn occluder_triangles(scene: &Scene, object: &Object) -> u64 {
    let Some(mesh) = object.occluder_mesh() else {
        return 0;
    };
    let surfaces = scene.meshes()[mesh].surfaces.iter();
    surfaces
        .filter(|s| occludes(&s.material))
        .map(|s| s.triangles.len() as u64)
        .sum()
}
