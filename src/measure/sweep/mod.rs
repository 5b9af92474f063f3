//! What each setting hides, what it costs, and what it gets wrong.
//!
//! Every frame is drawn exactly once, and culled with every place of a `grid`: selections and budgets, holes that may be ignored
//! and scales of the map; and once more behind the clusters that an [`Oracle`] names, which own the most pixels of that frame for their
//! triangles. Points are means over the path; those of the holes and scales keep their frames, too.

mod grid;
mod point;
mod scaling;

use rayon::ThreadPoolBuildError;
use serde::Serialize;

use super::oracle::Oracle;
use super::{Reference, pareto_front};
use crate::cull::{Culler, Settings};
use crate::occlusion::Approximation;
use crate::prepare::Prepared;
use crate::view::{CameraPath, MapScale};
use point::{Judged, Run};
use scaling::Scales;

pub use point::{PointFrame, SweepPoint};
pub use scaling::{MeasuredThreads, Scaling};

/// What the clusters that own the most pixels go by in place of a selection's name.
pub const ORACLE: &str = "oracle";

/// What settings have to hide to be compared by their wrong pixels, as a share of the most that one of them does.
pub const LEAST_HIDDEN: f64 = 0.8;

/// A frame's time is the least of so many repeats.
const REPEATS: usize = 3;

/// What to sweep over.
#[derive(Clone, Debug)]
pub struct SweepSettings {
    /// The base settings. The selection and the budget are replaced, and then the accuracy and the map's scale.
    pub cull: Settings,
    /// Budgets, in triangles; besides them each selection goes without one, and by contribution with one that chooses itself.
    pub budgets: Vec<u64>,
    /// Holes that may be ignored, in pixels; 0 is exact.
    pub holes: Vec<u32>,
    /// Scales of the map.
    pub map_scales: Vec<MapScale>,
    /// How holes are ignored; the size is replaced.
    pub approximation: Approximation,
    /// Whether to take all holes and scales with all selections and budgets.
    pub full: bool,
    /// Frames 0, N, 2N … are judged; at least 1.
    pub every: usize,
}

/// The settings that all points share, or the base ones of those that differ.
#[derive(Clone, Debug, Serialize)]
pub struct SweptWith {
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
    /// Pixels of the picture along the edge of the map's.
    pub map_scale: u32,
    /// The selection with which holes and scales are swept over.
    pub occluders: String,
    /// The budget with which they are.
    pub budget: String,
    /// The distribution factor of the holes.
    pub distribution: f64,
    /// Every how many frames one is judged.
    pub every: usize,
}

/// A judged frame, whatever the settings.
#[derive(Clone, Debug, Serialize)]
pub struct PathFrame {
    /// Which frame of the path.
    pub frame: usize,
    /// Objects in the frustum.
    pub in_frustum: u64,
    /// Of these, those that own a pixel.
    pub exactly_visible: u64,
    /// Triangles of the objects in the frustum.
    pub triangles_in_frustum: u64,
    /// Triangles of the objects that own a pixel.
    pub triangles_exactly_visible: u64,
}

/// Everything that was swept over.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    /// Objects of the scene.
    pub objects: u64,
    /// Triangles of the scene, a shared mesh counted for each object.
    pub triangles: u64,
    /// How it was culled.
    pub settings: SweptWith,
    /// Judged frames.
    pub frames: usize,
    /// At the base settings selection by selection and the oracle last, each from the smallest budget to none; then scale by scale the holes.
    pub points: Vec<SweepPoint>,
    /// The judged frames.
    pub path: Vec<PathFrame>,
    /// How the base settings scale with threads.
    pub scaling: Scaling,
}

impl Sweep {
    /// The points that differ from the base settings in the selection and the budget alone.
    pub fn choices(&self) -> impl Iterator<Item = &SweepPoint> {
        self.points.iter().filter(|point| point.is_base)
    }

