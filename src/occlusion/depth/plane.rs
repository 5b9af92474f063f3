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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occlusion::Footprint;
    use crate::raster::SurfaceTriangles;

    #[test]
    fn the_farthest_counts_wherever_it_is_and_as_far_is_not_behind() {
        let mut plane = FarPlane::default();
        let is_behind = |plane: &FarPlane, nearest_depth| {
            plane.is_behind(&SampleRect {
                x: [3, 4],
                y: [3, 4],
                nearest_depth,
            })
        };
        assert!(
            is_behind(&plane, 1.0),
            "nothing is drawn: the overlap test decides"
        );
        for (farthest_depth, expected) in [(0.5, 0.5), (0.75, 0.5), (0.25, 0.25)] {
            plane.note(&DrawnSurface {
                footprint: Footprint::Nowhere,
                farthest_depth,
                triangles: &SurfaceTriangles::default(),
            });
            assert!(!is_behind(&plane, expected) && is_behind(&plane, expected.next_down()));
        }
        plane.clear();
        assert!(is_behind(&plane, 0.75));
    }
}
