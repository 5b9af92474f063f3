//! Fills polygons into rows of tiles: coverage, and two layers of depth for each part.
//!
//! The plain form is the definition: polygon after polygon, tile after tile, the covered samples by
//! [`SpanPolygon::coverage_of_tile`] and [`merge`]. The vector form gives the same bits:
//!
//! * **Strips.** Eight rows of a polygon are a strip. Those of a large polygon are found one by one, with a row in each lane;
//!   those of small ones together ([`crate::small`]). A strip is merged (`merge`) by masks and layers.
//! * **Masks.** The spans of a strip are eight bytes for either end. A tile's mask is two table look-ups of
//!   those bytes, less the tile's own column, and an AND: for as many tiles at once as a vector has groups of eight bytes.
//! * **Layers.** A part's mask is 32 bits and its depth an f32, so a vector of either holds the parts of two, four or
//!   eight tiles. The cases of [`merge`] become a sort of three layers by selection.
//! * **Nothing to do.** Where every sample is covered by layers that are nearer, the tiles stay as they are. Whole vectors
//!   of such tiles at the start of a strip are skipped before the strip's spans are found.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x4, f32x8, f64x4, f64x8, i16x8, i16x16, i32x8};

use crate::merge::{
    Merger, Parts, RowDepth, STRIPS, Strip, TILES_PER_STRIP, Waiting, merge_strips,
};
use crate::order::{greater, lesser};
use crate::small::SmallStrips;
use crate::spans::{EDGES, SpanBlock, SpanPolygon};
use crate::tile::{TileMut, merge};
use crate::{Level, PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

/// Some whole rows of a picture's tiles.
#[derive(Debug)]
pub struct TileRows<'a> {
    /// The covered samples of each tile.
    pub coverage: &'a mut [u64],
    /// The depths of each tile's parts: of their far layers.
    pub far: &'a mut [[f32; PARTS_PER_TILE]],
    /// The samples of each tile's near layers.
    pub near_samples: &'a mut [u64],
    /// The depths of each tile's near layers. Unspecified where a part has no sample in its near layer.
    pub near: &'a mut [[f32; PARTS_PER_TILE]],
    /// The first row of tiles.
    pub first_row: i32,
    /// Tiles in a row.
    pub across: usize,
    /// Rows of samples in the picture.
    pub height: i32,
    /// For each owner of blocks, how many samples its polygons took over as they were filled: of those not covered before, and
    /// of those known to be covered farther away. What others take over is not counted.
    pub gains: &'a mut [u32],
}

impl TileRows<'_> {
    fn rows(&self) -> i32 {
        (self.coverage.len() / self.across) as i32
    }
}

/// Fills the polygons of runs of blocks in order, as far as they lie in these rows.
pub fn fill<'b>(
    level: Level,
    runs: impl Iterator<Item = &'b [SpanBlock]>,
    rows: &mut TileRows<'_>,
) {
    match level.token() {
        None => fill_plain(runs, rows),
        Some(token) => dispatch!(token, simd => fill_vector(simd, runs, rows)),
    }
}

fn fill_plain<'b>(runs: impl Iterator<Item = &'b [SpanBlock]>, rows: &mut TileRows<'_>) {
    for block in runs.flatten() {
        let gain: u32 = block
            .iter()
            .map(|polygon| fill_one_plain(&polygon, rows))
            .sum();
        if let Some(counted) = rows.gains.get_mut(block.owner as usize) {
            *counted += gain;
        }
    }
}

/// Returns how many samples it took over.
fn fill_one_plain(polygon: &SpanPolygon, rows: &mut TileRows<'_>) -> u32 {
    let mut gain = 0;
    let first = (polygon.y[0] / TILE_SIZE).max(rows.first_row);
    let last = (polygon.y[1] / TILE_SIZE).min(rows.first_row + rows.rows() - 1);
    for tile_y in first..=last {
        for tile_x in polygon.x[0] / TILE_SIZE..=polygon.x[1] / TILE_SIZE {
            let mask = polygon.coverage_of_tile(tile_x, tile_y);
            if mask != 0 {
                let tile = (tile_y - rows.first_row) as usize * rows.across + tile_x as usize;
                let tile = TileMut {
                    coverage: &mut rows.coverage[tile],
                    far: &mut rows.far[tile],
                    near_samples: &mut rows.near_samples[tile],
                    near: &mut rows.near[tile],
                };
                gain += merge(tile, mask, polygon, tile_x, tile_y);
            }
        }
    }
    gain
}

