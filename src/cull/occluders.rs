//! What is known of a scene's occluders before any frame.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::Settings;
use crate::occluders::{Contributions, Selection};
use crate::prepare::{
    Bridges, ClusterId, ClusteredMesh, ClusteredScene, OccluderFitness, Prepared, StaticCriteria,
};
use crate::scene::{Alpha, Object, Scene};

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
    /// Those with a translucent surface.
    translucent: Vec<u32>,
    /// Quadrilaterals over the seams of each mesh's clusters, once there is a slack.
    bridges: OnceLock<Vec<Bridges>>,
    /// What of them is worth drawing, once somebody wants to know.
    fitness: OnceLock<OccluderFitness>,
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
        let never_culled = objects.clone().filter(|(_, object)| object.never_cull);
        let is_translucent = |object: &Object| {
            let mut surfaces = scene.meshes()[object.mesh].surfaces.iter();
            !object.never_occlude && surfaces.any(|s| s.material.alpha == Alpha::Blend)
        };
        let translucent = objects.filter(|(_, object)| is_translucent(object));
        Occluders {
            translucent: translucent.map(|(number, _)| number).collect(),
            never_culled: never_culled.map(|(number, _)| number).collect(),
            is_all: scene.objects().iter().map(is_all).collect(),
            triangles: scene.objects().iter().map(triangles).collect(),
            clusters,
            bridges: OnceLock::new(),
            fitness: OnceLock::new(),
        }
    }

    /// Finds out what settings ask of a scene's objects. `by` does the work, and is only called if they ask for something: a thread
    /// that enters another pool takes up other work while it waits, which may be to make another culler.
    pub fn prepare_for(&self, scene: &Scene, settings: &Settings, by: impl Fn(&(dyn Fn() + Sync))) {
        if asks_for_fitness(settings) && self.fitness.get().is_none() {
            by(&|| {
                let fitness = OccluderFitness::new(scene, &self.clusters);
                // If another was quicker, it found the same.
                let _ = self.fitness.set(fitness);
            });
        }
        if !settings.slack.is_none() && self.bridges.get().is_none() {
            let meshes = scene.meshes().len();
            by(&|| {
                let bridges = Bridges::of_scene(&self.clusters, meshes);
                let _ = self.bridges.set(bridges);
            });
        }
    }

    /// Whether an object is among those that may be occluders by settings that are prepared for.
    pub fn is_candidate(&self, object: u32, settings: &Settings) -> bool {
        if self.triangles_of(object) == 0 {
            return false;
        }
        match self.fitness.get() {
            Some(fitness) if asks_for_fitness(settings) => {
                let is_by_weight = settings.occluders == Selection::Weight;
                fitness.is_fit(object, settings.static_criteria)
                    && !(is_by_weight
                        && fitness.compactness(object) < settings.weighing.least_compactness)
            }
            _ => true,
        }
    }

    /// The direction across the largest face of an object, in the world; zero if it has none, or nobody prepared for the question.
    pub fn across_largest_face(&self, object: u32) -> DVec3 {
        self.fitness
            .get()
            .map_or(DVec3::ZERO, |fitness| fitness.across_largest_face(object))
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

    /// The objects that have a translucent surface and may occlude, in scene order.
    pub fn translucent(&self) -> &[u32] {
        &self.translucent
    }

    /// The clusters of all of them.
    pub fn clusters(&self) -> &ClusteredScene {
        &self.clusters
    }

    /// A memory of given clusters, as if a frame had needed them; those of objects that do not occlude are left out.
    ///
    /// # Panics
    /// If there is no such object or cluster.
    pub fn remembered(&self, scene: &Scene, clusters: &[ClusterId]) -> Contributions {
        let mut given = Contributions::default();
        for &id in clusters {
            let object = &scene.objects()[id.object as usize];
            if let Some(mesh) = self.mesh_of(object) {
                let cluster = &mesh.clusters()[id.cluster as usize];
                given.needed(id, u32::from(cluster.triangle_count), 0);
            }
        }
        given.end_frame();
        given
    }

    /// What is drawn besides of a cluster of an object if there is a slack: see [`Bridges`].
    pub fn bridges_of(&self, object: &Object, cluster: usize) -> &[[u8; 4]] {
        match (self.bridges.get(), object.occluder_mesh()) {
            (Some(bridges), Some(mesh)) => bridges[mesh].of(cluster),
            _ => &[],
        }
    }

    /// What an object is drawn as; none if it is no occluder.
    pub fn mesh_of(&self, object: &Object) -> Option<&ClusteredMesh> {
        self.clusters.occluder(object)
    }
}

/// Whether settings choose occluders by what they are. By contribution it is found out what they hide.
fn asks_for_fitness(settings: &Settings) -> bool {
    settings.occluders != Selection::Contribution
        && (settings.static_criteria != StaticCriteria::NONE
            || settings.occluders == Selection::Weight)
}
