//! A single plane (HOM §6.2): perpendicular to the view, through the farthest point of all that is drawn.
//!
//! Every occluder counts for every question, wherever they stand on screen: one that is far away puts the plane beyond most of
//! what could be hidden. It takes a comparison to note an occluder and one to ask.

use antumbra_simd::tile::UNCOVERED;

use super::DrawnSurface;
use crate::occlusion::SampleRect;

/// The farthest depth of all that was drawn; see the module [`depth`](crate::occlusion).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarPlane {
    farthest: f32,
}

impl Default for FarPlane {
    fn default() -> FarPlane {
        FarPlane {
            farthest: UNCOVERED,
        }
    }
}

impl FarPlane {
    /// Forgets all that was drawn.
    pub fn clear(&mut self) {
        *self = FarPlane::default();
    }

    /// Moves the plane behind what is drawn.
    pub fn note(&mut self, drawn: &DrawnSurface<'_>) {
        self.farthest = self.farthest.min(drawn.farthest_depth);
    }

    /// Whether a rectangle is wholly behind the plane.
    pub fn is_behind(&self, rect: &SampleRect) -> bool {
        rect.nearest_depth < self.farthest
    }
}