#[inline(always)]
fn fill_vector<'b, S: Simd>(
    simd: S,
    runs: impl Iterator<Item = &'b [SpanBlock]>,
    rows: &mut TileRows<'_>,
) {
    if rows.across < S::f64s::LEN {
        // A picture narrower than a vector.
        return fill_plain(runs, rows);
    }
    let mut waiting = Waiting {
        strips: [Strip::EMPTY; STRIPS],
        count: 0,
    };
    let mut small = SmallStrips::EMPTY;
    let mut filler = Filler::new(simd, rows, &mut waiting, &mut small);
    for run in runs {
        for block in run {
            filler.find(block);
        }
    }
    filler.merge_waiting();
}

/// Strips of so many small polygons of a block are worth finding together.
const FEWEST_SMALL: u32 = 2;

/// No row of tiles.
const NONE: i32 = -1;

/// Finds polygons' strips in rows of tiles.
struct Filler<'a, S: Simd> {
    simd: S,
    parts: Parts<'a>,
    merger: Merger<S>,
    waiting: &'a mut Waiting,
    small: &'a mut SmallStrips,
    /// Tiles in a row.
    across: u32,
    first_row: i32,
    last_row: i32,
    /// The row of tiles that reaches beyond the picture's end, or [`NONE`].
    cut_row: i32,
    /// The bytes of the rows of samples before that end.
    rows_of_cut: u64,
    /// Whether the rows are all of the picture's.
    is_whole: bool,
    row_numbers: f64x8<S>,
}

impl<'a, S: Simd> Filler<'a, S> {
    #[inline(always)]
    fn new(
        simd: S,
        rows: &'a mut TileRows<'_>,
        waiting: &'a mut Waiting,
        small: &'a mut SmallStrips,
    ) -> Self {
        let last_row = rows.first_row + rows.rows() - 1;
        let samples_of_last = rows.height - last_row * TILE_SIZE;
        let is_cut = samples_of_last < TILE_SIZE;
        let is_whole = rows.first_row == 0 && samples_of_last <= TILE_SIZE;
        Filler {
            simd,
            first_row: rows.first_row,
            last_row,
            cut_row: if is_cut { last_row } else { NONE },
            rows_of_cut: if is_cut {
                (1 << (8 * samples_of_last)) - 1
            } else {
                u64::MAX
            },
            across: rows.across as u32,
            merger: Merger::new(simd, (rows.across - S::f64s::LEN) as u32),
            parts: Parts::new(rows),
            waiting,
            small,
            is_whole,
            row_numbers: f64x8::from_fn(simd, |i| i as f64),
        }
    }

