//! One place of the grid, and what comes of it.

use serde::Serialize;

use super::grid::Place;
use super::{ORACLE, REPEATS};
use crate::cull::{Culler, VisibleSet};
use crate::measure::Reference;
use crate::measure::oracle::{Owner, within};
use crate::scene::Scene;
use crate::view::Camera;

/// What came of one setting: means over the judged frames. The names of the fields are the JSON keys.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SweepPoint {
    /// The selection, or [`ORACLE`].
    pub occluders: String,
    /// Triangles, `auto` or `all`.
    pub budget: String,
    /// Triangles that were drawn as occluders.
    pub occluder_triangles: f64,
    /// Culled of the exactly hidden; 1 if nothing is hidden.
    pub culled_of_hidden: f64,
    /// Microseconds a frame; of the oracle, without finding out which clusters own pixels.
    pub time_us: f64,
    /// Exactly visible objects that were culled, in all frames.
    pub false_culls: u64,
    /// The depth representation.
    pub depth: String,
    /// `exact` or `approximate`.
    pub accuracy: String,
    /// Uncovered pixels ignored in any window of a tile's size.
    pub hole: u32,
    /// Pixels of the picture along the edge of the map's.
    pub map_scale: u32,
    /// Pixels of the id picture that change when culling is on, in all frames (DYN §4.3).
    pub wrong_pixels: u64,
    /// The same, a frame.
    pub wrong_pixels_a_frame: f64,
    /// Exactly hidden objects that were not culled, as a share of all that are hidden; 0 if nothing is.
    pub missed_culls: f64,
    /// Whether no other hole and scale is both as quick and as right about pixels, of those that hide enough.
    pub on_front_of_wrong_pixels: bool,
    /// Whether no other setting is as quick and misses as few.
    pub on_front_of_missed_culls: bool,
    /// Whether it has the selection and the budget of the base settings, and hides at least
    /// [`LEAST_HIDDEN`](super::LEAST_HIDDEN) of the most that a hole and scale does with them.
    pub hides_enough: bool,
    /// Whether it differs from the base settings in the selection and the budget alone.
    pub is_base: bool,
    /// Frame by frame, if it has the selection and the budget of the base settings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub series: Vec<PointFrame>,
}

impl SweepPoint {
    /// Whether it is what the others are held against, and no way to cull.
    pub fn is_oracle(&self) -> bool {
        self.occluders == ORACLE
    }
}

/// A judged frame with one setting.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PointFrame {
    /// Which frame of the path.
    pub frame: usize,
    /// Microseconds, of the repeat that took least.
    pub time_us: f64,
    /// Triangles of the survivors.
    pub triangles_drawn: u64,
    /// Pixels of the id picture that change when culling is on.
    pub wrong_pixels: u64,
    /// Pixels of holes that were ignored: no other can be wrong, if the map is as large as the picture or the distribution factor is 1.
    pub ignored_pixels: u64,
}

/// What all runs are judged by in a frame.
pub(super) struct Judged<'a> {
    pub number: usize,
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    pub reference: &'a Reference,
    pub owners: &'a [Owner],
    pub hidden: &'a [u32],
    pub triangles_of: &'a dyn Fn(&mut dyn Iterator<Item = u32>) -> u64,
}

/// A culler, and what came of its frames.
pub(super) struct Run {
    place: Place,
    culler: Culler,
    found: VisibleSet,
    triangles: u64,
    culled: u64,
    false_culls: u64,
    wrong_pixels: u64,
    time_us: f64,
    series: Vec<PointFrame>,
}

impl Run {
    pub fn new(place: Place, culler: Culler) -> Run {
        Run {
            place,
            culler,
            found: VisibleSet::default(),
            triangles: 0,
            culled: 0,
            false_culls: 0,
            wrong_pixels: 0,
            time_us: 0.0,
            series: Vec::new(),
        }
    }

    /// Lets a frame pass that is not judged.
    pub fn pass(&mut self, camera: &Camera) {
        if self.place.name != ORACLE {
            self.culler.cull_into(camera, &mut self.found);
        }
    }

    pub fn judge(&mut self, judged: &Judged<'_>) {
        let &Judged {
            camera, reference, ..
        } = judged;
        let before = self.culler.remembered().clone();
        let mut least = f64::INFINITY;
        for _ in 0..REPEATS {
            if self.place.name == ORACLE {
                let best = within(self.culler.settings().budget, judged.owners);
                self.culler.cull_behind(camera, &best, &mut self.found);
            } else {
                self.culler.recall(&before);
                self.culler.cull_into(camera, &mut self.found);
            }
            least = least.min(self.found.times.total().as_nanos() as f64 / 1000.0);
        }
        let visible = &self.found.visible;
        let survives = |object: &u32| visible.binary_search(object).is_ok();
        let culled = judged.hidden.iter().filter(|&object| !survives(object));
        self.culled += culled.count() as u64;
        let lost = reference
            .visible_objects()
            .filter(|object| !survives(object));
        let lost = lost.count() as u64;
        // A pixel changes only if its owner is gone, so without a false cull there is nothing to draw and compare.
        let wrong_pixels = if lost == 0 {
            0
        } else {
            reference.wrong_pixels(judged.scene, camera, visible)
        };
        if self.place.is_chosen {
            self.series.push(PointFrame {
                frame: judged.number,
                time_us: least,
                triangles_drawn: (judged.triangles_of)(&mut visible.iter().copied()),
                wrong_pixels,
                ignored_pixels: self.found.statistics.ignored_pixels,
            });
        }
        self.false_culls += lost;
        self.wrong_pixels += wrong_pixels;
        self.triangles += self.found.statistics.occluder_triangles;
        self.time_us += least;
    }

    pub fn point(self, frames: usize, hidden: u64) -> SweepPoint {
        let settings = self.culler.settings();
        let approximation = settings.accuracy.approximation();
        let frames = frames.max(1) as f64;
        let culled_of_hidden = if hidden == 0 {
            1.0
        } else {
            self.culled as f64 / hidden as f64
        };
        SweepPoint {
            occluders: self.place.name.to_owned(),
            budget: settings.budget.to_string(),
            occluder_triangles: self.triangles as f64 / frames,
            culled_of_hidden,
            time_us: self.time_us / frames,
            false_culls: self.false_culls,
            depth: self.place.settings.depth.name().to_owned(),
            accuracy: approximation.map_or("exact", |_| "approximate").into(),
            hole: approximation.map_or(0, |a| a.hole),
            map_scale: settings.map_scale.pixels(),
            wrong_pixels: self.wrong_pixels,
            wrong_pixels_a_frame: self.wrong_pixels as f64 / frames,
            missed_culls: 1.0 - culled_of_hidden,
            is_base: self.place.is_base,
            series: self.series,
            ..SweepPoint::default()
        }
    }
}
