//! Whether a rectangle of samples lies behind what tiles show: the first and quickest question.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, u32x4, u64x2};

use crate::coverage::{PART_MASKS, rectangle_mask};
use crate::strip_masks::StripMasks;
use crate::{Level, PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

/// What questions read of a picture's tiles.
#[derive(Clone, Copy, Debug)]
pub struct Tiles<'a> {
    /// The covered samples of each tile.
    pub coverage: &'a [u64],
    /// The depths of each tile's parts.
    pub depths: &'a [[f32; PARTS_PER_TILE]],
    /// Tiles in a row.
    pub across: usize,
}

/// A question: is a rectangle of samples, within the picture, hidden?
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// First and last column.
    pub x: [i32; 2],
    /// First and last row.
    pub y: [i32; 2],
    /// Nothing in it is nearer.
    pub nearest: f32,
}

/// Whether all of a rectangle's samples are covered by parts that are strictly nearer.
pub fn is_behind_all(level: Level, tiles: Tiles<'_>, rectangle: Rectangle) -> bool {
    match level.token() {
        None => is_behind_all_plain(tiles, rectangle),
        // Most boxes that are seen are seen at one of a few samples.
        Some(_) if !is_behind_some(tiles, rectangle) => false,
        Some(token) => dispatch!(token, simd => is_behind_all_vector(simd, tiles, rectangle)),
    }
}

/// Whether a rectangle is hidden at its middle and at four samples around it: no other can be hidden everywhere.
#[inline]
fn is_behind_some(tiles: Tiles<'_>, Rectangle { x, y, nearest }: Rectangle) -> bool {
    let tile = TILE_SIZE as u32;
    let at = |s: [i32; 2], eighths: u32| s[0] as u32 + (s[1] - s[0]) as u32 * eighths / 8;
    [(4, 4), (1, 7), (7, 1), (1, 1), (7, 7)]
        .into_iter()
        .all(|(across, down)| {
            let (x, y) = (at(x, across), at(y, down));
            let index = (y / tile) as usize * tiles.across + (x / tile) as usize;
            let (column, row) = (x % tile, y % tile);
            tiles.coverage[index] >> (tile * row + column) & 1 == 1
                && nearest < tiles.depths[index][(row / PART_HEIGHT as u32) as usize]
        })
}

fn is_behind_all_plain(tiles: Tiles<'_>, rectangle: Rectangle) -> bool {
    let Rectangle { x, y, nearest } = rectangle;
    let within = |range: [i32; 2], tile: i32| {
        let first = tile * TILE_SIZE;
        [
            (range[0] - first).max(0),
            (range[1] - first).min(TILE_SIZE - 1),
        ]
    };
    (y[0] / TILE_SIZE..=y[1] / TILE_SIZE).all(|tile_y| {
        (x[0] / TILE_SIZE..=x[1] / TILE_SIZE).all(|tile_x| {
            let mask = rectangle_mask(within(x, tile_x), within(y, tile_y));
            let tile = tile_y as usize * tiles.across + tile_x as usize;
            tiles.depths[tile]
                .iter()
                .zip(PART_MASKS)
                .filter(|&(_, samples)| mask & samples != 0)
                .all(|(&depth, samples)| {
                    mask & samples & !tiles.coverage[tile] == 0 && nearest < depth
                })
        })
    })
}

