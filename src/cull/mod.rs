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
mod covers;
mod draw;
mod gaps;
mod marks;
mod occluders;
mod recall;
mod rounds;
mod seen;
mod statistics;
mod test;
mod traverse;
mod waiting;

use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::occluders::{
    Budget, Contributions, DrawnCluster, Selection, distance_keys, keep_promising,
};
use crate::occlusion::{Accuracy, Footprint, OcclusionBuffer};
use crate::scene::Scene;
use crate::tasks::{Record, Stage, Tasks, Work, stay_awake};
use crate::view::{Camera, Containment, Frustum, PictureSize, Planes};

use draw::{DrawMemory, Drawn, draw_occluders, draw_remembered, draw_what_closes_gaps};
use marks::Marks;
use occluders::Occluders;
use seen::Seen;
use test::{Kept, LookMemory, TestMemory, look_closely, not_hidden};
use traverse::{FrustumMemory, Subtrees, TraverseMemory, not_hidden_so_far};

pub use antumbra_simd::{Level, LevelUnavailable};
pub use statistics::{StageTimes, Statistics};

/// How to cull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The final picture's size.
    pub size: PictureSize,
    /// What may be lost.
    pub accuracy: Accuracy,
    /// How occluders are chosen.
    pub occluders: Selection,
    /// How many triangles may be drawn as occluders.
    pub budget: Budget,
    /// Threads to use; 0: as many as the machine runs at once.
    pub threads: usize,
    /// The instruction set.
    pub level: Level,
}

impl Settings {
    /// Exact, by contribution, with a budget chosen by counted work, on all threads.
    pub fn new(size: PictureSize) -> Settings {
        Settings {
            size,
            accuracy: Accuracy::Exact,
            occluders: Selection::default(),
            budget: Budget::default(),
            threads: 0,
            level: Level::best(),
        }
    }
}

/// What a camera may see, and what finding it took.
#[derive(Clone, Debug, Default)]
pub struct VisibleSet {
    /// The objects in the frustum that are not culled, in scene order.
    pub visible: Vec<u32>,
    /// The clusters that were drawn as occluders, in the order they were drawn. May hold some of objects that were found hidden
    /// after.
    pub occluders: Vec<DrawnCluster>,
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
    remembered: Remembered,
    memory: Memory,
}

/// What a frame knows of those before it: what they needed, and what could be seen. It chooses occluders, and hides nothing.
#[derive(Clone, Debug, Default)]
pub struct Remembered {
    contributions: Contributions,
    seen: Seen,
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
    traverse: TraverseMemory,
    in_frustum: Vec<u32>,
    /// The objects that are not known to be hidden.
    undecided: Vec<(u32, Footprint)>,
    kept: Vec<Kept>,
    look: LookMemory,
    /// The keys of the occluders in the frustum, as tasks found them.
    candidates: Vec<Vec<u64>>,
    test: TestMemory,
    hidden: Marks,
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
                remembered: Remembered::default(),
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

    /// What the next frame knows of those before it.
    pub fn remembered(&self) -> &Remembered {
        &self.state.remembered
    }

    /// Goes back to what an earlier frame knew of those before it.
    pub fn recall(&mut self, remembered: &Remembered) {
        self.state.remembered.clone_from(remembered);
    }

    /// Forgets all frames.
    pub fn forget(&mut self) {
        self.state.remembered.clear();
    }

