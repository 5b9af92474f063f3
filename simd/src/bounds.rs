//! Projects the corners of a box to the screen: extents and what is nearest.

use crate::order::{greater, lesser};
use crate::vertex::ScreenTransform;

/// What the corners of a box span on screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Least and largest x, in sub-pixels.
    pub x: [f64; 2],
    /// Least and largest y, in sub-pixels.
    pub y: [f64; 2],
    /// The largest D of a corner (see [`ScreenTransform`]).
    pub depth: f64,
    /// The least W of a corner.
    pub w: f64,
}

/// The corners of a box on screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corners {
    /// X / W of each, in sub-pixels.
    pub x: [f64; 8],
    /// Y / W of each, in sub-pixels.
    pub y: [f64; 8],
    /// D of each (see [`ScreenTransform`]).
    pub depth: [f64; 8],
    /// W of each.
    pub w: [f64; 8],
}

/// The least of eight numbers.
#[inline(always)]
pub(crate) fn least_of(v: &[f64; 8]) -> f64 {
    let mut four = [0.0; 4];
    for i in 0..4 {
        four[i] = lesser(v[i], v[i + 4]);
    }
    lesser(lesser(four[0], four[2]), lesser(four[1], four[3]))
}

/// The largest of eight numbers.
#[inline(always)]
pub(crate) fn largest_of(v: &[f64; 8]) -> f64 {
    let mut four = [0.0; 4];
    for i in 0..4 {
        four[i] = greater(v[i], v[i + 4]);
    }
    greater(greater(four[0], four[2]), greater(four[1], four[3]))
}

#[inline(always)]
fn row(r: &[f64; 4], [x, y, z]: &[[f64; 8]; 3]) -> [f64; 8] {
    let mut of = [0.0; 8];
    for i in 0..8 {
        of[i] = ((r[0] * x[i] + r[1] * y[i]) + r[2] * z[i]) + r[3];
    }
    of
}

/// Projects corners, given by x, y and z in the coordinates that `t` takes; none if a corner is at or behind the near
/// plane, or not finite.
///
/// Values are as exact as f64 makes them (the bound stands in [`crate::vertex`]); the caller grows them.
#[inline(always)]
pub fn project_corners(t: &ScreenTransform, corners: &[[f64; 8]; 3]) -> Option<(Corners, Extent)> {
    let (w, depth) = (row(&t.w, corners), row(&t.depth, corners));
    let (mut x, mut y) = (row(&t.x, corners), row(&t.y, corners));
    let mut in_front = true;
    for i in 0..8 {
        x[i] /= w[i];
        y[i] /= w[i];
        in_front &= w[i] > 0.0 && depth[i] < t.near_depth * w[i];
        in_front &= x[i].is_finite() && y[i].is_finite() && depth[i].is_finite();
    }
    if !in_front {
        return None;
    }
    let extent = Extent {
        x: [least_of(&x), largest_of(&x)],
        y: [least_of(&y), largest_of(&y)],
        depth: largest_of(&depth),
        w: least_of(&w),
    };
    Some((Corners { x, y, depth, w }, extent))
}
