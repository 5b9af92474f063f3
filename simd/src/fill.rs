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
    let mut strips = [Strip::EMPTY; STRIPS];
    let mut waiting = 0;
    for block in blocks {
        let mut left = block.present;
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            let t = Current::new(block, i);
            let first = (t.y[0] / TILE_SIZE).max(filler.first_row);
            let last = (t.y[1] / TILE_SIZE).min(filler.first_row + filler.rows - 1);
            for tile_y in first..=last {
                if let Some(strip) = filler.strip(&t, tile_y) {
                    strips[waiting] = strip;
                    waiting += 1;
                    if waiting == STRIPS {
                        filler.merge_strips(&strips);
                        waiting = 0;
                    }
                }
            }
        }
    }
    filler.merge_strips(&strips[..waiting]);
}

/// Strips that are found before they are merged. What a strip is takes a long chain of operations, and so does merging:
/// taken in turns, each would wait for the other; in runs, several of a kind are under way at once.
const STRIPS: usize = 32;

/// Eight rows of samples of a triangle, ready to be merged.
#[derive(Clone, Copy)]
struct Strip<'b> {
    block: &'b SpanBlock,
    i: usize,
    /// The first covered column of each row.
    first: [i16; 8],
    /// The first column of each row, after those, that is not covered.
    end: [i16; 8],
    /// The depths of the farthest row of either half, where the plane starts.
    halves: [f64; PARTS_PER_TILE],
    /// Where the row of tiles begins.
    row: usize,
    /// First and last tile.
    tiles: [usize; 2],
}

