//! Finds what is seen from viewpoints on a grid (HOM §7.5), before any frame.
//!
//! Around each viewpoint the six faces of a cube are drawn as item buffers (`item_buffer`), and the clusters that own most of what is
//! seen for what they cost to draw make the viewpoint's list.
//!
//! **Invariant.** The same scene and settings give the same bits for any number of threads. To spare drawing all of the scene for each
//! face, the culler says which objects may be seen. What it remembers depends on which thread culled which viewpoint before, and so may
//! its answer; the item buffer does not: exact culling leaves the owner of each pixel out of no answer.

mod item_buffer;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use glam::DVec3;
use rayon::prelude::*;

use crate::cull::{Culler, Settings, VisibleSet};
use crate::occluders::{Budget, Selection};
use crate::occlusion::Accuracy;
use crate::prepare::{
    ClusterId, GridLayout, MOST_CLUSTERS_PER_VIEWPOINT, SampledCluster, VisibilityGrid,
    VisibilityGridError,
};
use crate::view::{Camera, MapScale, PictureSize, Projection, Slack};

use item_buffer::ItemBuffer;

/// So many viewpoints in a row are one task: each is culled with what the one before needed.
const VIEWPOINTS_PER_TASK: usize = 16;

/// The near planes of the cube's faces stand so many times nearer than the next viewpoint.
const SPACING_BEYOND_NEAR: f64 = 1000.0;

/// How to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplingSettings {
    /// Where the viewpoints stand.
    pub layout: GridLayout,
    /// Pixels along the edge of a face of the cube.
    pub face: PictureSize,
    /// Clusters in a viewpoint's list at most; above [`MOST_CLUSTERS_PER_VIEWPOINT`] means that.
    pub most_clusters: usize,
    /// What owns less than this is left out, in steradians; the whole sphere is 4π.
    pub least_solid_angle: f64,
}

impl SamplingSettings {
    /// Viewpoints there, with faces of 256 pixels and lists of up to 2,048 clusters.
    ///
    /// # Panics
    /// Never: 256 pixels are a possible size.
    pub fn new(layout: GridLayout) -> SamplingSettings {
        SamplingSettings {
            layout,
            face: PictureSize::new(256, 256).expect("a possible size"),
            most_clusters: 2_048,
            least_solid_angle: 0.0,
        }
    }
}

/// Where the six faces look, and what is up on each.
const FACES: [[DVec3; 2]; 6] = [
    [DVec3::X, DVec3::Y],
    [DVec3::NEG_X, DVec3::Y],
    [DVec3::Y, DVec3::Z],
    [DVec3::NEG_Y, DVec3::Z],
    [DVec3::Z, DVec3::Y],
    [DVec3::NEG_Z, DVec3::Y],
];

/// Finds what is seen of a culler's scene, on rayon's current threads; calls `on_viewpoints` with the number of viewpoints done and of
/// all, in any order.
///
/// # Errors
/// If the layout cannot be used, or the operating system gives no threads.
pub fn sample_visibility(
    culler: &Culler,
    settings: &SamplingSettings,
    on_viewpoints: impl Fn(usize, usize) + Sync,
) -> Result<VisibilityGrid, VisibilityGridError> {
    settings.layout.check()?;
    let viewpoints = settings.layout.viewpoints() as usize;
    let idle: Mutex<Vec<Sampler>> = Mutex::new(Vec::new());
    let done = AtomicUsize::new(0);
    on_viewpoints(0, viewpoints);
    let tasks = 0..viewpoints.div_ceil(VIEWPOINTS_PER_TASK);
    let lists: Result<Vec<Vec<Vec<SampledCluster>>>, VisibilityGridError> = tasks
        .into_par_iter()
        .map(|task| {
            let lock = || idle.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            let from = lock().pop();
            let mut sampler = match from {
                Some(sampler) => sampler,
                None => Sampler::new(culler, settings)?,
            };
            let first = task * VIEWPOINTS_PER_TASK;
            let numbers = first..viewpoints.min(first + VIEWPOINTS_PER_TASK);
            let lists = numbers.map(|number| {
                let list = sampler.sample(settings.layout.viewpoint(number));
                on_viewpoints(done.fetch_add(1, Relaxed) + 1, viewpoints);
                list
            });
            let lists = lists.collect();
            lock().push(sampler);
            Ok(lists)
        })
        .collect();
    VisibilityGrid::new(settings.layout, &lists?.concat())
}

