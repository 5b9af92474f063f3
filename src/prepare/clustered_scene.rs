//! The clusters of every mesh that occludes in a scene.

use rayon::prelude::*;

use super::ClusteredMesh;
use crate::scene::{Object, Scene};

/// One [`ClusteredMesh`] for each mesh that an object of a scene is drawn as when it is an occluder. Objects that share
/// a mesh share its clusters.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusteredScene {
    /// As many as the scene's meshes.
    meshes: Vec<Option<ClusteredMesh>>,
}

/// What clusters take, in memory and in number; a mesh counts once however many objects share it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// All of it, in bytes.
    pub bytes: usize,
    /// The clusters.
    pub clusters: usize,
    /// Their triangles.
    pub triangles: usize,
}

impl MemoryUse {
    /// Bytes a triangle; 0 if there is none.
    pub fn bytes_per_triangle(self) -> f64 {
        self.bytes as f64 / self.triangles.max(1) as f64
    }

    /// Bytes a cluster; 0 if there is none.
    pub fn bytes_per_cluster(self) -> f64 {
        self.bytes as f64 / self.clusters.max(1) as f64
    }
}

impl ClusteredScene {
    /// Clusters a scene's occluders, with rayon's current threads. The result is the same for any number of them.
    pub fn new(scene: &Scene) -> ClusteredScene {
        let occludes = ClusteredScene::occluding_meshes(scene);
        let meshes = scene.meshes().par_iter().zip(&occludes);
        ClusteredScene {
            meshes: meshes
                .map(|(mesh, &occludes)| {
                    let clustered = occludes.then(|| ClusteredMesh::new(mesh));
                    clustered.filter(|c| !c.clusters().is_empty())
                })
                .collect(),
        }
    }

    /// Which of a scene's meshes an object is drawn as when it is an occluder.
    pub(super) fn occluding_meshes(scene: &Scene) -> Vec<bool> {
        let mut occludes = vec![false; scene.meshes().len()];
        let occluders = scene.objects().iter().filter_map(Object::occluder_mesh);
        occluders.for_each(|mesh| occludes[mesh] = true);
        occludes
    }

    /// Those of each mesh, in the order of the scene's; none that has no cluster.
    pub(super) fn of(meshes: Vec<Option<ClusteredMesh>>) -> ClusteredScene {
        ClusteredScene { meshes }
    }

    /// The clusters of a mesh, by its index in [`Scene::meshes`]. None if no object occludes by it, if none of its
    /// surfaces occludes, or if there is no such mesh.
    pub fn mesh(&self, index: usize) -> Option<&ClusteredMesh> {
        self.meshes.get(index)?.as_ref()
    }

    /// The clusters to draw for an object of the scene when it is an occluder: its proxy's or its own mesh's, in its
    /// local coordinates. None if it hides nothing.
    pub fn occluder(&self, object: &Object) -> Option<&ClusteredMesh> {
        self.mesh(object.occluder_mesh()?)
    }

    /// What the clusters take.
    pub fn memory_use(&self) -> MemoryUse {
        let meshes = self.meshes.iter().flatten();
        meshes.fold(MemoryUse::default(), |sum, mesh| MemoryUse {
            bytes: sum.bytes + mesh.memory_bytes(),
            clusters: sum.clusters + mesh.clusters().len(),
            triangles: sum.triangles + mesh.triangle_count(),
        })
    }
}
