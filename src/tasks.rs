//! The work of a frame in tasks: done by one thread or by several, and recorded if somebody wants to know what each took.
//!
//! A frame is a row of stages, and a stage a row of tasks that do not depend on each other. Every task writes to a place of
//! its own, named by its number, and what comes after reads those places in their order: so nothing is locked, nothing
//! is allocated once the places are as large as they will be, and no answer depends on who did what when.
//!
//! A stage often takes a few microseconds. A thread that went to sleep between two of them would need longer than that to
//! wake up, so all stay awake until the frame is done ([`stay_awake`]).

use std::cell::Cell;
use std::fmt;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rayon::Yield;

/// What a stage is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Finds what is in the frustum, and sorts occluders.
    Select,
    /// Empties the buffer.
    Clear,
    /// Asks whole groups of objects.
    Look,
    /// Asks occluders.
    Ask,
    /// Asks occluders' clusters.
    AskClusters,
    /// Sets triangles up.
    Assemble,
    /// Fills triangles into rows of tiles.
    Fill,
    /// Builds the pyramid.
    Finish,
    /// Asks what is left in the end.
    Test,
    /// What is done between stages.
    Between,
}

impl fmt::Display for Work {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Work::Select => "select",
            Work::Clear => "clear",
            Work::Look => "look",
            Work::Ask => "ask",
            Work::AskClusters => "ask clusters",
            Work::Assemble => "assemble",
            Work::Fill => "fill",
            Work::Finish => "finish",
            Work::Test => "test",
            Work::Between => "between",
        })
    }
}

/// Tasks that do not depend on each other, and wait for all stages before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stage {
    /// What it is for.
    pub work: Work,
    /// What each task took.
    pub tasks: Vec<Duration>,
}

/// How a frame's work is done.
#[derive(Clone, Copy, Debug)]
pub struct Tasks<'a> {
    threads: usize,
    record: Option<&'a Record>,
}

impl<'a> Tasks<'a> {
    /// By the calling thread alone.
    pub const ALONE: Tasks<'static> = Tasks {
        threads: 1,
        record: None,
    };

    /// By so many threads: all those of the pool that the calling thread belongs to.
    pub fn shared(threads: usize) -> Tasks<'a> {
        Tasks {
            threads,
            record: None,
        }
    }

    /// By the calling thread alone, but cut into tasks as for so many threads, and recorded.
    pub fn recorded(threads: usize, record: &'a Record) -> Tasks<'a> {
        Tasks {
            threads,
            record: Some(record),
        }
    }

    /// The same, but with each stage as for one thread.
    pub fn by_one(self) -> Tasks<'a> {
        Tasks { threads: 1, ..self }
    }

    /// How many threads the work is cut for.
    pub fn threads(self) -> usize {
        self.threads
    }

    /// A stage with a task for each item; tasks are given their item's number.
    pub fn each<T: Send>(self, work: Work, items: &mut [T], task: impl Fn(usize, &mut T) + Sync) {
        self.divide(
            work,
            items.len(),
            (0, items),
            |(first, items), count| {
                let (a, b) = items.split_at_mut(count);
                ((first, a), (first + count, b))
            },
            |(first, items)| items.iter_mut().for_each(|item| task(first, item)),
        );
    }

    /// A stage of `count` tasks. `split(items, n)` separates the first `n` from the rest.
    pub fn divide<T: Send>(
        self,
        work: Work,
        count: usize,
        items: T,
        split: impl Fn(T, usize) -> (T, T) + Sync,
        task: impl Fn(T) + Sync,
    ) {
        if count == 0 {
            return;
        }
        if self.threads > 1 && self.record.is_none() {
            return halve(count, items, &split, &task);
        }
        let mut stage = self.record.map(|record| record.begin(work, count));
        let mut rest = items;
        for _ in 1..count {
            let (first, others) = split(rest, 1);
            task(first);
            if let Some(stage) = &mut stage {
                stage.task_done();
            }
            rest = others;
        }
        task(rest);
        if let Some(mut stage) = stage {
            stage.task_done();
            stage.end();
        }
    }

    /// A stage that is one task.
    pub fn alone<R>(self, work: Work, task: impl FnOnce() -> R) -> R {
        let Some(record) = self.record else {
            return task();
        };
        let mut stage = record.begin(work, 1);
        let result = task();
        stage.task_done();
        stage.end();
        result
    }
}

