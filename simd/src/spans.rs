//! Which samples of a row a triangle covers, as an interval of columns: the edges solved for x.
//!
//! The edge `A·x + B·y + C ≥ 0` crosses row `y` at `v = −(B·y + C + ½) / A`: the first covered column is `⌈v⌉` where
//! `A > 0`, and the first one not covered where `A < 0`. At whole columns and rows `A·x + B·y + C` is an integer, so `v`
//! is at least `½/|A|` away from any column, and rounding that is smaller than this cannot move the ceiling.
//!
//! With [`Edge`](crate::triangle::Edge)'s coefficients, exact in f64, `slope·y + at_zero` is off by at most six roundings
//! of numbers up to `(|B|·|y| + |C| + 1)/|A|` in size. `|B| ≤ 2²⁴`, `|y| ≤ 2¹⁵` and `|C| ≤ 2⁴²`: by less than `2⁻⁸/|A|`.
//! A horizontal edge takes `A = 2⁻³⁰` and crosses every row beyond all columns, on the side that says whether the row is
//! inside.

use crate::TILE_SIZE;
use crate::coverage::rectangle_mask;
use crate::triangle::{DepthPlane, Edge, Triangle};

/// Where edges cross the rows of samples, at `slope·y + at_zero`: first two edges with their inside on the right, then
/// two with their inside on the left. A triangle has three edges: one stands twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spans {
    /// Columns a row.
    pub slope: [f64; 4],
    /// The crossing of row 0.
    pub at_zero: [f64; 4],
}

/// Stands for 1/A where an edge is horizontal.
pub(crate) const HORIZONTAL: f64 = (1_u64 << 30) as f64;

impl Spans {
    /// The spans between three edges.
    pub fn between(edges: &[Edge; 3]) -> Spans {
        let crossing = |e: &Edge| {
            let inverse = if e.a == 0 { HORIZONTAL } else { 1.0 / e.a as f64 };
            (-(e.b as f64) * inverse, -(e.c as f64 + 0.5) * inverse)
        };
        let mut slope = [0.0; 4];
        let mut at_zero = [0.0; 4];
        for first in [0, 2] {
            let mut of_side = edges.iter().filter(|e| (e.a >= 0) == (first == 0));
            // Their A add up to 0 and are not all 0: there is an edge on either side.
            let one = of_side.next().map_or((0.0, 0.0), crossing);
            let other = of_side.next().map_or(one, crossing);
            (slope[first], at_zero[first]) = one;
            (slope[first + 1], at_zero[first + 1]) = other;
        }
        Spans { slope, at_zero }
    }

    /// First covered column of a row, and the first one after it that is not covered, both within `x`: from its first
    /// column to the one after its last.
    #[inline]
    pub fn of_row(&self, y: i32, x: [i32; 2]) -> [i32; 2] {
        let at = |edge: usize| self.slope[edge] * f64::from(y) + self.at_zero[edge];
        let greater = |a: f64, b: f64| if b > a { b } else { a };
        let lesser = |a: f64, b: f64| if b < a { b } else { a };
        // A quarter beside the first and the last column, so that the ceiling gives what it should.
        let (least, largest) = (f64::from(x[0]) - 0.25, f64::from(x[1]) + 0.75);
        let column = |v: f64| lesser(greater(v, least), largest).ceil() as i32;
        [
            column(greater(at(0), at(1))),
            column(lesser(at(2), at(3))),
        ]
    }
}

/// A triangle ready to be filled, in the form that the occluders' filler reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanTriangle {
    /// Its rows' intervals.
    pub spans: Spans,
    /// First and last column of samples that can be covered, within the picture.
    pub x: [i32; 2],
    /// First and last row of samples that can be covered, within the picture.
    pub y: [i32; 2],
    /// Its depth.
    pub depth: DepthPlane,
}

impl From<&Triangle> for SpanTriangle {
    /// The triangle's extents must lie within the picture.
    fn from(t: &Triangle) -> SpanTriangle {
        SpanTriangle {
            spans: Spans::between(&t.edges),
            x: t.x,
            y: t.y,
            depth: t.depth,
        }
    }
}

impl SpanTriangle {
    /// The samples of tile (`tile_x`, `tile_y`) that the triangle covers: the same as
    /// [`coverage_of_tile`](crate::coverage::coverage_of_tile) finds.
    #[inline]
    pub fn coverage_of_tile(&self, tile_x: i32, tile_y: i32) -> u64 {
        let x0 = tile_x * TILE_SIZE;
        let mut mask = 0;
        for row in 0..TILE_SIZE {
            let y = tile_y * TILE_SIZE + row;
            if y < self.y[0] || y > self.y[1] {
                continue;
            }
            let [first, end] = self.spans.of_row(y, self.x);
            let (first, end) = ((first - x0).max(0), (end - x0).min(TILE_SIZE));
            if first < end {
                mask |= rectangle_mask([first, end - 1], [row, row]);
            }
        }
        mask
    }
}