    /// Finds the strips of the polygons of a block.
    #[inline(always)]
    fn find(&mut self, block: &SpanBlock) {
        let present = if self.is_whole {
            block.present
        } else {
            block.present & self.in_rows(block)
        };
        let small = block.small & present;
        let small = if small.count_ones() < FEWEST_SMALL {
            0
        } else {
            small
        };
        if small != 0 {
            self.small.find(self.simd, block, small);
        }
        let mut left = present;
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            if small >> i & 1 == 1 {
                self.find_small(block, i);
            } else {
                let polygon = Current::new(self.simd, block, i);
                let [first, last] = polygon.y.map(|y| to_tile(y) as i32);
                let first = first.max(self.first_row);
                let last = last.min(self.last_row);
                for tile_y in first..last + 1 {
                    self.find_strips(&polygon, tile_y);
                }
            }
        }
    }

    /// Which polygons of a block reach into these rows.
    #[inline(always)]
    fn in_rows(&self, block: &SpanBlock) -> u8 {
        let first = (self.first_row * TILE_SIZE) as f32;
        let last = ((self.last_row + 1) * TILE_SIZE - 1) as f32;
        let from = f32x8::load_array_ref(self.simd, &block.y[0]);
        let until = f32x8::load_array_ref(self.simd, &block.y[1]);
        (from.simd_le(last) & until.simd_ge(first)).to_bitmask() as u8
    }

    /// Merges the strips of a small polygon; finds those anew that reach beyond the picture's end.
    #[inline(always)]
    fn find_small(&mut self, block: &SpanBlock, i: usize) {
        let [first_tile, last] = self.small.tiles.each_ref().map(|end| end[i] as u32);
        let [first_row, last_row] = self.small.rows.each_ref().map(|end| end[i]);
        let from = first_row.max(self.first_row);
        let until = last_row.min(self.last_row);
        for tile_y in from..until + 1 {
            let k = (tile_y - first_row) as usize;
            if tile_y == self.cut_row || first_tile > self.merger.last_from {
                self.find_strips(&Current::new(self.simd, block, i), tile_y);
                continue;
            }
            // What waits comes before it.
            if self.waiting.count > 0 {
                self.merge_waiting();
            }
            let [upper, lower] = self.small.halves[k].each_ref().map(|half| half[i]);
            let strip = Strip {
                depth: RowDepth {
                    halves: [upper, lower, upper, lower],
                    per_tile: block.per_tile[i],
                    farthest: block.farthest[i],
                    nearest: block.nearest[i],
                    first_tile,
                },
                first: self.small.first[k][i],
                end: self.small.end[k][i],
                row: self.row_of(tile_y),
                from: first_tile,
                last,
                owner: block.owner,
            };
            let mut parts = self.parts.borrow();
            let gain = self.merger.merge_strip(&mut parts, &strip);
            parts.count(strip.owner, gain);
        }
    }

    /// Where a row of tiles begins.
    #[inline(always)]
    fn row_of(&self, tile_y: i32) -> u32 {
        (tile_y - self.first_row) as u32 * self.across
    }

    #[inline(always)]
    fn merge_waiting(&mut self) {
        let parts = self.parts.borrow();
        merge_strips(self.simd, parts, self.merger.last_from, self.waiting);
    }

    /// Finds a polygon's strip in a row of tiles; none where it is hidden, or holds nothing.
    #[inline(always)]
    fn find_strips(&mut self, p: &Current<S>, tile_y: i32) {
        let y = f64::from(tile_y * TILE_SIZE);
        let [first, last] = if p.columns[1] - p.columns[0] >= S::f64s::LEN as u32 {
            self.columns_of_strip(p, y)
        } else {
            p.columns
        };
        let row = self.row_of(tile_y);
        // Long runs of tiles show something nearer already: most are known to before anything else of the strip is, others
        // before its spans are.
        let (mut tile, is_covered) =
            self.merger
                .skip_behind_nearest(&self.parts, p.nearest, row, [first, last]);
        if tile > last {
            return;
        }
        let depth = RowDepth {
            halves: p.depths_of_halves(y as f32).to_array(),
            per_tile: p.per_tile,
            farthest: p.farthest,
            nearest: p.nearest,
            first_tile: p.columns[0],
        };
        if is_covered {
            tile = self
                .merger
                .skip_behind(&self.parts, &depth, row, [tile, last]);
        }
        if tile > last {
            return;
        }
        let ends = self.spans(p, y);
        while tile <= last {
            let from = tile.min(self.merger.last_from);
            let until = last.min(tile + TILES_PER_STRIP - 1);
            let [first, mut end] = self.counted_from(ends, [from, tile]);
            if tile_y == self.cut_row {
                // What is beyond the picture's end is not covered. Its rows are the bytes from the lowest on.
                end &= self.rows_of_cut;
            }
            self.waiting.strips[self.waiting.count] = Strip {
                depth,
                first,
                end,
                row,
                from,
                last: until,
                owner: p.owner,
            };
            self.waiting.count += 1;
            if self.waiting.count == STRIPS {
                self.merge_waiting();
            }
            tile = until + 1;
        }
    }

    /// The first covered column of each of eight rows, and the first one not covered after it.
    #[inline(always)]
    fn spans(&self, p: &Current<S>, y: f64) -> i16x16<S> {
        let rows = self.row_numbers + y;
        let v0 = rows * p.slope[0] + p.at_zero[0];
        let v1 = rows * p.slope[1] + p.at_zero[1];
        let v2 = rows * p.slope[2] + p.at_zero[2];
        let v3 = rows * p.slope[3] + p.at_zero[3];
        let (first, end) = match p.lower {
            1 => (v0, v1.min(v2).min(v3)),
            2 => (v0.max(v1), v2.min(v3)),
            _ => (v0.max(v1).max(v2), v3),
        };
        self.columns(p, first).relaxed_narrow(self.columns(p, end))
    }

    #[inline(always)]
    fn columns(&self, p: &Current<S>, v: f64x8<S>) -> i32x8<S> {
        let simd = self.simd;
        let (low, high) = simd.split_f64x8(v.ceil());
        // Small whole numbers are exact in f32, and all others lie beyond the columns.
        let v = low
            .narrow(high)
            .max(f32x8::splat(simd, p.x[0] as f32))
            .min(f32x8::splat(simd, p.x[1] as f32 + 1.0));
        simd.cvt_i32_f32x8(v)
    }

    /// Columns as bytes, counted from tile `from`, none of the first before `tile`.
    #[inline(always)]
    fn counted_from(&self, ends: i16x16<S>, [from, tile]: [u32; 2]) -> [u64; 2] {
        let simd = self.simd;
        let column = |tile: u32| (tile * TILE_SIZE as u32) as i16;
        let mut ends = ends;
        if from < tile {
            // At the end of the row.
            let (first, end) = simd.split_i16x16(ends);
            ends = simd.combine_i16x8(first.max(i16x8::splat(simd, column(tile))), end);
        }
        let ends = (ends - column(from))
            .max(i16x16::splat(simd, 0))
            .min(i16x16::splat(simd, i16::from(u8::MAX)));
        let (first, end) = simd.split_u16x16(ends.bitcast());
        bytemuck::cast(first.relaxed_narrow(end).to_array())
    }

    /// First and last tile of a strip that may hold a covered sample.
    #[inline(always)]
    fn columns_of_strip(&self, p: &Current<S>, y: f64) -> [u32; 2] {
        let simd = self.simd;
        let slope = f64x4::load_array(simd, p.slope);
        let at_zero = f64x4::load_array(simd, p.at_zero);
        let above = slope * greater(y, p.y[0]) + at_zero;
        let below = slope * lesser(y + f64::from(TILE_SIZE - 1), p.y[1]) + at_zero;
        let least = above.min(below).to_array();
        let most = above.max(below).to_array();
        let (first, last) = match p.lower {
            1 => (least[0], lesser(lesser(most[1], most[2]), most[3])),
            2 => (greater(least[0], least[1]), lesser(most[2], most[3])),
            _ => (greater(greater(least[0], least[1]), least[2]), most[3]),
        };
        let first = greater(first, p.x[0]);
        let last = lesser(last, p.x[1]);
        // Where there is nothing, the last comes out before the first.
        [
            to_tile(lesser(first, p.x[1] + 8.0)),
            to_tile(greater(last, 0.0)),
        ]
    }
}

