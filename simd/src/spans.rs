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
//!
//! Of a small polygon ([`SMALL`]), slopes and crossings count from the corner of its first tile and are f32. There `|A|` and
//! `|B|` are at most `48·2⁸`, corners lie within 57 samples, or 48 beyond the picture's edge, so `|C| < 2²¹`: all exact.
//! Rows are below 56, and a crossing that matters is at most 57 in size. With `s = |B|/|A|` the slope is off by two roundings
//! of `s`, so a row's part of the crossing by three of `55·s`; `at_zero` by two of numbers up to `57 + 55·s`; the sum by one
//! of 57. Together `2⁻²⁴·(171·|A| + 275·|B|)/|A|`, less than `0.33/|A|`.

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
    /// From which column and row these count: the picture's corner, or that of a small polygon's first tile.
    pub origin: [i32; 2],
}

/// Stands for 1/A where an edge is horizontal.
pub(crate) const HORIZONTAL: f64 = (1_u64 << 30) as f64;

/// Exchanges in this order sort four edges by their side.
pub(crate) const EXCHANGES: [[usize; 2]; 5] = [[0, 1], [2, 3], [0, 2], [1, 3], [1, 2]];

impl Spans {
    /// The spans between the edges of a polygon, which is small or not and has its first sample in this column and row.
    pub fn between(edges: &[Edge; EDGES], first: [i32; 2], is_small: bool) -> Spans {
        if is_small {
            let origin = first.map(|v| v / TILE_SIZE * TILE_SIZE);
            let [x, y] = origin.map(i64::from);
            Spans::sorted(origin, edges, |e| {
                let inverse = match e.a {
                    0 => HORIZONTAL as f32,
                    a => 1.0 / a as f32,
                };
                let at_origin = (e.a * x + e.b * y + e.c) as f32;
                let [slope, at_zero] = [-(e.b as f32) * inverse, -(at_origin + 0.5) * inverse];
                [slope, at_zero].map(f64::from)
            })
        } else {
            Spans::sorted([0, 0], edges, |e| {
                let inverse = match e.a {
                    0 => HORIZONTAL,
                    a => 1.0 / a as f64,
                };
                [-(e.b as f64) * inverse, -(e.c as f64 + 0.5) * inverse]
            })
        }
    }

    fn sorted(
        origin: [i32; 2],
        edges: &[Edge; EDGES],
        solved: impl Fn(&Edge) -> [f64; 2],
    ) -> Spans {
        let mut crossings = edges.each_ref().map(|e| (e.a >= 0, solved(e)));
        for [i, j] in EXCHANGES {
            if !crossings[i].0 && crossings[j].0 {
                crossings.swap(i, j);
            }
        }
        Spans {
            slope: crossings.map(|(_, [slope, _])| slope),
            at_zero: crossings.map(|(_, [_, at_zero])| at_zero),
            // What is inside everywhere counts too. A of the others add up to 0 and are not all 0.
            lower: crossings.iter().filter(|(is_lower, _)| *is_lower).count(),
            origin,
        }
    }

