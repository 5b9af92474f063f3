//! A box on screen: its outline and its faces, more closely than a rectangle and a nearest depth.
//!
//! Everything here rests on one sentence: **a half-space of the screen that holds the eight corners holds the box.**
//! Perspective division maps straight lines to straight lines where W > 0 (and a box that reaches the near plane never
//! gets here), so in screen space (x, y, depth) the box is the convex hull of its projected corners. That is true of
//! every half-space, however its slope was found, so slopes need no error bound: each is taken from an edge or a face
//! as it comes out, and only the offset is made to hold all eight corners, not just those of that edge or face. A slope
//! spoilt by rounding, or taken from a face whose back is seen, makes a bound that is wide, but a bound.
//!
//! **Outline.** A half-plane of the screen is `x ≥ k·y + m`, or `≤`. A vertex of a triangle inside the box is drawn
//! within `eₓ` and `e_y` of a point of the box's projection, in columns and in rows: snap, position and rounding, as in
//! the caller's documentation of footprints. Moved outwards by `eₓ + |k|·e_y` the half-plane still holds it. Three vertices in a half-plane put their
//! triangle there, and each sample that the triangle covers. So does clipping: what it leaves of a triangle is inside
//! it, and it adds no more than the rounding that the position's error has room for.
//!
//! **Faces.** Likewise with depth: if `d ≤ a·x + b·y + c` at all corners, then a vertex, drawn off by `eₓ`, `e_y` and
//! by `e_d` in depth, keeps `d ≤ a·x + b·y + c + |a|·eₓ + |b|·e_y + e_d`, and the plane through three vertices keeps it
//! at each sample of their triangle, as do its least and its largest depth in their places (a sliver has its farthest
//! depth all over, and a clamp to the vertices' range can only raise a depth to that of the farthest vertex, which is
//! not above the plane). What the triangle's own formula is off by is added,
//! [`DepthPlane::SLOPE_ERROR`](crate::triangle::DepthPlane::SLOPE_ERROR) of the vertices' range of depths, which
//! is within the corners'; and last the rounding of the bound's own evaluation, as 2⁻⁴⁸ of the largest terms it can
//! have, for sums of four terms.
//!
//! No face has to be left out because the eye is close to its plane: it comes out steep, its margin `|a|·eₓ + |b|·e_y`
//! large, and other bounds are lower. Which edges and faces to take is a matter of speed alone.
//!
//! There is one form of this for all levels: plain loops over eight corners, which the compiler turns into whatever
//! vectors there are where they are inlined into a loop of that level. Least and largest are found in halves, so that it
//! can.

use crate::SUBPIXELS;
use crate::bounds::{Corners, Extent, largest_of, least_of, project_corners};
use crate::boxes::BoxView;
use crate::faces::{FacePlane, Faces};
use crate::order::{greater, lesser};
use crate::outline::{Outline, OutlineEdge};
use crate::query::Rectangle;

/// An edge flatter than this many columns a row bounds nothing that the rectangle does not: it would have to be moved
/// outwards by so many columns times the error of rows, 1/512.
const FLATTEST: f64 = (1_u32 << 16) as f64;

/// What a sum of a few products is off by at the most, as a share of the largest terms that it can have: 32 times 2⁻⁵³.
const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

/// No coordinate of a sample is larger.
const LARGEST_SAMPLE: f64 = (1_u32 << 14) as f64;

/// A box with any orientation, in the coordinates that the transform to the screen takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerBox {
    /// x, y and z of the corners; bit `i` of a corner's number chooses its side along axis `i` of the box.
    pub corners: [[f64; 8]; 3],
    /// How far what the box stands for may lie outside it, in scene units.
    pub error: f64,
    /// Whether the box's axes are left-handed.
    pub mirrored: bool,
}

/// A box on screen.
#[derive(Clone, Debug)]
pub struct OnScreen {
    /// Columns of the corners, counting samples.
    x: [f64; 8],
    /// Their rows.
    y: [f64; 8],
    /// Their depths.
    depth: [f64; 8],
    /// How far a vertex of the box's triangles may be drawn from the box's projection: columns and rows.
    error: [f64; 2],
    /// What a vertex's depth may be off by, absolutely and as a share of it.
    depth_error: [f64; 2],
    /// What a depth between vertices may be off by, as a share of their range.
    slope_error: f64,
    /// The largest magnitude of a column and of a row, samples included.
    reach: [f64; 2],
    /// Which faces the eye sees: by axis, then the side where that axis' bit of a corner's number is 0 or 1.
    seen: [[bool; 2]; 3],
}

