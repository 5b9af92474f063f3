//! The strips of small polygons, those of a block at once: a lane for each polygon.
//!
//! A strip's eight rows fill a vector of f64, but a polygon of a few pixels has one or two strips, and what it takes to get
//! at each is more than the rows. So the strips of all small polygons of a block are found together, row by row, in f32.
//!
//! That is exact enough. Let coordinates count samples from the corner of the polygon's first tile. Then |A| and |B| are at
//! most [`SMALL`] sub-pixels, rows are below 56, columns below 57, and a crossing that matters is at most 57 in size. With
//! `s = |B|/|A|`, its value at the first row is off by half a unit of `57 + 56·s`, the slope by one of `s`, its product with
//! the row by one of `55·s`, and the sum by one of 57: together `2⁻²⁴·(114·|A| + 166·|B|)/|A|`, less than `0.21/|A|`. With the
//! `2⁻⁸/|A|` of the numbers that this starts from it stays below the `½/|A|` that [`crate::spans`] asks for.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, f64x8, i32x8, mask32x8, u32x8};

use crate::spans::{BLOCK, EDGES, SpanBlock};
use crate::{PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

/// A polygon is small if its corners reach over no more sub-pixels than this, across and down.
pub const SMALL: i32 = 48 * crate::SUBPIXELS;

/// The most strips that a small polygon has.
const STRIPS_FOUND: usize = (SMALL / crate::SUBPIXELS / TILE_SIZE) as usize + 1;

/// Strips but the first are found here if so many polygons have one.
const FEWEST_MORE: u32 = 2;

/// The strips of the small polygons of a block.
pub(crate) struct SmallStrips {
    /// First and last rows of tiles.
    pub(crate) rows: [[i32; BLOCK]; 2],
    /// First and last columns of tiles.
    pub(crate) tiles: [[i32; BLOCK]; 2],
    /// How many strips of each are known.
    pub(crate) found: usize,
    /// Strip by strip, a byte for each of eight rows: the first covered columns, counted from the first tile.
    pub(crate) first: [[u64; BLOCK]; STRIPS_FOUND],
    /// And the first columns after those that are not covered.
    pub(crate) end: [[u64; BLOCK]; STRIPS_FOUND],
    /// Strip by strip, the depths over the halves of the first tile.
    pub(crate) halves: [[[f32; BLOCK]; PARTS_PER_TILE]; STRIPS_FOUND],
}

impl SmallStrips {
    pub(crate) const EMPTY: SmallStrips = SmallStrips {
        rows: [[0; BLOCK]; 2],
        tiles: [[0; BLOCK]; 2],
        found: 0,
        first: [[0; BLOCK]; STRIPS_FOUND],
        end: [[0; BLOCK]; STRIPS_FOUND],
        halves: [[[0.0; BLOCK]; PARTS_PER_TILE]; STRIPS_FOUND],
    };

    /// Finds the strips of the polygons that `small` names.
    #[inline(always)]
    pub(crate) fn find<S: Simd>(&mut self, simd: S, block: &SpanBlock, small: u8) {
        let names = mask32x8::from_bitmask(simd, u64::from(small));
        let zero = f32x8::splat(simd, 0.0);
        let tile = TILE_SIZE as f32;
        // Not by `map`: what it calls is not compiled for the level.
        let x0 = names.select(narrow(simd, &block.x[0]), zero);
        let x1 = names.select(narrow(simd, &block.x[1]), zero);
        let y0 = names.select(narrow(simd, &block.y[0]), zero);
        let y1 = names.select(narrow(simd, &block.y[1]), zero);
        let per_sample = 1.0 / tile;
        let tiles = [(x0 * per_sample).floor(), (x1 * per_sample).floor()];
        let rows = [(y0 * per_sample).floor(), (y1 * per_sample).floor()];
        for end in 0..2 {
            to_whole(simd, tiles[end]).store_array(&mut self.tiles[end]);
            to_whole(simd, rows[end]).store_array(&mut self.rows[end]);
        }
        let corner = [tiles[0] * tile, rows[0] * tile];
        let left = x0 - corner[0];
        let right = x1 - corner[0] + 1.0;
        let edges = Edges::new(simd, block, small, corner);

        let more = rows[1] - rows[0];
        for strip in 0..STRIPS_FOUND {
            let have = more.simd_ge(strip as f32) & names;
            if strip > 0 && have.to_bitmask().count_ones() < FEWEST_MORE {
                break;
            }
            self.found = strip + 1;
            let row = (strip as i32 * TILE_SIZE) as f32;
            let upper = edges.of_four_rows(row, [left, right]);
            let lower = edges.of_four_rows(row + 4.0, [left, right]);
            store_rows(upper[0], lower[0], &mut self.first[strip]);
            store_rows(upper[1], lower[1], &mut self.end[strip]);
            self.find_halves(simd, block, strip, [y0, y1], corner[1]);
        }
    }

    /// The depths over the halves of first tiles: [`PartDepth::over`](crate::part_depth::PartDepth::over).
    #[inline(always)]
    fn find_halves<S: Simd>(
        &mut self,
        simd: S,
        block: &SpanBlock,
        strip: usize,
        y: [f32x8<S>; 2],
        corner: f32x8<S>,
    ) {
        let at = f32x8::load_array(simd, block.at);
        let per_row = f32x8::load_array(simd, block.per_row);
        let zero = f32x8::splat(simd, 0.0);
        let last = f32x8::splat(simd, (PART_HEIGHT - 1) as f32);
        let farthest = per_row.simd_lt(zero).select(last, zero);
        for (half, kept) in self.halves[strip].iter_mut().enumerate() {
            let first = strip as i32 * TILE_SIZE + half as i32 * PART_HEIGHT;
            let row = (corner + first as f32 + farthest).max(y[0]).min(y[1]);
            (at + per_row * (row - y[0])).store_array(kept);
        }
    }
}

/// Where the edges of small polygons cross rows that are counted, like columns, from their first tiles.
struct Edges<S: Simd> {
    slope: [f32x8<S>; EDGES],
    at_zero: [f32x8<S>; EDGES],
    /// Whether the second and the third have their inside on the right.
    lower: [mask32x8<S>; 2],
}

impl<S: Simd> Edges<S> {
    #[inline(always)]
    fn new(simd: S, block: &SpanBlock, small: u8, [x, y]: [f32x8<S>; 2]) -> Self {
        let names = mask32x8::from_bitmask(simd, u64::from(small));
        let nothing = f32x8::splat(simd, 0.0);
        let (x, y) = (widen(simd, x), widen(simd, y));
        let slopes = block
            .slope
            .each_ref()
            .map(|s| f64x8::load_array_ref(simd, s));
        let mut at_zero = [nothing; EDGES];
        let mut slope = [nothing; EDGES];
        for edge in 0..EDGES {
            let at = slopes[edge] * y + f64x8::load_array_ref(simd, &block.at_zero[edge]) - x;
            // What is not small may be anything.
            at_zero[edge] = names.select(narrow_lanes(simd, at), nothing);
            slope[edge] = names.select(narrow_lanes(simd, slopes[edge]), nothing);
        }
        Edges {
            slope,
            at_zero,
            lower: block
                .lower
                .map(|bits| mask32x8::from_bitmask(simd, u64::from(bits))),
        }
    }

    /// A byte for each of four rows: the first covered columns, and the first after those that are not covered.
    #[inline(always)]
    fn of_four_rows(&self, y: f32, within: [f32x8<S>; 2]) -> [u32x8<S>; 2] {
        let [a, e] = self.of_row(y, within);
        let [b, f] = self.of_row(y + 1.0, within);
        let [c, g] = self.of_row(y + 2.0, within);
        let [d, h] = self.of_row(y + 3.0, within);
        [
            a | b << 8_u32 | c << 16_u32 | d << 24_u32,
            e | f << 8_u32 | g << 16_u32 | h << 24_u32,
        ]
    }

    #[inline(always)]
    fn of_row(&self, y: f32, [left, right]: [f32x8<S>; 2]) -> [u32x8<S>; 2] {
        let v0 = self.slope[0] * y + self.at_zero[0];
        let v1 = self.slope[1] * y + self.at_zero[1];
        let v2 = self.slope[2] * y + self.at_zero[2];
        let v3 = self.slope[3] * y + self.at_zero[3];
        let [second, third] = self.lower;
        let first = v0.max(second.select(v1, v0)).max(third.select(v2, v0));
        let end = v3.min(second.select(v3, v1)).min(third.select(v3, v2));
        let simd = first.token();
        [
            to_whole(simd, first.ceil().max(left).min(right)).bitcast(),
            to_whole(simd, end.ceil().max(left).min(right)).bitcast(),
        ]
    }
}

/// Polygon by polygon, the bytes of four rows and of the four below.
#[inline(always)]
fn store_rows<S: Simd>(upper: u32x8<S>, lower: u32x8<S>, into: &mut [u64; BLOCK]) {
    let (low, high) = upper.interleave(lower);
    let words: &mut [u32] = bytemuck::cast_slice_mut(into);
    low.store_slice(&mut words[..BLOCK]);
    high.store_slice(&mut words[BLOCK..]);
}

#[inline(always)]
fn narrow<S: Simd>(simd: S, v: &[f64; BLOCK]) -> f32x8<S> {
    narrow_lanes(simd, f64x8::load_array_ref(simd, v))
}

#[inline(always)]
fn narrow_lanes<S: Simd>(simd: S, v: f64x8<S>) -> f32x8<S> {
    let (low, high) = simd.split_f64x8(v);
    low.narrow(high)
}

#[inline(always)]
fn widen<S: Simd>(simd: S, v: f32x8<S>) -> f64x8<S> {
    let (low, high) = v.widen();
    simd.combine_f64x4(low, high)
}

#[inline(always)]
fn to_whole<S: Simd>(simd: S, v: f32x8<S>) -> i32x8<S> {
    simd.cvt_i32_f32x8(v)
}