fn halve<T: Send>(
    count: usize,
    items: T,
    split: &(impl Fn(T, usize) -> (T, T) + Sync),
    task: &(impl Fn(T) + Sync),
) {
    if count == 1 {
        return task(items);
    }
    let (a, b) = split(items, count / 2);
    rayon::join(
        || halve(count / 2, a, split, task),
        || within_a_stage(|| halve(count - count / 2, b, split, task)),
    );
}

thread_local! {
    /// Whether the current thread is doing a part of a stage, or waits within one for another thread.
    static IS_WITHIN_A_STAGE: Cell<bool> = const { Cell::new(false) };
}

fn within_a_stage(part: impl FnOnce()) {
    let before = IS_WITHIN_A_STAGE.replace(true);
    part();
    IS_WITHIN_A_STAGE.set(before);
}

/// What the tasks of a frame took.
#[derive(Debug)]
pub struct Record(Mutex<Recorded>);

#[derive(Debug)]
struct Recorded {
    stages: Vec<Stage>,
    /// When the last stage ended.
    since: Instant,
}

impl Record {
    /// Of a frame that begins now.
    pub fn start() -> Record {
        Record(Mutex::new(Recorded {
            stages: Vec::with_capacity(1024),
            since: Instant::now(),
        }))
    }

    /// Of a frame that ends now: its stages.
    pub fn finish(self) -> Vec<Stage> {
        let end = Instant::now();
        let Recorded { mut stages, since } = self
            .0
            .into_inner()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        stages.push(Stage {
            work: Work::Between,
            tasks: vec![end - since],
        });
        stages
    }

    fn begin(&self, work: Work, tasks: usize) -> Recording<'_> {
        let begin = Instant::now();
        let stage = Stage {
            work,
            tasks: Vec::with_capacity(tasks),
        };
        Recording {
            record: self,
            stage,
            begin,
            since: Instant::now(),
        }
    }
}

/// A stage that is being recorded.
struct Recording<'a> {
    record: &'a Record,
    stage: Stage,
    begin: Instant,
    since: Instant,
}

impl Recording<'_> {
    fn task_done(&mut self) {
        let now = Instant::now();
        self.stage.tasks.push(now - self.since);
        self.since = now;
    }

    fn end(self) {
        if let Ok(mut recorded) = self.record.0.lock() {
            let between = self.begin - recorded.since;
            recorded.stages.push(Stage {
                work: Work::Between,
                tasks: vec![between],
            });
            recorded.stages.push(self.stage);
            recorded.since = Instant::now();
        }
    }
}

/// How often a thread looks for work before it lets others of the machine go first.
const LOOKS_BEFORE_YIELD: u32 = 256;

/// Runs a frame on the current thread of a pool, and keeps the pool's others looking for its tasks until it is done.
pub fn stay_awake(frame: impl FnOnce() + Send) {
    let done = AtomicBool::new(false);
    let frame_thread = rayon::current_thread_index();
    rayon::in_place_scope(|scope| {
        scope.spawn_broadcast(|_, context| {
            // One that waits within a stage, and finds this instead of what it waits for, would let the frame wait for it.
            if Some(context.index()) != frame_thread && !IS_WITHIN_A_STAGE.get() {
                look_for_work(&done);
            }
        });
        // Others must not wait for ever if the frame panics.
        let _end = SetOnDrop(&done);
        frame();
    });
}

fn look_for_work(done: &AtomicBool) {
    let mut looks = 0;
    while !done.load(Ordering::Acquire) {
        if rayon::yield_now() == Some(Yield::Executed) {
            looks = 0;
            continue;
        }
        looks += 1;
        if looks % LOOKS_BEFORE_YIELD == 0 {
            std::thread::yield_now();
        }
        std::hint::spin_loop();
    }
}

struct SetOnDrop<'a>(&'a AtomicBool);

impl Drop for SetOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thread that waits within a task for another thread must not begin to look for work until the frame is done: the
    /// frame would wait for its task. This hung within a minute while it could.
    #[test]
    fn short_frames_end() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
        let pool = pool.expect("threads");
        let mut sums = [0_u32; 64];
        for frame in 0..100_000_u32 {
            pool.install(|| {
                stay_awake(|| {
                    Tasks::shared(2).each(Work::Clear, &mut sums, |_, sum| {
                        (0..frame % 64).for_each(|_| std::hint::spin_loop());
                        *sum += 1;
                    });
                });
            });
        }
        assert_eq!(sums, [100_000; 64]);
    }
}
