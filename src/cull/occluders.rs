//! What is known of a scene's occluders before any frame.

use std::sync::Arc;

use crate::prepare::{ClusteredMesh, ClusteredScene, Prepared};
use crate::scene::Object;

/// A scene's occluders, ready to be drawn.
#[derive(Debug)]
pub struct Occluders {
    clusters: Arc<ClusteredScene>,
    /// How many triangles each object puts in the way.
    triangles: Vec<u32>,
    /// Whether each object's clusters are all that is ever drawn of it.
    is_all: Vec<bool>,
    /// The objects that are never culled.
    never_culled: Vec<u32>,
}

impl Occluders {
    /// Makes a prepared scene's occluders ready.
    pub fn new(prepared: &Prepared) -> Occluders {
        let (scene, clusters) = (prepared.scene(), prepared.occluders().clone());
        let triangles = |object: &Object| {
            clusters
                .occluder(object)
                .map_or(0, |mesh| mesh.triangle_count() as u32)
        };
        let is_all = |object: &Object| {
            let surfaces = &scene.meshes()[object.mesh].surfaces;
            object.occluder_mesh() == Some(object.mesh)
                && surfaces.iter().all(|surface| surface.material.occludes())
        };
        let objects = (0..).zip(scene.objects());
        let never_culled = objects.filter(|(_, object)| object.never_cull);
        Occluders {
            never_culled: never_culled.map(|(number, _)| number).collect(),
            is_all: scene.objects().iter().map(is_all).collect(),
            triangles: scene.objects().iter().map(triangles).collect(),
            clusters,
        }
    }

    /// How many triangles an object puts in the way as an occluder; 0 if it is none.
    pub fn triangles_of(&self, object: u32) -> u32 {
        self.triangles[object as usize]
    }

    /// Whether an object's clusters are all that is ever drawn of it: then it is hidden if they are.
    pub fn is_all_of(&self, object: u32) -> bool {
        self.is_all[object as usize]
    }

    /// The objects that are never culled, in scene order.
    pub fn never_culled(&self) -> &[u32] {
        &self.never_culled
    }

    /// The clusters of all of them.
    pub fn clusters(&self) -> &ClusteredScene {
        &self.clusters
    }

    /// What an object is drawn as; none if it is no occluder.
    pub fn mesh_of(&self, object: &Object) -> Option<&ClusteredMesh> {
        self.clusters.occluder(object)
    }
}
