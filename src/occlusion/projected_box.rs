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
//! `footprint`. Moved outwards by `eₓ + |k|·e_y` the half-plane still holds it. Three vertices in a half-plane put their
//! triangle there, and each sample that the triangle covers. So does clipping: what it leaves of a triangle is inside
//! it, and it adds no more than the rounding that the position's error has room for.
//!
//! **Faces.** Likewise with depth: if `d ≤ a·x + b·y + c` at all corners, then a vertex, drawn off by `eₓ`, `e_y` and
//! by `e_d` in depth, keeps `d ≤ a·x + b·y + c + |a|·eₓ + |b|·e_y + e_d`, and the plane through three vertices keeps it
//! at each sample of their triangle, as do its least and its largest depth in their places (a sliver has its farthest
//! depth all over, and a clamp to the vertices' range can only raise a depth to that of the farthest vertex, which is
//! not above the plane). What the triangle's own formula is off by is added,
//! [`DepthPlane::SLOPE_ERROR`](antumbra_simd::triangle::DepthPlane::SLOPE_ERROR) of the vertices' range of depths, which
//! is within the corners'; and last the rounding of the bound's own evaluation, as 2⁻⁴⁸ of the largest terms it can
//! have, for sums of four terms.
//!
//! No face has to be left out because the eye is close to its plane: it comes out steep, its margin `|a|·eₓ + |b|·e_y`
//! large, and other bounds are lower. Which edges and faces to take is a matter of speed alone.

use antumbra_simd::SUBPIXELS;
use antumbra_simd::bounds::Corners;
use antumbra_simd::faces::{FacePlane, Faces};
use antumbra_simd::glance::Slabs;
use antumbra_simd::outline::{Outline, OutlineEdge};
use antumbra_simd::triangle::DepthPlane;

use super::footprint::POSITION_ERROR;
use super::{Footprint, SampleRect};
use crate::view::PictureSize;

/// An edge flatter than this many columns a row bounds nothing that the rectangle does not: it would have to be moved
/// outwards by so many columns times the error of rows, 1/512.
const FLATTEST: f64 = (1_u32 << 16) as f64;

/// What a sum of a few products is off by at the most, as a share of the largest terms that it can have: 32 times 2⁻⁵³.
const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

/// A box on screen, ready to be asked about; see [`Screen::project_aabb`](super::Screen::project_aabb).
#[derive(Clone, Debug)]
pub struct ProjectedBox {
    footprint: Footprint,
    corners: Corners,
    /// Whether the corners' three axes are left-handed.
    mirrored: bool,
    errors: Errors,
    slabs: Slabs,
}

/// How far a vertex of the box's triangles may be drawn from the box's projection.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Errors {
    /// Columns, in sub-pixels.
    pub x: f64,
    /// Rows, in sub-pixels.
    pub y: f64,
    /// Depth.
    pub depth: f64,
    /// Depth, as a share of it.
    pub relative_depth: f64,
}

impl ProjectedBox {
    pub(super) const UNBOUNDED: ProjectedBox = ProjectedBox {
        corners: Corners {
            x: [0.0; 8],
            y: [0.0; 8],
            depth: [0.0; 8],
            w: [0.0; 8],
        },
        mirrored: false,
        errors: Errors {
            x: 0.0,
            y: 0.0,
            depth: 0.0,
            relative_depth: 0.0,
        },
        footprint: Footprint::Unbounded,
        slabs: Slabs {
            normal: [[0.0; 3]; 3],
            low: [0.0; 3],
            high: [0.0; 3],
        },
    };

    pub(super) fn new(
        footprint: Footprint,
        corners: Corners,
        mirrored: bool,
        errors: Errors,
        slabs: Slabs,
    ) -> ProjectedBox {
        ProjectedBox {
            footprint,
            corners,
            mirrored,
            errors,
            slabs,
        }
    }

    /// The box's faces, relative to the eye.
    pub(super) fn slabs(&self) -> &Slabs {
        &self.slabs
    }

    /// Where the box may be drawn, and its nearest corner's depth.
    pub fn footprint(&self) -> Footprint {
        self.footprint
    }

