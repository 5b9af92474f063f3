//! How much effort a frame is worth: what occlusion costs against what it spares.
//!
//! Costs are counted work at fixed prices, in nanoseconds of a machine that nobody has: the same on every machine, so that
//! decisions are. What drawing costs is for the user to say, or to learn ([`PriceLearner`]). A wrong price makes a frame slower, never
//! wrong: what is skipped is drawn.

use std::time::Duration;

use glam::DVec3;

use super::skips::Skip;
use super::traverse::MayCover;
use super::{Frame, Statistics};
use crate::view::Camera;

/// What it costs whoever draws the survivors to draw one, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prices {
    /// An object, without its triangles: a draw call.
    pub object: f64,
    /// A triangle.
    pub triangle: f64,
}

impl Default for Prices {
    /// A draw call of 5 µs, and triangles of a nanosecond: dear enough for all culling that hides something.
    fn default() -> Prices {
        Prices {
            object: 5000.0,
            triangle: 1.0,
        }
    }
}

impl Prices {
    /// What it costs to draw an object of so many triangles, in nanoseconds.
    pub fn of(&self, triangles: f64) -> f64 {
        self.object + self.triangle * triangles
    }
}

/// What a frame may leave out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Whether it takes from the last one's answer what still holds: all of it where neither the camera nor the scene has changed,
    /// and all but what they touch where a few objects have moved. (The latter only if occluders are chosen by contribution, and
    /// nothing may be lost.) A budget of time has every frame find out everything.
    pub reuse: bool,
    /// Whether it does without occlusion, and finds what is in the frustum alone, where looking for what is hidden costs more than
    /// drawing it; and does not ask about objects that cost less to draw. Only if occluders are chosen by contribution.
    pub skip: bool,
    /// What drawing costs.
    pub prices: Prices,
}

impl Default for Effort {
    /// Everything that pays is left out, with prices that make nearly all culling pay.
    fn default() -> Effort {
        Effort {
            reuse: true,
            skip: true,
            prices: Prices::default(),
        }
    }
}

impl Effort {
    /// Nothing is left out.
    pub const FULL: Effort = Effort {
        reuse: false,
        skip: false,
        prices: Prices {
            object: f64::INFINITY,
            triangle: 0.0,
        },
    };
}

/// What steps cost, in nanoseconds: about what they take on an AMD EPYC with AVX-512.
const TRIANGLE: f64 = 25.0;
const CLUSTER: f64 = 100.0;
const NODE: f64 = 40.0;
const RECTANGLE: f64 = 60.0;
/// A closer look at an object than its rectangle,
pub const CLOSE_LOOK: f64 = 300.0;
/// and looking for what might cover it, and drawing that.
pub const GAP: f64 = 1500.0;

/// What a frame with occlusion costs for each object in its frustum, before anything is known of it.
const OBJECT: f64 = 300.0;

/// Of what may be covered so much is hidden, at a guess: boxes reach over the borders of what covers them.
const HIDDEN_OF_COVERED: f64 = 0.5;

/// An object that may cover so much of the picture is worth a try.
const LARGE: f64 = 1.0 / 64.0;

/// When occlusion has not paid twice in a row, it is left out for two frames, and if it does not pay after that for four, eight …, and for
/// this many at the most.
const LONGEST_PAUSE: u32 = 64;
/// It is tried again at once when there are so many times as many objects, or so many times as much of the picture may be covered,
const MUCH_MORE: f64 = 1.5;
/// or the camera has turned by more than the angle with this cosine: 30 degrees.
const TURNED: f64 = 0.866;

/// What a frame costs that has done so much, in nanoseconds.
fn cost_of(did: &Statistics, clusters: usize) -> f64 {
    TRIANGLE * did.occluder_triangles as f64
        + CLUSTER * clusters as f64
        + NODE * did.nodes_tested as f64
        + RECTANGLE * (did.objects_asked + did.occluders_asked) as f64
        + CLOSE_LOOK * did.objects_tested as f64
        + GAP * did.objects_in_question as f64
}

/// Whether occlusion has paid of late.
#[derive(Clone, Debug, Default)]
pub struct Worth {
    /// How many times in a row it has not.
    unpaid: u32,
    /// For how many frames it is left out.
    pause: u32,
    /// How much of the picture could be covered when it was first left out.
    covered: Option<f64>,
    /// How many objects there were when it was last tried, and whither the camera looked.
    objects: u64,
    forward: DVec3,
}

impl Worth {
    /// Forgets all.
    pub fn clear(&mut self) {
        *self = Worth::default();
    }

    /// Whether occlusion is to be left out, as far as nothing has changed.
    pub fn pauses(&self) -> bool {
        self.pause > 0
    }

