//! Projects the corners of a box to the screen: extents and what is nearest.

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

/// Projects corners, given in the coordinates that `t` takes; none if a corner is at or behind the near plane, or not
/// finite.
///
/// Values are as exact as f64 makes them (the bound stands in [`crate::vertex`]); the caller grows them.
#[inline]
pub fn project_corners(t: &ScreenTransform, corners: &[[f64; 3]; 8]) -> Option<(Corners, Extent)> {
    let row = |r: &[f64; 4], p: [f64; 3]| ((r[0] * p[0] + r[1] * p[1]) + r[2] * p[2]) + r[3];
    let least = |a: f64, b: f64| if b < a { b } else { a };
    let largest = |a: f64, b: f64| if b > a { b } else { a };
    let mut extent = Extent {
        x: [f64::INFINITY, f64::NEG_INFINITY],
        y: [f64::INFINITY, f64::NEG_INFINITY],
        depth: f64::NEG_INFINITY,
        w: f64::INFINITY,
    };
    let mut projected = Corners {
        x: [0.0; 8],
        y: [0.0; 8],
        depth: [0.0; 8],
        w: [0.0; 8],
    };
    for (i, &p) in corners.iter().enumerate() {
        let (w, depth) = (row(&t.w, p), row(&t.depth, p));
        let (x, y) = (row(&t.x, p) / w, row(&t.y, p) / w);
        let in_front = w > 0.0 && depth < t.near_depth * w;
        if !(in_front && x.is_finite() && y.is_finite() && depth.is_finite()) {
            return None;
        }
        extent.x = [least(extent.x[0], x), largest(extent.x[1], x)];
        extent.y = [least(extent.y[0], y), largest(extent.y[1], y)];
        extent.depth = largest(extent.depth, depth);
        extent.w = least(extent.w, w);
        (projected.x[i], projected.y[i]) = (x, y);
        (projected.depth[i], projected.w[i]) = (depth, w);
    }
    Some((projected, extent))
}
