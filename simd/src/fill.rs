//! Fills triangles into rows of tiles: coverage, and two layers of depth for each part.
//!
//! The plain form is the definition: triangle after triangle, tile after tile, the covered samples by
//! [`SpanPolygon::coverage_of_tile`] and [`merge`]. The vector form gives the same bits:
//!
//! * **Masks.** The spans of a strip of eight rows are eight bytes for either end. A tile's mask is two table look-ups of
//!   those bytes, less the tile's own column, and an AND: for as many tiles at once as a vector has groups of eight bytes.
//! * **Layers.** A part's mask is 32 bits and its depth an f32, so a vector of either holds the parts of two, four or
//!   eight tiles. The cases of [`merge`] become a sort of three layers by selection.
//! * **Nothing to do.** Where every sample is covered by layers that are nearer, the tiles stay as they are.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f64x8, i16x8};

use crate::spans::{EDGES, SpanBlock, SpanPolygon};
use crate::strip_masks::StripMasks;
use crate::tile::{TileMut, UNCOVERED, merge};
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
}

impl TileRows<'_> {
    fn rows(&self) -> i32 {
        (self.coverage.len() / self.across) as i32
    }
}

/// Fills the triangles of blocks in order, as far as they lie in these rows.
pub fn fill(level: Level, blocks: &[SpanBlock], rows: &mut TileRows<'_>) {
    match level.token() {
        None => fill_plain(blocks, rows),
        Some(token) => dispatch!(token, simd => fill_vector(simd, blocks, rows)),
    }
}

fn fill_plain(blocks: &[SpanBlock], rows: &mut TileRows<'_>) {
    for triangle in blocks.iter().flat_map(SpanBlock::iter) {
        fill_one_plain(&triangle, rows);
    }
}

fn fill_one_plain(triangle: &SpanPolygon, rows: &mut TileRows<'_>) {
    let first = (triangle.y[0] / TILE_SIZE).max(rows.first_row);
    let last = (triangle.y[1] / TILE_SIZE).min(rows.first_row + rows.rows() - 1);
    for tile_y in first..=last {
        for tile_x in triangle.x[0] / TILE_SIZE..=triangle.x[1] / TILE_SIZE {
            let mask = triangle.coverage_of_tile(tile_x, tile_y);
            if mask != 0 {
                let tile = (tile_y - rows.first_row) as usize * rows.across + tile_x as usize;
                let tile = TileMut {
                    coverage: &mut rows.coverage[tile],
                    far: &mut rows.far[tile],
                    near_samples: &mut rows.near_samples[tile],
                    near: &mut rows.near[tile],
                };
                merge(tile, mask, triangle, tile_x, tile_y);
            }
        }
    }
}

#[inline(always)]
fn fill_vector<S: Simd>(simd: S, blocks: &[SpanBlock], rows: &mut TileRows<'_>) {
    if rows.across < S::f64s::LEN {
        // A picture narrower than a vector.
        return fill_plain(blocks, rows);
    }
    let mut filler = Filler::new(simd, rows);
    let mut waiting = Waiting {
        strips: [Strip::EMPTY; STRIPS],
        count: 0,
    };
    for block in blocks {
        let mut left = block.present;
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            let polygon = Current::new(block, i);
            let first = (polygon.y[0] / TILE_SIZE).max(filler.first_row);
            let last = (polygon.y[1] / TILE_SIZE).min(filler.first_row + filler.rows - 1);
            for tile_y in first..=last {
                filler.find_strips(&polygon, tile_y, &mut waiting);
            }
        }
    }
    filler.merge_strips(&mut waiting);
}

/// Strips that are found before they are merged. What a strip is takes a long chain of operations, and so does merging:
/// taken in turns, each would wait for the other; in runs, several of a kind are under way at once.
const STRIPS: usize = 32;

/// A strip has so many tiles at most, a multiple of what any vector holds: its columns fit a byte.
const TILES_PER_STRIP: usize = 24;