    /// The points of holes and scales, with the selection and the budget of the base settings.
    pub fn variants(&self) -> impl Iterator<Item = &SweepPoint> {
        self.points.iter().filter(|point| !point.series.is_empty())
    }

    /// The points of other depth representations, with the selection and the budget of the base settings.
    pub fn depths(&self) -> impl Iterator<Item = &SweepPoint> {
        let base = self.base();
        self.points.iter().filter(move |point| {
            base.is_some_and(|base| {
                let of = |p: &SweepPoint| (p.occluders.clone(), p.budget.clone());
                point.depth != base.depth && of(point) == of(base)
            })
        })
    }

    /// The point of the base settings.
    pub fn base(&self) -> Option<&SweepPoint> {
        self.variants().find(|point| point.is_base)
    }

    /// The points that are on a front, the quickest first: those that nothing beats at both time and an error.
    pub fn front(&self, is_on_it: impl Fn(&SweepPoint) -> bool) -> Vec<&SweepPoint> {
        let mut front: Vec<&SweepPoint> = self.points.iter().filter(|p| is_on_it(p)).collect();
        front.sort_by(|a, b| a.time_us.total_cmp(&b.time_us));
        front
    }
}

/// Culls a path with every setting; calls `on_frame` with the number of frames done and of all, first with 0.
///
/// # Errors
/// If the operating system gives no threads.
pub fn sweep(
    prepared: &Prepared,
    path: &CameraPath,
    settings: &SweepSettings,
    mut on_frame: impl FnMut(usize, usize),
) -> Result<Sweep, ThreadPoolBuildError> {
    let every = settings.every.max(1);
    let scene = prepared.scene();
    let first = Culler::with_prepared(prepared, settings.cull)?;
    let places = grid::places(settings, first.visibility_grid().is_some());
    let mut runs = Vec::with_capacity(places.len());
    for place in places {
        runs.push(Run::new(place, first.another(place.settings)?));
    }
    let oracle = Oracle::new(scene, first.clusters());
    let mut scales = Scales::new(&first)?;
    let triangles_of = |objects: &mut dyn Iterator<Item = u32>| -> u64 {
        let meshes = objects.map(|o| &scene.meshes()[scene.objects()[o as usize].mesh]);
        meshes.map(|mesh| mesh.triangles.len() as u64).sum()
    };
    let cameras = path.cameras();
    on_frame(0, cameras.len());
    let mut of_path = Vec::new();
    for (number, camera) in cameras.iter().enumerate() {
        if number % every != 0 {
            for run in &mut runs {
                run.pass(camera);
            }
            scales.pass(camera);
        } else {
            let reference = Reference::new(scene, camera, settings.cull.size);
            let in_frustum = first.in_frustum(camera);
            let is_hidden = |object: &&u32| !reference.is_visible(**object);
            let hidden: Vec<u32> = in_frustum.iter().filter(is_hidden).copied().collect();
            let owners = oracle.owners(camera, settings.cull.size);
            of_path.push(PathFrame {
                frame: number,
                in_frustum: in_frustum.len() as u64,
                exactly_visible: (in_frustum.len() - hidden.len()) as u64,
                triangles_in_frustum: triangles_of(&mut in_frustum.iter().copied()),
                triangles_exactly_visible: triangles_of(&mut reference.visible_objects()),
            });
            let judged = Judged {
                number,
                scene,
                camera,
                reference: &reference,
                owners: &owners,
                hidden: &hidden,
                triangles_of: &triangles_of,
            };
            for run in &mut runs {
                run.judge(&judged);
            }
            scales.judge(camera);
        }
        on_frame(number + 1, cameras.len());
    }
    let hidden = of_path
        .iter()
        .map(|frame| frame.in_frustum - frame.exactly_visible)
        .sum();
    let frames = of_path.len();
    let mut points: Vec<SweepPoint> = runs.into_iter().map(|r| r.point(frames, hidden)).collect();
    mark_fronts(&mut points);
    Ok(Sweep {
        objects: scene.objects().len() as u64,
        triangles: scene.triangle_count(),
        settings: shared(settings, first.threads()),
        frames,
        points,
        path: of_path,
        scaling: scales.scaling(),
    })
}

