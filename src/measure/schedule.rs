//! How long would a frame take on more threads than this machine has?
//!
//! A frame is culled by one thread, but cut into the tasks that it would have on N, and what each task took is recorded
//! ([`Culler::cull_recorded`]). The tasks of each stage are then put on N imagined threads, in their order, each on the one that
//! is free first (R. L. Graham's list scheduling); a stage begins when the one before has ended. The sum of the stages
//! is the time that N threads would take if nothing but the tasks took any.
//!
//! So it is a prediction of what the shape of the work allows, and leaves out what the machine adds: waking the threads up
//! at a frame's beginning, handing out tasks (about a tenth of a microsecond each), and all that threads cost each other, from
//! tiles that move between their caches to the bandwidth of memory and the clock of a busy processor. On the other side, each
//! task is timed with the clock, whose reading takes some tens of nanoseconds.

use std::time::Duration;

use serde::Serialize;

use crate::cull::{Culler, Remembered, VisibleSet};
use crate::tasks::{Stage, Work};
use crate::view::Camera;

/// The numbers of threads that are simulated.
pub const SIMULATED_THREADS: [usize; 6] = [2, 4, 8, 16, 32, 64];

/// A frame is recorded so often for each number of threads.
const REPEATS: usize = 5;

/// How long tasks take on some threads, each begun in its turn on the thread that is free first.
pub fn makespan(tasks: &[Duration], threads: usize) -> Duration {
    let mut free_at = vec![Duration::ZERO; threads.clamp(1, tasks.len().max(1))];
    for &task in tasks {
        if let Some(first_free) = free_at.iter_mut().min() {
            *first_free += task;
        }
    }
    free_at.into_iter().max().unwrap_or_default()
}

/// What some frames would take on a number of threads, together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simulated {
    /// The threads.
    pub threads: usize,
    /// The frames.
    pub frames: u32,
    /// On one thread, as one thread does them.
    pub alone: Duration,
    /// On so many threads.
    pub time: Duration,
    /// For each kind of work, how much of that time threads wait, spread over all of them: what would be won if these stages
    /// fell into equal parts.
    pub waits: Vec<(Work, Duration)>,
}

impl Simulated {
    /// Adds a frame's stages, of which `alone` is the time on one thread.
    pub fn add(&mut self, stages: &[Stage], alone: Duration) {
        self.frames += 1;
        self.alone += alone;
        for stage in stages {
            let time = makespan(&stage.tasks, self.threads);
            let busy: Duration = stage.tasks.iter().sum();
            let wait = time - busy / self.threads as u32;
            self.time += time;
            match self.waits.iter_mut().find(|(work, _)| *work == stage.work) {
                Some((_, sum)) => *sum += wait,
                None => self.waits.push((stage.work, wait)),
            }
        }
    }

    /// How many times as quick as one thread.
    pub fn speed_up(&self) -> f64 {
        self.alone.as_secs_f64() / self.time.as_secs_f64()
    }

    /// The work that threads wait for longest, and the share of the time that they do.
    pub fn limit(&self) -> Option<(Work, f64)> {
        let longest = self.waits.iter().max_by_key(|(_, wait)| *wait);
        longest.map(|&(work, wait)| (work, wait.as_secs_f64() / self.time.as_secs_f64()))
    }
}

/// The prediction for a number of threads. The names of the fields are the JSON keys.
#[derive(Clone, Debug, Serialize)]
pub struct Prediction {
    /// The threads.
    pub threads: usize,
    /// The mean of the frames, in microseconds.
    pub time_us: f64,
    /// How many times as quick as one thread.
    pub speed_up: f64,
    /// The work that threads wait for longest.
    pub limited_by: String,
    /// Which share of the time they do.
    pub limited_share: f64,
}

impl From<&Simulated> for Prediction {
    fn from(simulated: &Simulated) -> Prediction {
        let limit = simulated.limit();
        Prediction {
            threads: simulated.threads,
            time_us: simulated.time.as_secs_f64() * 1e6 / f64::from(simulated.frames.max(1)),
            speed_up: simulated.speed_up(),
            limited_by: limit.map_or(String::new(), |(work, _)| work.to_string()),
            limited_share: limit.map_or(0.0, |(_, share)| share),
        }
    }
}

