//! The depth test: is a rectangle farther than every occluder surface it overlaps? (HOM chapter 6)
//!
//! Whoever is behind all that was drawn where he stands, and stands wholly within what it covers, is hidden. The second is the
//! overlap test's business; the first takes a boundary that no drawn surface is farther than, and the nearer that is the more
//! lies behind it. What the four representations keep of it:
//!
//! | | keeps | of what |
//! |---|---|---|
//! | `plane` | the farthest depth of all (HOM §6.2) | boxes of what is drawn |
//! | `estimation` | the farthest depth in each of 64×64 cells (HOM §6.3) | rectangles on screen around those boxes |
//! | `no_background` | the nearest surfaces' farthest depth in each half of a tile (HOM §6.4) | what is drawn itself |
//! | `hierarchical` | the nearest surface's depth at each sample, and the farthest of ever larger cells (GW §5.3, LOD §5.3) | what is drawn itself |
//!
//! Invariant: where a sample is covered, no representation has a depth there that is nearer than the nearest drawn surface.
//! Where none is, it may have any, up to the nearest possible (HOM §6.4): the overlap test fails there. Depths of what is drawn
//! are rounded away from the eye, those of what is asked towards it, and "behind" is strictly farther; depths are the larger the
//! nearer.

mod estimation;
mod hierarchical;
mod no_background;
mod plane;

use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

use thiserror::Error;

use super::{Footprint, SampleRect};
use crate::raster::{SurfaceTriangles, TileBuffer};
use crate::view::PictureSize;

pub use estimation::{ESTIMATION_CELLS, EstimationBuffer};
pub use hierarchical::{HierarchicalZ, MOST_NTH};
pub use no_background::is_behind;
pub use plane::FarPlane;

/// What is kept of the depth of occluders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum DepthRepresentation {
    /// The farthest depth of all that is drawn (HOM §6.2).
    Plane,
    /// The farthest depth in each of 64×64 cells (HOM §6.3).
    Estimation,
    /// The depth of the nearest surfaces in each half of a tile (HOM §6.4).
    #[default]
    NoBackground,
    /// A Z-buffer under a pyramid of farthest values, or of the N-th farthest, so that N − 1 samples are ignored in each cell
    /// of a tile's size or larger (GW §5.3).
    Hierarchical {
        /// N: 1 is exact, and exact accuracy takes 1 whatever is asked for; [`MOST_NTH`] at the most.
        nth: NonZeroU32,
    },
}

/// A name that no depth representation has.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("give plane, estimation, no-background or hierarchical")]
pub struct UnknownDepthRepresentation;

impl DepthRepresentation {
    /// The pyramid of farthest values.
    pub const HIERARCHICAL: DepthRepresentation = DepthRepresentation::Hierarchical {
        nth: NonZeroU32::MIN,
    };

    /// All of them, from the coarsest to the finest.
    pub const ALL: [DepthRepresentation; 4] = [
        DepthRepresentation::Plane,
        DepthRepresentation::Estimation,
        DepthRepresentation::NoBackground,
        DepthRepresentation::HIERARCHICAL,
    ];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            DepthRepresentation::Plane => "plane",
            DepthRepresentation::Estimation => "estimation",
            DepthRepresentation::NoBackground => "no-background",
            DepthRepresentation::Hierarchical { .. } => "hierarchical",
        }
    }

    /// Which of the farthest values are kept; 1 but for a pyramid that says otherwise.
    pub fn nth(self) -> u32 {
        match self {
            DepthRepresentation::Hierarchical { nth } => nth.get(),
            _ => 1,
        }
    }
}

impl fmt::Display for DepthRepresentation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for DepthRepresentation {
    type Err = UnknownDepthRepresentation;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let named = |representation: &DepthRepresentation| representation.name() == name;
        DepthRepresentation::ALL
            .into_iter()
            .find(named)
            .ok_or(UnknownDepthRepresentation)
    }
}