/// Eight rows of samples of a polygon, ready to be merged.
#[derive(Clone, Copy)]
struct Strip {
    /// The first covered column of each row, and then the first column of each, after those, that is not covered; counted
    /// from the first tile.
    ends: [u8; 16],
    /// The depths over the halves of the polygon's first tile.
    halves: [f32; PARTS_PER_TILE],
    /// What one column of tiles adds.
    per_tile: f32,
    farthest: f32,
    nearest: f32,
    /// The polygon's first column of tiles.
    first_tile: u32,
    /// Where the row of tiles begins.
    row: u32,
    /// First and last tile.
    tiles: [u32; 2],
}

impl Strip {
    const EMPTY: Strip = Strip {
        ends: [0; 16],
        halves: [0.0; PARTS_PER_TILE],
        per_tile: 0.0,
        farthest: 0.0,
        nearest: 0.0,
        first_tile: 0,
        row: 0,
        tiles: [0; 2],
    };
}

/// Strips that wait to be merged.
struct Waiting {
    strips: [Strip; STRIPS],
    count: usize,
}

/// What stays the same from triangle to triangle. A vector holds the parts of `S::f64s::LEN` tiles.
struct Filler<'a, S: Simd> {
    simd: S,
    coverage: &'a mut [u32],
    far: &'a mut [f32],
    near_samples: &'a mut [u32],
    near: &'a mut [f32],
    first_row: i32,
    rows: i32,
    across: usize,
    masks: StripMasks<S>,
    /// The tiles of the parts, counted from the first.
    part_tile: S::f32s,
    /// Whether a lane belongs to a lower part.
    is_lower: S::mask32s,
    row_numbers: f64x8<S>,
    row_numbers_short: i16x8<S>,
}

impl<'a, S: Simd> Filler<'a, S> {
    #[inline(always)]
    fn new(simd: S, rows: &'a mut TileRows<'_>) -> Self {
        Filler {
            simd,
            rows: rows.rows(),
            coverage: bytemuck::cast_slice_mut(rows.coverage),
            far: rows.far.as_flattened_mut(),
            near_samples: bytemuck::cast_slice_mut(rows.near_samples),
            near: rows.near.as_flattened_mut(),
            first_row: rows.first_row,
            across: rows.across,
            masks: StripMasks::new(simd),
            part_tile: S::f32s::from_fn(simd, |i| (i / PARTS_PER_TILE) as f32),
            is_lower: S::f32s::from_fn(simd, |i| (i % PARTS_PER_TILE) as f32)
                .simd_gt(S::f32s::splat(simd, 0.0)),
            row_numbers: f64x8::from_fn(simd, |i| i as f64),
            row_numbers_short: i16x8::from_fn(simd, |i| i as i16),
        }
    }

    /// Finds a polygon's strip in a row of tiles; none where it is hidden, or holds nothing.
    #[inline(always)]
    fn find_strips(&mut self, p: &Current<'_>, tile_y: i32, waiting: &mut Waiting) {
        let tiles = S::f64s::LEN;
        let y = tile_y * TILE_SIZE;
        let [mut tile, mut last] = p.columns;
        if last - tile >= tiles {
            [tile, last] = self.columns_of_strip(p, y);
        }
        let row = (tile_y - self.first_row) as usize * self.across;
        // Long runs of tiles are behind what they show already: that is known before anything else of the strip is.
        while tile <= last && self.is_hidden(p.nearest, row, tile) {
            tile += tiles;
        }
        if tile > last {
            return;
        }
        let [first, end] = self.spans(p, y);
        let halves = [p.depth_of_half(y), p.depth_of_half(y + PART_HEIGHT)];
        loop {
            let until = last.min(tile + TILES_PER_STRIP - 1);
            let from = tile.min(self.across - tiles);
            let strip = &mut waiting.strips[waiting.count];
            strip.ends = self.masks.ends_from(first, end, from).to_array();
            strip.halves = halves;
            strip.per_tile = p.per_tile;
            strip.farthest = p.farthest;
            strip.nearest = p.nearest;
            strip.first_tile = p.columns[0] as u32;
            strip.row = row as u32;
            strip.tiles = [tile as u32, until as u32];
            waiting.count += 1;
            if waiting.count == STRIPS {
                self.merge_strips(waiting);
            }
            if until == last {
                return;
            }
            tile = until + 1;
        }
    }

