//! Which samples of a row a convex polygon covers, as an interval of columns: the edges solved for x.
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
use crate::order::{greater, lesser};
use crate::part_depth::PartDepth;
use crate::small::SMALL;
use crate::triangle::{Edge, Triangle};

/// Edges of a polygon: of a quadrilateral, or of a triangle and one that is inside everywhere.
pub const EDGES: usize = 4;

/// Where edges cross the rows of samples, at `slope·y + at_zero`: first those with their inside on the right, then those
/// with their inside on the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spans {
    /// Columns a row.
    pub slope: [f64; EDGES],
    /// The crossing of row 0.
    pub at_zero: [f64; EDGES],
    /// How many have their inside on the right: one to three.
    pub lower: usize,
}

/// Stands for 1/A where an edge is horizontal.
pub(crate) const HORIZONTAL: f64 = (1_u64 << 30) as f64;

/// Exchanges in this order sort four edges by their side.
pub(crate) const EXCHANGES: [[usize; 2]; 5] = [[0, 1], [2, 3], [0, 2], [1, 3], [1, 2]];

impl Spans {
    /// The spans between the edges of a polygon.
    pub fn between(edges: &[Edge; EDGES]) -> Spans {
        let mut crossings = edges.map(|e| {
            let inverse = if e.a == 0 {
                HORIZONTAL
            } else {
                1.0 / e.a as f64
            };
            let slope = -(e.b as f64) * inverse;
            (e.a >= 0, slope, -(e.c as f64 + 0.5) * inverse)
        });
        for [i, j] in EXCHANGES {
            if !crossings[i].0 && crossings[j].0 {
                crossings.swap(i, j);
            }
        }
        Spans {
            slope: crossings.map(|(_, slope, _)| slope),
            at_zero: crossings.map(|(.., at_zero)| at_zero),
            // What is inside everywhere counts too. A of the others add up to 0 and are not all 0.
            lower: crossings.iter().filter(|(is_lower, ..)| *is_lower).count(),
        }
    }

    /// First covered column of a row, and the first one after it that is not covered, both within `x`: from its first
    /// column to the one after its last.
    #[inline]
    pub fn of_row(&self, y: i32, x: [i32; 2]) -> [i32; 2] {
        let at = |edge: usize| self.slope[edge] * f64::from(y) + self.at_zero[edge];
        // A quarter beside the first and the last column, so that the ceiling gives what it should.
        let (least, largest) = (f64::from(x[0]) - 0.25, f64::from(x[1]) + 0.75);
        let column = |v: f64| lesser(greater(v, least), largest).ceil() as i32;
        let first = (0..self.lower).map(at).fold(f64::NEG_INFINITY, greater);
        let end = (self.lower..EDGES).map(at).fold(f64::INFINITY, lesser);
        [column(first), column(end)]
    }
}

/// A triangle or a convex quadrilateral ready to be filled, in the form that the occluders' filler reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanPolygon {
    /// Its rows' intervals.
    pub spans: Spans,
    /// First and last column of samples that can be covered, within the picture.
    pub x: [i32; 2],
    /// First and last row of samples that can be covered, within the picture.
    pub y: [i32; 2],
    /// Its depth.
    pub depth: PartDepth,
    /// Whether its corners reach over no more than [`SMALL`] sub-pixels, across and down.
    pub is_small: bool,
}

impl From<&Triangle> for SpanPolygon {
    /// The triangle's extents must lie within the picture.
    fn from(t: &Triangle) -> SpanPolygon {
        // One of three edges is as wide as all, and one as high.
        let [across, down] = t.edges.iter().fold([0, 0], |[across, down], e| {
            [across.max(e.b.abs()), down.max(e.a.abs())]
        });
        let limit = i64::from(SMALL);
        SpanPolygon {
            is_small: across <= limit && down <= limit,
            spans: Spans::between(&[t.edges[0], t.edges[1], t.edges[2], Edge::EVERYWHERE]),
            x: t.x,
            y: t.y,
            depth: PartDepth::new(&t.depth, [across, down].map(|e| e as f64), t.x, t.y),
        }
    }
}