/// Frames on more threads than there are.
#[derive(Clone, Debug)]
pub struct Simulation(Vec<Simulated>);

impl Default for Simulation {
    fn default() -> Simulation {
        let of = |threads| Simulated {
            threads,
            ..Simulated::default()
        };
        Simulation(SIMULATED_THREADS.map(of).into())
    }
}

impl Simulation {
    /// Records a frame, and adds it,
    /// which knows `before` of those before it. (The culler has learnt from it after this.)
    pub fn add_frame(&mut self, culler: &mut Culler, before: &Remembered, camera: &Camera) {
        let alone = total(&record(culler, before, camera, 1));
        for simulated in &mut self.0 {
            let stages = record(culler, before, camera, simulated.threads);
            simulated.add(&stages, alone);
        }
    }

    /// What comes of the frames so far.
    pub fn predictions(&self) -> Vec<Prediction> {
        self.0.iter().map(Prediction::from).collect()
    }
}

/// A frame's stages, each task with the least time that it took in some repeats: they do the same work every time, and
/// whatever else the machine does only makes them longer.
fn record(culler: &mut Culler, before: &Remembered, camera: &Camera, threads: usize) -> Vec<Stage> {
    let mut set = VisibleSet::default();
    culler.recall(before);
    let mut least = culler.cull_recorded(camera, threads, &mut set);
    for _ in 1..REPEATS {
        culler.recall(before);
        let again = culler.cull_recorded(camera, threads, &mut set);
        let tasks = again.iter().flat_map(|stage| &stage.tasks);
        let least = least.iter_mut().flat_map(|stage| &mut stage.tasks);
        least.zip(tasks).for_each(|(l, &t)| *l = t.min(*l));
    }
    least
}

fn total(stages: &[Stage]) -> Duration {
    stages.iter().flat_map(|stage| &stage.tasks).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn us(tasks: &[u64]) -> Vec<Duration> {
        tasks.iter().map(|&t| Duration::from_micros(t)).collect()
    }

    fn span(tasks: &[u64], threads: usize) -> u128 {
        makespan(&us(tasks), threads).as_micros()
    }

    #[test]
    fn one_thread_takes_the_sum() {
        assert_eq!(span(&[3, 1, 4, 1, 5], 1), 14);
        assert_eq!(span(&[], 1), 0);
    }

    #[test]
    fn the_longest_task_is_a_lower_bound() {
        assert_eq!(span(&[2, 9, 3], 3), 9);
        assert_eq!(span(&[2, 9, 3], 64), 9);
    }

    #[test]
    fn tasks_go_in_their_order_to_the_thread_that_is_free_first() {
        // 3 | 2 → 2+2 | 3+4 → 7 and 4, where a better order would take 6.
        assert_eq!(span(&[3, 2, 2, 4], 2), 7);
        // Graham's example of a long task that comes last: 2m − 1 instead of m.
        assert_eq!(span(&[1, 1, 1, 1, 1, 1, 3], 3), 5);
        assert_eq!(span(&[3, 1, 1, 1, 1, 1, 1], 3), 3);
    }

    #[test]
    fn stages_follow_each_other_and_the_one_with_the_longest_wait_limits() {
        let stage = |work, tasks: &[u64]| Stage {
            work,
            tasks: us(tasks),
        };
        let mut simulated = Simulated {
            threads: 2,
            ..Simulated::default()
        };
        let stages = [
            stage(Work::Ask, &[4, 4]),
            stage(Work::Between, &[2]),
            stage(Work::Fill, &[6, 2]),
            stage(Work::Fill, &[3, 1]),
        ];
        simulated.add(&stages, Duration::from_micros(22));
        assert_eq!(simulated.time, Duration::from_micros(4 + 2 + 6 + 3));
        assert!((simulated.speed_up() - 22.0 / 15.0).abs() < 1e-9);
        let (work, share) = simulated.limit().expect("there are stages");
        assert_eq!(work, Work::Fill);
        assert!((share - 3.0 / 15.0).abs() < 1e-9);
    }
}