    /// A function of its own, since it is called from two places.
    #[inline(always)]
    fn merge_strips(&mut self, waiting: &mut Waiting) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                for strip in &waiting.strips[..waiting.count] {
                    self.merge_strip(strip);
                }
                waiting.count = 0;
            },
        );
    }

    #[inline(always)]
    fn merge_strip(&mut self, strip: &Strip) {
        let simd = self.simd;
        let tiles = S::f64s::LEN;
        let [mut tile, last] = strip.tiles.map(|tile| tile as usize);
        let from = tile.min(self.across - tiles);
        let mut first = self.masks.ends(&strip.ends[..8]);
        let end = self.masks.ends(&strip.ends[8..]);
        let halves = self.is_lower.select(
            S::f32s::splat(simd, strip.halves[1]),
            S::f32s::splat(simd, strip.halves[0]),
        );
        loop {
            let start = tile.min(self.across - tiles);
            if start < tile {
                // At the end of the row, some tiles of the vector have had theirs.
                first = self.masks.not_before(first, tile - from);
            }
            let mask = self.masks.between(first, end, start - from);
            let number = start as f32 - strip.first_tile as f32;
            let depth = halves + (self.part_tile + number) * strip.per_tile;
            let depth = depth
                .max(S::f32s::splat(simd, strip.farthest))
                .min(S::f32s::splat(simd, strip.nearest));
            self.merge(mask, depth, strip.row as usize + start);
            tile += tiles;
            if tile > last {
                return;
            }
        }
    }

    /// Whether a vector's tiles are covered and nowhere farther than the triangle's nearest vertex.
    #[inline(always)]
    fn is_hidden(&self, nearest: f32, row: usize, tile: usize) -> bool {
        let at = (row + tile.min(self.across - S::f64s::LEN)) * PARTS_PER_TILE;
        let range = at..at + S::u32s::LEN;
        let coverage = S::u32s::from_slice(self.simd, &self.coverage[range.clone()]);
        let far = S::f32s::from_slice(self.simd, &self.far[range]);
        let full = coverage.simd_eq(S::u32s::splat(self.simd, u32::MAX));
        (full & far.simd_ge(S::f32s::splat(self.simd, nearest))).all_true()
    }

    /// The first covered column of each of eight rows, and the first one not covered after it.
    #[inline(always)]
    fn spans(&self, p: &Current<'_>, y: i32) -> [i16x8<S>; 2] {
        let simd = self.simd;
        let rows = self.row_numbers + f64::from(y);
        let v0 = rows * p.slope[0] + p.at_zero[0];
        let v1 = rows * p.slope[1] + p.at_zero[1];
        let v2 = rows * p.slope[2] + p.at_zero[2];
        let v3 = rows * p.slope[3] + p.at_zero[3];
        let (first, end) = match p.lower {
            1 => (v0, v1.min(v2).min(v3)),
            2 => (v0.max(v1), v2.min(v3)),
            _ => (v0.max(v1).max(v2), v3),
        };
        let (first, end) = (self.columns(p, first), self.columns(p, end));
        // Rows below the picture's end.
        let inside = self
            .row_numbers_short
            .simd_le(i16x8::splat(simd, (p.y[1] - y).min(TILE_SIZE) as i16));
        [first, inside.select(end, i16x8::splat(simd, 0))]
    }

    #[inline(always)]
    fn columns(&self, p: &Current<'_>, v: f64x8<S>) -> i16x8<S> {
        let simd = self.simd;
        let least = f64x8::splat(simd, p.x[0] - 0.25);
        let largest = f64x8::splat(simd, p.x[1] + 0.75);
        let (low, high) = simd.split_f64x8(v.max(least).min(largest).ceil());
        let (low, high) = simd.split_i32x8(simd.cvt_i32_f32x8(low.narrow(high)));
        low.relaxed_narrow(high)
    }

    /// First and last tile of a strip that may hold a covered sample.
    #[inline(always)]
    fn columns_of_strip(&self, p: &Current<'_>, y: i32) -> [usize; 2] {
        let top = f64::from(y.max(p.y[0]));
        let bottom = f64::from((y + TILE_SIZE - 1).min(p.y[1]));
        let mut at = [[0.0; 2]; EDGES];
        for ((at, slope), zero) in at.iter_mut().zip(p.slope).zip(p.at_zero) {
            let (above, below) = (slope * top + zero, slope * bottom + zero);
            *at = [lesser(above, below), greater(above, below)];
        }
        let (first, last) = match p.lower {
            1 => (at[0][0], lesser(lesser(at[1][1], at[2][1]), at[3][1])),
            2 => (greater(at[0][0], at[1][0]), lesser(at[2][1], at[3][1])),
            _ => (greater(greater(at[0][0], at[1][0]), at[2][0]), at[3][1]),
        };
        let first = greater(first, p.x[0]);
        let last = lesser(last, p.x[1]);
        // Where there is nothing, the last comes out before the first.
        [
            to_tile(lesser(first, p.x[1] + 8.0)),
            to_tile(greater(last, 0.0)),
        ]
    }

    /// Merges the samples `mask`, in parts at these depths, into the tiles from `tile`.
    #[inline(always)]
    fn merge(&mut self, mask: S::u32s, depth: S::f32s, tile: usize) {
        let simd = self.simd;
        let at = tile * PARTS_PER_TILE;
        let range = at..at + S::u32s::LEN;
        let coverage = S::u32s::from_slice(simd, &self.coverage[range.clone()]);
        let near_samples = S::u32s::from_slice(simd, &self.near_samples[range.clone()]);
        let far = S::f32s::from_slice(simd, &self.far[range.clone()]);
        let near = S::f32s::from_slice(simd, &self.near[range.clone()]);
        let none = S::u32s::splat(simd, 0);
        let far_samples = coverage & !near_samples;
        // Samples that a layer shows nearer, or as near.
        let hidden = far.simd_ge(depth).select(far_samples, none)
            | near.simd_ge(depth).select(near_samples, none);
        let new = mask & !hidden;
        if new.simd_eq(none).all_true() {
            return;
        }
        let far_samples = far_samples & !new;
        let near_samples = near_samples & !new;
        (coverage | mask).store_slice(&mut self.coverage[range.clone()]);
        if (far_samples | near_samples).simd_eq(none).all_true() {
            // Nothing but this triangle is left, or nothing at all.
            none.store_slice(&mut self.near_samples[range.clone()]);
            let depth = new.simd_eq(none).select(far, depth);
            depth.store_slice(&mut self.far[range]);
            return;
        }
        let [far, near] = Layer::<S>::two_of_three([
            Layer::new(far_samples, far),
            Layer::new(near_samples, near),
            Layer::new(new, depth),
        ]);
        near.samples
            .store_slice(&mut self.near_samples[range.clone()]);
        far.depth.store_slice(&mut self.far[range.clone()]);
        near.depth.store_slice(&mut self.near[range]);
    }
}