impl SpanPolygon {
    /// The samples of tile (`tile_x`, `tile_y`) that the polygon covers: the same as
    /// [`coverage_of_tile`](crate::coverage::coverage_of_tile) finds of its triangles.
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

/// Polygons in a block.
pub const BLOCK: usize = 8;

/// Up to eight polygons ready to be filled, structure of arrays: what a set-up of several at once leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanBlock {
    /// Bit `i` is set if there is a polygon `i`.
    pub present: u8,
    /// Columns a row, of four edges each; see [`Spans`].
    pub slope: [[f64; BLOCK]; EDGES],
    /// The crossings of row 0, of four edges each.
    pub at_zero: [[f64; BLOCK]; EDGES],
    /// Whether the second and the third edge have their inside on the right: bit `i` for polygon `i`.
    pub lower: [u8; 2],
    /// Bit `i` is set if polygon `i` is small: [`SMALL`].
    pub small: u8,
    /// First and last columns.
    pub x: [[f64; BLOCK]; 2],
    /// First and last rows.
    pub y: [[f64; BLOCK]; 2],
    /// The depths in the first rows and columns of tiles; see [`PartDepth`].
    pub at: [f32; BLOCK],
    /// What one row of samples adds.
    pub per_row: [f32; BLOCK],
    /// What one column of tiles adds.
    pub per_tile: [f32; BLOCK],
    /// The least of each polygon's depths.
    pub farthest: [f32; BLOCK],
    /// The largest of each polygon's depths.
    pub nearest: [f32; BLOCK],
}

impl SpanBlock {
    /// No polygon.
    pub const EMPTY: SpanBlock = SpanBlock {
        present: 0,
        slope: [[0.0; BLOCK]; EDGES],
        at_zero: [[0.0; BLOCK]; EDGES],
        lower: [0; 2],
        small: 0,
        x: [[0.0; BLOCK]; 2],
        y: [[0.0; BLOCK]; 2],
        at: [0.0; BLOCK],
        per_row: [0.0; BLOCK],
        per_tile: [0.0; BLOCK],
        farthest: [0.0; BLOCK],
        nearest: [0.0; BLOCK],
    };

    /// How many edges of polygon `i` have their inside on the right.
    #[inline(always)]
    pub fn lower_edges(&self, i: usize) -> usize {
        1 + usize::from(self.lower[0] >> i & 1) + usize::from(self.lower[1] >> i & 1)
    }

    /// Polygon `i`.
    pub fn get(&self, i: usize) -> SpanPolygon {
        SpanPolygon {
            spans: Spans {
                slope: self.slope.map(|e| e[i]),
                at_zero: self.at_zero.map(|e| e[i]),
                lower: self.lower_edges(i),
            },
            x: self.x.map(|x| x[i] as i32),
            y: self.y.map(|y| y[i] as i32),
            depth: PartDepth {
                at: self.at[i],
                per_row: self.per_row[i],
                per_tile: self.per_tile[i],
                farthest: self.farthest[i],
                nearest: self.nearest[i],
                first_row: self.y[0][i] as i32,
                first_tile: self.x[0][i] as i32 / TILE_SIZE,
            },
            is_small: self.small >> i & 1 == 1,
        }
    }

    /// Puts a polygon at place `i`.
    pub fn set(&mut self, i: usize, t: &SpanPolygon) {
        self.present |= 1 << i;
        for (edge, lower) in self.lower.iter_mut().enumerate() {
            *lower |= u8::from(t.spans.lower > edge + 1) << i;
        }
        self.small |= u8::from(t.is_small) << i;
        for edge in 0..EDGES {
            self.slope[edge][i] = t.spans.slope[edge];
            self.at_zero[edge][i] = t.spans.at_zero[edge];
        }
        for end in 0..2 {
            self.x[end][i] = f64::from(t.x[end]);
            self.y[end][i] = f64::from(t.y[end]);
        }
        self.at[i] = t.depth.at;
        self.per_row[i] = t.depth.per_row;
        self.per_tile[i] = t.depth.per_tile;
        self.farthest[i] = t.depth.farthest;
        self.nearest[i] = t.depth.nearest;
    }

    /// The polygons, in order.
    pub fn iter(&self) -> impl Iterator<Item = SpanPolygon> + '_ {
        (0..BLOCK)
            .filter(|i| self.present >> i & 1 == 1)
            .map(|i| self.get(i))
    }

    /// Packs polygons into blocks.
    pub fn pack(polygons: impl Iterator<Item = SpanPolygon>, blocks: &mut Vec<SpanBlock>) {
        for (index, polygon) in polygons.enumerate() {
            if index % BLOCK == 0 {
                blocks.push(SpanBlock::EMPTY);
            }
            if let Some(block) = blocks.last_mut() {
                block.set(index % BLOCK, &polygon);
            }
        }
    }
}
