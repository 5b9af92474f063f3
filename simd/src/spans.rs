//! Which samples of a row a triangle covers, as an interval of columns: the edges solved for x.
//!
//! The edge `A·x + B·y + C ≥ 0` crosses row `y` at `v = −(B·y + C + ½) / A`: the first covered column is `⌈v⌉` where
//! `A > 0`, and the first one not covered where `A < 0`. At whole columns and rows `A·x + B·y + C` is an integer, so `v`
//! is at least `½/|A|` away from any column, and rounding that is smaller than this cannot move the ceiling.
//!
//! With [`Edge`]'s coefficients, exact in f64, `slope·y + at_zero` is off by at most six roundings
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
            let inverse = if e.a == 0 {
                HORIZONTAL
            } else {
                1.0 / e.a as f64
            };
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
        [column(greater(at(0), at(1))), column(lesser(at(2), at(3)))]
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

/// Triangles in a block.
pub const BLOCK: usize = 8;

/// Up to eight triangles ready to be filled, structure of arrays: what a set-up of several at once leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanBlock {
    /// Bit `i` is set if there is a triangle `i`.
    pub present: u8,
    /// Columns a row, of four edges each; see [`Spans`].
    pub slope: [[f64; BLOCK]; 4],
    /// The crossings of row 0, of four edges each.
    pub at_zero: [[f64; BLOCK]; 4],
    /// First and last columns.
    pub x: [[f64; BLOCK]; 2],
    /// First and last rows.
    pub y: [[f64; BLOCK]; 2],
    /// Columns that the depth planes start from.
    pub origin_x: [f64; BLOCK],
    /// Rows that the depth planes start from.
    pub origin_y: [f64; BLOCK],
    /// Depths there.
    pub depth: [f64; BLOCK],
    /// What one sample to the right adds.
    pub slope_x: [f64; BLOCK],
    /// What one sample down adds.
    pub slope_y: [f64; BLOCK],
    /// The least of each triangle's depths.
    pub farthest: [f64; BLOCK],
    /// The largest of each triangle's depths.
    pub nearest: [f64; BLOCK],
}

impl SpanBlock {
    /// No triangle.
    pub const EMPTY: SpanBlock = SpanBlock {
        present: 0,
        slope: [[0.0; BLOCK]; 4],
        at_zero: [[0.0; BLOCK]; 4],
        x: [[0.0; BLOCK]; 2],
        y: [[0.0; BLOCK]; 2],
        origin_x: [0.0; BLOCK],
        origin_y: [0.0; BLOCK],
        depth: [0.0; BLOCK],
        slope_x: [0.0; BLOCK],
        slope_y: [0.0; BLOCK],
        farthest: [0.0; BLOCK],
        nearest: [0.0; BLOCK],
    };

    /// Triangle `i`.
    pub fn get(&self, i: usize) -> SpanTriangle {
        SpanTriangle {
            spans: Spans {
                slope: self.slope.map(|e| e[i]),
                at_zero: self.at_zero.map(|e| e[i]),
            },
            x: self.x.map(|x| x[i] as i32),
            y: self.y.map(|y| y[i] as i32),
            depth: DepthPlane {
                origin_x: self.origin_x[i],
                origin_y: self.origin_y[i],
                depth: self.depth[i],
                slope_x: self.slope_x[i],
                slope_y: self.slope_y[i],
                farthest: self.farthest[i],
                nearest: self.nearest[i],
            },
        }
    }

    /// Puts a triangle at place `i`.
    pub fn set(&mut self, i: usize, t: &SpanTriangle) {
        self.present |= 1 << i;
        for edge in 0..4 {
            self.slope[edge][i] = t.spans.slope[edge];
            self.at_zero[edge][i] = t.spans.at_zero[edge];
        }
        for end in 0..2 {
            self.x[end][i] = f64::from(t.x[end]);
            self.y[end][i] = f64::from(t.y[end]);
        }
        self.origin_x[i] = t.depth.origin_x;
        self.origin_y[i] = t.depth.origin_y;
        self.depth[i] = t.depth.depth;
        self.slope_x[i] = t.depth.slope_x;
        self.slope_y[i] = t.depth.slope_y;
        self.farthest[i] = t.depth.farthest;
        self.nearest[i] = t.depth.nearest;
    }

    /// The triangles, in order.
    pub fn iter(&self) -> impl Iterator<Item = SpanTriangle> + '_ {
        (0..BLOCK)
            .filter(|i| self.present >> i & 1 == 1)
            .map(|i| self.get(i))
    }

    /// Packs triangles into blocks.
    pub fn pack(triangles: impl Iterator<Item = SpanTriangle>, blocks: &mut Vec<SpanBlock>) {
        for (index, triangle) in triangles.enumerate() {
            if index % BLOCK == 0 {
                blocks.push(SpanBlock::EMPTY);
            }
            if let Some(block) = blocks.last_mut() {
                block.set(index % BLOCK, &triangle);
            }
        }
    }
}
