//! What `measure` reports. The names of the fields are the JSON keys, and scripts outside the project read them.

use serde::Serialize;

use super::Prediction;
use crate::cull::StageTimes;

/// Everything measured on a path.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// What was measured.
    pub scene: SceneReport,
    /// How.
    pub settings: SettingsReport,
    /// Frame by frame.
    pub frames: Vec<FrameReport>,
    /// All frames together.
    pub totals: Totals,
    /// What they would take on more threads, if that was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub simulated: Vec<Prediction>,
}

/// The size of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneReport {
    /// Objects.
    pub objects: u64,
    /// Triangles, a shared mesh counted for each object.
    pub triangles: u64,
}

/// The settings of a measurement, those that hold by default too.
#[derive(Clone, Debug, Serialize)]
pub struct SettingsReport {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Threads.
    pub threads: usize,
    /// The instruction set.
    pub simd: String,
    /// `exact` or `approximate`.
    pub accuracy: String,
    /// Uncovered pixels ignored in any window of a tile's size.
    pub hole: u32,
    /// The finest level of the pyramid with a threshold, or null if exact.
    pub base_level: Option<u8>,
    /// The distribution factor, or null if exact.
    pub distribution: Option<f64>,
    /// The base level's transparency threshold, or null if exact.
    pub transparency: Option<f64>,
    /// Whether translucent surfaces are occluders.
    pub translucent: bool,
    /// How occluders are selected.
    pub occluders: String,
    /// Occluder triangles, or `all`.
    pub budget: String,
    /// What makes objects unfit to be occluders, with commas between, or `none`.
    pub static_criteria: String,
    /// By weight: the least compactness of a candidate.
    pub least_compactness: f32,
    /// By weight: how many objects are active, or null.
    pub most_active: Option<u32>,
    /// By what was visible: how many frames back.
    pub frames_back: u32,
    /// By contribution: how many passes a frame has at the most, or null.
    pub most_passes: Option<u32>,
    /// How many viewpoints of sampled visibility there are; 0 if none was made.
    pub viewpoints: u64,
    /// Whether each frame starts without memory of the last.
    pub cold: bool,
    /// The depth representation.
    pub depth: String,
    /// Which of the farthest depths stands for a cell, where it is hierarchical; else 1.
    pub nth: u32,
    /// Final pixels along the edge of a map pixel.
    pub map_scale: u32,
    /// How far the final pass may draw from where ours does, in pixels: 0 if it is ours.
    pub slack: f64,
    /// Every how many frames one is judged.
    pub every: usize,
    /// What moves: `doors`, `all`, or null.
    pub animate: Option<String>,
    /// The seed that says how, or null.
    pub seed: Option<u64>,
}

/// Times in microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TimesUs {
    /// Frustum culling, and choosing and sorting occluders.
    pub select: f64,
    /// Asking and drawing occluders.
    pub raster: f64,
    /// Building the pyramid.
    pub pyramid: f64,
    /// Testing boxes.
    pub test: f64,
    /// The whole of `cull`.
    pub total: f64,
}

impl From<StageTimes> for TimesUs {
    fn from(times: StageTimes) -> TimesUs {
        let us = |d: std::time::Duration| d.as_nanos() as f64 / 1000.0;
        TimesUs {
            select: us(times.select),
            raster: us(times.raster),
            pyramid: us(times.pyramid),
            test: us(times.test),
            total: us(times.total()),
        }
    }
}

impl TimesUs {
    /// The mean of some times; zero of none.
    pub fn mean<'a>(times: impl ExactSizeIterator<Item = &'a TimesUs> + Clone) -> TimesUs {
        let count = times.len().max(1) as f64;
        let mean = |of: fn(&TimesUs) -> f64| times.clone().map(of).sum::<f64>() / count;
        TimesUs {
            select: mean(|t| t.select),
            raster: mean(|t| t.raster),
            pyramid: mean(|t| t.pyramid),
            test: mean(|t| t.test),
            total: mean(|t| t.total),
        }
    }
}

/// One frame.
#[derive(Clone, Debug, Serialize)]
pub struct FrameReport {
    /// Which frame of the path.
    pub frame: usize,
    /// Of the repeat that took least.
    pub time_us: TimesUs,
    /// Objects that were moved before it,
    pub moved: u64,
    /// and how long that took, in microseconds; not part of the times above.
    pub move_us: f64,
    /// Objects whose world box is not wholly outside a plane of the frustum.
    pub in_frustum: u64,
    /// Of these, those that own a pixel.
    pub exactly_visible: u64,
    /// The rest of those in the frustum.
    pub exactly_hidden: u64,
    /// Those of the hidden that cover no pixel centre, even alone.
    pub sampleless: u64,
    /// Exactly hidden objects that are not in the visible set.
    pub culled: u64,
    /// Pixels of holes that were ignored.
    pub ignored_pixels: u64,
    /// Exactly hidden objects that the ideal box test finds.
    pub ideal_box_culled: u64,
    /// Exactly hidden objects that the ideal face test finds.
    pub ideal_face_culled: u64,
    /// Exactly visible objects that are not in the visible set.
    pub false_culls: u64,
    /// Pixels of the id picture that change when culling is on.
    pub wrong_pixels: u64,
    /// Triangles of the objects in the frustum.
    pub triangles_in_frustum: u64,
    /// Triangles of the survivors: what the final pass draws.
    pub triangles_drawn: u64,
    /// Triangles drawn as occluders.
    pub occluder_triangles: u64,
    /// The steps that were skipped, each with its reason.
    pub skipped: Vec<String>,
    /// 64-bit FNV-1a over coverage and depth, 16 hexadecimal digits.
    pub buffer_hash: String,
}

/// All frames together. Fractions are sums over sums.
#[derive(Clone, Debug, Serialize)]
pub struct Totals {
    /// The mean over the frames.
    pub time_us_mean: TimesUs,
    /// Culled of the exactly hidden; 1 if nothing is hidden.
    pub culled_of_hidden: f64,
    /// What the ideal box test finds of the exactly hidden.
    pub ideal_box_culled_of_hidden: f64,
    /// What the ideal face test finds of the exactly hidden.
    pub ideal_face_culled_of_hidden: f64,
    /// False culls of all frames.
    pub false_culls: u64,
    /// Wrong pixels of all frames.
    pub wrong_pixels: u64,
    /// Wrong pixels of all pixels.
    pub wrong_pixel_fraction: f64,
}

impl Totals {
    /// Adds frames up; each has `pixels` pixels.
    pub fn of(frames: &[FrameReport], pixels: u64) -> Totals {
        let sum = |of: fn(&FrameReport) -> u64| frames.iter().map(of).sum::<u64>();
        let hidden = sum(|f| f.exactly_hidden);
        let of_hidden = |part: u64| {
            if hidden == 0 {
                1.0
            } else {
                part as f64 / hidden as f64
            }
        };
        let wrong_pixels = sum(|f| f.wrong_pixels);
        Totals {
            time_us_mean: TimesUs::mean(frames.iter().map(|f| &f.time_us)),
            culled_of_hidden: of_hidden(sum(|f| f.culled)),
            ideal_box_culled_of_hidden: of_hidden(sum(|f| f.ideal_box_culled)),
            ideal_face_culled_of_hidden: of_hidden(sum(|f| f.ideal_face_culled)),
            false_culls: sum(|f| f.false_culls),
            wrong_pixels,
            wrong_pixel_fraction: wrong_pixels as f64
                / (pixels * frames.len().max(1) as u64) as f64,
        }
    }
}
