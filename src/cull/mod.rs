//! The frame: from a camera to the set of objects that it may see.
//!
//! Two passes over the hierarchy (HOM §3.2). The first finds the objects in the frustum; the nearest of them are drawn
//! as occluders, front to back, each asked first whether what is drawn already hides it. The second pass tests boxes
//! against the finished buffer, inner nodes before their children: a hidden node ends its subtree.
//!
//! In exact mode the picture of the survivors is the picture of the scene. Every answer "hidden" rests on an occluder
//! surface strictly nearer at each sample the object could own; the nearest surface at a sample is never culled by
//! it, since nothing is strictly nearer there.

mod statistics;
mod traverse;

use std::sync::Arc;
use std::time::Instant;

use antumbra_simd::triangle::Triangle;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::occluders::{Budget, nearest_first, occluder_mesh, occluder_triangles, occludes};
use crate::occlusion::{Accuracy, Footprint, OcclusionBuffer, ProjectedBox};
use crate::raster::ObjectAssembler;
use crate::scene::Scene;
use crate::view::{Camera, Frustum, PictureSize};

pub use antumbra_simd::{Level, LevelUnavailable};
pub use statistics::{StageTimes, Statistics};

/// Objects that are asked, and then drawn, together. An answer sees only what whole batches before its own have
/// drawn, so that any number of threads gives the same one.
const OBJECTS_PER_BATCH: usize = 16;

/// How to cull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The final picture's size.
    pub size: PictureSize,
    /// What may be lost.
    pub accuracy: Accuracy,
    /// How many triangles may be drawn as occluders.
    pub budget: Budget,
    /// Threads to use; 0: as many as the machine runs at once.
    pub threads: usize,
    /// The instruction set.
    pub level: Level,
}

impl Settings {
    /// Exact, without a budget, on all threads.
    pub fn new(size: PictureSize) -> Settings {
        Settings {
            size,
            accuracy: Accuracy::Exact,
            budget: Budget::All,
            threads: 0,
            level: Level::best(),
        }
    }
}

/// What a camera may see, and what finding it took.
#[derive(Clone, Debug, Default)]
pub struct VisibleSet {
    /// Objects in the frustum, in scene order.
    pub in_frustum: Vec<u32>,
    /// Those that are not culled, in scene order.
    pub visible: Vec<u32>,
    /// Those that were drawn as occluders, in the order they were drawn. May hold some that were found hidden after.
    pub occluders: Vec<u32>,
    /// Counts.
    pub statistics: Statistics,
    /// Times.
    pub times: StageTimes,
}

/// Culls a scene, frame by frame.
#[derive(Debug)]
pub struct Culler {
    scene: Arc<Scene>,
    settings: Settings,
    pool: ThreadPool,
    buffer: Option<OcclusionBuffer>,
}