    /// Whether a frame is to do without occlusion, and why: of `objects` in the frustum, which cost `price` each to draw.
    fn skip(
        &mut self,
        camera: &Camera,
        objects: usize,
        price: f64,
        MayCover {
            times: covered,
            largest,
        }: MayCover,
        is_known: bool,
    ) -> Option<Skip> {
        if self.pause > 0 {
            self.pause -= 1;
            let before = *self.covered.get_or_insert(covered);
            let are_more = objects as f64 > self.objects as f64 * MUCH_MORE;
            let is_turned = self.forward.dot(camera.forward()) < TURNED;
            if covered <= before * MUCH_MORE && !are_more && !is_turned {
                return Some(Skip::OcclusionLittleHidden);
            }
            *self = Worth::default();
        }
        let share = if covered < 1.0 { covered } else { 1.0 };
        let spared = objects as f64 * price * share * HIDDEN_OF_COVERED;
        let cost = OBJECT * objects as f64;
        (!is_known && largest < LARGE && spared < cost).then_some(Skip::OcclusionLittleCovers)
    }

    /// Notes what a frame with occlusion did, which hid so many of its objects that cost `price` each to draw.
    fn judge(
        &mut self,
        camera: &Camera,
        did: &Statistics,
        clusters: usize,
        [hidden, objects]: [u64; 2],
        price: f64,
    ) {
        if hidden as f64 * price >= cost_of(did, clusters) {
            self.clear();
            return;
        }
        self.pause = match self.unpaid {
            0 => 0,
            times => 1 << times.min(LONGEST_PAUSE.ilog2()),
        };
        self.unpaid += 1;
        self.covered = None;
        self.objects = objects;
        self.forward = camera.forward();
    }
}

impl Frame<'_> {
    /// Whether an object costs less to draw than a step does.
    pub(super) fn is_cheaper(&self, object: u32, step: f64) -> bool {
        let Effort { skip, prices, .. } = self.settings.effort;
        skip && prices.object < step && {
            let mesh = self.scene.objects()[object as usize].mesh;
            prices.of(self.scene.meshes()[mesh].triangles.len() as f64) < step
        }
    }

    /// Whether a frame that has listed what is in its frustum is to leave it at that, and why; `is_known`: whether something is
    /// remembered that hides.
    pub(super) fn skips_occlusion(
        &self,
        worth: &mut Worth,
        camera: &Camera,
        objects: usize,
        may_cover: MayCover,
        is_known: bool,
    ) -> Option<Skip> {
        let skips = self.settings.effort.skip;
        { skips }.then(|| worth.skip(camera, objects, self.price, may_cover, is_known))?
    }

    /// Finds out whether occlusion has paid in a frame that kept so many of the objects that their rectangles did not hide.
    pub(super) fn judge_worth(
        &self,
        worth: &mut Worth,
        camera: &Camera,
        did: &Statistics,
        clusters: usize,
        [kept, undecided]: [usize; 2],
    ) {
        if self.settings.effort.skip {
            let objects = did.objects_hidden + undecided as u64;
            let hidden = objects - kept as u64;
            worth.judge(camera, did, clusters, [hidden, objects], self.price);
        }
    }
}

/// Finds out what drawing costs from what it took: the objects and triangles that were drawn, and the time. Later frames count for
/// more.
///
/// Prices that are learned make frames depend on the machine and on chance: they leave out other steps, and lose nothing.
///
/// ```
/// use antumbra::cull::PriceLearner;
/// use std::time::Duration;
///
/// let mut learner = PriceLearner::default();
/// learner.drew(100, 50_000, Duration::from_micros(300));
/// learner.drew(200, 20_000, Duration::from_micros(440));
/// let prices = learner.prices().expect("two different frames");
/// assert!((prices.object - 2000.0).abs() < 50.0 && (prices.triangle - 2.0).abs() < 0.1);
/// ```
#[derive(Clone, Debug, Default)]
pub struct PriceLearner {
    /// Sums of products, of what was drawn with itself and with the time.
    objects: f64,
    both: f64,
    triangles: f64,
    time: [f64; 2],
}

/// What earlier frames still count for, from frame to frame.
const KEPT: f64 = 0.95;

impl PriceLearner {
    /// Notes a frame: how many objects and triangles were drawn, and how long that took.
    pub fn drew(&mut self, objects: u64, triangles: u64, time: Duration) {
        let (o, t) = (objects as f64, triangles as f64);
        let ns = time.as_nanos() as f64;
        let add = |sum: &mut f64, more: f64| *sum = *sum * KEPT + more;
        add(&mut self.objects, o * o);
        add(&mut self.both, o * t);
        add(&mut self.triangles, t * t);
        add(&mut self.time[0], o * ns);
        add(&mut self.time[1], t * ns);
    }

    /// The prices that fit best, in least squares, none below zero. None before frames tell objects and triangles apart.
    pub fn prices(&self) -> Option<Prices> {
        let both = self.both * self.both;
        let apart = self.objects * self.triangles - both;
        if apart.is_nan() || apart <= both * 1e-6 {
            return None;
        }
        let object = (self.time[0] * self.triangles - self.time[1] * self.both) / apart;
        let triangle = (self.time[1] * self.objects - self.time[0] * self.both) / apart;
        Some(if object < 0.0 {
            Prices {
                object: 0.0,
                triangle: self.time[1] / self.triangles,
            }
        } else if triangle < 0.0 {
            Prices {
                object: self.time[0] / self.objects,
                triangle: 0.0,
            }
        } else {
            Prices { object, triangle }
        })
    }
}
