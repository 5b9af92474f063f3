//! How frames scale with threads: measured on those that the machine has, predicted for more.

use rayon::ThreadPoolBuildError;
use serde::Serialize;

use super::REPEATS;
use crate::cull::{Culler, Settings, VisibleSet};
use crate::measure::{Prediction, Simulation};
use crate::view::Camera;

/// What frames took on a number of threads.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredThreads {
    /// The threads.
    pub threads: usize,
    /// The mean of the judged frames, in microseconds.
    pub time_us: f64,
    /// How many times as quick as one thread.
    pub speed_up: f64,
}

/// How the base settings scale with threads.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Scaling {
    /// On 1, 2, 4 … threads, up to those of the settings.
    pub measured: Vec<MeasuredThreads>,
    /// On more threads than a machine may have, from what tasks take on one.
    pub predicted: Vec<Prediction>,
}

/// Measures scaling while a path is swept.
pub(super) struct Scales {
    cullers: Vec<(Culler, f64)>,
    frames: usize,
    recorded: Culler,
    simulation: Simulation,
    found: VisibleSet,
}

impl Scales {
    pub fn new(first: &Culler) -> Result<Scales, ThreadPoolBuildError> {
        let most = first.threads();
        let mut counts: Vec<usize> = (0..)
            .map(|power| 1 << power)
            .take_while(|&n| n < most)
            .collect();
        counts.push(most);
        let on = |threads| {
            first.another(Settings {
                threads,
                ..*first.settings()
            })
        };
        let cullers = counts.into_iter().map(|threads| Ok((on(threads)?, 0.0)));
        Ok(Scales {
            cullers: cullers.collect::<Result<_, _>>()?,
            frames: 0,
            recorded: on(1)?,
            simulation: Simulation::default(),
            found: VisibleSet::default(),
        })
    }

    /// Lets a frame pass that is not judged.
    pub fn pass(&mut self, camera: &Camera) {
        for (culler, _) in &mut self.cullers {
            culler.cull_into(camera, &mut self.found);
        }
        self.recorded.cull_into(camera, &mut self.found);
    }

    /// Measures a frame.
    pub fn judge(&mut self, camera: &Camera) {
        self.frames += 1;
        for (culler, sum) in &mut self.cullers {
            let before = culler.remembered().clone();
            let mut least = f64::INFINITY;
            for _ in 0..REPEATS {
                culler.recall(&before);
                culler.cull_into(camera, &mut self.found);
                least = least.min(self.found.times.total().as_nanos() as f64 / 1000.0);
            }
            *sum += least;
        }
        let before = self.recorded.remembered().clone();
        self.simulation
            .add_frame(&mut self.recorded, &before, camera);
    }

    /// What came of it.
    pub fn scaling(&self) -> Scaling {
        let alone = self.cullers[0].1;
        let measured = |(culler, sum): &(Culler, f64)| MeasuredThreads {
            threads: culler.threads(),
            time_us: sum / self.frames.max(1) as f64,
            speed_up: alone / sum,
        };
        Scaling {
            measured: self.cullers.iter().map(measured).collect(),
            predicted: self.simulation.predictions(),
        }
    }
}