#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The tile of a column or row: of a number from 0 to 2¹⁵, rounded down.
#[inline(always)]
fn to_tile(v: f64) -> usize {
    to_index((v * (1.0 / f64::from(TILE_SIZE))).floor())
}

/// A small whole number as an index: beside 2⁵² its bits are the last ones. (`as` takes ten instructions to be right for
/// all numbers.)
#[inline(always)]
fn to_index(v: f64) -> usize {
    ((v + (1_u64 << 52) as f64).to_bits() & 0xffff) as usize
}

/// The polygon whose strips are being found.
struct Current<'b> {
    block: &'b SpanBlock,
    i: usize,
    slope: [f64; EDGES],
    at_zero: [f64; EDGES],
    lower: u8,
    x: [f64; 2],
    y: [i32; 2],
    /// First and last column of tiles.
    columns: [usize; 2],
    per_tile: f32,
    farthest: f32,
    nearest: f32,
}

impl<'b> Current<'b> {
    #[inline(always)]
    fn new(block: &'b SpanBlock, i: usize) -> Current<'b> {
        Current {
            slope: block.slope.map(|edge| edge[i]),
            at_zero: block.at_zero.map(|edge| edge[i]),
            lower: block.lower[i],
            x: [block.x[0][i], block.x[1][i]],
            y: [
                to_index(block.y[0][i]) as i32,
                to_index(block.y[1][i]) as i32,
            ],
            columns: [to_tile(block.x[0][i]), to_tile(block.x[1][i])],
            per_tile: block.per_tile[i],
            farthest: block.farthest[i],
            nearest: block.nearest[i],
            block,
            i,
        }
    }

    /// The depth over a half of the first tile: [`PartDepth::over`](crate::part_depth::PartDepth::over).
    #[inline(always)]
    fn depth_of_half(&self, first: i32) -> f32 {
        let per_row = self.block.per_row[self.i];
        let row = if per_row < 0.0 {
            (first + PART_HEIGHT - 1).min(self.y[1])
        } else {
            first.max(self.y[0])
        };
        self.block.at[self.i] + per_row * (row - self.y[0]) as f32
    }
}

/// A layer of several parts: see [`crate::tile`]. Minus infinity is the depth where there is no sample.
#[derive(Clone, Copy)]
struct Layer<S: Simd> {
    samples: S::u32s,
    depth: S::f32s,
}

impl<S: Simd> Layer<S> {
    #[inline(always)]
    fn new(samples: S::u32s, depth: S::f32s) -> Layer<S> {
        let simd = samples.token();
        let absent = S::f32s::splat(simd, f32::NEG_INFINITY);
        let none = S::u32s::splat(simd, 0);
        Layer {
            samples,
            depth: samples.simd_eq(none).select(absent, depth),
        }
    }

