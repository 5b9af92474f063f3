//! The strips of small polygons, those of a block at once: a lane for each polygon.
//!
//! A strip's eight rows fill a vector of f64, but a polygon of a few pixels has one or two strips, and what it takes to get
//! at each is more than the rows. So the strips of all small polygons of a block are found together, row by row, in f32.
//!
//! That is exact enough: [`crate::spans`] has the bound. Of four rows the crossings of the first are found so, and what one, two
//! and three rows make is added for the others. That is one more rounding of a number up to 57, and the first row's are up to
//! 3·|B|/|A| larger: less than `0.38/|A|` instead of `0.33/|A|`.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, i32x8, mask32x8, u32x8};

use crate::spans::{BLOCK, EDGES, SpanBlock};
use crate::{PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

/// A polygon is small if its corners reach over no more sub-pixels than this, across and down.
pub const SMALL: i32 = 48 * crate::SUBPIXELS;

/// The most strips that a small polygon has.
const MOST_STRIPS: usize = (SMALL / crate::SUBPIXELS / TILE_SIZE) as usize + 1;

/// The strips of the small polygons of a block.
pub(crate) struct SmallStrips {
    /// First and last rows of tiles.
    pub(crate) rows: [[i32; BLOCK]; 2],
    /// First and last columns of tiles.
    pub(crate) tiles: [[i32; BLOCK]; 2],
    /// Strip by strip, a byte for each of eight rows: the first covered columns, counted from the first tile.
    pub(crate) first: [[u64; BLOCK]; MOST_STRIPS],
    /// And the first columns after those that are not covered.
    pub(crate) end: [[u64; BLOCK]; MOST_STRIPS],
    /// Strip by strip, the depths over the halves of the first tile.
    pub(crate) halves: [[[f32; BLOCK]; PARTS_PER_TILE]; MOST_STRIPS],
}

impl SmallStrips {
    pub(crate) const EMPTY: SmallStrips = SmallStrips {
        rows: [[0; BLOCK]; 2],
        tiles: [[0; BLOCK]; 2],
        first: [[0; BLOCK]; MOST_STRIPS],
        end: [[0; BLOCK]; MOST_STRIPS],
        halves: [[[0.0; BLOCK]; PARTS_PER_TILE]; MOST_STRIPS],
    };

    /// Finds the strips of the polygons that `small` names.
    #[inline(always)]
    pub(crate) fn find<S: Simd>(&mut self, simd: S, block: &SpanBlock, small: u8) {
        // Lanes of other polygons hold numbers too, which nobody reads.
        let tile = TILE_SIZE as f32;
        let first_x = f32x8::load_array_ref(simd, &block.x[0]);
        let last_x = f32x8::load_array_ref(simd, &block.x[1]);
        let first_y = f32x8::load_array_ref(simd, &block.y[0]);
        let last_y = f32x8::load_array_ref(simd, &block.y[1]);
        let first_column = (first_x * (1.0 / tile)).floor();
        let last_column = (last_x * (1.0 / tile)).floor();
        let first_row = (first_y * (1.0 / tile)).floor();
        let last_row = (last_y * (1.0 / tile)).floor();
        to_whole(simd, first_column).store_array(&mut self.tiles[0]);
        to_whole(simd, last_column).store_array(&mut self.tiles[1]);
        to_whole(simd, first_row).store_array(&mut self.rows[0]);
        to_whole(simd, last_row).store_array(&mut self.rows[1]);
        let corner = [first_column * tile, first_row * tile];
        let left = first_x - corner[0];
        let right = last_x - corner[0] + 1.0;
        let edges = Edges::new(simd, block);

        let last = last_row - first_row;
        for strip in 0..MOST_STRIPS {
            let has_strip = last.simd_ge(strip as f32).to_bitmask() & u64::from(small);
            if has_strip == 0 {
                return;
            }
            let row = (strip as i32 * TILE_SIZE) as f32;
            let upper = edges.of_four_rows(row, [left, right]);
            let lower = edges.of_four_rows(row + 4.0, [left, right]);
            store_rows(upper[0], lower[0], &mut self.first[strip]);
            store_rows(upper[1], lower[1], &mut self.end[strip]);
            self.find_halves(simd, block, strip, [first_y, last_y], corner[1]);
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
    /// What two rows add, and three.
    two_rows: [f32x8<S>; EDGES],
    three_rows: [f32x8<S>; EDGES],
    at_zero: [f32x8<S>; EDGES],
    /// Whether the second and the third have their inside on the right.
    lower: [mask32x8<S>; 2],
}

impl<S: Simd> Edges<S> {
    #[inline(always)]
    fn new(simd: S, block: &SpanBlock) -> Self {
        let load = |edge: &[f32; BLOCK]| f32x8::load_array_ref(simd, edge);
        let (slope, at_zero) = (&block.small_slope, &block.small_at_zero);
        let lower = |edge: usize| mask32x8::from_bitmask(simd, u64::from(block.lower[edge]));
        let slope = [
            load(&slope[0]),
            load(&slope[1]),
            load(&slope[2]),
            load(&slope[3]),
        ];
        let times = |rows: f32| {
            [
                slope[0] * rows,
                slope[1] * rows,
                slope[2] * rows,
                slope[3] * rows,
            ]
        };
        Edges {
            slope,
            two_rows: times(2.0),
            three_rows: times(3.0),
            at_zero: [
                load(&at_zero[0]),
                load(&at_zero[1]),
                load(&at_zero[2]),
                load(&at_zero[3]),
            ],
            lower: [lower(0), lower(1)],
        }
    }

    /// A byte for each of four rows: the first covered columns, and the first after those that are not covered.
    #[inline(always)]
    fn of_four_rows(&self, y: f32, within: [f32x8<S>; 2]) -> [u32x8<S>; 2] {
        let first = [
            self.slope[0] * y + self.at_zero[0],
            self.slope[1] * y + self.at_zero[1],
            self.slope[2] * y + self.at_zero[2],
            self.slope[3] * y + self.at_zero[3],
        ];
        let below = |rows: &[f32x8<S>; EDGES]| {
            [
                first[0] + rows[0],
                first[1] + rows[1],
                first[2] + rows[2],
                first[3] + rows[3],
            ]
        };
        let [a, e] = self.of_row(first, within);
        let [b, f] = self.of_row(below(&self.slope), within);
        let [c, g] = self.of_row(below(&self.two_rows), within);
        let [d, h] = self.of_row(below(&self.three_rows), within);
        [
            a | b << 8_u32 | c << 16_u32 | d << 24_u32,
            e | f << 8_u32 | g << 16_u32 | h << 24_u32,
        ]
    }

    #[inline(always)]
    fn of_row(
        &self,
        [v0, v1, v2, v3]: [f32x8<S>; EDGES],
        [left, right]: [f32x8<S>; 2],
    ) -> [u32x8<S>; 2] {
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
fn to_whole<S: Simd>(simd: S, v: f32x8<S>) -> i32x8<S> {
    simd.cvt_i32_f32x8(v)
}
