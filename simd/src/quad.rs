//! Two triangles that share a diagonal, as one convex quadrilateral.
//!
//! ```text
//!   d ------ c      the triangles a b c and a c d, which meet in the diagonal a c;
//!    \     / |      a triangle alone has d in the same place as c
//!     \  /   |
//!      a --- b
//! ```
//!
//! If no corner is turned inwards on the grid, the samples of the two triangles are those of the quadrilateral: the rule
//! for samples on edges is that of a sample moved by next to nothing to the lower right, and such a sample is on no edge.
//!
//! Its depth is the plane of the first triangle, put back by as much as the other corner lies behind it: at every sample
//! it is not nearer than the sample's own triangle, but for rounding, which [`PartDepth`] makes up for.

use crate::order::{greater, lesser};
use crate::part_depth::PartDepth;
use crate::small::SMALL;
use crate::spans::{SpanPolygon, Spans};
use crate::triangle::{CullMode, DepthPlane, Edge, SLIVER};
use crate::vertex::ScreenVertex;
use crate::{SUBPIXELS, triangle};

/// A quadrilateral is drawn as one if the fourth corner is not farther from the plane of the others than this many times
/// the range of depths. With a quarter castle takes 3 % more instructions and Sponza 5, and culling gains nothing.
pub(crate) const BEND: f64 = 1.0;

/// A quadrilateral is tiny if its corners reach over no more sub-pixels than this, and its samples over no more than two
/// columns and two rows. It is then asked whether it covers a sample at all: on falcon three in ten of those set up did not.
pub(crate) const TINY: i32 = 3 * SUBPIXELS;

/// What can be done with a quadrilateral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quad {
    /// It covers no sample.
    Nothing,
    /// It can be drawn as one.
    Whole(SpanPolygon),
    /// Its triangles have to be drawn one by one.
    Apart,
}

/// Twice the area of a triangle on the grid, positive if it runs clockwise on screen.
fn twice_area(a: ScreenVertex, b: ScreenVertex, c: ScreenVertex) -> i64 {
    let delta = |a: i32, b: i32| i64::from(a) - i64::from(b);
    delta(b.x, a.x) * delta(c.y, a.y) - delta(c.x, a.x) * delta(b.y, a.y)
}

impl Quad {
    /// Sets up what `corners` stand for, pulled in by `inset` sub-pixels ([`Edge::moved_in`]), in a picture of
    /// `width` × `height` samples.
    pub fn new(
        corners: [ScreenVertex; 4],
        cull: CullMode,
        width: i32,
        height: i32,
        inset: i32,
    ) -> Quad {
        let [a, b, c, d] = corners;
        let (xs, ys) = (corners.map(|v| v.x), corners.map(|v| v.y));
        let (x, y) = (samples(xs, width, inset), samples(ys, height, inset));
        let areas = [
            twice_area(a, b, c),
            twice_area(a, c, d),
            twice_area(a, b, d),
            twice_area(b, c, d),
        ];
        let [first, second, ..] = areas;
        if x[0] > x[1] || y[0] > y[1] || cull.leaves_out(first) && cull.leaves_out(second) {
            return Quad::Nothing;
        }
        let is_convex = first > 0 && areas.iter().all(|&area| area >= 0)
            || first < 0 && areas.iter().all(|&area| area <= 0);
        if !is_convex || cull.leaves_out(first) {
            return Quad::Apart;
        }
        let extent =
            |[a, b, c, d]: [i32; 4]| f64::from(a.max(b).max(c).max(d) - a.min(b).min(c).min(d));
        let extent = [extent(xs), extent(ys)];
        // Clockwise.
        let [b, d] = if first < 0 { [d, b] } else { [b, d] };
        let edges = [
            Edge::between(a, b),
            Edge::between(b, c),
            Edge::between(c, d),
            Edge::between(d, a),
        ]
        .map(|edge| edge.moved_in(inset));
        let is_tiny = extent.iter().all(|&e| e <= f64::from(TINY))
            && [x, y].iter().all(|[first, last]| last - first < 2);
        let is_covered = |x: i32, y: i32| {
            let inside = |e: &Edge| e.a * i64::from(x) + e.b * i64::from(y) + e.c >= 0;
            edges.iter().all(inside)
        };
        if is_tiny && !x.iter().any(|&x| y.iter().any(|&y| is_covered(x, y))) {
            return Quad::Nothing;
        }
        let Some(plane) = plane_of(corners, extent, first, second) else {
            return Quad::Apart;
        };
        let is_small = extent.iter().all(|&e| e <= f64::from(SMALL));
        Quad::Whole(SpanPolygon {
            spans: Spans::between(&edges, [x[0], y[0]], is_small),
            x,
            y,
            depth: PartDepth::new(&plane, extent, x, y, inset),
            is_small,
        })
    }
}

fn samples(v: [i32; 4], count: i32, inset: i32) -> [i32; 2] {
    let [a, b, c, d] = v;
    let (least, largest) = (a.min(b).min(c).min(d), a.max(b).max(c).max(d));
    let [first, last] = triangle::samples(least + inset, largest - inset);
    [first.max(0), last.min(count - 1)]
}

/// The plane of a quadrilateral with an extent in sub-pixels, whose triangles have these areas; none if they have to be
/// drawn one by one.
fn plane_of(
    corners: [ScreenVertex; 4],
    extent: [f64; 2],
    first: i64,
    second: i64,
) -> Option<DepthPlane> {
    let [a, b, c, d] = corners;
    let mut plane = DepthPlane::through([a, b, c], first);
    if c == d {
        return Some(plane);
    }
    let smaller = lesser(first.abs() as f64, second.abs() as f64);
    let is_sliver = extent[0] * extent[1] > SLIVER * smaller;
    plane.farthest = lesser(plane.farthest, d.depth);
    plane.nearest = greater(plane.nearest, d.depth);
    let per_subpixel = 1.0 / f64::from(SUBPIXELS);
    let there = (plane.depth + plane.slope_y * (f64::from(d.y - a.y) * per_subpixel))
        + plane.slope_x * (f64::from(d.x - a.x) * per_subpixel);
    let behind = there - d.depth;
    // Not for a NaN either.
    let is_flat = behind.abs() <= (plane.nearest - plane.farthest) * BEND;
    plane.depth -= greater(behind, 0.0);
    (is_flat && !is_sliver).then_some(plane)
}
