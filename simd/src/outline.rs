//! The samples inside a box's outline on screen, one strip (a row of tiles) at a time, and whether they are covered.
//!
//! An outline is a rectangle of samples, cut by edges on the left and on the right. Each edge is a column that changes
//! linearly from row to row; in every row the samples from the largest of the left edges to the least of the right ones
//! are inside:
//!
//! ```text
//!   left edges  ╱▒▒▒▒▒╲            a strip: 8 rows, each with its first and last column
//!              ╱▒▒▒▒▒▒▒╲
//!              ╲▒▒▒▒▒▒▒▒╲  right edges
//!               ╲▒▒▒▒▒▒╱
//! ```
//!
//! Whoever makes the edges moves them outwards by all that may be off, the rounding of [`OutlineEdge::at`] included.

use crate::TILE_SIZE;

/// A column, counting samples, that changes linearly with the row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlineEdge {
    /// What one row down adds.
    pub slope: f64,
    /// The column at row 0.
    pub offset: f64,
}

impl OutlineEdge {
    /// The column at a row.
    #[inline]
    pub fn at(&self, row: i32) -> f64 {
        self.slope * f64::from(row) + self.offset
    }
}

/// A box's outline has at most six edges, and all may be on one side.
pub const MOST_EDGES: usize = 6;

/// The edges on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlineSide {
    edges: [OutlineEdge; MOST_EDGES],
    count: usize,
}

impl OutlineSide {
    const EMPTY: OutlineSide = OutlineSide {
        edges: [OutlineEdge {
            slope: 0.0,
            offset: 0.0,
        }; MOST_EDGES],
        count: 0,
    };

    /// The edges.
    pub fn edges(&self) -> &[OutlineEdge] {
        &self.edges[..self.count]
    }

    /// Adds an edge. Beyond [`MOST_EDGES`] it is left out: the outline stays wider.
    pub fn push(&mut self, edge: OutlineEdge) {
        if let Some(free) = self.edges.get_mut(self.count) {
            *free = edge;
            self.count += 1;
        }
    }
}

/// The samples that something may cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// First and last column; within 0 to 2^14.
    pub x: [i32; 2],
    /// First and last row; within 0 to 2^14.
    pub y: [i32; 2],
    /// Samples lie at or to the right of these. Finite.
    pub left: OutlineSide,
    /// Samples lie at or to the left of these. Finite.
    pub right: OutlineSide,
}

/// A row without samples: its first column is beyond every last one.
const NO_COLUMNS: [i32; 2] = [1 << 20, -1];

impl Outline {
    /// All samples of columns `x` and rows `y`, ends included.
    pub fn of_rectangle(x: [i32; 2], y: [i32; 2]) -> Outline {
        Outline {
            x,
            y,
            left: OutlineSide::EMPTY,
            right: OutlineSide::EMPTY,
        }
    }

    /// First and last column of the samples in a row of the outline's rectangle; the first is the greater if there are
    /// none.
    #[inline]
    pub fn columns(&self, row: i32) -> [i32; 2] {
        let [mut first, mut last] = self.x.map(f64::from);
        for edge in self.left.edges() {
            let column = edge.at(row);
            first = if column > first { column } else { first };
        }
        for edge in self.right.edges() {
            let column = edge.at(row);
            last = if column < last { column } else { last };
        }
        // Past this both lie within the rectangle's columns, which are not negative: to truncate is to round down.
        if first > last {
            return NO_COLUMNS;
        }
        let below = first as i32;
        let first = below + i32::from(f64::from(below) < first);
        let last = last as i32;
        if first > last {
            NO_COLUMNS
        } else {
            [first, last]
        }
    }

    /// The samples in the row of tiles `tile_y`, which the outline's rectangle meets.
    #[inline]
    pub fn strip(&self, tile_y: i32) -> Strip {
        let top = tile_y * TILE_SIZE;
        let mut strip = Strip {
            columns: [NO_COLUMNS; TILE_SIZE as usize],
            rows: 0,
            outer: NO_COLUMNS,
            inner: [i32::MIN, i32::MAX],
        };
        for row in self.y[0].max(top)..=self.y[1].min(top + TILE_SIZE - 1) {
            let [first, last] = self.columns(row);
            if first <= last {
                let index = row - top;
                strip.columns[index as usize] = [first, last];
                strip.rows |= 0xff << (8 * index);
                strip.outer = [strip.outer[0].min(first), strip.outer[1].max(last)];
                strip.inner = [strip.inner[0].max(first), strip.inner[1].min(last)];
            }
        }
        strip
    }
}