    #[inline(always)]
    fn select(mask: S::mask32s, a: Layer<S>, b: Layer<S>) -> Layer<S> {
        Layer {
            samples: mask.select(a.samples, b.samples),
            depth: mask.select(a.depth, b.depth),
        }
    }

    /// The farther first; as they are where neither is.
    #[inline(always)]
    fn sort([a, b]: [Layer<S>; 2]) -> [Layer<S>; 2] {
        let swap = b.depth.simd_lt(a.depth);
        [Layer::select(swap, b, a), Layer::select(swap, a, b)]
    }

    /// The far and the near layer that three become: [`crate::tile`]'s rule, by selection.
    #[inline(always)]
    fn two_of_three([far, near, new]: [Layer<S>; 3]) -> [Layer<S>; 2] {
        let simd = far.samples.token();
        let none = S::u32s::splat(simd, 0);
        let absent = S::f32s::splat(simd, f32::NEG_INFINITY);
        let [a, b] = Layer::<S>::sort([far, near]);
        let [b, c] = Layer::sort([b, new]);
        let [a, b] = Layer::sort([a, b]);
        let only_two = a.depth.simd_eq(absent);
        let gap_is_farther =
            ((b.depth - a.depth) * c.depth.abs()).simd_le((c.depth - b.depth) * a.depth.abs());
        let b_is_far = only_two | gap_is_farther;
        let far = Layer::<S> {
            samples: a.samples | b_is_far.select(b.samples, none),
            depth: only_two.select(b.depth, a.depth),
        };
        let near = Layer::<S> {
            samples: c.samples | b_is_far.select(none, b.samples),
            depth: b_is_far.select(c.depth, b.depth),
        };
        let only_one = far.depth.simd_eq(absent);
        let is_one = only_one | far.depth.simd_eq(near.depth);
        let depth = only_one.select(near.depth, far.depth);
        [
            Layer {
                samples: is_one.select(far.samples | near.samples, far.samples),
                depth: depth
                    .simd_eq(absent)
                    .select(S::f32s::splat(simd, UNCOVERED), depth),
            },
            Layer {
                samples: is_one.select(none, near.samples),
                depth: near.depth,
            },
        ]
    }
}
