//! Fills triangles into rows of tiles: coverage, and two layers of depth for each part.
//!
//! The plain form is the definition: triangle after triangle, tile after tile, the covered samples by
//! [`SpanTriangle::coverage_of_tile`] and [`merge`]. The vector form gives the same bits:
//!
//! * **Masks.** The spans of a strip of eight rows are eight bytes for either end. A tile's mask is two table look-ups of
//!   those bytes, less the tile's own column, and an AND: for as many tiles at once as a vector has groups of eight bytes.
//! * **Layers.** A part's mask is 32 bits and its depth an f32, so a vector of either holds the parts of two, four or
//!   eight tiles. The cases of [`merge`] become a sort of three layers by selection ([`Layers::merge`]).
//! * **Nothing to do.** Where every sample is covered by layers that are nearer, the tiles stay as they are.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f64x4, f64x8, i16x8, u8x16};

use crate::spans::SpanTriangle;
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

/// Fills triangles in order, as far as they lie in these rows.
pub fn fill(level: Level, triangles: &[SpanTriangle], rows: &mut TileRows<'_>) {
    match level.token() {
        None => fill_plain(triangles, rows),
        Some(token) => dispatch!(token, simd => fill_vector(simd, triangles, rows)),
    }
}

fn fill_plain(triangles: &[SpanTriangle], rows: &mut TileRows<'_>) {
    for triangle in triangles {
        fill_one_plain(triangle, rows);
    }
}

/// The strips of eight rows that a triangle shares with `rows`.
#[inline(always)]
fn strips(triangle: &SpanTriangle, rows: &TileRows<'_>) -> std::ops::RangeInclusive<i32> {
    (triangle.y[0] / TILE_SIZE).max(rows.first_row)
        ..=(triangle.y[1] / TILE_SIZE).min(rows.first_row + rows.rows() - 1)
}