/// The samples of an outline in one row of tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// First and last column of each row.
    columns: [[i32; 2]; TILE_SIZE as usize],
    /// All samples of a tile in the rows that have any.
    rows: u64,
    /// Columns that hold all samples.
    outer: [i32; 2],
    /// Columns that each such row has samples in.
    inner: [i32; 2],
}

impl Strip {
    /// The tiles of the row that may hold samples, from the left.
    #[inline]
    pub fn tiles(&self) -> std::ops::Range<usize> {
        if self.rows == 0 {
            0..0
        } else {
            (self.outer[0] / TILE_SIZE) as usize..(self.outer[1] / TILE_SIZE) as usize + 1
        }
    }

    /// The samples of tile `tile_x`, bit 8·row + column.
    #[inline]
    pub fn mask(&self, tile_x: usize) -> u64 {
        let x0 = tile_x as i32 * TILE_SIZE;
        if self.inner[0] <= x0 && x0 + TILE_SIZE - 1 <= self.inner[1] {
            return self.rows;
        }
        let mut mask = 0;
        for (row, [first, last]) in self.columns.iter().enumerate() {
            let first = (first - x0).clamp(0, TILE_SIZE);
            let end = (last + 1 - x0).clamp(0, TILE_SIZE);
            let bits = (0xff_u64 << first) & ((1 << end) - 1);
            mask |= bits << (8 * row);
        }
        mask
    }

    /// Whether all samples are covered. `coverage` is that row of tiles.
    #[inline]
    pub fn is_covered(&self, coverage: &[u64]) -> bool {
        self.tiles()
            .all(|tile| self.mask(tile) & !coverage[tile] == 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(slope: f64, offset: f64) -> OutlineEdge {
        OutlineEdge { slope, offset }
    }

    /// Edges of all slopes, some of them on whole columns.
    fn outlines() -> impl Iterator<Item = Outline> {
        let mut state = 7_u64;
        let mut number = move |count: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) % count
        };
        (0..3_000).map(move |_| {
            let mut span = |limit: u64| {
                let (a, b) = (number(limit) as i32, number(limit) as i32);
                [a.min(b), a.max(b)]
            };
            let mut outline = Outline::of_rectangle(span(61), span(43));
            for _ in 0..number(5) {
                let slope = (number(65) as f64 - 32.0) * [0.125, 1.0, 1e6][number(3) as usize];
                let (x, y) = (number(61) as f64, number(43) as f64);
                let through = edge(slope, x - slope * y);
                if number(2) == 0 {
                    outline.left.push(through);
                } else {
                    outline.right.push(through);
                }
            }
            outline
        })
    }

    fn is_inside(o: &Outline, x: i32, y: i32) -> bool {
        let within = |r: [i32; 2], v: i32| r[0] <= v && v <= r[1];
        within(o.x, x)
            && within(o.y, y)
            && o.left.edges().iter().all(|e| e.at(y) <= f64::from(x))
            && o.right.edges().iter().all(|e| f64::from(x) <= e.at(y))
    }

    #[test]
    fn a_strip_holds_just_the_samples_between_the_edges() {
        let mut seen = 0;
        for outline in outlines() {
            for tile_y in outline.y[0] / 8..=outline.y[1] / 8 {
                let strip = outline.strip(tile_y);
                for tile_x in 0..8_i32 {
                    let mut expected = 0_u64;
                    for bit in 0..64 {
                        let (x, y) = (8 * tile_x + bit % 8, 8 * tile_y + bit / 8);
                        expected |= u64::from(is_inside(&outline, x, y)) << bit;
                    }
                    let tile = tile_x as usize;
                    assert_eq!(strip.mask(tile), expected, "{outline:?} {tile_x} {tile_y}");
                    assert!(expected == 0 || strip.tiles().contains(&tile));
                    seen += expected.count_ones();
                }
            }
        }
        assert!(seen > 100_000, "{seen} samples");
    }

    #[test]
    fn a_strip_is_covered_where_no_tile_lacks_more_than_is_ignored() {
        for (round, outline) in outlines().enumerate() {
            let hole = ((round * 7 % 61) as i32, (round * 5 % 43) as i32);
            let tile_y = hole.1 / 8;
            if tile_y < outline.y[0] / 8 || tile_y > outline.y[1] / 8 {
                continue;
            }
            let mut coverage = [u64::MAX; 8];
            coverage[hole.0 as usize / 8] &= !(1 << (hole.1 % 8 * 8 + hole.0 % 8));
            let strip = outline.strip(tile_y);
            let seen_through = is_inside(&outline, hole.0, hole.1);
            assert_eq!(strip.is_covered(&coverage), !seen_through);
        }
    }
}