impl OnScreen {
    /// Projects a box; none if a corner is or may be at or behind the near plane, or is not finite.
    #[inline(always)]
    pub fn new(view: &BoxView, b: &CornerBox) -> Option<(OnScreen, Extent)> {
        let (Corners { x, y, depth, w }, extent) = project_corners(&view.screen, &b.corners)?;
        let [norm_x, norm_y, norm_depth, norm_w] = view.norms;
        let least_w = extent.w - b.error * norm_w;
        let largest_depth = extent.depth + b.error * norm_depth;
        // False for a NaN.
        let is_in_front = least_w > 0.0 && largest_depth < view.screen.near_depth * least_w;
        if !is_in_front {
            return None;
        }
        let mut seen = [[false; 2]; 3];
        for (axis, seen) in seen.iter_mut().enumerate() {
            for (side, seen) in seen.iter_mut().enumerate() {
                let [q0, q1, q2, q3] = face(axis, side);
                let area = (x[q3] - x[q0]) * (y[q2] - y[q1]) - (x[q2] - x[q1]) * (y[q3] - y[q0]);
                *seen = if (side == 1) == b.mirrored {
                    area > 0.0
                } else {
                    area < 0.0
                };
            }
        }
        let (x, y) = (to_samples(&x), to_samples(&y));
        let mut corner_depth = [0.0; 8];
        for i in 0..8 {
            corner_depth[i] = depth[i] / w[i];
        }
        let on_screen = OnScreen {
            x,
            y,
            depth: corner_depth,
            error: [
                screen_error(view, extent.x, norm_x, b.error, least_w),
                screen_error(view, extent.y, norm_y, b.error, least_w),
            ],
            // A vertex's depth, and the 2⁻⁴⁰ of it that the footprint's has, too.
            depth_error: [
                b.error * norm_depth / least_w,
                b.error * norm_w / least_w + 2.0 * view.relative_error,
            ],
            slope_error: view.slope_error,
            reach: [reach(extent.x), reach(extent.y)],
            seen,
        };
        Some((on_screen, extent))
    }

    /// What of a rectangle the box may cover, and its nearest depth there; none if it covers nothing of it. `extent` came
    /// with the box.
    #[inline(always)]
    pub fn within(&self, extent: &Extent, rectangle: Rectangle) -> Option<Rectangle> {
        let [error_x, error_y] = self.error;
        let x = samples_within(extent.x, error_x, rectangle.x);
        let y = samples_within(extent.y, error_y, rectangle.y);
        if x[0] > x[1] || y[0] > y[1] {
            return None;
        }
        let [farthest, nearest] = [least_of(&self.depth), largest_of(&self.depth)];
        let nearest = (nearest + self.depth_error_within(farthest, nearest)) as f32;
        let nearest = if nearest < rectangle.nearest {
            nearest
        } else {
            rectangle.nearest
        };
        let [x, y] = [x.map(|v| v as i32), y.map(|v| v as i32)];
        Some(Rectangle { x, y, nearest })
    }

    /// What a vertex's depth may be off by, where those of the corners have a range.
    #[inline(always)]
    fn depth_error_within(&self, farthest: f64, nearest: f64) -> f64 {
        self.depth_error[0] + greater(farthest.abs(), nearest.abs()) * self.depth_error[1]
    }

    /// The samples of the box's rectangle that can be covered: those inside the outline.
    #[inline(always)]
    pub fn outline(&self, rectangle: Rectangle) -> Outline {
        let mut outline = Outline::of_rectangle(rectangle.x, rectangle.y);
        let OnScreen { x, y, seen, .. } = self;
        for axis in 0..3 {
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            for sides in 0..4 {
                let (side_b, side_c) = (sides >> 1, sides & 1);
                // The outline runs between the faces that are seen and those that are not.
                if seen[b][side_b] == seen[c][side_c] {
                    continue;
                }
                let from = side_b << b | side_c << c;
                let to = from | 1 << axis;
                let slope = (x[to] - x[from]) / (y[to] - y[from]);
                // False for a NaN.
                let is_steep = slope.abs() <= FLATTEST;
                if !is_steep {
                    continue;
                }
                let mut offsets = [0.0; 8];
                for i in 0..8 {
                    offsets[i] = x[i] - slope * y[i];
                }
                let (least, largest) = (least_of(&offsets), largest_of(&offsets));
                let margin = self.margin(1.0, slope, 0.0);
                if offsets[from] - least < largest - offsets[from] {
                    outline.left.push(OutlineEdge {
                        slope,
                        offset: least - margin,
                    });
                } else {
                    outline.right.push(OutlineEdge {
                        slope,
                        offset: largest + margin,
                    });
                }
            }
        }
        outline
    }