fn fill_one_plain(triangle: &SpanTriangle, rows: &mut TileRows<'_>) {
    for tile_y in strips(triangle, rows) {
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
fn fill_vector<S: Simd>(simd: S, triangles: &[SpanTriangle], rows: &mut TileRows<'_>) {
    if rows.across < S::f64s::LEN {
        // A picture narrower than a vector.
        return fill_plain(triangles, rows);
    }
    let mut filler = Filler::new(simd, rows);
    for triangle in triangles {
        filler.fill(triangle);
    }
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
    /// Byte `i`: the lowest `i` bits set.
    low_bits: S::u8s,
    /// Byte `i`: the column of the tile that byte `i` of a mask belongs to.
    tile_column: S::u8s,
    /// Lane `i`: the column of tile `i`.
    tile_x: S::f64s,
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
            low_bits: S::u8s::block_splat(u8x16::from_fn(simd, |i| {
                (0xff_u16 >> (8 - i.min(8))) as u8
            })),
            tile_column: S::u8s::from_fn(simd, |i| (i & !7) as u8),
            tile_x: S::f64s::from_fn(simd, |i| f64::from(i as i32 * TILE_SIZE)),
            row_numbers: f64x8::from_fn(simd, |i| i as f64),
            row_numbers_short: i16x8::from_fn(simd, |i| i as i16),
        }
    }

    #[inline(always)]
    fn fill(&mut self, t: &SpanTriangle) {
        let first = (t.y[0] / TILE_SIZE).max(self.first_row);
        let last = (t.y[1] / TILE_SIZE).min(self.first_row + self.rows - 1);
        for tile_y in first..=last {
            self.fill_strip(t, tile_y);
        }
    }

    #[inline(always)]
    fn fill_strip(&mut self, t: &SpanTriangle, tile_y: i32) {
        let tiles = S::f64s::LEN;
        let y = tile_y * TILE_SIZE;
        let [first, end] = self.spans(t, y);
        let plane = self.depth_of_strip(t, y);
        let mut tile = (t.x[0] / TILE_SIZE) as usize;
        let mut last = (t.x[1] / TILE_SIZE) as usize;
        if last - tile >= tiles {
            [tile, last] = self.columns_of_strip(t, y);
        }
        let row = (tile_y - self.first_row) as usize * self.across;
        while tile <= last {
            let start = tile.min(self.across - tiles);
            let mask = self.mask(first, end, start, tile);
            self.merge(t, &plane, mask, row, start);
            tile += tiles;
        }
    }

    /// The first covered column of each of eight rows, and the first one not covered after it.
    #[inline(always)]
    fn spans(&self, t: &SpanTriangle, y: i32) -> [i16x8<S>; 2] {
        let simd = self.simd;
        let rows = self.row_numbers + f64::from(y);
        let at = |edge: usize| rows * t.spans.slope[edge] + t.spans.at_zero[edge];
        let least = f64x8::splat(simd, f64::from(t.x[0]) - 0.25);
        let largest = f64x8::splat(simd, f64::from(t.x[1]) + 0.75);
        let column = |v: f64x8<S>| {
            let (low, high) = simd.split_f64x8(v.max(least).min(largest).ceil());
            let columns = simd.cvt_i32_f32x8(low.narrow(high));
            let (low, high) = simd.split_i32x8(columns);
            low.narrow(high)
        };
        let first = column(at(0).max(at(1)));
        let end = column(at(2).min(at(3)));
        // Rows below the picture's end.
        let inside = self
            .row_numbers_short
            .simd_le(i16x8::splat(simd, (t.y[1] - y).min(TILE_SIZE) as i16));
        [first, inside.select(end, i16x8::splat(simd, 0))]
    }

    /// First and last tile of a strip that may hold a covered sample.
    #[inline(always)]
    fn columns_of_strip(&self, t: &SpanTriangle, y: i32) -> [usize; 2] {
        let simd = self.simd;
        let slope = f64x4::load_array(simd, t.spans.slope);
        let at_zero = f64x4::load_array(simd, t.spans.at_zero);
        let top = slope * f64::from(y.max(t.y[0])) + at_zero;
        let bottom = slope * f64::from((y + TILE_SIZE - 1).min(t.y[1])) + at_zero;
        let [a, b, ..] = top.min(bottom).to_array();
        let [.., c, d] = top.max(bottom).to_array();
        let first = a.max(b).max(f64::from(t.x[0]));
        let last = c.min(d).min(f64::from(t.x[1]));
        // Where there is nothing, the last comes out before the first.
        [
            first.min(f64::from(t.x[1]) + 8.0) as usize / TILE_SIZE as usize,
            last.max(0.0) as usize / TILE_SIZE as usize,
        ]
    }

    /// The covered samples of the tiles from `start`; none left of tile `from`.
    #[inline(always)]
    fn mask(&self, first: i16x8<S>, end: i16x8<S>, start: usize, from: usize) -> S::u32s {
        let simd = self.simd;
        let column = i16x8::splat(simd, (start * TILE_SIZE as usize) as i16);
        let bytes = |v: i16x8<S>, least: usize| {
            let least = i16x8::splat(simd, (least * TILE_SIZE as usize) as i16);
            let v = (v - column).max(least).min(i16x8::splat(simd, 64));
            let bytes: u8x16<S> = v.narrow(v).bitcast();
            let of_tile = S::u8s::block_splat(bytes)
                .saturating_sub(self.tile_column)
                .min(S::u8s::splat(simd, 8));
            self.low_bits.swizzle_dyn_within_blocks(of_tile)
        };
        let (before, until) = (bytes(first, from - start), bytes(end, 0));
        (until & !before).bitcast()
    }

    /// What a strip adds to the depth: see [`DepthPlane::farthest_over`](crate::triangle::DepthPlane::farthest_over).
    #[inline(always)]
    fn depth_of_strip(&self, t: &SpanTriangle, y: i32) -> StripDepth<S> {
        let simd = self.simd;
        let plane = &t.depth;
        let of_half = |first: i32| {
            let row = if plane.slope_y < 0.0 {
                (first + PART_HEIGHT - 1).min(t.y[1])
            } else {
                first.max(t.y[0])
            };
            S::f64s::splat(simd, plane.slope_y * (f64::from(row) - plane.origin_y))
        };
        StripDepth {
            halves: [of_half(y), of_half(y + PART_HEIGHT)],
        }
    }

    /// Merges the samples `mask` of tiles from `start` in the row of tiles that begins at `row`.
    #[inline(always)]
    fn merge(
        &mut self,
        t: &SpanTriangle,
        strip: &StripDepth<S>,
        mask: S::u32s,
        row: usize,
        start: usize,
    ) {
        let simd = self.simd;
        let lanes = S::u32s::LEN;
        let at = (row + start) * PARTS_PER_TILE;
        let plane = &t.depth;
        // The farthest corner of each part, in the order of operations of `DepthPlane::at`.
        let right = if plane.slope_x < 0.0 { 7.0 } else { 0.0 };
        let x = (self.tile_x + (f64::from((start as i32) * TILE_SIZE) + right))
            .max(S::f64s::splat(simd, f64::from(t.x[0])))
            .min(S::f64s::splat(simd, f64::from(t.x[1])));
        let along = (x - plane.origin_x) * plane.slope_x + plane.depth;
        let (low, high) = (along + strip.halves[0]).interleave(along + strip.halves[1]);
        let depth: S::f32s = low.narrow(high);
        let nearest = S::f32s::splat(simd, plane.nearest as f32);
        let farthest = S::f32s::splat(simd, plane.farthest as f32);
        let depth = depth
            .simd_gt(nearest)
            .select(nearest, depth.simd_gt(farthest).select(depth, farthest));

        let range = at..at + lanes;
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
        let absent = S::f32s::splat(simd, f32::NEG_INFINITY);
        let layer = |samples: S::u32s, depth: S::f32s| Layer::<S> {
            samples,
            depth: samples.simd_eq(none).select(absent, depth),
        };
        let [far, near] = Layer::<S>::two_of_three([
            layer(far_samples, far),
            layer(near_samples, near),
            layer(new, depth),
        ]);
        near.samples.store_slice(&mut self.near_samples[range.clone()]);
        far.depth.store_slice(&mut self.far[range.clone()]);
        near.depth.store_slice(&mut self.near[range]);
    }
}

struct StripDepth<S: Simd> {
    halves: [S::f64s; PARTS_PER_TILE],
}

/// A layer of several parts: see [`crate::tile`]. Minus infinity is the depth where there is no sample.
#[derive(Clone, Copy)]
struct Layer<S: Simd> {
    samples: S::u32s,
    depth: S::f32s,
}

impl<S: Simd> Layer<S> {
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
