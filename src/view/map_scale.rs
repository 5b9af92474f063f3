//! How much coarser than the picture an occlusion map is.
//!
//! A coarse sample stands for a square block of the picture's pixel centres. What is said of it has to hold for all of them,
//! whichever way it is asked:
//!
//! ```text
//!   o   o   o   o      o  a pixel's centre
//!                      x  the sample of a map at a quarter, which stands for 16 of them
//!   o   o   o   o
//!         x            An occluder covers the sample if the square around the 16 centres lies within its edges:
//!   o   o   o   o      they are pulled in by half the square's side (`inset`). An object may show at the sample if
//!                      its outline, moved out by as much (`reach`), holds it. Depths are taken anywhere in the
//!   o   o   o   o      square.
//! ```
//!
//! Vertices snap to a grid of 1/256 of a sample, so those of an occluder lie elsewhere in the map than in the picture: by no more
//! than half a step of either grid. The inset has room for twice that.

use std::fmt;
use std::str::FromStr;

use antumbra_simd::SUBPIXELS;
use antumbra_simd::vertex::ScreenTransform;

use super::PictureSize;

/// How many of the picture's pixels lie along the edge of a map's (HOM §8.2.2 draws occluders at a quarter of the final size).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MapScale {
    /// One: a sample of the map is a pixel's centre.
    #[default]
    Full,
    /// Two.
    Half,
    /// Four.
    Quarter,
}

impl MapScale {
    /// From the finest to the coarsest.
    pub const ALL: [MapScale; 3] = [MapScale::Full, MapScale::Half, MapScale::Quarter];

    /// Pixels along the edge.
    pub const fn pixels(self) -> u32 {
        match self {
            MapScale::Full => 1,
            MapScale::Half => 2,
            MapScale::Quarter => 4,
        }
    }

    /// How far the centres of a block reach from its middle along an axis, in sub-pixels of the map.
    pub(crate) const fn reach(self) -> i32 {
        let pixels = self.pixels() as i32;
        SUBPIXELS / 2 * (pixels - 1) / pixels
    }

    /// Sub-pixels of the map by which occluders are pulled in.
    pub(crate) const fn inset(self) -> i32 {
        match self {
            MapScale::Full => 0,
            // Half a step of the map's grid and a fourth or an eighth of one, twice.
            MapScale::Half | MapScale::Quarter => self.reach() + 2,
        }
    }

    /// The size of the map of a picture.
    pub fn map_size(self, picture: PictureSize) -> PictureSize {
        picture.divided_by(self.pixels())
    }

    /// From coordinates to the map, if `screen` leads to the picture. Exact: numbers are divided by a power of two.
    pub(crate) fn map_from(self, screen: &ScreenTransform) -> ScreenTransform {
        let share = 1.0 / f64::from(self.pixels());
        ScreenTransform {
            x: screen.x.map(|v| v * share),
            y: screen.y.map(|v| v * share),
            ..*screen
        }
    }
}

impl fmt::Display for MapScale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.pixels().fmt(f)
    }
}

impl FromStr for MapScale {
    type Err = String;

    fn from_str(text: &str) -> Result<MapScale, String> {
        let known = MapScale::ALL.into_iter();
        let named = |scale: &MapScale| scale.to_string() == text;
        { known }
            .find(named)
            .ok_or_else(|| "give 1, 2 or 4".to_owned())
    }
}