/// Says of each point whether it is on the fronts. The oracle is on none: its time leaves out how it knows.
///
/// Wrong pixels are compared among the points of holes and scales alone, and of these only those that hide enough
/// ([`SweepPoint::hides_enough`]). Exact culling has none however little it hides, so what hides least in the least time would be best
/// at both and tell nothing.
fn mark_fronts(points: &mut [SweepPoint]) {
    let front = |points: &[SweepPoint],
                 takes: fn(&SweepPoint) -> bool,
                 error: fn(&SweepPoint) -> f64|
     -> Vec<usize> {
        let taken: Vec<usize> = (0..points.len()).filter(|&i| takes(&points[i])).collect();
        let value = |&i: &usize| (points[i].time_us, error(&points[i]));
        let values: Vec<(f64, f64)> = taken.iter().map(value).collect();
        pareto_front(&values)
            .into_iter()
            .map(|i| taken[i])
            .collect()
    };
    let of_variants = points.iter().filter(|p| !p.series.is_empty());
    let most = of_variants.map(|p| p.culled_of_hidden).fold(0.0, f64::max);
    for point in points.iter_mut().filter(|p| !p.series.is_empty()) {
        point.hides_enough = point.culled_of_hidden >= LEAST_HIDDEN * most;
    }
    for i in front(points, |p| p.hides_enough, |p| p.wrong_pixels_a_frame) {
        points[i].on_front_of_wrong_pixels = true;
    }
    for i in front(points, |p| !p.is_oracle(), |p| p.missed_culls) {
        points[i].on_front_of_missed_culls = true;
    }
}

fn shared(settings: &SweepSettings, threads: usize) -> SweptWith {
    let Settings {
        size,
        accuracy,
        map_scale,
        level,
        occluders,
        budget,
        ..
    } = settings.cull;
    let approximation = accuracy.approximation();
    SweptWith {
        size: [size.width(), size.height()],
        threads,
        simd: level.to_string(),
        accuracy: approximation.map_or("exact", |_| "approximate").into(),
        hole: approximation.map_or(0, |a| a.hole),
        map_scale: map_scale.pixels(),
        occluders: occluders.to_string(),
        budget: budget.to_string(),
        distribution: settings.approximation.distribution,
        every: settings.every.max(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(name: &str, time_us: f64, missed_culls: f64, wrong: Option<f64>) -> SweepPoint {
        SweepPoint {
            occluders: name.to_owned(),
            time_us,
            missed_culls,
            culled_of_hidden: 1.0 - missed_culls,
            wrong_pixels_a_frame: wrong.unwrap_or(0.0),
            series: wrong.map_or(Vec::new(), |_| vec![PointFrame::default()]),
            ..SweepPoint::default()
        }
    }

    #[test]
    fn fronts_leave_out_the_oracle_and_what_hides_little() {
        let mut points = [
            point("nearest", 10.0, 0.9, None),
            point(ORACLE, 1.0, 0.0, None),
            point("contribution", 30.0, 0.02, Some(0.0)),
            point("contribution", 20.0, 0.03, Some(5.0)),
            point("contribution", 25.0, 0.03, Some(6.0)),
            point("weight", 40.0, 0.02, None),
            point("contribution", 5.0, 0.5, Some(0.0)),
        ];
        mark_fronts(&mut points);
        let wrong = points.each_ref().map(|p| p.on_front_of_wrong_pixels);
        assert_eq!(wrong, [false, false, true, true, false, false, false]);
        let missed = points.each_ref().map(|p| p.on_front_of_missed_culls);
        assert_eq!(missed, [false, false, true, true, false, false, true]);
    }
}
