//! How many frames a second, and how long from a camera to its picture: frame by frame, and in pipelines.
//!
//! All flows take the same cameras in turns, several times, since whatever else the machine does only makes them slower: the least
//! of the repeats is what a flow can do, the median what it does on this machine now. A repeat begins without memory of earlier
//! frames, with an empty pipeline, and ends when the last picture is done.

use std::convert::Infallible;
use std::hint::black_box;
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use serde::Serialize;
use thiserror::Error;

use crate::cull::{Culler, Settings, VisibleSet};
use crate::final_pass::render_image;
use crate::pipeline::{Pipeline, PipelineError, Schedule};
use crate::prepare::Prepared;
use crate::view::Camera;

/// How frames follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Each is culled and drawn before the next begins, by so many threads together.
    FrameByFrame {
        /// The threads.
        threads: usize,
    },
    /// By a schedule, each stage one thread's work.
    Pipeline(Schedule),
}

/// What draws the survivors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FinalDraw {
    /// The processor: [`render_image`].
    Picture {
        /// The threads that draw a pipeline's pictures. Frame by frame, it is those that cull.
        threads: usize,
    },
    /// Somebody else, in this time: the thread sleeps.
    Elsewhere(Duration),
}

/// How to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct ThroughputSettings {
    /// How to cull, but for the threads.
    pub cull: Settings,
    /// Names and flows to compare.
    pub flows: Vec<(String, Flow)>,
    /// What the last stage does.
    pub final_draw: FinalDraw,
    /// How often all flows take all cameras; at least 1.
    pub repeats: usize,
}

/// The least and the median of some repeats.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LeastAndMedian {
    /// The least.
    pub least: f64,
    /// The median.
    pub median: f64,
}

/// What came of a flow. The names of the fields are the JSON keys. Times are in microseconds.
#[derive(Clone, Debug, Serialize)]
pub struct FlowReport {
    /// Its name.
    pub name: String,
    /// The threads of its stages: those of its places, or those that cull.
    pub threads: usize,
    /// How many frames back a frame knows.
    pub frames_back: u8,
    /// The time of all frames over their number: the throughput's inverse.
    pub frame_us: LeastAndMedian,
    /// From taking a camera until its picture is done: the mean.
    pub latency_us: LeastAndMedian,
    /// And what 95 of 100 frames do not exceed.
    pub latency_95_us: LeastAndMedian,
    /// Objects that are not culled, mean.
    pub objects_visible: f64,
    /// Triangles drawn as occluders, mean.
    pub occluder_triangles: f64,
    /// Selecting, drawing occluders, culling, and the final draw: the mean of each in the repeat that took least. Frame by frame, all
    /// before the final draw is culling.
    pub stages_us: [f64; 4],
    /// What a frame would take if each place had a processor to itself ([`Schedule::longest_place`]).
    pub longest_place_us: f64,
}

impl FlowReport {
    /// Frames a second, of the least time.
    pub fn frames_per_second(&self) -> f64 {
        1e6 / self.frame_us.least
    }
}

/// Why nothing was measured.
#[derive(Debug, Error)]
pub enum ThroughputError {
    /// There are no threads to cull or draw.
    #[error("the operating system gives no threads: {0}")]
    Threads(#[from] ThreadPoolBuildError),
    /// There are none for a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError<Infallible>),
}

/// Measures all flows on some cameras; calls `on_run` with the number of runs done and of all, first with 0.
///
/// # Errors
/// If the operating system gives no threads.
pub fn throughput(
    prepared: &Prepared,
    cameras: &[Camera],
    settings: &ThroughputSettings,
    mut on_run: impl FnMut(usize, usize),
) -> Result<Vec<FlowReport>, ThroughputError> {
    let first = Culler::with_prepared(
        prepared,
        Settings {
            threads: 1,
            ..settings.cull
        },
    )?;
    let runners = settings.flows.iter();
    let mut runners = runners
        .map(|(_, flow)| Runner::new(&first, *flow, settings))
        .collect::<Result<Vec<Runner>, ThreadPoolBuildError>>()?;
    let repeats = settings.repeats.max(1);
    let all = repeats * runners.len();
    on_run(0, all);
    for repeat in 0..repeats {
        for i in 0..runners.len() {
            runners[i].run(cameras, settings.final_draw)?;
            on_run(repeat * runners.len() + i + 1, all);
        }
    }
    let reports = runners.into_iter().zip(&settings.flows);
    Ok(reports
        .map(|(runner, (name, flow))| runner.report(name, *flow))
        .collect())
}

/// A flow at work, and what came of its runs.
struct Runner {
    worker: Worker,
    pool: ThreadPool,
    runs: Vec<Run>,
}

enum Worker {
    Culler(Culler, VisibleSet),
    Pipeline(Pipeline),
}

impl Runner {
    fn new(
        first: &Culler,
        flow: Flow,
        settings: &ThroughputSettings,
    ) -> Result<Runner, ThreadPoolBuildError> {
        let cullers_threads = match flow {
            Flow::FrameByFrame { threads } => threads,
            Flow::Pipeline(_) => 1,
        };
        let culler = first.another(Settings {
            threads: cullers_threads,
            ..settings.cull
        })?;
        let threads = match (flow, settings.final_draw) {
            (Flow::FrameByFrame { threads }, _) | (_, FinalDraw::Picture { threads }) => threads,
            _ => 1,
        };
        Ok(Runner {
            worker: match flow {
                Flow::FrameByFrame { .. } => Worker::Culler(culler, VisibleSet::default()),
                Flow::Pipeline(schedule) => Worker::Pipeline(Pipeline::new(culler, schedule)),
            },
            pool: ThreadPoolBuilder::new().num_threads(threads).build()?,
            runs: Vec::new(),
        })
    }

