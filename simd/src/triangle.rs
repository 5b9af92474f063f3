//! Sets up a snapped triangle: three exact edge functions, the samples it can cover, and a depth plane.
//!
//! Coordinates count samples (pixel centres) from here on. With snapped vertices in sub-pixels, the edge from `a` to
//! `b` is the integer function `E = A·x + B·y + C`, `A = a.y − b.y`, `B = b.x − a.x`, positive inside. The top-left
//! rule subtracts 1 from `C` of every edge that is neither a top nor a left one, so that "covered" is `E ≥ 0` on all
//! three, and a sample on an edge that two triangles share belongs to exactly one of them. A sample stands at
//! `256·i + 128`, hence `E ≥ 0` there if and only if `A·i + B·j + ⌊(128·A + 128·B + C) / 256⌋ ≥ 0`: the division
//! loses nothing. |A|, |B| ≤ 2²⁴ and |C| < 2⁴⁹, so i64 holds everything.

use crate::SUBPIXELS;
use crate::order::{greater, lesser};
use crate::vertex::ScreenVertex;

/// Which sides of a triangle are drawn. A front face winds counter-clockwise on screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum CullMode {
    /// Both sides are drawn.
    None,
    /// Back faces are left out.
    #[default]
    Back,
    /// Front faces are left out.
    Front,
}

impl CullMode {
    /// The mode that does for mirrored geometry what this one does for the original.
    pub fn mirrored(self) -> CullMode {
        match self {
            CullMode::None => CullMode::None,
            CullMode::Back => CullMode::Front,
            CullMode::Front => CullMode::Back,
        }
    }

    /// Whether a triangle with twice this area on the grid is left out. Where y points down, what winds
    /// counter-clockwise for the viewer has a negative area.
    #[inline]
    pub(crate) fn leaves_out(self, twice_area: i64) -> bool {
        match self {
            CullMode::None => twice_area == 0,
            CullMode::Back => twice_area >= 0,
            CullMode::Front => twice_area <= 0,
        }
    }
}

/// One edge: inside or on it where `a·x + b·y + c ≥ 0`, `x` and `y` counting samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// What one sample to the right adds.
    pub a: i64,
    /// What one sample down adds.
    pub b: i64,
    /// The value at sample (0, 0).
    pub c: i64,
}

impl Edge {
    /// The edge from a point to itself: every sample is inside.
    pub const EVERYWHERE: Edge = Edge { a: 0, b: 0, c: 0 };

    /// The edge moved inwards: a sample is inside if all places no more than `inset` sub-pixels beside and above or below it
    /// are inside.
    #[inline]
    pub fn moved_in(self, inset: i32) -> Edge {
        let steepness = self.a.abs() + self.b.abs();
        let moved = steepness * i64::from(inset) + i64::from(SUBPIXELS - 1);
        Edge {
            c: self.c - moved.div_euclid(i64::from(SUBPIXELS)),
            ..self
        }
    }

    /// The edge from `a` to `b`, as a polygon has it that lies to its right on screen.
    #[inline]
    pub fn between(a: ScreenVertex, b: ScreenVertex) -> Edge {
        let ea = i64::from(a.y) - i64::from(b.y);
        let eb = i64::from(b.x) - i64::from(a.x);
        let is_left = b.y < a.y;
        // Or a point.
        let is_top = b.y == a.y && b.x >= a.x;
        let bias = if is_left || is_top { 0 } else { -1 };
        let c = -(ea * i64::from(a.x) + eb * i64::from(a.y)) + bias;
        let half = i64::from(SUBPIXELS / 2);
        Edge {
            a: ea,
            b: eb,
            c: (c + half * (ea + eb)).div_euclid(i64::from(SUBPIXELS)),
        }
    }
}

/// Depth over the screen: one formula, which every pass uses.
///
/// The depth that a triangle writes at a sample is [`DepthPlane::at`]; it is defined by its floating-point
/// operations, not by the real plane behind it. What occluders leave in tiles is a bound for it ([`crate::part_depth`]).
///
/// The clamp keeps a sliver, whose slope is all rounding, between its own vertices; one whose bounding box is more than
/// 2²⁴ times its own area is given its farthest depth everywhere. For any other, let `R` be the range of the vertices'
/// depths and `D` the largest of their magnitudes. A slope times the extent along it is at most `Q = 2R·w·h/a`, with
/// extents `w`, `h` and twice the area `a`, so at most `2²⁵·R`. In units of 2⁻⁵³ each of the slopes is off by `5Q`, each
/// product by `Q` more, the two sums by `D + Q` and `D + 2Q`: the formula lies within 2⁻²³·R + 2⁻⁵⁰·D of the plane
/// through the snapped vertices ([`DepthPlane::SLOPE_ERROR`]), before it is rounded to f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthPlane {
    /// The first vertex's column, counting samples.
    pub origin_x: f64,
    /// The first vertex's row, counting samples.
    pub origin_y: f64,
    /// The first vertex's depth.
    pub depth: f64,
    /// What one sample to the right adds.
    pub slope_x: f64,
    /// What one sample down adds.
    pub slope_y: f64,
    /// The least of the vertices' depths.
    pub farthest: f64,
    /// The largest of the vertices' depths.
    pub nearest: f64,
}

