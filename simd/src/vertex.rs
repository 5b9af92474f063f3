//! Transforms vertex positions to homogeneous screen space and snaps them to the sub-pixel grid.
//!
//! The transform runs in f64, from the f32 position to the division: the eye has been subtracted before the matrix
//! was made, and a world of ±200,000 units loses nothing. Every pass uses these same snapped vertices, which is why a
//! picture with culling equals the picture without.
//!
//! Error bound, written once for all who rely on it: each of the four sums has three products and three additions of
//! terms bounded by `|row|·(|p|, 1)`, so it is off by at most 4·2⁻⁵³ of that magnitude (Higham's γ₄ for f64). The
//! snapped coordinate adds at most half a sub-pixel: 1/512 pixel.

use crate::GUARD_BAND;

/// From a mesh's local coordinates to homogeneous screen space. Rows of `[x, y, z, 1]` coefficients.
///
/// With `(X, Y, D, W)` the four row products of a position, `X / W` and `Y / W` are the position on screen in
/// sub-pixels (x to the right, y down, the origin at the picture's upper left corner) and `D / W` is its depth:
/// linear on screen, and the larger the nearer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenTransform {
    /// Gives X.
    pub x: [f64; 4],
    /// Gives Y.
    pub y: [f64; 4],
    /// Gives D.
    pub depth: [f64; 4],
    /// Gives W: the distance along the view direction, or 1 for an orthographic view.
    pub w: [f64; 4],
    /// The depth of the near plane. What has a larger depth is clipped.
    pub near_depth: f64,
    /// The depth of the far plane; minus infinity or 0 where there is none. What has a smaller depth is clipped.
    pub far_depth: f64,
}

/// A vertex in homogeneous screen space; see [`ScreenTransform`] for the units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipVertex {
    /// X: sub-pixels × w.
    pub x: f64,
    /// Y: sub-pixels × w.
    pub y: f64,
    /// D: depth × w.
    pub depth: f64,
    /// W.
    pub w: f64,
}

/// A vertex on the sub-pixel grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenVertex {
    /// Sub-pixels from the picture's left edge, within the guard band.
    pub x: i32,
    /// Sub-pixels from the picture's upper edge, within the guard band.
    pub y: i32,
    /// Depth, the larger the nearer.
    pub depth: f64,
}

#[inline]
fn row(r: &[f64; 4], p: [f64; 3]) -> f64 {
    ((r[0] * p[0] + r[1] * p[1]) + r[2] * p[2]) + r[3]
}

/// One position in homogeneous screen space.
#[inline]
pub fn transform(t: &ScreenTransform, position: [f32; 3]) -> ClipVertex {
    let p = position.map(f64::from);
    ClipVertex {
        x: row(&t.x, p),
        y: row(&t.y, p),
        depth: row(&t.depth, p),
        w: row(&t.w, p),
    }
}

impl ClipVertex {
    /// Whether the vertex lies between the near and far planes and in the guard band, so that it can be snapped as it
    /// is. False for a NaN, and where the band's own extent overflows.
    #[inline]
    pub fn is_inside(&self, t: &ScreenTransform) -> bool {
        let band = f64::from(GUARD_BAND) * self.w;
        self.w > 0.0
            && band < f64::INFINITY
            && self.depth <= t.near_depth * self.w
            && (t.far_depth == f64::NEG_INFINITY || self.depth >= t.far_depth * self.w)
            && self.x.abs() <= band
            && self.y.abs() <= band
    }

    /// Whether the vertex lies in front of the near plane: nothing is seen of a polygon whose vertices all do. False for a
    /// NaN.
    #[inline]
    pub fn is_too_near(&self, t: &ScreenTransform) -> bool {
        self.depth > t.near_depth * self.w
    }

    /// The vertex on the sub-pixel grid, rounded to the nearest point, halves up. Only for a vertex that
    /// [`ClipVertex::is_inside`] (or that clipping put on the border of the inside).
    #[inline]
    pub fn snap(&self) -> ScreenVertex {
        let to_grid = |v: f64| (v + 0.5).floor() as i32;
        let inverse = 1.0 / self.w;
        ScreenVertex {
            x: to_grid(self.x * inverse),
            y: to_grid(self.y * inverse),
            depth: self.depth * inverse,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCREEN: ScreenTransform = ScreenTransform {
        x: [256.0, 0.0, 0.0, 0.0],
        y: [0.0, 256.0, 0.0, 0.0],
        depth: [0.0, 0.0, 0.0, 1.0],
        w: [0.0, 0.0, 1.0, 0.0],
        near_depth: 1.0,
        far_depth: f64::NEG_INFINITY,
    };

    #[test]
    fn snaps_to_the_nearest_grid_point_and_halves_up() {
        let snap = |x: f32| transform(&SCREEN, [x, 0.0, 1.0]).snap().x;
        assert_eq!(snap(1.0), 256);
        assert_eq!(snap(1.0 + 1.0 / 512.0), 257);
        assert_eq!(snap(1.0 - 1.0 / 512.0), 256);
        assert_eq!(snap(-1.0 / 512.0), 0);
        assert_eq!(snap(-1.0 / 511.0), -1);
    }

    #[test]
    fn what_is_not_finite_is_never_inside() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for at in 0..3 {
                let mut p = [0.5, 0.5, 2.0];
                p[at] = bad;
                assert!(!transform(&SCREEN, p).is_inside(&SCREEN), "{p:?}");
            }
        }
        assert!(transform(&SCREEN, [0.5, 0.5, 2.0]).is_inside(&SCREEN));
        let overflown = ClipVertex {
            x: f64::INFINITY,
            y: 0.0,
            depth: 1.0,
            w: f64::MAX / 256.0,
        };
        assert!(!overflown.is_inside(&SCREEN));
    }
}