impl Strip<'_> {
    const EMPTY: Strip<'static> = Strip {
        block: &SpanBlock::EMPTY,
        i: 0,
        first: [0; 8],
        end: [0; 8],
        halves: [0.0; PARTS_PER_TILE],
        row: 0,
        tiles: [0; 2],
    };
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
    /// The columns of the parts' tiles, two parts each: for the lower lanes of a vector of depths, and the upper ones.
    part_x: [S::f64s; 2],
    /// Whether a lane belongs to a lower part.
    is_lower: S::mask64s,
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
            part_x: [0, S::f64s::LEN].map(|first| {
                S::f64s::from_fn(simd, |i| {
                    f64::from((first + i) as i32 / PARTS_PER_TILE as i32 * TILE_SIZE)
                })
            }),
            is_lower: S::f64s::from_fn(simd, |i| (i % PARTS_PER_TILE) as f64)
                .simd_gt(S::f64s::splat(simd, 0.0)),
            row_numbers: f64x8::from_fn(simd, |i| i as f64),
            row_numbers_short: i16x8::from_fn(simd, |i| i as i16),
        }
    }

    /// A triangle's strip; none where it is hidden, or holds nothing.
    #[inline(always)]
    fn strip<'b>(&self, t: &Current<'b>, tile_y: i32) -> Option<Strip<'b>> {
        let tiles = S::f64s::LEN;
        let y = tile_y * TILE_SIZE;
        let [mut tile, mut last] = t.columns;
        if last - tile >= tiles {
            [tile, last] = self.columns_of_strip(t, y);
        }
        let row = (tile_y - self.first_row) as usize * self.across;
        // Long runs of tiles are behind what they show already: that is known before anything else of the strip is.
        while tile <= last && self.is_hidden(t.nearest, row, tile) {
            tile += tiles;
        }
        if tile > last {
            return None;
        }
        let [first, end] = self.spans(t, y);
        Some(Strip {
            block: t.block,
            i: t.i,
            first: first.to_array(),
            end: end.to_array(),
            halves: [depth_of_half(t, y), depth_of_half(t, y + PART_HEIGHT)],
            row,
            tiles: [tile, last],
        })
    }

    #[inline(always)]
    fn merge_strips(&mut self, strips: &[Strip<'_>]) {
        for strip in strips {
            self.merge_strip(strip);
        }
    }

    #[inline(always)]
    fn merge_strip(&mut self, strip: &Strip<'_>) {
        let simd = self.simd;
        let tiles = S::f64s::LEN;
        let first = i16x8::load_array(simd, strip.first);
        let end = i16x8::load_array(simd, strip.end);
        let halves = self.is_lower.select(
            S::f64s::splat(simd, strip.halves[1]),
            S::f64s::splat(simd, strip.halves[0]),
        );
        let [mut tile, last] = strip.tiles;
        loop {
            let start = tile.min(self.across - tiles);
            let mask = self.masks.between(first, end, start, tile);
            self.merge(strip, halves, mask, start);
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
    fn spans(&self, t: &Current<'_>, y: i32) -> [i16x8<S>; 2] {
        let simd = self.simd;
        let rows = self.row_numbers + f64::from(y);
        let v0 = rows * t.slope[0] + t.at_zero[0];
        let v1 = rows * t.slope[1] + t.at_zero[1];
        let v2 = rows * t.slope[2] + t.at_zero[2];
        let v3 = rows * t.slope[3] + t.at_zero[3];
        let (first, end) = match t.lower {
            1 => (v0, v1.min(v2).min(v3)),
            2 => (v0.max(v1), v2.min(v3)),
            _ => (v0.max(v1).max(v2), v3),
        };
        let (first, end) = (self.columns(t, first), self.columns(t, end));
        // Rows below the picture's end.
        let inside = self
            .row_numbers_short
            .simd_le(i16x8::splat(simd, (t.y[1] - y).min(TILE_SIZE) as i16));
        [first, inside.select(end, i16x8::splat(simd, 0))]
    }

    #[inline(always)]
    fn columns(&self, t: &Current<'_>, v: f64x8<S>) -> i16x8<S> {
        let simd = self.simd;
        let least = f64x8::splat(simd, t.x[0] - 0.25);
        let largest = f64x8::splat(simd, t.x[1] + 0.75);
        let (low, high) = simd.split_f64x8(v.max(least).min(largest).ceil());
        let (low, high) = simd.split_i32x8(simd.cvt_i32_f32x8(low.narrow(high)));
        low.relaxed_narrow(high)
    }

    /// First and last tile of a strip that may hold a covered sample.
    #[inline(always)]
    fn columns_of_strip(&self, t: &Current<'_>, y: i32) -> [usize; 2] {
        let top = f64::from(y.max(t.y[0]));
        let bottom = f64::from((y + TILE_SIZE - 1).min(t.y[1]));
        let mut at = [[0.0; 2]; EDGES];
        for ((at, slope), zero) in at.iter_mut().zip(t.slope).zip(t.at_zero) {
            let (above, below) = (slope * top + zero, slope * bottom + zero);
            *at = [lesser(above, below), greater(above, below)];
        }
        let (first, last) = match t.lower {
            1 => (at[0][0], lesser(lesser(at[1][1], at[2][1]), at[3][1])),
            2 => (greater(at[0][0], at[1][0]), lesser(at[2][1], at[3][1])),
            _ => (greater(greater(at[0][0], at[1][0]), at[2][0]), at[3][1]),
        };
        let first = greater(first, t.x[0]);
        let last = lesser(last, t.x[1]);
        // Where there is nothing, the last comes out before the first.
        [
            to_tile(lesser(first, t.x[1] + 8.0)),
            to_tile(greater(last, 0.0)),
        ]
    }

    #[inline(always)]
    fn depth_of_parts(&self, strip: &Strip<'_>, halves: S::f64s, x: S::f64s) -> S::f64s {
        let (block, i) = (strip.block, strip.i);
        let x = x
            .max(S::f64s::splat(self.simd, block.x[0][i]))
            .min(S::f64s::splat(self.simd, block.x[1][i]));
        (x - block.origin_x[i]) * block.slope_x[i] + halves
    }

    /// Merges the samples `mask` of tiles from `start` in a strip's row.
    #[inline(always)]
    fn merge(&mut self, strip: &Strip<'_>, halves: S::f64s, mask: S::u32s, start: usize) {
        let simd = self.simd;
        let (block, i) = (strip.block, strip.i);
        let at = (strip.row + start) * PARTS_PER_TILE;
        // The farthest corner of each part, in the order of operations of `DepthPlane::at`.
        let right = if block.slope_x[i] < 0.0 { 7.0 } else { 0.0 };
        let column = f64::from((start as i32) * TILE_SIZE) + right;
        let low = self.depth_of_parts(strip, halves, self.part_x[0] + column);
        let high = self.depth_of_parts(strip, halves, self.part_x[1] + column);
        let depth: S::f32s = low.narrow(high);
        let nearest = S::f32s::splat(simd, block.nearest[i] as f32);
        let farthest = S::f32s::splat(simd, block.farthest[i] as f32);
        let not_farther = depth.simd_gt(farthest).select(depth, farthest);
        let depth = depth.simd_gt(nearest).select(nearest, not_farther);

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

/// The depth of the farthest row of a half, where the plane starts: see
/// [`DepthPlane::farthest_over`](crate::triangle::DepthPlane::farthest_over).
#[inline(always)]
fn depth_of_half(t: &Current<'_>, first: i32) -> f64 {
    let (block, i) = (t.block, t.i);
    let row = if block.slope_y[i] < 0.0 {
        (first + PART_HEIGHT - 1).min(t.y[1])
    } else {
        first.max(t.y[0])
    };
    block.depth[i] + block.slope_y[i] * (f64::from(row) - block.origin_y[i])
}

/// The triangle whose strips are being found.
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
    nearest: f32,
}

impl<'b> Current<'b> {
    #[inline(always)]
    fn new(block: &'b SpanBlock, i: usize) -> Current<'b> {
        Current {
            x: [block.x[0][i], block.x[1][i]],
            y: [
                to_index(block.y[0][i]) as i32,
                to_index(block.y[1][i]) as i32,
            ],
            columns: [to_tile(block.x[0][i]), to_tile(block.x[1][i])],
            nearest: block.nearest[i] as f32,
            slope: block.slope.map(|edge| edge[i]),
            at_zero: block.at_zero.map(|edge| edge[i]),
            lower: block.lower[i],
            block,
            i,
        }
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
