//! What each way to choose occluders hides, for what budget.
//!
//! Every frame is drawn exactly once, and culled with every selection and budget; and once more behind the clusters that an
//! [`Oracle`] names, which own the most pixels of that frame for their triangles.

use rayon::ThreadPoolBuildError;
use serde::Serialize;

use super::Reference;
use super::oracle::{Oracle, Owner, within};
use crate::cull::{Culler, Settings, VisibleSet};
use crate::occluders::{Budget, Selection};
use crate::prepare::Prepared;
use crate::view::{Camera, CameraPath};

/// What the clusters that own the most pixels go by in place of a selection's name.
pub const ORACLE: &str = "oracle";

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
}

/// The settings that all points share.
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
    /// Every how many frames one is judged.
    pub every: usize,
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
    /// Selection by selection and the oracle last, each from the smallest budget to none.
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
            let settings = Settings {
                occluders,
                budget,
                ..settings.cull
            };
            runs.push(Run::new(occluders.name(), first.another(settings)?));
        }
    }
    let budgets = settings.budgets.iter().copied().map(Budget::Triangles);
    for budget in budgets.chain([Budget::All]) {
        let settings = Settings {
            budget,
            ..settings.cull
        };
        runs.push(Run::new(ORACLE, first.another(settings)?));
    }
    let oracle = Oracle::new(scene, first.clusters());
    let cameras = path.cameras();
    on_frame(0, cameras.len());
    let (mut frames, mut hidden) = (0, 0);
    for (number, camera) in cameras.iter().enumerate() {
        if number % every != 0 {
            for run in runs.iter_mut().filter(|run| run.name != ORACLE) {
                run.culler.cull_into(camera, &mut run.found);
            }
        } else {
            let reference = Reference::new(scene, camera, settings.cull.size);
            let in_frustum = first.in_frustum(camera);
            let is_hidden = |object: &&u32| !reference.is_visible(**object);
            let of_frame: Vec<u32> = in_frustum.iter().filter(is_hidden).copied().collect();
            let owners = oracle.owners(camera, settings.cull.size);
            frames += 1;
            hidden += of_frame.len() as u64;
            for run in &mut runs {
                run.judge(camera, &reference, &owners, &of_frame);
            }
        }
        on_frame(number + 1, cameras.len());
    }
    Ok(Sweep {
        objects: scene.objects().len() as u64,
        triangles: scene.triangle_count(),
        settings: shared(settings, first.threads()),
        frames,
        points: runs.iter().map(|run| run.point(frames, hidden)).collect(),
    })
}

fn shared(settings: &SweepSettings, threads: usize) -> SweptWith {
    let Settings {
        size,
        accuracy,
        level,
        ..
    } = settings.cull;
    let approximation = accuracy.approximation();
    SweptWith {
        size: [size.width(), size.height()],
        threads,
        simd: level.to_string(),
        accuracy: approximation.map_or("exact", |_| "approximate").into(),
        hole: approximation.map_or(0, |a| a.hole),
        every: settings.every.max(1),
    }
}

/// A culler, and what came of its frames.
struct Run {
    /// Of its selection, or [`ORACLE`].
    name: &'static str,
    culler: Culler,
    found: VisibleSet,
    triangles: u64,
    culled: u64,
    false_culls: u64,
    time_us: f64,
}

impl Run {
    fn new(name: &'static str, culler: Culler) -> Run {
        Run {
            name,
            culler,
            found: VisibleSet::default(),
            triangles: 0,
            culled: 0,
            false_culls: 0,
            time_us: 0.0,
        }
    }

    fn judge(&mut self, camera: &Camera, reference: &Reference, owners: &[Owner], hidden: &[u32]) {
        let before = self.culler.remembered().clone();
        let mut least = f64::INFINITY;
        for _ in 0..REPEATS {
            if self.name == ORACLE {
                let best = within(self.culler.settings().budget, owners);
                self.culler.cull_behind(camera, &best, &mut self.found);
            } else {
                self.culler.recall(&before);
                self.culler.cull_into(camera, &mut self.found);
            }
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
            occluders: self.name.to_owned(),
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
