//! Which objects to draw as occluders this frame, and in which order.

use std::fmt;
use std::time::Duration;

mod contribution;
mod last_frame;
mod nearest;
mod promise;
mod solid_angle;
mod weight;
mod z_plane;

pub use contribution::Contributions;
pub use last_frame::{FramesBack, LastFrame};
pub use nearest::{distance_keys, object_of, sort_nearest};
pub use promise::keep_promising;
pub use solid_angle::solid_angle_keys;
pub use weight::{Weighing, keep_active, weight_keys};
pub use z_plane::z_plane_keys;

use crate::prepare::ClusterId;
use crate::scene::{Aabb, Scene};

/// The key of an object that sorts by a number that is not negative, ties in scene order.
fn key(number: f32, object: u32) -> u64 {
    // Bits of floats that are not negative sort as the floats do.
    u64::from(number.to_bits()) << 32 | u64::from(object)
}

/// The same, the largest number first.
fn key_of_largest(number: f32, object: u32) -> u64 {
    u64::from(!number.to_bits()) << 32 | u64::from(object)
}

fn objects_and_bounds(
    scene: &Scene,
    objects: impl Iterator<Item = u32>,
) -> impl Iterator<Item = (u32, &Aabb)> {
    objects.map(|object| (object, &scene.bounds()[object as usize]))
}

/// How many triangles may be drawn as occluders in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Budget {
    /// Every candidate's.
    All,
    /// As many as pay, by counted work: the same on any machine.
    #[default]
    Auto,
    /// Candidates are drawn in order for as long as they fit (HOM §7.3.2).
    Triangles(u64),
    /// As many as pay, until so much time has gone by since the frame began. This is the one setting by which a result depends on
    /// the machine, and on what else it does: how much is culled, never whether that is right. The time is looked at between
    /// batches and rounds, so that what is begun is finished; what is left is asking, which takes its time besides.
    Time(Duration),
}

/// How occluders are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Selection {
    /// The nearest objects (HOM §7.3.2).
    Nearest,
    /// Those that begin nearest along the view (HOM §7.3.1).
    ZPlane,
    /// Those that look largest.
    SolidAngle,
    /// Those that fill their boxes, are large, near and turned towards the eye (LOD §5.1, §5.2): see [`Weighing`].
    Weight,
    /// Of those that were visible in the last frame or the one before, the nearest (GW §5.2): see [`FramesBack`].
    PreviousVisible,
    /// The nearest of those and of what has entered the frustum (HOM §7.4, equation 7.1).
    Coherent,
    /// The clusters that are seen from the nearest viewpoint of a grid (HOM §7.5); where there is no such viewpoint, the nearest
    /// objects.
    Sampled,
    /// The clusters that the frames before needed, and what closes the gaps between them.
    #[default]
    Contribution,
}

impl Selection {
    /// All of them.
    pub const ALL: [Selection; 8] = [
        Selection::Nearest,
        Selection::ZPlane,
        Selection::SolidAngle,
        Selection::Weight,
        Selection::PreviousVisible,
        Selection::Coherent,
        Selection::Sampled,
        Selection::Contribution,
    ];

    /// Whether objects are taken nearest first.
    pub fn is_by_distance(self) -> bool {
        !matches!(
            self,
            Selection::ZPlane | Selection::SolidAngle | Selection::Weight
        )
    }

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Selection::Nearest => "nearest",
            Selection::ZPlane => "z-plane",
            Selection::SolidAngle => "solid-angle",
            Selection::Weight => "weight",
            Selection::PreviousVisible => "previous-visible",
            Selection::Coherent => "coherent",
            Selection::Sampled => "sampled",
            Selection::Contribution => "contribution",
        }
    }
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Budget::All => f.pad("all"),
            Budget::Auto => f.pad("auto"),
            Budget::Triangles(triangles) => write!(f, "{triangles}"),
            Budget::Time(time) => write!(f, "{}us", time.as_nanos() as f64 / 1000.0),
        }
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A cluster that was drawn as an occluder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawnCluster {
    /// Which.
    pub id: ClusterId,
    /// Its triangles, before clipping and culling by facing.
    pub triangles: u32,
    /// How many samples it took over from what was drawn before it.
    pub gain: u32,
}

impl Budget {
    /// How many triangles more may be drawn after so many.
    pub fn left(self, drawn: u64) -> u64 {
        match self {
            Budget::All | Budget::Auto | Budget::Time(_) => u64::MAX,
            Budget::Triangles(most) => most.saturating_sub(drawn),
        }
    }

    /// Whether only what pays is drawn.
    pub fn is_for_what_pays(self) -> bool {
        matches!(self, Budget::Auto | Budget::Time(_))
    }

    /// After how much time of a frame no more is drawn.
    pub fn time(self) -> Option<Duration> {
        match self {
            Budget::Time(time) => Some(time),
            Budget::All | Budget::Auto | Budget::Triangles(_) => None,
        }
    }
}
