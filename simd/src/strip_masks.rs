//! The samples between two columns in each of eight rows, as the masks of as many tiles as a vector holds.
//!
//! The ends of eight rows are eight bytes. For each tile they are repeated, less the tile's own column; a table look-up
//! makes of each byte the bits of the columns below it; and an AND of what two ends give is the mask, row by row as a
//! tile's word has it.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, i16x8, u8x16, u16x8, u64x2};

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

    #[inline(always)]
    fn counted_from(&self, v: i16x8<S>, from: usize) -> i16x8<S> {
        let column = i16x8::splat(self.simd, (from * TILE_SIZE as usize) as i16);
        let none = i16x8::splat(self.simd, 0);
        let most = i16x8::splat(self.simd, i16::from(u8::MAX));
        (v - column).max(none).min(most)
    }

    /// The bytes of eight rows, for every tile.
    #[inline(always)]
    pub(crate) fn ends(&self, rows: u64) -> S::u8s {
        let rows: u8x16<S> = u64x2::splat(self.simd, rows).bitcast();
        S::u8s::block_splat(rows)
    }

    /// The samples of the tiles from `start` on, of each row from its column in `first` to before that in `end`; none
    /// left of tile `from`.
    #[inline(always)]
    pub(crate) fn of_rows(
        &self,
        first: i16x8<S>,
        end: i16x8<S>,
        start: usize,
        from: usize,
    ) -> S::u32s {
        let first: u16x8<S> = self.counted_from(first, start).bitcast();
        let end: u16x8<S> = self.counted_from(end, start).bitcast();
        let first = S::u8s::block_splat(first.relaxed_narrow(first));
        let end = S::u8s::block_splat(end.relaxed_narrow(end));
        let first = self.not_before(first, (from - start) as u32);
        self.between(first, end, self.columns_from(0))
    }

    /// First columns, none of them before a tile.
    #[inline(always)]
    pub(crate) fn not_before(&self, first: S::u8s, tile: u32) -> S::u8s {
        first.max(S::u8s::splat(self.simd, column_of(tile)))
    }

    /// The columns of the tiles from `start` on.
    #[inline(always)]
    pub(crate) fn columns_from(&self, start: u32) -> S::u8s {
        self.tile_column + column_of(start)
    }

    /// The samples of the tiles with these columns, of each row from its column in `first` to before that in `end`.
    #[inline(always)]
    pub(crate) fn between(&self, first: S::u8s, end: S::u8s, columns: S::u8s) -> S::u32s {
        (self.of_tiles(end, columns) & !self.of_tiles(first, columns)).bitcast()
    }

    /// The samples of the tiles from `start` on in columns `x`, ends included, of every row.
    #[inline(always)]
    pub(crate) fn of_columns(&self, x: [i32; 2], start: usize) -> S::u32s {
        let from = start as i32 * TILE_SIZE;
        // There are at most eight tiles.
        let before = S::u8s::splat(self.simd, (x[0] - from).max(0) as u8);
        let until = S::u8s::splat(self.simd, (x[1] + 1 - from).min(64) as u8);
        let (before, until) = (
            self.of_tiles(before, self.tile_column),
            self.of_tiles(until, self.tile_column),
        );
        (until & !before).bitcast()
    }

    /// For each row of tiles that begin at `tiles`: the columns before those given.
    #[inline(always)]
    fn of_tiles(&self, columns: S::u8s, tiles: S::u8s) -> S::u8s {
        let of_tile = columns
            .saturating_sub(tiles)
            .min(S::u8s::splat(self.simd, TILE_SIZE as u8));
        self.low_bits.swizzle_dyn_within_blocks(of_tile)
    }
}

/// The first column of a tile, or that many tiles' columns.
#[inline(always)]
pub(crate) fn column_of(tile: u32) -> u8 {
    (tile * TILE_SIZE as u32) as u8
}