    fn run(&mut self, cameras: &[Camera], final_draw: FinalDraw) -> Result<(), ThroughputError> {
        let pool = &self.pool;
        let mut run = Run::with_capacity(cameras.len());
        let begin = Instant::now();
        match &mut self.worker {
            Worker::Culler(culler, found) => {
                culler.forget();
                for camera in cameras {
                    let camera_in = Instant::now();
                    culler.cull_into(camera, found);
                    let culled = Instant::now();
                    draw(final_draw, pool, culler, camera, found);
                    let all = [Duration::ZERO, Duration::ZERO, culled - camera_in];
                    run.add(camera_in, culled, found, all);
                }
            }
            Worker::Pipeline(pipeline) => {
                // Its culler only lends its scene and settings to the pictures.
                let culler = pipeline.culler().another(*pipeline.culler().settings())?;
                pipeline.run(cameras.iter().copied(), |frame| {
                    let culled = Instant::now();
                    draw(final_draw, pool, &culler, frame.camera, frame.found);
                    run.add(frame.camera_in, culled, frame.found, frame.stage_times);
                    Ok::<(), Infallible>(())
                })?;
            }
        }
        run.time = begin.elapsed();
        self.runs.push(run);
        Ok(())
    }

    fn report(&self, name: &str, flow: Flow) -> FlowReport {
        let of = |value: &dyn Fn(&Run) -> f64| least_and_median(self.runs.iter().map(value));
        // Frame by frame is a schedule, too.
        let (threads, schedule) = match flow {
            Flow::FrameByFrame { threads } => (threads, Schedule::SEQUENTIAL),
            Flow::Pipeline(schedule) => (schedule.threads(), schedule),
        };
        let quickest = self.runs.iter().min_by_key(|run| run.time);
        let stages_us = quickest.map_or([0.0; 4], |run| run.stages.map(|time| run.mean(us(time))));
        FlowReport {
            name: name.to_owned(),
            threads,
            frames_back: schedule.frames_back.max(1),
            frame_us: of(&|run| run.mean(us(run.time))),
            latency_us: of(&|run| run.mean(run.latencies.iter().copied().map(us).sum())),
            latency_95_us: of(&Run::latency_95_us),
            objects_visible: quickest.map_or(0.0, |run| run.mean(run.objects_visible as f64)),
            occluder_triangles: quickest.map_or(0.0, |run| run.mean(run.occluder_triangles as f64)),
            stages_us,
            longest_place_us: schedule.longest_place(stages_us),
        }
    }
}

fn draw(
    final_draw: FinalDraw,
    pool: &ThreadPool,
    culler: &Culler,
    camera: &Camera,
    found: &VisibleSet,
) {
    match final_draw {
        FinalDraw::Picture { .. } => {
            let size = culler.settings().size;
            let picture = || render_image(culler.scene(), camera, size, &found.visible);
            black_box(pool.install(picture));
        }
        FinalDraw::Elsewhere(time) if time > Duration::ZERO => std::thread::sleep(time),
        FinalDraw::Elsewhere(_) => {}
    }
}

/// What came of all cameras, once.
struct Run {
    time: Duration,
    latencies: Vec<Duration>,
    objects_visible: u64,
    occluder_triangles: u64,
    stages: [Duration; 4],
}

impl Run {
    fn with_capacity(frames: usize) -> Run {
        Run {
            time: Duration::ZERO,
            latencies: Vec::with_capacity(frames),
            objects_visible: 0,
            occluder_triangles: 0,
            stages: [Duration::ZERO; 4],
        }
    }

    /// Adds a frame whose picture is done.
    fn add(
        &mut self,
        camera_in: Instant,
        culled: Instant,
        found: &VisibleSet,
        [select, draw_occluders, cull]: [Duration; 3],
    ) {
        let now = Instant::now();
        self.latencies.push(now - camera_in);
        self.objects_visible += found.statistics.objects_visible;
        self.occluder_triangles += found.statistics.occluder_triangles;
        let stages = [select, draw_occluders, cull, now - culled];
        for (sum, time) in self.stages.iter_mut().zip(stages) {
            *sum += time;
        }
    }

    fn mean(&self, sum: f64) -> f64 {
        sum / self.latencies.len().max(1) as f64
    }

    fn latency_95_us(&self) -> f64 {
        let mut sorted = self.latencies.clone();
        sorted.sort_unstable();
        // The nearest rank.
        let rank = (sorted.len() * 95).div_ceil(100);
        sorted.get(rank.saturating_sub(1)).copied().map_or(0.0, us)
    }
}

fn us(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1000.0
}

fn least_and_median(values: impl Iterator<Item = f64>) -> LeastAndMedian {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |place: usize| sorted.get(place).copied().unwrap_or_default();
    LeastAndMedian {
        least: at(0),
        median: at(sorted.len() / 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latency_of_95_in_100_is_the_nearest_rank() {
        let of = |latencies: Vec<u64>| {
            let mut run = Run::with_capacity(0);
            run.latencies = latencies.into_iter().map(Duration::from_micros).collect();
            run.latency_95_us()
        };
        assert_eq!(of((1..=100).rev().collect()), 95.0);
        assert_eq!(of((1..=10).collect()), 10.0);
        assert_eq!(of(vec![7]), 7.0);
        assert_eq!(of(vec![]), 0.0);
    }

    #[test]
    fn the_median_is_the_value_in_the_middle() {
        let of = least_and_median([5.0, 1.0, 9.0].into_iter());
        assert_eq!((of.least, of.median), (1.0, 5.0));
    }
}