/// An occluder that was drawn, as a representation takes it.
#[derive(Clone, Copy, Debug)]
pub struct DrawnSurface<'a> {
    /// The samples that it may cover.
    pub footprint: Footprint,
    /// No sample of it is farther.
    pub farthest_depth: f32,
    /// Its triangles, if they are [asked for](DepthMap::takes_triangles).
    pub triangles: &'a SurfaceTriangles,
}

/// The depth of what was drawn, in one of four representations.
///
/// Each frame: [`clear`](DepthMap::clear), [`note`](DepthMap::note) all that is drawn, [`finish`](DepthMap::finish), and ask
/// whether rectangles are [behind](DepthMap::is_behind), from any number of threads.
#[derive(Clone, Debug, PartialEq)]
pub enum DepthMap {
    /// See [`DepthRepresentation::Plane`].
    Plane(FarPlane),
    /// See [`DepthRepresentation::Estimation`].
    Estimation(EstimationBuffer),
    /// See [`DepthRepresentation::NoBackground`]: drawing leaves it in the tiles, and there is nothing to note.
    NoBackground,
    /// See [`DepthRepresentation::Hierarchical`].
    Hierarchical(HierarchicalZ),
}

impl DepthMap {
    /// An empty one.
    pub fn new(representation: DepthRepresentation, size: PictureSize) -> DepthMap {
        match representation {
            DepthRepresentation::Plane => DepthMap::Plane(FarPlane::default()),
            DepthRepresentation::Estimation => DepthMap::Estimation(EstimationBuffer::new(size)),
            DepthRepresentation::NoBackground => DepthMap::NoBackground,
            DepthRepresentation::Hierarchical { nth } => {
                DepthMap::Hierarchical(HierarchicalZ::new(size, nth))
            }
        }
    }

    /// Whether [`DepthMap::note`] has to know the triangles of what is drawn within a footprint.
    pub fn takes_triangles(&self, footprint: Footprint) -> bool {
        match self {
            DepthMap::Hierarchical(z) => !z.is_farther_than_drawn(footprint),
            _ => false,
        }
    }

    /// Forgets all that was drawn.
    pub fn clear(&mut self) {
        match self {
            DepthMap::Plane(plane) => plane.clear(),
            DepthMap::Estimation(buffer) => buffer.clear(),
            DepthMap::NoBackground => {}
            DepthMap::Hierarchical(z) => z.clear(),
        }
    }

    /// Takes in what is drawn. The order makes no difference.
    pub fn note(&mut self, drawn: &DrawnSurface<'_>) {
        match self {
            DepthMap::Plane(plane) => plane.note(drawn),
            DepthMap::Estimation(buffer) => buffer.note(drawn),
            DepthMap::NoBackground => {}
            DepthMap::Hierarchical(z) => z.note(drawn),
        }
    }

    /// Ends drawing: builds what questions read.
    pub fn finish(&mut self) {
        if let DepthMap::Hierarchical(z) = self {
            z.finish();
        }
    }

    /// Whether a rectangle is strictly farther than all that was drawn where it stands. `tiles` are those that the same
    /// surfaces were drawn into.
    pub fn is_behind(&self, tiles: &TileBuffer, rect: &SampleRect) -> bool {
        match self {
            DepthMap::Plane(plane) => plane.is_behind(rect),
            DepthMap::Estimation(buffer) => buffer.is_behind(rect),
            DepthMap::NoBackground => is_behind(tiles, rect),
            DepthMap::Hierarchical(z) => z.is_behind(rect),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for representation in DepthRepresentation::ALL {
            assert_eq!(representation.to_string().parse(), Ok(representation));
        }
        assert_eq!(
            "hiz".parse::<DepthRepresentation>(),
            Err(UnknownDepthRepresentation)
        );
        assert_eq!(
            DepthRepresentation::default(),
            DepthRepresentation::NoBackground
        );
    }
}