    /// The objects whose boxes are not wholly outside one plane of a camera's frustum, in scene order: those that culling
    /// chooses from. (A frame does not look at all of them.)
    pub fn in_frustum(&self, camera: &Camera) -> Vec<u32> {
        let frustum = Frustum::new(camera, self.state.settings.size);
        let mut found = Vec::new();
        let frame = self.state.frame_of(Tasks::ALONE);
        traverse::in_frustum(&frame, &frustum, &mut FrustumMemory::default(), &mut found);
        found
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

impl Remembered {
    fn clear(&mut self) {
        self.contributions.clear();
        self.seen.clear();
    }
}

impl State {
    fn frame_of<'a>(&'a self, tasks: Tasks<'a>) -> Frame<'a> {
        Frame {
            scene: &self.scene,
            occluders: &self.occluders,
            subtrees: &self.subtrees,
            settings: &self.settings,
            tasks,
        }
    }

    fn frame(&mut self, tasks: Tasks<'_>, camera: &Camera, found: &mut VisibleSet) {
        let State {
            scene,
            settings,
            occluders,
            subtrees,
            buffer,
            remembered,
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
        frame.run(camera, buffer, remembered, memory, found);
    }
}

/// Of so many objects, a frame that remembers nothing draws what is promising, before it closes gaps.
const FIRST_OCCLUDERS: usize = 64;

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
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        let mut clock = Clock::start();
        let &Frame {
            scene,
            settings,
            tasks,
            ..
        } = self;
        let VisibleSet {
            visible,
            occluders,
            statistics,
            times,
        } = found;
        *statistics = Statistics::default();
        *times = StageTimes::default();
        occluders.clear();
        let objects = scene.objects().len();
        remembered.seen.begin_frame(scene);
        memory.hidden.clear(objects);
        buffer.set_accuracy(settings.accuracy);
        buffer.set_level(settings.level);
        buffer.clear_by(tasks, camera);
        let Remembered {
            contributions,
            seen,
            ..
        } = remembered;
        let mut drawn = Drawn {
            hidden: &mut memory.hidden,
            occluders,
            contributions,
            statistics,
        };
        // Where everything is drawn there is nothing to choose.
        let learns =
            settings.occluders == Selection::Contribution && settings.budget != Budget::All;
        if learns {
            if drawn.contributions.is_empty() {
                let frustum = Frustum::new(camera, settings.size);
                let in_frustum = &mut memory.in_frustum;
                traverse::in_frustum(self, &frustum, &mut memory.frustum, in_frustum);
                let candidates = self.candidates(camera, in_frustum, &mut memory.candidates);
                keep_promising(scene, camera.eye(), candidates, FIRST_OCCLUDERS, |object| {
                    self.occluders.triangles_of(object)
                });
                clock.lap(&mut times.select);
                draw_occluders(self, candidates, buffer, &mut memory.draw, &mut drawn);
                for cluster in drawn.occluders.iter().filter(|cluster| cluster.gain > 0) {
                    let &DrawnCluster { id, triangles, gain } = cluster;
                    drawn.contributions.needed(id, triangles, gain);
                }
            } else {
                draw_remembered(self, buffer, &mut memory.draw, &mut drawn);
                drawn.statistics.clusters_remembered = drawn.occluders.len() as u64;
            }
            clock.lap(&mut times.raster);
            let undecided = &mut memory.undecided;
            tasks.alone(Work::Look, || buffer.find_blocks());
            let traverse = &mut memory.traverse;
            not_hidden_so_far(self, seen, buffer, traverse, undecided, drawn.statistics);
            undecided.sort_unstable_by_key(|(object, _)| *object);
            let kept = &mut memory.kept;
            look_closely(self, seen, undecided, buffer, &mut memory.look, kept);
            clock.lap(&mut times.test);
            let questions = kept.iter().filter_map(|kept| match kept.footprint {
                Footprint::Within(rect) if !seen.is_trusted(kept.object) => {
                    Some((kept.object, rect))
                }
                _ => None,
            });
            draw_what_closes_gaps(
                self,
                buffer,
                undecided,
                questions,
                &mut memory.draw,
                &mut drawn,
            );
            kept.retain(|kept| !drawn.hidden.has(kept.object));
            visible.clear();
            visible.extend(kept.iter().map(|kept| kept.object));
            clock.lap(&mut times.raster);
            tasks.alone(Work::Finish, || buffer.finish());
            clock.lap(&mut times.pyramid);
            statistics.objects_tested = seen.count_in_question(undecided);
            seen.note(&self.subtrees, undecided, kept);
            self.put_back_never_culled(camera, visible);
        } else {
            let frustum = Frustum::new(camera, settings.size);
            let in_frustum = &mut memory.in_frustum;
            traverse::in_frustum(self, &frustum, &mut memory.frustum, in_frustum);
            let candidates = self.candidates(camera, in_frustum, &mut memory.candidates);
            clock.lap(&mut times.select);
            draw_occluders(self, candidates, buffer, &mut memory.draw, &mut drawn);
            clock.lap(&mut times.raster);
            tasks.alone(Work::Finish, || buffer.finish());
            clock.lap(&mut times.pyramid);
            let undecided = |&&object: &&u32| {
                !drawn.hidden.has(object) || scene.objects()[object as usize].never_cull
            };
            let undecided = in_frustum.iter().filter(undecided);
            not_hidden(self, undecided, buffer, &mut memory.test, visible);
            drawn.statistics.objects_tested = memory.test.tested() as u64;
        }
        statistics.objects_visible = visible.len() as u64;
        remembered.contributions.end_frame();
        clock.lap(&mut times.test);
    }

    /// Puts objects back that are never culled.
    fn put_back_never_culled(&self, camera: &Camera, visible: &mut Vec<u32>) {
        let never_culled = self.occluders.never_culled();
        if never_culled.is_empty() {
            return;
        }
        let frustum = Frustum::new(camera, self.settings.size);
        let is_in_it = |object: &&u32| {
            let bounds = &self.scene.bounds()[**object as usize];
            frustum.contains(bounds, Planes::ALL) != Containment::Outside
        };
        visible.extend(never_culled.iter().filter(is_in_it));
        visible.sort_unstable();
        visible.dedup();
    }
}

/// Tells how long stages take.
struct Clock(Instant);

impl Clock {
    fn start() -> Clock {
        Clock(Instant::now())
    }

    /// Adds the time since the last lap.
    fn lap(&mut self, to: &mut Duration) {
        let now = Instant::now();
        *to += now - self.0;
        self.0 = now;
    }
}