    /// What bounds the depth of the box's triangles over the samples of its rectangle.
    #[inline(always)]
    pub fn faces(&self, rectangle: Rectangle) -> Faces {
        let mut faces = Faces::new(rectangle.nearest);
        let OnScreen { x, y, depth, .. } = self;
        let (farthest, nearest) = (least_of(depth), largest_of(depth));
        let magnitude = greater(farthest.abs(), nearest.abs());
        let error = self.depth_error_within(farthest, nearest);
        let formula_error = self.slope_error * (nearest - farthest + 2.0 * error);
        for axis in 0..3 {
            for side in 0..2 {
                if !self.seen[axis][side] {
                    continue;
                }
                let [q0, q1, q2, q3] = face(axis, side);
                let (x1, x2) = (x[q3] - x[q0], x[q2] - x[q1]);
                let (y1, y2) = (y[q3] - y[q0], y[q2] - y[q1]);
                let (d1, d2) = (depth[q3] - depth[q0], depth[q2] - depth[q1]);
                let area = x1 * y2 - x2 * y1;
                let slope_x = (d1 * y2 - d2 * y1) / area;
                let slope_y = (d2 * x1 - d1 * x2) / area;
                let mut heights = [0.0; 8];
                for i in 0..8 {
                    heights[i] = depth[i] - slope_x * x[i] - slope_y * y[i];
                }
                let margin = self.margin(slope_x, slope_y, magnitude) + error + formula_error;
                let plane = FacePlane {
                    slope_x,
                    slope_y,
                    depth: largest_of(&heights) + margin,
                };
                // A finite margin has bounded all terms of the plane. Neither holds for a NaN.
                let is_farther =
                    plane.farthest_over(rectangle.x, rectangle.y) < f64::from(rectangle.nearest);
                if margin.is_finite() && is_farther {
                    faces.push(plane);
                }
            }
        }
        faces
    }

    /// What `a·x + b·y + c` may be off by where `x` and `y` are a vertex, and `c` is no larger than `constant`.
    #[inline(always)]
    fn margin(&self, a: f64, b: f64, constant: f64) -> f64 {
        let ([error_x, error_y], [reach_x, reach_y]) = (self.error, self.reach);
        let (a, b) = (a.abs(), b.abs());
        (a * error_x + b * error_y) + (a * reach_x + b * reach_y + constant) * ROUNDING
    }
}

/// The samples of a range that a box may cover whose corners span `extent`, in sub-pixels, and that may be off by `error`.
#[inline(always)]
fn samples_within(extent: [f64; 2], error: f64, range: [i32; 2]) -> [f64; 2] {
    let first = (to_sample(extent[0]) - error).ceil();
    let last = (to_sample(extent[1]) + error).floor();
    [
        greater(first, f64::from(range[0])),
        lesser(last, f64::from(range[1])),
    ]
}

/// How far a vertex may be drawn from where its position, off by `error`, projects to, in samples: along one axis of the
/// screen, whose row has length `norm`, where coordinates are within `range` and no W is less than `w`.
#[inline(always)]
fn screen_error(view: &BoxView, range: [f64; 2], norm: f64, error: f64, w: f64) -> f64 {
    let largest = greater(range[0].abs(), range[1].abs());
    // A move by e changes X by |e|·norm and W by |e|·|w|, hence X / W by no more than this.
    let moved = error * (norm + largest * view.norms[3]) / w;
    (view.snap_error + moved + largest * view.relative_error) * (1.0 / f64::from(SUBPIXELS))
}

/// A face's corners: its first diagonal is from 0 to 3, its second from 1 to 2.
#[inline(always)]
fn face(axis: usize, side: usize) -> [usize; 4] {
    let (b, c) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    let base = side << axis;
    [base, base | b, base | c, base | b | c]
}

#[inline(always)]
fn to_sample(subpixels: f64) -> f64 {
    (subpixels - f64::from(SUBPIXELS / 2)) * (1.0 / f64::from(SUBPIXELS))
}

#[inline(always)]
fn to_samples(subpixels: &[f64; 8]) -> [f64; 8] {
    let mut samples = [0.0; 8];
    for i in 0..8 {
        samples[i] = to_sample(subpixels[i]);
    }
    samples
}

/// The largest magnitude of these and of any sample's coordinate.
#[inline(always)]
fn reach(subpixels: [f64; 2]) -> f64 {
    let [least, largest] = [to_sample(subpixels[0]), to_sample(subpixels[1])];
    greater(greater(least.abs(), largest.abs()), LARGEST_SAMPLE)
}