/// What one thread samples with.
struct Sampler {
    settings: SamplingSettings,
    projection: Projection,
    /// One for each face: what it remembers is of the same direction.
    cullers: Vec<Culler>,
    found: VisibleSet,
    items: ItemBuffer,
    /// What each face shows, one after the other.
    seen: Vec<(ClusterId, f64)>,
}

impl Sampler {
    fn new(culler: &Culler, settings: &SamplingSettings) -> Result<Sampler, VisibilityGridError> {
        let for_face = Settings {
            accuracy: Accuracy::Exact,
            map_scale: MapScale::Full,
            slack: Slack::NONE,
            occluders: Selection::Contribution,
            budget: Budget::Auto,
            threads: 1,
            ..Settings {
                size: settings.face,
                ..*culler.settings()
            }
        };
        let cullers = FACES.map(|_| culler.another(for_face));
        let cullers: Result<Vec<Culler>, _> = cullers.into_iter().collect();
        Ok(Sampler {
            settings: *settings,
            projection: Projection::Perspective {
                fov_y: std::f64::consts::FRAC_PI_2,
                near: (settings.layout.spacing / SPACING_BEYOND_NEAR).max(1e-30),
                far: None,
            },
            cullers: cullers.map_err(|e| VisibilityGridError::Threads(e.to_string()))?,
            found: VisibleSet::default(),
            items: ItemBuffer::new(settings.face),
            seen: Vec::new(),
        })
    }

    /// The list of a viewpoint.
    fn sample(&mut self, eye: DVec3) -> Vec<SampledCluster> {
        self.seen.clear();
        for ([forward, up], culler) in FACES.into_iter().zip(&mut self.cullers) {
            // Where coordinates are too large for a step of one unit, nothing is seen.
            let reach = eye.abs().max_element().max(1.0);
            let Ok(camera) = Camera::look_at(eye, eye + forward * reach, up, self.projection)
            else {
                continue;
            };
            culler.cull_into(&camera, &mut self.found);
            if let Some(buffer) = culler.buffer() {
                let (scene, clusters) = (culler.scene(), culler.clusters());
                self.items
                    .draw(scene, clusters, &self.found.visible, buffer);
                self.items.add_up(&mut self.seen);
            }
        }
        // Stable: what faces add stays in the order of faces, and sums round alike.
        self.seen.sort_by_key(|&(id, _)| id);
        let of_cluster = self.seen.chunk_by(|a, b| a.0 == b.0);
        let sums = of_cluster.map(|faces| SampledCluster {
            id: faces[0].0,
            solid_angle: faces.iter().map(|&(_, angle)| angle).sum::<f64>() as f32,
        });
        let least = self.settings.least_solid_angle as f32;
        let mut list: Vec<SampledCluster> = sums.filter(|s| s.solid_angle >= least).collect();
        let most = self.settings.most_clusters.min(MOST_CLUSTERS_PER_VIEWPOINT);
        if list.len() > most {
            let culler = &self.cullers[0];
            list.sort_by_cached_key(|seen| {
                let object = &culler.scene().objects()[seen.id.object as usize];
                let mesh = culler.clusters().occluder(object);
                let triangles = mesh.map_or(0, |mesh| {
                    mesh.clusters()[seen.id.cluster as usize].triangle_count
                });
                // Numbers that are not negative sort as their bits do.
                (!seen.worth(triangles.into()).to_bits(), seen.id)
            });
            list.truncate(most);
            list.sort_unstable_by_key(|seen| seen.id);
        }
        list
    }
}