impl Culler {
    /// A culler for a scene.
    ///
    /// # Errors
    /// If the operating system gives no threads.
    pub fn new(scene: Arc<Scene>, settings: Settings) -> Result<Culler, ThreadPoolBuildError> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(settings.threads)
            .build()?;
        Ok(Culler {
            scene,
            settings,
            pool,
            buffer: None,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// How many threads are used.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// What the last frame drew; none before the first.
    pub fn buffer(&self) -> Option<&OcclusionBuffer> {
        self.buffer.as_ref()
    }

    /// Finds what a camera may see.
    pub fn cull(&mut self, camera: &Camera) -> VisibleSet {
        let mut buffer = self.buffer.take();
        let set = self.pool.install(|| {
            let buffer =
                buffer.get_or_insert_with(|| OcclusionBuffer::new(self.settings.size, *camera));
            frame(&self.scene, &self.settings, camera, buffer)
        });
        self.buffer = buffer;
        set
    }
}

fn frame(
    scene: &Scene,
    settings: &Settings,
    camera: &Camera,
    buffer: &mut OcclusionBuffer,
) -> VisibleSet {
    let start = Instant::now();
    let frustum = Frustum::new(camera, settings.size);
    let mut in_frustum = traverse::in_frustum(scene, &frustum);
    let mut candidates = in_frustum.clone();
    candidates.retain(|&o| occluder_triangles(scene, &scene.objects()[o as usize]) > 0);
    nearest_first(scene, camera.eye(), &mut candidates);
    in_frustum.sort_unstable();
    let selected = Instant::now();

    buffer.set_accuracy(settings.accuracy);
    buffer.clear(camera);
    let mut statistics = Statistics {
        objects_in_frustum: in_frustum.len() as u64,
        ..Statistics::default()
    };
    let (hidden, occluders) = draw_occluders(
        scene,
        settings,
        camera,
        &candidates,
        buffer,
        &mut statistics,
    );
    let drawn = Instant::now();

    buffer.finish();
    let finished = Instant::now();

    let mut visible = traverse::not_hidden(scene, &frustum, buffer, &hidden, &mut statistics);
    // A hidden inner node may hold objects that are never to be culled.
    visible.extend(
        in_frustum
            .iter()
            .filter(|&&o| scene.objects()[o as usize].never_cull),
    );
    visible.sort_unstable();
    visible.dedup();
    statistics.objects_visible = visible.len() as u64;
    let tested = Instant::now();

    let times = StageTimes {
        select: selected - start,
        raster: drawn - selected,
        pyramid: finished - drawn,
        test: tested - finished,
    };
    VisibleSet {
        in_frustum,
        visible,
        occluders,
        statistics,
        times,
    }
}

/// Whether an object is hidden: by its world box, or by its own.
fn is_hidden(
    scene: &Scene,
    buffer: &OcclusionBuffer,
    object: u32,
    world_box: &ProjectedBox,
) -> bool {
    let by = |b: &ProjectedBox| buffer.test_box(b).is_hidden();
    by(world_box)
        || scene
            .own_box(object as usize)
            .is_some_and(|own| by(&buffer.screen().project_oriented_box(&own.shape, own.growth)))
}

/// Draws candidates in their order, as far as the budget goes, each asked first; says of each object of the scene
/// whether it was found hidden, and which were drawn. What is hidden by a part of the occluders stays hidden behind all of them.
fn draw_occluders(
    scene: &Scene,
    settings: &Settings,
    camera: &Camera,
    candidates: &[u32],
    buffer: &mut OcclusionBuffer,
    statistics: &mut Statistics,
) -> (Vec<bool>, Vec<u32>) {
    let assembler = ObjectAssembler::new(*camera, settings.size);
    let mut hidden = vec![false; scene.objects().len()];
    let mut drawn = Vec::new();
    for batch in candidates.chunks(OBJECTS_PER_BATCH) {
        let answers: Vec<(bool, bool)> = batch
            .par_iter()
            .map(|&object| {
                let world_box = buffer
                    .screen()
                    .project_aabb(&scene.bounds()[object as usize]);
                // From inside an object, or cut open by the near plane, its surface does not hide its proxy.
                let is_whole = world_box.footprint() != Footprint::Unbounded
                    || scene.objects()[object as usize].occluder_proxy.is_none();
                (is_hidden(scene, buffer, object, &world_box), is_whole)
            })
            .collect();
        statistics.occluders_asked += batch.len() as u64;
        let mut to_draw = Vec::with_capacity(batch.len());
        let mut spent = false;
        for (&object, (is_hidden, is_whole)) in batch.iter().zip(answers) {
            let cost = occluder_triangles(scene, &scene.objects()[object as usize]);
            if is_hidden {
                hidden[object as usize] = true;
            } else if !is_whole {
                // Its own mesh may be far beyond any budget: that is what it has a proxy for.
            } else if settings.budget.allows(statistics.occluder_triangles + cost) {
                statistics.occluder_triangles += cost;
                to_draw.push(object);
            } else {
                spent = true;
                break;
            }
        }
        statistics.occluders_drawn += to_draw.len() as u64;
        let triangles: Vec<Vec<Triangle>> = to_draw
            .par_iter()
            .map_init(
                || assembler.clone(),
                |assembler, &object| {
                    let object = &scene.objects()[object as usize];
                    let mut triangles = Vec::new();
                    let mesh = occluder_mesh(scene, object);
                    assembler.assemble(mesh, &object.world_from_local, occludes, |t| {
                        triangles.push(t.triangle);
                    });
                    triangles
                },
            )
            .collect();
        for triangles in &triangles {
            buffer.draw_assembled(triangles);
        }
        drawn.extend(to_draw);
        if spent {
            break;
        }
    }
    (hidden, drawn)
}