/// The tile of a column or row: of a number from 0 to 2¹⁵, rounded down.
#[inline(always)]
fn to_tile(v: f64) -> u32 {
    to_index((v * (1.0 / f64::from(TILE_SIZE))).floor())
}

/// A small whole number as an integer: beside 2⁵² its bits are the last ones. (`as` takes ten instructions to be right for
/// all numbers.)
#[inline(always)]
fn to_index(v: f64) -> u32 {
    ((v + (1_u64 << 52) as f64).to_bits() & 0xffff) as u32
}

/// The polygon whose strips are being found.
struct Current<S: Simd> {
    slope: [f64; EDGES],
    at_zero: [f64; EDGES],
    lower: usize,
    x: [f64; 2],
    y: [f64; 2],
    /// First and last column of tiles.
    columns: [u32; 2],
    /// The row of each half that is farthest, counted from the strip's first.
    farthest_row: f32x4<S>,
    at: f32,
    per_row: f32,
    per_tile: f32,
    farthest: f32,
    nearest: f32,
    owner: u32,
}

impl<S: Simd> Current<S> {
    #[inline(always)]
    fn new(simd: S, block: &SpanBlock, i: usize) -> Current<S> {
        let per_row = block.per_row[i];
        let last = if per_row < 0.0 {
            (PART_HEIGHT - 1) as f32
        } else {
            0.0
        };
        let [slope, at_zero] = block.crossings(i);
        let x = [f64::from(block.x[0][i]), f64::from(block.x[1][i])];
        Current {
            slope,
            at_zero,
            lower: block.lower_edges(i),
            x,
            y: [f64::from(block.y[0][i]), f64::from(block.y[1][i])],
            columns: [to_tile(x[0]), to_tile(x[1])],
            farthest_row: f32x4::from_fn(simd, |half| (half as i32 % 2 * PART_HEIGHT) as f32)
                + last,
            at: block.at[i],
            per_row,
            per_tile: block.per_tile[i],
            farthest: block.farthest[i],
            nearest: block.nearest[i],
            owner: block.owner,
        }
    }

    /// The depths over the halves of the first tile, twice: [`PartDepth::over`](crate::part_depth::PartDepth::over).
    #[inline(always)]
    fn depths_of_halves(&self, y: f32) -> f32x4<S> {
        let simd = self.farthest_row.token();
        let [first, last] = self.y.map(|y| f32x4::splat(simd, y as f32));
        let row = (self.farthest_row + y).max(first).min(last);
        (row - first) * self.per_row + self.at
    }
}
