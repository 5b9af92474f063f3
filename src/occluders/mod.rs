//! Which objects to draw as occluders this frame, and in which order.

mod nearest;

pub use nearest::{distance_keys, object_of, sort_nearest};

/// How many triangles may be drawn as occluders in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Budget {
    /// Every candidate's.
    #[default]
    All,
    /// Candidates are drawn in order for as long as they fit (HOM §7.3.2).
    Triangles(u64),
}

impl Budget {
    /// Whether `triangles` in all are within the budget.
    pub fn allows(self, triangles: u64) -> bool {
        match self {
            Budget::All => true,
            Budget::Triangles(most) => triangles <= most,
        }
    }
}
