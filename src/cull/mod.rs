//! The frame: from a camera to the set of objects that it may see.
//!
//! The hierarchy gives the objects in the frustum (HOM §3.2). The nearest are drawn as occluders, batch after batch, each
//! asked first whether what is drawn already hides it; now and then whole nodes are asked, and a hidden one answers for
//! all below it (`draw`, `traverse`). What is left is asked once more against the finished buffer.
//!
//! In exact mode the picture of the survivors is the picture of the scene. Every answer "hidden" rests on an occluder
//! surface strictly nearer at each sample the object could own; the nearest surface at a sample is never culled by
//! it, since nothing is strictly nearer there.

mod ask;
mod draw;
mod occluders;
mod rounds;
mod statistics;
mod test;
mod traverse;
mod waiting;

use std::sync::Arc;
use std::time::Instant;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::occluders::{Budget, distance_keys};
use crate::occlusion::{Accuracy, OcclusionBuffer};
use crate::scene::Scene;
use crate::tasks::{Record, Stage, Tasks, Work, stay_awake};
use crate::view::{Camera, Frustum, PictureSize};

use draw::{DrawMemory, Drawn, draw_occluders};
use occluders::Occluders;
use test::{TestMemory, not_hidden};
use traverse::{FrustumMemory, Subtrees};

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
    /// None for one thread: the caller's own does it all.
    pool: Option<ThreadPool>,
    state: State,
}

/// All of a culler but its threads.
#[derive(Debug)]
struct State {
    scene: Arc<Scene>,
    settings: Settings,
    occluders: Occluders,
    subtrees: Subtrees,
    buffer: Option<OcclusionBuffer>,
    memory: Memory,
}

/// What a frame is made of, but for what it changes.
#[derive(Clone, Copy, Debug)]
struct Frame<'a> {
    scene: &'a Scene,
    occluders: &'a Occluders,
    subtrees: &'a Subtrees,
    settings: &'a Settings,
    tasks: Tasks<'a>,
}

/// What is kept from frame to frame, so that none allocates.
#[derive(Debug, Default)]
struct Memory {
    draw: DrawMemory,
    frustum: FrustumMemory,
    /// The keys of the occluders in the frustum, as tasks found them.
    candidates: Vec<Vec<u64>>,
    test: TestMemory,
    hidden: Vec<bool>,
}

/// What task `task` of several takes, of `items` that are handed out by `share`.
fn share_of<T>(items: &[T], share: usize, task: usize) -> &[T] {
    items.chunks(share).nth(task).unwrap_or_default()
}

/// Makes sure that there are `count` things; those that are more than that are kept.
fn grow<T: Default>(things: &mut Vec<T>, count: usize) {
    if things.len() < count {
        things.resize_with(count, T::default);
    }
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
            pool: (pool.current_num_threads() > 1).then_some(pool),
            state: State {
                subtrees: Subtrees::new(&scene),
                scene,
                settings,
                occluders,
                buffer: None,
                memory: Memory::default(),
            },
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.state.scene
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.state.settings
    }

    /// How many threads are used.
    pub fn threads(&self) -> usize {
        self.pool
            .as_ref()
            .map_or(1, ThreadPool::current_num_threads)
    }

    /// What the last frame drew; none before the first.
    pub fn buffer(&self) -> Option<&OcclusionBuffer> {
        self.state.buffer.as_ref()
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
        let state = &mut self.state;
        match &self.pool {
            None => state.frame(Tasks::ALONE, camera, found),
            Some(pool) => {
                let tasks = Tasks::shared(pool.current_num_threads());
                pool.install(|| stay_awake(|| state.frame(tasks, camera, found)));
            }
        }
    }

    /// Finds what a camera may see, on the calling thread alone but in the tasks that a frame on so many threads would
    /// have, and says what each took.
    pub fn cull_recorded(
        &mut self,
        camera: &Camera,
        threads: usize,
        found: &mut VisibleSet,
    ) -> Vec<Stage> {
        let record = Record::start();
        let tasks = Tasks::recorded(threads, &record);
        self.state.frame(tasks, camera, found);
        record.finish()
    }
}

impl State {
    fn frame(&mut self, tasks: Tasks<'_>, camera: &Camera, found: &mut VisibleSet) {
        let State {
            scene,
            settings,
            occluders,
            subtrees,
            buffer,
            memory,
        } = self;
        let frame = Frame {
            scene,
            occluders,
            subtrees,
            settings,
            tasks,
        };
        let buffer = buffer.get_or_insert_with(|| OcclusionBuffer::new(settings.size, *camera));
        frame.run(camera, buffer, memory, found);
    }
}

/// Each thread has so many tasks of finding keys,
const KEY_TASKS_PER_THREAD: usize = 4;
/// each for at least so many objects.
const FEWEST_KEYS: usize = 128;

impl Frame<'_> {
    /// The keys of the occluders among objects.
    fn candidates<'m>(
        &self,
        camera: &Camera,
        objects: &[u32],
        memory: &'m mut Vec<Vec<u64>>,
    ) -> &'m mut Vec<u64> {
        let share = match self.tasks.threads() {
            1 => objects.len().max(1),
            threads => objects
                .len()
                .div_ceil(KEY_TASKS_PER_THREAD * threads)
                .max(FEWEST_KEYS),
        };
        let count = objects.len().div_ceil(share).max(1);
        grow(memory, count);
        let keys = &mut memory[..count];
        self.tasks.each(Work::Select, keys, |task, keys| {
            let occludes = |object: &u32| self.occluders.triangles_of(*object) > 0;
            let objects = share_of(objects, share, task).iter().copied();
            distance_keys(self.scene, camera.eye(), objects.filter(occludes), keys);
        });
        let (first, others) = memory.split_at_mut(1);
        for others in &others[..count - 1] {
            first[0].extend_from_slice(others);
        }
        &mut first[0]
    }

    fn run(
        &self,
        camera: &Camera,
        buffer: &mut OcclusionBuffer,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        let start = Instant::now();
        let &Frame {
            scene,
            settings,
            tasks,
            ..
        } = self;
        let VisibleSet {
            in_frustum,
            visible,
            occluders: drawn_occluders,
            statistics,
            times,
        } = found;
        let frustum = Frustum::new(camera, settings.size);
        traverse::in_frustum(self, &frustum, &mut memory.frustum, in_frustum);
        let candidates = self.candidates(camera, in_frustum, &mut memory.candidates);
        let selected = Instant::now();

        buffer.set_accuracy(settings.accuracy);
        buffer.set_level(settings.level);
        buffer.clear_by(tasks, camera);
        *statistics = Statistics {
            objects_in_frustum: in_frustum.len() as u64,
            ..Statistics::default()
        };
        let hidden = &mut memory.hidden;
        hidden.clear();
        hidden.resize(scene.objects().len(), false);
        drawn_occluders.clear();
        draw_occluders(
            self,
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

        tasks.alone(Work::Finish, || buffer.finish());
        let finished = Instant::now();

        let undecided = |&&object: &&u32| {
            !memory.hidden[object as usize] || scene.objects()[object as usize].never_cull
        };
        let undecided = in_frustum.iter().filter(undecided);
        not_hidden(self, undecided, buffer, &mut memory.test, visible);
        statistics.objects_tested = memory.test.tested() as u64;
        statistics.objects_visible = visible.len() as u64;
        let tested = Instant::now();

        *times = StageTimes {
            select: selected - start,
            raster: drawn - selected,
            pyramid: finished - drawn,
            test: tested - finished,
        };
    }
}