    /// The samples of `rect` that can be covered: those inside the outline. `rect` is the box's footprint.
    pub fn outline(&self, rect: &SampleRect) -> Outline {
        let mut outline = Outline::of_rectangle(rect.x, rect.y);
        let seen = self.seen();
        let on_screen = self.in_samples();
        let OnScreen { x, y, .. } = &on_screen;
        for axis in 0..3 {
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            for (side_b, side_c) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
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
                let offsets: [f64; 8] = std::array::from_fn(|i| x[i] - slope * y[i]);
                let [least, largest] = range(&offsets);
                let margin = on_screen.margin(1.0, slope, 0.0);
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

    /// What bounds the depth of the box's triangles over the samples of `rect`, its footprint.
    pub fn faces(&self, rect: &SampleRect) -> Faces {
        let mut faces = Faces::new(rect.nearest_depth);
        let seen = self.seen();
        let on_screen = self.in_samples();
        let OnScreen { x, y, .. } = &on_screen;
        let depth: [f64; 8] = std::array::from_fn(|i| self.corners.depth[i] / self.corners.w[i]);
        let [farthest, nearest] = range(&depth);
        let magnitude = farthest.abs().max(nearest.abs());
        // A vertex's depth, and the 2⁻⁴⁰ of it that the footprint's has, too.
        let error =
            self.errors.depth + magnitude * (self.errors.relative_depth + 2.0 * POSITION_ERROR);
        let formula_error = DepthPlane::SLOPE_ERROR * (nearest - farthest + 2.0 * error);
        for (axis, seen) in seen.into_iter().enumerate() {
            for (side, seen) in seen.into_iter().enumerate() {
                if !seen {
                    continue;
                }
                let [q0, q1, q2, q3] = face(axis, side);
                let diagonals = |of: &[f64; 8]| [of[q3] - of[q0], of[q2] - of[q1]];
                let ([x1, x2], [y1, y2]) = (diagonals(x), diagonals(y));
                let [d1, d2] = diagonals(&depth);
                let area = x1 * y2 - x2 * y1;
                let slope_x = (d1 * y2 - d2 * y1) / area;
                let slope_y = (d2 * x1 - d1 * x2) / area;
                let heights: [f64; 8] =
                    std::array::from_fn(|i| depth[i] - slope_x * x[i] - slope_y * y[i]);
                let [_, highest] = range(&heights);
                let margin = on_screen.margin(slope_x, slope_y, magnitude) + error + formula_error;
                let plane = FacePlane {
                    slope_x,
                    slope_y,
                    depth: highest + margin,
                };
                // A finite margin has bounded all terms of the plane. Neither holds for a NaN.
                let is_farther =
                    plane.farthest_over(rect.x, rect.y) < f64::from(rect.nearest_depth);
                if margin.is_finite() && is_farther {
                    faces.push(plane);
                }
            }
        }
        faces
    }

    fn in_samples(&self) -> OnScreen {
        let (x, y) = (to_samples(&self.corners.x), to_samples(&self.corners.y));
        OnScreen {
            error: [self.errors.x, self.errors.y].map(|e| e / f64::from(SUBPIXELS)),
            reach: [largest_magnitude(&x), largest_magnitude(&y)],
            x,
            y,
        }
    }

    /// Which faces the eye sees: by axis, then the side where that axis' bit of a corner's index is 0 or 1.
    fn seen(&self) -> [[bool; 2]; 3] {
        let Corners { x, y, .. } = &self.corners;
        std::array::from_fn(|axis| {
            std::array::from_fn(|side| {
                let [q0, q1, q2, q3] = face(axis, side);
                let area = (x[q3] - x[q0]) * (y[q2] - y[q1]) - (x[q2] - x[q1]) * (y[q3] - y[q0]);
                if (side == 1) == self.mirrored {
                    area > 0.0
                } else {
                    area < 0.0
                }
            })
        })
    }
}

/// Where corners are on screen, counting samples.
struct OnScreen {
    x: [f64; 8],
    y: [f64; 8],
    /// How far a vertex may be drawn from there: columns and rows.
    error: [f64; 2],
    /// The largest magnitude of a column and of a row.
    reach: [f64; 2],
}

impl OnScreen {
    /// What `a·x + b·y + c` may be off by where `x` and `y` are a vertex, and `c` is no larger than `constant`.
    fn margin(&self, a: f64, b: f64, constant: f64) -> f64 {
        let of = |[x, y]: [f64; 2]| a.abs() * x + b.abs() * y;
        of(self.error) + (of(self.reach) + constant) * ROUNDING
    }
}

/// A face's corners: its first diagonal is from 0 to 3, its second from 1 to 2.
fn face(axis: usize, side: usize) -> [usize; 4] {
    let (b, c) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    let base = side << axis;
    [base, base | b, base | c, base | b | c]
}

fn to_samples(subpixels: &[f64; 8]) -> [f64; 8] {
    let half = f64::from(SUBPIXELS / 2);
    subpixels.map(|v| (v - half) / f64::from(SUBPIXELS))
}

fn range(of: &[f64; 8]) -> [f64; 2] {
    of.iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, g], &v| {
            [if v < l { v } else { l }, if v > g { v } else { g }]
        })
}

/// The largest magnitude of these and of any sample's coordinate.
fn largest_magnitude(of: &[f64; 8]) -> f64 {
    let [least, largest] = range(of);
    least
        .abs()
        .max(largest.abs())
        .max(f64::from(PictureSize::LARGEST))
}
