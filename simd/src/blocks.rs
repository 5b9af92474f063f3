//! What blocks of tiles hide as a whole: large rectangles are asked by these first.
//!
//! A block is [`BLOCK`] × [`BLOCK`] tiles. Its depth is the farthest of its parts if all of its samples are covered; otherwise
//! nothing is hidden by all of it. The answer of a rectangle's blocks, if it is yes, is the answer of its tiles.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};

use crate::query::{Rectangle, Tiles};
use crate::{Level, PARTS_PER_TILE, TILE_SIZE};

/// Tiles along the edge of a block.
pub const BLOCK: usize = 8;

/// Finds the depths of blocks of tiles, row by row; minus infinity where a block is not covered as a whole. Blocks at the right
/// and the lower edge may have fewer tiles.
pub fn find_blocks(level: Level, tiles: Tiles<'_>, depths: &mut Vec<f32>) {
    let parts = tiles.across * PARTS_PER_TILE;
    let coverage: &[u32] = bytemuck::cast_slice(tiles.coverage);
    let rows = tiles.depths.as_flattened();
    depths.clear();
    let strips = coverage
        .chunks(BLOCK * parts)
        .zip(rows.chunks(BLOCK * parts));
    for (coverage, rows) in strips {
        match level.token() {
            None => find_row_plain(coverage, rows, parts, depths),
            Some(token) => {
                dispatch!(token, simd => find_row_vector(simd, coverage, rows, parts, depths));
            }
        }
    }
}

/// The parts of a block in a row of tiles.
const PARTS: usize = BLOCK * PARTS_PER_TILE;

fn find_row_plain(coverage: &[u32], rows: &[f32], parts: usize, depths: &mut Vec<f32>) {
    depths.extend((0..parts).step_by(PARTS).map(|first| {
        let columns = first..parts.min(first + PARTS);
        find_block_plain(coverage, rows, parts, columns)
    }));
}

/// The depth of the block in these columns of parts.
fn find_block_plain(coverage: &[u32], rows: &[f32], parts: usize, columns: Range<usize>) -> f32 {
    let mut depth = f32::INFINITY;
    for (coverage, rows) in coverage.chunks(parts).zip(rows.chunks(parts)) {
        for part in columns.clone() {
            let of_part = if coverage[part] == u32::MAX {
                rows[part]
            } else {
                f32::NEG_INFINITY
            };
            if of_part < depth {
                depth = of_part;
            }
        }
    }
    depth
}

#[inline(always)]
fn find_row_vector<S: Simd>(
    simd: S,
    coverage: &[u32],
    rows: &[f32],
    parts: usize,
    depths: &mut Vec<f32>,
) {
    let lanes = S::u32s::LEN;
    let whole = parts / PARTS * PARTS;
    let all = S::u32s::splat(simd, u32::MAX);
    let open = S::f32s::splat(simd, f32::NEG_INFINITY);
    for first in (0..whole).step_by(PARTS) {
        let mut farthest = S::f32s::splat(simd, f32::INFINITY);
        for (coverage, rows) in coverage.chunks_exact(parts).zip(rows.chunks_exact(parts)) {
            let (coverage, rows) = (&coverage[first..first + PARTS], &rows[first..first + PARTS]);
            for at in (0..PARTS).step_by(lanes) {
                let is_covered = S::u32s::from_slice(simd, &coverage[at..at + lanes]).simd_eq(all);
                let depth = S::f32s::from_slice(simd, &rows[at..at + lanes]);
                farthest = farthest.min(is_covered.select(depth, open));
            }
        }
        let mut of_lanes = [f32::INFINITY; PARTS];
        farthest.store_slice(&mut of_lanes[..lanes]);
        let mut depth = f32::INFINITY;
        for of_lane in of_lanes {
            if of_lane < depth {
                depth = of_lane;
            }
        }
        depths.push(depth);
    }
    if whole < parts {
        depths.push(find_block_plain(coverage, rows, parts, whole..parts));
    }
}

/// Whether a rectangle is hidden by the blocks that it touches. `across` is how many tiles are in a row.
#[inline]
pub fn is_behind_blocks(depths: &[f32], across: usize, rectangle: Rectangle) -> bool {
    let size = TILE_SIZE as usize * BLOCK;
    let across = across.div_ceil(BLOCK);
    let [left, right] = rectangle.x.map(|x| x as usize / size);
    let [top, bottom] = rectangle.y.map(|y| y as usize / size);
    (top..=bottom).all(|row| {
        let blocks = &depths[row * across + left..=row * across + right];
        blocks.iter().all(|&depth| rectangle.nearest < depth)
    })
}
