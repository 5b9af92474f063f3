//! The frame: from a camera to the set of objects that it may see.
//!
//! The hierarchy gives the objects in the frustum (HOM §3.2). The nearest are drawn as occluders, batch after batch, each
//! asked first whether what is drawn already hides it; now and then whole nodes are asked, and a hidden one answers for
//! all below it (`draw`, `traverse`). What is left is asked once more against the finished buffer.
//!
//! In exact mode the picture of the survivors is the picture of the scene. Every answer "hidden" rests on an occluder
//! surface strictly nearer at each sample the object could own; the nearest surface at a sample is never culled by
//! it, since nothing is strictly nearer there.

mod draw;
mod statistics;
mod traverse;

use std::sync::Arc;
use std::time::Instant;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::occluders::{Budget, nearest_first};
use crate::occlusion::{Accuracy, Footprint, OcclusionBuffer};
use crate::scene::Scene;
use crate::view::{Camera, Frustum, PictureSize};

use draw::{DrawMemory, Drawn, Occluders, draw_occluders};
use traverse::Pending;

pub use antumbra_simd::{Level, LevelUnavailable};
pub use statistics::{StageTimes, Statistics};

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
    occluders: Occluders,
    /// None for one thread: the caller's own does it all.
    pool: Option<ThreadPool>,
    buffer: Option<OcclusionBuffer>,
    memory: Memory,
}

/// What is kept from frame to frame, so that none allocates.
#[derive(Debug, Default)]
struct Memory {
    draw: DrawMemory,
    pending: Vec<Pending>,
    candidates: Vec<u32>,
    keys: Vec<u64>,
    undecided: Vec<u32>,
    footprints: Vec<Footprint>,
    hidden: Vec<bool>,
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
        let occluders = pool.install(|| Occluders::new(&scene));
        Ok(Culler {
            scene,
            settings,
            occluders,
            pool: (pool.current_num_threads() > 1).then_some(pool),
            buffer: None,
            memory: Memory::default(),
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
        self.pool
            .as_ref()
            .map_or(1, ThreadPool::current_num_threads)
    }

    /// What the last frame drew; none before the first.
    pub fn buffer(&self) -> Option<&OcclusionBuffer> {
        self.buffer.as_ref()
    }

    /// Finds what a camera may see.
    pub fn cull(&mut self, camera: &Camera) -> VisibleSet {
        let mut found = VisibleSet::default();
        self.cull_into(camera, &mut found);
        found
    }

    /// Finds what a camera may see, and puts it into the memory of an earlier answer: when frames are alike, none
    /// allocates.
    pub fn cull_into(&mut self, camera: &Camera, found: &mut VisibleSet) {
        let threads = self.threads();
        let Culler {
            scene,
            settings,
            occluders,
            pool,
            buffer,
            memory,
        } = self;
        let buffer = buffer.get_or_insert_with(|| OcclusionBuffer::new(settings.size, *camera));
        let mut frame = || {
            frame(
                scene, occluders, settings, threads, camera, buffer, memory, found,
            );
        };
        match pool {
            None => frame(),
            Some(pool) => pool.install(frame),
        }
    }
}

#[expect(
    clippy::too_many_arguments,
    reason = "the parts of a culler, apart so that each can be borrowed"
)]
fn frame(
    scene: &Scene,
    occluders: &Occluders,
    settings: &Settings,
    threads: usize,
    camera: &Camera,
    buffer: &mut OcclusionBuffer,
    memory: &mut Memory,
    found: &mut VisibleSet,
) {
    let start = Instant::now();
    let VisibleSet {
        in_frustum,
        visible,
        occluders: drawn_occluders,
        statistics,
        times,
    } = found;
    let frustum = Frustum::new(camera, settings.size);
    traverse::in_frustum(scene, &frustum, &mut memory.pending, in_frustum);
    let candidates = &mut memory.candidates;
    candidates.clear();
    candidates.extend(
        in_frustum
            .iter()
            .filter(|&&o| occluders.triangles_of(o) > 0),
    );
    nearest_first(scene, camera.eye(), candidates, &mut memory.keys);
    in_frustum.sort_unstable();
    let selected = Instant::now();

    buffer.set_accuracy(settings.accuracy);
    buffer.set_level(settings.level);
    buffer.clear(camera);
    *statistics = Statistics {
        objects_in_frustum: in_frustum.len() as u64,
        ..Statistics::default()
    };
    let hidden = &mut memory.hidden;
    hidden.clear();
    hidden.resize(scene.objects().len(), false);
    drawn_occluders.clear();
    draw_occluders(
        scene,
        occluders,
        settings,
        threads,
        candidates,
        buffer,
        &mut memory.draw,
        Drawn {
            hidden,
            occluders: drawn_occluders,
            statistics,
        },
    );
    let drawn = Instant::now();

    buffer.finish();
    let finished = Instant::now();

    not_hidden(
        scene, settings, in_frustum, buffer, memory, statistics, visible,
    );
    statistics.objects_visible = visible.len() as u64;
    let tested = Instant::now();

    *times = StageTimes {
        select: selected - start,
        raster: drawn - selected,
        pyramid: finished - drawn,
        test: tested - finished,
    };
}

/// Whether an object is hidden that its world box's footprint alone does not hide: by that box, or by its own.
fn is_hidden(scene: &Scene, buffer: &OcclusionBuffer, object: usize, footprint: Footprint) -> bool {
    buffer.hides_aabb_closely(&scene.bounds()[object], footprint)
        || scene
            .own_box(object)
            .is_some_and(|own| buffer.hides_own_box(&own.shape, own.growth, footprint))
}

/// The objects that all occluders together do not hide, in scene order.
fn not_hidden(
    scene: &Scene,
    settings: &Settings,
    in_frustum: &[u32],
    buffer: &OcclusionBuffer,
    memory: &mut Memory,
    statistics: &mut Statistics,
    visible: &mut Vec<u32>,
) {
    let undecided = &mut memory.undecided;
    undecided.clear();
    undecided.extend(in_frustum.iter().filter(|&&object| {
        !memory.hidden[object as usize] || scene.objects()[object as usize].never_cull
    }));
    statistics.objects_tested = undecided.len() as u64;
    memory.footprints.clear();
    buffer.screen().footprints_of_aabbs(
        settings.level,
        undecided.iter().map(|&o| &scene.bounds()[o as usize]),
        &mut memory.footprints,
    );
    let tests = undecided.iter().zip(&memory.footprints);
    let kept = tests.filter(|&(&object, &footprint)| {
        scene.objects()[object as usize].never_cull
            || !buffer.test(footprint).is_hidden()
                && !is_hidden(scene, buffer, object as usize, footprint)
    });
    visible.clear();
    visible.extend(kept.map(|(&object, _)| object));
}