    /// First covered column of a row, and the first one after it that is not covered, both within `x`: from its first
    /// column to the one after its last.
    #[inline]
    pub fn of_row(&self, y: i32, x: [i32; 2]) -> [i32; 2] {
        let [column, row] = self.origin;
        let at = |edge: usize| self.slope[edge] * f64::from(y - row) + self.at_zero[edge];
        // A quarter beside the first and the last column, so that the ceiling gives what it should.
        let least = f64::from(x[0] - column) - 0.25;
        let largest = f64::from(x[1] - column) + 0.75;
        let column = |v: f64| column + lesser(greater(v, least), largest).ceil() as i32;
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

impl SpanPolygon {
    /// A triangle pulled in by `inset` sub-pixels: see [`Edge::moved_in`]. Its extents must lie within the picture.
    pub fn of_triangle(t: &Triangle, inset: i32) -> SpanPolygon {
        // One of three edges is as wide as all, and one as high.
        let [across, down] = t.edges.iter().fold([0, 0], |[across, down], e| {
            [across.max(e.b.abs()), down.max(e.a.abs())]
        });
        let is_small = across.max(down) <= i64::from(SMALL);
        let edges = [t.edges[0], t.edges[1], t.edges[2], Edge::EVERYWHERE];
        let edges = edges.map(|edge| edge.moved_in(inset));
        let extent = [across, down].map(|e| e as f64);
        SpanPolygon {
            is_small,
            spans: Spans::between(&edges, [t.x[0], t.y[0]], is_small),
            x: t.x,
            y: t.y,
            depth: PartDepth::new(&t.depth, extent, t.x, t.y, inset),
        }
    }

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
    /// Whose polygons these are: a place in the gains that [`fill`](crate::fill::fill) counts.
    pub owner: u32,
    /// Bit `i` is set if polygon `i` is small: [`SMALL`].
    pub small: u8,
    /// Whether the second and the third edge have their inside on the right: bit `i` for polygon `i`.
    pub lower: [u8; 2],
    /// Of polygons that are not small, columns a row of four edges each; see [`Spans`].
    pub slope: [[f64; BLOCK]; EDGES],
    /// And the crossings of row 0.
    pub at_zero: [[f64; BLOCK]; EDGES],
    /// Of small polygons, the same, from the corners of their first tiles.
    pub small_slope: [[f32; BLOCK]; EDGES],
    /// Likewise.
    pub small_at_zero: [[f32; BLOCK]; EDGES],
    /// First and last columns.
    pub x: [[f32; BLOCK]; 2],
    /// First and last rows.
    pub y: [[f32; BLOCK]; 2],
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
        owner: 0,
        small: 0,
        lower: [0; 2],
        slope: [[0.0; BLOCK]; EDGES],
        at_zero: [[0.0; BLOCK]; EDGES],
        small_slope: [[0.0; BLOCK]; EDGES],
        small_at_zero: [[0.0; BLOCK]; EDGES],
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

    /// Where the edges of polygon `i` cross row 0 and how far from one row to the next, counted from the picture's corner.
    /// (To move a small one's takes them off by less than `2⁻²⁰/|A|`.)
    #[inline(always)]
    pub(crate) fn crossings(&self, i: usize) -> [[f64; EDGES]; 2] {
        let (mut slope, mut at_zero) = ([0.0; EDGES], [0.0; EDGES]);
        if self.small >> i & 1 == 0 {
            for edge in 0..EDGES {
                slope[edge] = self.slope[edge][i];
                at_zero[edge] = self.at_zero[edge][i];
            }
        } else {
            let per_tile = 1.0 / TILE_SIZE as f32;
            let tiles = [self.x[0][i], self.y[0][i]].map(|v| (v * per_tile).floor());
            let [x, y] = tiles.map(|tile| f64::from(tile) * f64::from(TILE_SIZE));
            for edge in 0..EDGES {
                slope[edge] = f64::from(self.small_slope[edge][i]);
                at_zero[edge] = f64::from(self.small_at_zero[edge][i]) - slope[edge] * y + x;
            }
        }
        [slope, at_zero]
    }

    /// Polygon `i`.
    pub fn get(&self, i: usize) -> SpanPolygon {
        let is_small = self.small >> i & 1 == 1;
        let first_tile = [self.x[0][i], self.y[0][i]].map(|v| v as i32 / TILE_SIZE);
        let lower = self.lower_edges(i);
        let spans = if is_small {
            Spans {
                slope: self.small_slope.map(|e| f64::from(e[i])),
                at_zero: self.small_at_zero.map(|e| f64::from(e[i])),
                lower,
                origin: first_tile.map(|tile| tile * TILE_SIZE),
            }
        } else {
            Spans {
                slope: self.slope.map(|e| e[i]),
                at_zero: self.at_zero.map(|e| e[i]),
                lower,
                origin: [0, 0],
            }
        };
        SpanPolygon {
            spans,
            x: self.x.map(|x| x[i] as i32),
            y: self.y.map(|y| y[i] as i32),
            depth: PartDepth {
                at: self.at[i],
                per_row: self.per_row[i],
                per_tile: self.per_tile[i],
                farthest: self.farthest[i],
                nearest: self.nearest[i],
                first_row: self.y[0][i] as i32,
                first_tile: first_tile[0],
            },
            is_small,
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
            let (slope, at_zero) = (t.spans.slope[edge], t.spans.at_zero[edge]);
            if t.is_small {
                self.small_slope[edge][i] = slope as f32;
                self.small_at_zero[edge][i] = at_zero as f32;
            } else {
                self.slope[edge][i] = slope;
                self.at_zero[edge][i] = at_zero;
            }
        }
        for end in 0..2 {
            self.x[end][i] = t.x[end] as f32;
            self.y[end][i] = t.y[end] as f32;
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
}

/// Blocks one after the other, in memory that is used again: what was there is written over, but for what is not in a block.
#[derive(Clone, Debug, Default)]
pub struct SpanBlocks {
    memory: Vec<SpanBlock>,
    count: usize,
}

impl SpanBlocks {
    /// Forgets all blocks.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Appends a block without a polygon. Its numbers may be any of earlier polygons.
    #[inline]
    pub(crate) fn append(&mut self) -> &mut SpanBlock {
        if self.count == self.memory.len() {
            self.memory.push(SpanBlock::EMPTY);
        }
        let block = &mut self.memory[self.count];
        self.count += 1;
        block.present = 0;
        block.owner = 0;
        block.small = 0;
        block.lower = [0; 2];
        block
    }

    /// Appends a block.
    pub fn push(&mut self, block: SpanBlock) {
        *self.append() = block;
    }

    /// Says whose the blocks from `first` on are.
    pub fn set_owner(&mut self, first: usize, owner: u32) {
        for block in &mut self.memory[first..self.count] {
            block.owner = owner;
        }
    }

    /// Appends polygons, in blocks of their own.
    pub fn pack(&mut self, mut polygons: impl Iterator<Item = SpanPolygon>) {
        while let Some(first) = polygons.next() {
            let block = self.append();
            block.set(0, &first);
            for (i, polygon) in (1..BLOCK).zip(&mut polygons) {
                block.set(i, &polygon);
            }
        }
    }
}

impl std::ops::Deref for SpanBlocks {
    type Target = [SpanBlock];

    fn deref(&self) -> &[SpanBlock] {
        &self.memory[..self.count]
    }
}
