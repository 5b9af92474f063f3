//! What each way to choose occluders hides, for what budget.
//!
//! Every frame is drawn exactly once, and culled with every selection and budget.

use rayon::ThreadPoolBuildError;
use serde::Serialize;

use super::Reference;
use crate::cull::{Culler, Settings, VisibleSet};
use crate::occluders::{Budget, Selection};
use crate::prepare::Prepared;
use crate::view::CameraPath;

/// A frame's time is the least of so many repeats.
const REPEATS: usize = 3;

/// What to sweep over.
#[derive(Clone, Debug)]
pub struct SweepSettings {
    /// How to cull; the selection and the budget are replaced.
    pub cull: Settings,
    /// Budgets, in triangles; besides them each selection goes without one, and by contribution with one that chooses itself.
    pub budgets: Vec<u64>,
    /// Frames 0, N, 2N … are judged; at least 1.
    pub every: usize,
}

/// What came of one selection with one budget: means over the judged frames.
#[derive(Clone, Debug, Serialize)]
pub struct SweepPoint {
    /// The selection.
    pub occluders: String,
    /// Triangles, `auto` or `all`.
    pub budget: String,
    /// Triangles that were drawn as occluders.
    pub occluder_triangles: f64,
    /// Culled of the exactly hidden; 1 if nothing is hidden.
    pub culled_of_hidden: f64,
    /// Microseconds a frame.
    pub time_us: f64,
    /// Exactly visible objects that were culled, in all frames.
    pub false_culls: u64,
}

/// Everything that was swept over.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    /// Objects of the scene.
    pub objects: u64,
    /// Triangles of the scene, a shared mesh counted for each object.
    pub triangles: u64,
    /// Judged frames.
    pub frames: usize,
    /// Selection by selection, from the smallest budget to none.
    pub points: Vec<SweepPoint>,
}

/// Culls a path with every selection and budget; calls `on_frame` with the number of frames done and of all, first with 0.
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
    let mut runs = Vec::new();
    for occluders in Selection::ALL {
        if occluders == Selection::Sampled && first.visibility_grid().is_none() {
            // It would be the nearest once more.
            continue;
        }
        let budgets = settings.budgets.iter().copied().map(Budget::Triangles);
        let auto = (occluders == Selection::Contribution).then_some(Budget::Auto);
        for budget in budgets.chain(auto).chain([Budget::All]) {
            runs.push(Run::new(&first, occluders, budget)?);
        }
    }
    let cameras = path.cameras();
    on_frame(0, cameras.len());
    let (mut frames, mut hidden) = (0, 0);
    for (number, camera) in cameras.iter().enumerate() {
        if number % every != 0 {
            runs.iter_mut().for_each(|run| {
                run.culler.cull_into(camera, &mut run.found);
            });
        } else {
            let reference = Reference::new(scene, camera, settings.cull.size);
            let in_frustum = first.in_frustum(camera);
            let is_hidden = |object: &&u32| !reference.is_visible(**object);
            let of_frame: Vec<u32> = in_frustum.iter().filter(is_hidden).copied().collect();
            frames += 1;
            hidden += of_frame.len() as u64;
            for run in &mut runs {
                run.judge(camera, &reference, &of_frame);
            }
        }
        on_frame(number + 1, cameras.len());
    }
    Ok(Sweep {
        objects: scene.objects().len() as u64,
        triangles: scene.triangle_count(),
        frames,
        points: runs.iter().map(|run| run.point(frames, hidden)).collect(),
    })
}

/// A culler, and what came of its frames.
struct Run {
    culler: Culler,
    found: VisibleSet,
    triangles: u64,
    culled: u64,
    false_culls: u64,
    time_us: f64,
}

impl Run {
    fn new(
        first: &Culler,
        occluders: Selection,
        budget: Budget,
    ) -> Result<Run, ThreadPoolBuildError> {
        let settings = Settings {
            occluders,
            budget,
            ..*first.settings()
        };
        Ok(Run {
            culler: first.another(settings)?,
            found: VisibleSet::default(),
            triangles: 0,
            culled: 0,
            false_culls: 0,
            time_us: 0.0,
        })
    }

    fn judge(&mut self, camera: &crate::view::Camera, reference: &Reference, hidden: &[u32]) {
        let before = self.culler.remembered().clone();
        let mut least = f64::INFINITY;
        for _ in 0..REPEATS {
            self.culler.recall(&before);
            self.culler.cull_into(camera, &mut self.found);
            least = least.min(self.found.times.total().as_nanos() as f64 / 1000.0);
        }
        let survives = |object: &u32| self.found.visible.binary_search(object).is_ok();
        self.culled += hidden.iter().filter(|&object| !survives(object)).count() as u64;
        let lost = reference
            .visible_objects()
            .filter(|object| !survives(object));
        self.false_culls += lost.count() as u64;
        self.triangles += self.found.statistics.occluder_triangles;
        self.time_us += least;
    }

    fn point(&self, frames: usize, hidden: u64) -> SweepPoint {
        let settings = self.culler.settings();
        let frames = frames.max(1) as f64;
        SweepPoint {
            occluders: settings.occluders.to_string(),
            budget: settings.budget.to_string(),
            occluder_triangles: self.triangles as f64 / frames,
            culled_of_hidden: if hidden == 0 {
                1.0
            } else {
                self.culled as f64 / hidden as f64
            },
            time_us: self.time_us / frames,
            false_culls: self.false_culls,
        }
    }
}
