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
//! Its depth is the plane of the first triangle, put back by as much as the other corner lies behind it, so that at
//! every sample it is not nearer than what the sample's own triangle writes. With `e` the error of a
//! depth formula ([`DepthPlane`]), what the plane is off at `d`, what it is off at a sample and what the triangle's own
//! formula is off there are `3e` together; [`SLACK`] stands for `4e`.

use crate::spans::{SpanPolygon, Spans};
use crate::triangle::{CullMode, DepthPlane, Edge, SLIVER};
use crate::vertex::ScreenVertex;
use crate::{SUBPIXELS, triangle};

/// By how much a quadrilateral's plane is put back for rounding: as a part of the range of its depths, and as a part of
/// the largest.
pub(crate) const SLACK: [f64; 2] = [4.0 * DepthPlane::SLOPE_ERROR, 4.0 / (1_u64 << 50) as f64];

/// A quadrilateral is drawn as one if the fourth corner is not farther from the plane of the others than this part of
/// the range of depths.
pub(crate) const BEND: f64 = 1.0;

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
    /// Sets up what `corners` stand for, in a picture of `width` × `height` samples.
    pub fn new(corners: [ScreenVertex; 4], cull: CullMode, width: i32, height: i32) -> Quad {
        let [a, b, c, d] = corners;
        let (xs, ys) = (corners.map(|v| v.x), corners.map(|v| v.y));
        let (x, y) = (samples(xs, width), samples(ys, height));
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
        let Some(depth) = depth_over(corners, first, second) else {
            return Quad::Apart;
        };
        // Clockwise.
        let [b, d] = if first < 0 { [d, b] } else { [b, d] };
        Quad::Whole(SpanPolygon {
            spans: Spans::between(&[
                Edge::between(a, b),
                Edge::between(b, c),
                Edge::between(c, d),
                Edge::between(d, a),
            ]),
            x,
            y,
            depth,
        })
    }
}

fn samples(v: [i32; 4], count: i32) -> [i32; 2] {
    let [a, b, c, d] = v;
    let [first, last] = triangle::samples(a.min(b).min(c).min(d), a.max(b).max(c).max(d));
    [first.max(0), last.min(count - 1)]
}

/// The depth of a quadrilateral whose triangles have these areas; none if they have to be drawn one by one.
fn depth_over(corners: [ScreenVertex; 4], first: i64, second: i64) -> Option<DepthPlane> {
    let [a, b, c, d] = corners;
    let mut plane = DepthPlane::through([a, b, c], first);
    if c == d {
        return Some(plane);
    }
    let lesser = |a: f64, b: f64| if b < a { b } else { a };
    let greater = |a: f64, b: f64| if b > a { b } else { a };
    let extent = |v: [i32; 4]| {
        let [a, b, c, d] = v;
        f64::from(a.max(b).max(c).max(d) - a.min(b).min(c).min(d))
    };
    let box_area = extent(corners.map(|v| v.x)) * extent(corners.map(|v| v.y));
    let is_sliver = box_area > SLIVER * lesser(first.abs() as f64, second.abs() as f64);
    plane.farthest = lesser(plane.farthest, d.depth);
    plane.nearest = greater(plane.nearest, d.depth);
    let per_subpixel = 1.0 / f64::from(SUBPIXELS);
    let there = (plane.depth + plane.slope_y * (f64::from(d.y - a.y) * per_subpixel))
        + plane.slope_x * (f64::from(d.x - a.x) * per_subpixel);
    let behind = there - d.depth;
    let range = plane.nearest - plane.farthest;
    let slack = range * SLACK[0] + greater(plane.nearest.abs(), plane.farthest.abs()) * SLACK[1];
    // Not for a NaN either.
    let is_flat = behind.abs() <= range * BEND + slack;
    plane.depth -= greater(behind, 0.0) + slack;
    (is_flat && !is_sliver).then_some(plane)
}
