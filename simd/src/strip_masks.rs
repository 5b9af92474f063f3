//! The samples between two columns in each of eight rows, as the masks of as many tiles as a vector holds.
//!
//! The ends of eight rows are eight bytes. For each tile they are repeated, less the tile's own column; a table look-up
//! makes of each byte the bits of the columns below it; and an AND of what two ends give is the mask, row by row as a
//! tile's word has it.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, i16x8, u8x16};

use crate::TILE_SIZE;

/// Makes masks of `S::f64s::LEN` tiles at a time.
#[derive(Clone, Copy)]
pub(crate) struct StripMasks<S: Simd> {
    simd: S,
    /// Byte `i`: the lowest `i` bits set.
    low_bits: S::u8s,
    /// Byte `i`: the column of the tile that byte `i` of a mask belongs to.
    tile_column: S::u8s,
}

impl<S: Simd> StripMasks<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S) -> Self {
        StripMasks {
            simd,
            low_bits: S::u8s::block_splat(u8x16::from_fn(simd, |i| {
                (0xff_u16 >> (8 - i.min(8))) as u8
            })),
            tile_column: S::u8s::from_fn(simd, |i| (i & !7) as u8),
        }
    }

    /// The samples of the tiles from `start` on, of each row from its column in `first` to before that in `end`; none
    /// left of tile `from`.
    #[inline(always)]
    pub(crate) fn between(
        &self,
        first: i16x8<S>,
        end: i16x8<S>,
        start: usize,
        from: usize,
    ) -> S::u32s {
        let before = self.bits_below(first, start, from - start);
        let until = self.bits_below(end, start, 0);
        (until & !before).bitcast()
    }

    /// For each row of the tiles from `start`: the columns before `v`, and all of those of the first `skip` tiles.
    #[inline(always)]
    fn bits_below(&self, v: i16x8<S>, start: usize, skip: usize) -> S::u8s {
        let simd = self.simd;
        let column = i16x8::splat(simd, (start * TILE_SIZE as usize) as i16);
        let least = i16x8::splat(simd, (skip * TILE_SIZE as usize) as i16);
        let v = (v - column).max(least).min(i16x8::splat(simd, 64));
        let bytes: u8x16<S> = v.relaxed_narrow(v).bitcast();
        self.of_tiles(S::u8s::block_splat(bytes))
    }

    /// The samples of the tiles from `start` on in columns `x`, ends included, of every row.
    #[inline(always)]
    pub(crate) fn of_columns(&self, x: [i32; 2], start: usize) -> S::u32s {
        let from = start as i32 * TILE_SIZE;
        // There are at most eight tiles.
        let before = S::u8s::splat(self.simd, (x[0] - from).max(0) as u8);
        let until = S::u8s::splat(self.simd, (x[1] + 1 - from).min(64) as u8);
        (self.of_tiles(until) & !self.of_tiles(before)).bitcast()
    }

    #[inline(always)]
    fn of_tiles(&self, columns: S::u8s) -> S::u8s {
        let of_tile = columns
            .saturating_sub(self.tile_column)
            .min(S::u8s::splat(self.simd, 8));
        self.low_bits.swizzle_dyn_within_blocks(of_tile)
    }
}
