//! The depth of a polygon over tile parts: nowhere nearer than what the final pass writes at any of their samples.
//!
//! The final pass writes the f64 formula of [`DepthPlane`]. Parts need a bound only, and take one in f32 that a vector of
//! parts finds with two additions, a multiplication and a clamp:
//!
//! ```text
//!   (at + per_row·(row − first row)) + per_tile·(tile − first tile)      between `farthest` and `nearest`
//! ```
//!
//! with the part's farthest row, within the polygon's extent, and `at` taken at the farthest column of the first tile (of
//! the extent, where there is only one column of tiles). Let `M` be the largest of the depths, plus what the slopes make of
//! the extent and two tiles more: no number in either formula is larger. The one in f32 is off by seven roundings of
//! such numbers, `2⁻²⁴·M` each. The one in f64 is off by `2⁻²²·M` at most ([`DepthPlane::SLOPE_ERROR`]), at the sample, at the
//! corner where the plane is taken, and where a quadrilateral's fourth corner was compared. `2⁻¹⁹·M` is taken off for all.
//! Where f32 is subnormal its roundings are off by `2⁻¹⁵⁰` each, however small the number; that of a slope counts as often as
//! there are rows or tiles, `2¹⁴` at the most. So `2⁻¹³⁴` more is taken off.

use crate::order::greater;
use crate::triangle::DepthPlane;
use crate::{SUBPIXELS, TILE_SIZE};

/// What is taken off, as a part of the largest number that occurs.
pub(crate) const ROUNDING: f64 = 1.0 / (1_u64 << 19) as f64;

/// What is taken off besides, for depths that are subnormal in f32.
pub(crate) const SUBNORMAL_ROUNDING: f64 = f64::from_bits((1023 - 134) << 52);

/// Where numbers are larger than this, the whole polygon is given its farthest depth.
pub(crate) const LARGEST: f64 = 1e30;

/// Depths of a polygon over tile parts; see the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartDepth {
    /// The depth at the first row of samples, in the first column of tiles.
    pub at: f32,
    /// What one row of samples adds.
    pub per_row: f32,
    /// What one column of tiles adds.
    pub per_tile: f32,
    /// The least of the corners' depths.
    pub farthest: f32,
    /// The largest of the corners' depths.
    pub nearest: f32,
    /// The first row of samples.
    pub first_row: i32,
    /// The first column of tiles.
    pub first_tile: i32,
}

impl PartDepth {
    /// The depth of a polygon with a plane, whose corners reach over `extent` sub-pixels across and down and whose samples
    /// lie in columns `x` and rows `y`, and reach `inset` sub-pixels around.
    pub fn new(
        plane: &DepthPlane,
        extent: [f64; 2],
        x: [i32; 2],
        y: [i32; 2],
        inset: i32,
    ) -> PartDepth {
        let per_subpixel = 1.0 / f64::from(SUBPIXELS);
        let [across, down] = extent.map(|e| e * per_subpixel);
        let tiles = x.map(|x| x / TILE_SIZE);
        let column = if tiles[0] == tiles[1] {
            x
        } else {
            [tiles[0] * TILE_SIZE, tiles[0] * TILE_SIZE + TILE_SIZE - 1]
        }[usize::from(plane.slope_x < 0.0)];
        let (steep_x, steep_y) = (plane.slope_x.abs(), plane.slope_y.abs());
        let largest = (greater(plane.nearest.abs(), plane.farthest.abs())
            + steep_x * (across + 16.0))
            + steep_y * (down + 16.0);
        let at = (plane.depth + plane.slope_y * (f64::from(y[0]) - plane.origin_y))
            + plane.slope_x * (f64::from(column) - plane.origin_x);
        let at = at - (steep_x + steep_y) * (f64::from(inset) * per_subpixel);
        // Not for a NaN either.
        let is_sloped = largest <= LARGEST;
        let if_sloped = |sloped: f64, flat: f64| (if is_sloped { sloped } else { flat }) as f32;
        PartDepth {
            at: if_sloped(
                at - (largest * ROUNDING + SUBNORMAL_ROUNDING),
                plane.farthest,
            ) + 0.0,
            per_row: if_sloped(plane.slope_y, 0.0),
            per_tile: if_sloped(plane.slope_x * f64::from(TILE_SIZE), 0.0),
            // There is one zero only, for least and largest to be the same on all machines.
            farthest: plane.farthest as f32 + 0.0,
            nearest: plane.nearest as f32 + 0.0,
            first_row: y[0],
            first_tile: tiles[0],
        }
    }

    /// A depth that none of the samples in rows `y`, within the polygon's extent, of a column of tiles is farther than.
    #[inline]
    pub fn over(&self, tile_x: i32, y: [i32; 2]) -> f32 {
        let row = y[usize::from(self.per_row < 0.0)];
        let depth = (self.at + self.per_row * (row - self.first_row) as f32)
            + self.per_tile * (tile_x - self.first_tile) as f32;
        let depth = if depth > self.farthest {
            depth
        } else {
            self.farthest
        };
        if depth > self.nearest {
            self.nearest
        } else {
            depth
        }
    }
}