/// A sliver's bounding box is more than this many times twice its area.
pub(crate) const SLIVER: f64 = (1_u64 << 24) as f64;

impl DepthPlane {
    /// How far the formula may lie from the real plane, as a part of the range of the vertices' depths.
    pub const SLOPE_ERROR: f64 = 1.0 / (1_u64 << 23) as f64;

    /// The plane through three vertices, with twice the area of their triangle, either sign.
    pub(crate) fn through(v: [ScreenVertex; 3], twice_area: i64) -> DepthPlane {
        let [v0, v1, v2] = v;
        let delta = |a: i32, b: i32| f64::from(a - b);
        let (d1, d2) = (v1.depth - v0.depth, v2.depth - v0.depth);
        // Exact: the area stays below 2^53, and a power of two scales it to samples.
        let area = twice_area as f64;
        let extent = |a: i32, b: i32, c: i32| f64::from(a.max(b).max(c) - a.min(b).min(c));
        let box_area = extent(v0.x, v1.x, v2.x) * extent(v0.y, v1.y, v2.y);
        let is_sliver = box_area > SLIVER * area.abs();
        let per_sample = f64::from(SUBPIXELS) / area;
        let slope_x = (d1 * delta(v2.y, v0.y) - d2 * delta(v1.y, v0.y)) * per_sample;
        let slope_y = (d2 * delta(v1.x, v0.x) - d1 * delta(v2.x, v0.x)) * per_sample;
        let to_samples = |v: i32| f64::from(v - SUBPIXELS / 2) / f64::from(SUBPIXELS);
        let farthest = lesser(lesser(v0.depth, v1.depth), v2.depth);
        let unless_sliver = |sloped: f64, flat: f64| if is_sliver { flat } else { sloped };
        DepthPlane {
            origin_x: to_samples(v0.x),
            origin_y: to_samples(v0.y),
            depth: unless_sliver(v0.depth, farthest),
            slope_x: unless_sliver(slope_x, 0.0),
            slope_y: unless_sliver(slope_y, 0.0),
            farthest,
            nearest: greater(greater(v0.depth, v1.depth), v2.depth),
        }
    }

    /// The depth that the triangle writes at a sample.
    #[inline]
    pub fn at(&self, x: i32, y: i32) -> f32 {
        let depth = (self.depth + self.slope_y * (f64::from(y) - self.origin_y))
            + self.slope_x * (f64::from(x) - self.origin_x);
        // In this order a NaN (two infinite slopes that cancel) comes out as the farthest.
        let clamped = if depth > self.nearest {
            self.nearest
        } else if depth > self.farthest {
            depth
        } else {
            self.farthest
        };
        clamped as f32
    }
}

/// A triangle ready to be filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The three edges.
    pub edges: [Edge; 3],
    /// First and last column of samples that can be covered; see [`Triangle::within`].
    pub x: [i32; 2],
    /// First and last row of samples that can be covered; see [`Triangle::within`].
    pub y: [i32; 2],
    /// Its depth.
    pub depth: DepthPlane,
}

/// First and last sample between two sub-pixel coordinates, ends included.
#[inline]
pub(crate) fn samples(first: i32, last: i32) -> [i32; 2] {
    let half = SUBPIXELS / 2;
    [
        (first + half - 1).div_euclid(SUBPIXELS), // ⌈(first − 128) / 256⌉
        (last - half).div_euclid(SUBPIXELS),
    ]
}

impl Triangle {
    /// The triangle with its extent cut to a picture of `width` × `height` samples; none if it lies outside.
    #[inline]
    pub fn within(mut self, width: i32, height: i32) -> Option<Triangle> {
        self.x = [self.x[0].max(0), self.x[1].min(width - 1)];
        self.y = [self.y[0].max(0), self.y[1].min(height - 1)];
        (self.x[0] <= self.x[1] && self.y[0] <= self.y[1]).then_some(self)
    }

    /// Sets a triangle up; none if it is culled by its facing, has no area on the grid, or has no sample between its
    /// extremes.
    #[inline]
    pub fn new(vertices: [ScreenVertex; 3], cull: CullMode) -> Option<Triangle> {
        let [v0, mut v1, mut v2] = vertices;
        let (x1, y1) = (
            i64::from(v1.x) - i64::from(v0.x),
            i64::from(v1.y) - i64::from(v0.y),
        );
        let (x2, y2) = (
            i64::from(v2.x) - i64::from(v0.x),
            i64::from(v2.y) - i64::from(v0.y),
        );
        let mut twice_area = x1 * y2 - x2 * y1;
        if cull.leaves_out(twice_area) {
            return None;
        }
        if twice_area < 0 {
            (v1, v2) = (v2, v1);
            twice_area = -twice_area;
        }
        let extent = |a: i32, b: i32, c: i32| samples(a.min(b).min(c), a.max(b).max(c));
        let (x, y) = (extent(v0.x, v1.x, v2.x), extent(v0.y, v1.y, v2.y));
        if x[0] > x[1] || y[0] > y[1] {
            return None;
        }
        Some(Triangle {
            edges: [
                Edge::between(v0, v1),
                Edge::between(v1, v2),
                Edge::between(v2, v0),
            ],
            x,
            y,
            depth: DepthPlane::through([v0, v1, v2], twice_area),
        })
    }
}