#[inline(always)]
fn is_behind_all_vector<S: Simd>(simd: S, tiles: Tiles<'_>, rectangle: Rectangle) -> bool {
    let Rectangle { x, y, nearest } = rectangle;
    let lanes = S::u32s::LEN;
    let per_vector = lanes / PARTS_PER_TILE;
    if tiles.across < per_vector {
        return is_behind_all_plain(tiles, rectangle);
    }
    let (first, last) = ((x[0] / TILE_SIZE) as usize, (x[1] / TILE_SIZE) as usize);
    // The columns of the first vector and of the last one, which ends with the last tile if there is room for that; all of
    // those between belong to the rectangle.
    let first_at = first.min(tiles.across - per_vector);
    let last_at = (last + 1).saturating_sub(per_vector).max(first_at);
    let between = (last_at - first_at).div_ceil(per_vector).saturating_sub(1) * lanes;
    let masks = StripMasks::new(simd);
    let first_columns = masks.of_columns(x, first_at);
    let last_columns = masks.of_columns(x, last_at);
    let depth = S::f32s::splat(simd, nearest);
    let [top, bottom] = y.map(|y| (y / TILE_SIZE) as usize);
    let tiles_of_rows = top * tiles.across..(bottom + 1) * tiles.across;
    let coverage: &[u32] = bytemuck::cast_slice(&tiles.coverage[tiles_of_rows.clone()]);
    let depths = tiles.depths[tiles_of_rows].as_flattened();
    let parts_across = tiles.across * PARTS_PER_TILE;
    let rows = coverage
        .chunks_exact(parts_across)
        .zip(depths.chunks_exact(parts_across));
    let [first_at, last_at] = [first_at, last_at].map(|tile| tile * PARTS_PER_TILE);
    for (i, (coverage, depths)) in rows.enumerate() {
        let row = Parts { coverage, depths };
        let mut needed = S::u32s::splat(simd, u32::MAX);
        if i == 0 {
            needed &= rows_of::<S>(simd, u64::MAX << (8 * (y[0] % TILE_SIZE)));
        }
        if i == bottom - top {
            let below = TILE_SIZE - 1 - y[1] % TILE_SIZE;
            needed &= rows_of::<S>(simd, u64::MAX >> (8 * below));
        }
        let mut open = row.open::<S>(simd, first_columns & needed, depth, first_at)
            | row.open::<S>(simd, last_columns & needed, depth, last_at);
        if between > 0 {
            open |= row.open_between::<S>(simd, needed, depth, first_at + lanes, between);
        }
        if !open.simd_eq(S::u32s::splat(simd, 0)).all_true() {
            return false;
        }
    }
    true
}

/// The samples of some rows, all in one row of tiles, in each part.
#[inline(always)]
fn rows_of<S: Simd>(simd: S, rows: u64) -> S::u32s {
    let rows: u32x4<S> = u64x2::splat(simd, rows).bitcast();
    S::u32s::block_splat(rows)
}

/// A row of tiles, part by part.
#[derive(Clone, Copy)]
struct Parts<'a> {
    coverage: &'a [u32],
    depths: &'a [f32],
}

impl Parts<'_> {
    /// The samples of `needed`, of a vector of parts from `at`, that are not covered, or not by parts nearer than `depth`.
    #[inline(always)]
    fn open<S: Simd>(&self, simd: S, needed: S::u32s, depth: S::f32s, at: usize) -> S::u32s {
        let range = at..at + S::u32s::LEN;
        let coverage = S::u32s::from_slice(simd, &self.coverage[range.clone()]);
        let nearer = S::f32s::from_slice(simd, &self.depths[range]).simd_gt(depth);
        nearer.select(needed & !coverage, needed)
    }

    /// The same of `count` parts, whole vectors of them, together: samples that any of them leaves open.
    #[inline(always)]
    fn open_between<S: Simd>(
        &self,
        simd: S,
        needed: S::u32s,
        depth: S::f32s,
        at: usize,
        count: usize,
    ) -> S::u32s {
        let range = at..at + count;
        let coverage = self.coverage[range.clone()].chunks_exact(S::u32s::LEN);
        let depths = self.depths[range].chunks_exact(S::u32s::LEN);
        let mut covered = S::u32s::splat(simd, u32::MAX);
        let mut farthest = S::f32s::splat(simd, f32::INFINITY);
        for (coverage, depths) in coverage.zip(depths) {
            covered &= S::u32s::from_slice(simd, coverage);
            farthest = farthest.min(S::f32s::from_slice(simd, depths));
        }
        let nearer = farthest.simd_gt(depth);
        nearer.select(needed & !covered, needed)
    }
}
