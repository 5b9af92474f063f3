//! Which objects to draw as occluders this frame, and in which order.

use std::fmt;

mod contribution;
mod nearest;
mod promise;

pub use contribution::{ClusterId, Contributions};
pub use nearest::{distance_keys, object_of, sort_nearest};
pub use promise::keep_promising;

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
}

/// How occluders are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Selection {
    /// The nearest objects (HOM §7.3.2).
    Nearest,
    /// The clusters that added most in the frames before, and what came into view.
    #[default]
    Contribution,
}

impl Selection {
    /// All of them.
    pub const ALL: [Selection; 2] = [Selection::Nearest, Selection::Contribution];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Selection::Nearest => "nearest",
            Selection::Contribution => "contribution",
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
            Budget::All | Budget::Auto => u64::MAX,
            Budget::Triangles(most) => most.saturating_sub(drawn),
        }
    }
}
