//! Whether a rectangle of samples lies behind what tiles show: the first and quickest question.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};

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

/// What has to be covered for a rectangle to be hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Covered {
    /// The rectangle's own samples.
    Samples,
    /// The parts that hold them, as a whole. A part that is covered as a whole only ever becomes nearer; the depth of
    /// another may move away when it gets more samples. What is hidden in this sense is so at any later time too.
    Parts,
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
pub fn is_behind_all(
    level: Level,
    tiles: Tiles<'_>,
    rectangle: Rectangle,
    covered: Covered,
) -> bool {
    match level.token() {
        None => is_behind_all_plain(tiles, rectangle, covered),
        // Most boxes that are seen are seen at one of a few samples.
        Some(_) if !is_behind_some(tiles, rectangle) => false,
        Some(token) => {
            dispatch!(token, simd => is_behind_all_vector(simd, tiles, rectangle, covered))
        }
    }
}

/// Whether a rectangle is hidden at its middle and at four samples around it: no other can be hidden everywhere.
#[inline]
fn is_behind_some(tiles: Tiles<'_>, Rectangle { x, y, nearest }: Rectangle) -> bool {
    let part_of = |s: [i32; 2], eighths: i32| s[0] + (s[1] - s[0]) * eighths / 8;
    [(4, 4), (1, 7), (7, 1), (1, 1), (7, 7)]
        .into_iter()
        .all(|(across, down)| {
            let (x, y) = (part_of(x, across), part_of(y, down));
            let tile = (y / TILE_SIZE) as usize * tiles.across + (x / TILE_SIZE) as usize;
            let (column, row) = (x % TILE_SIZE, y % TILE_SIZE);
            tiles.coverage[tile] >> (TILE_SIZE * row + column) & 1 == 1
                && nearest < tiles.depths[tile][(row / PART_HEIGHT) as usize]
        })
}

fn is_behind_all_plain(tiles: Tiles<'_>, rectangle: Rectangle, covered: Covered) -> bool {
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
                    let needed = match covered {
                        Covered::Samples => mask & samples,
                        Covered::Parts => samples,
                    };
                    needed & !tiles.coverage[tile] == 0 && nearest < depth
                })
        })
    })
}

#[inline(always)]
fn is_behind_all_vector<S: Simd>(
    simd: S,
    tiles: Tiles<'_>,
    rectangle: Rectangle,
    covered: Covered,
) -> bool {
    let Rectangle { x, y, nearest } = rectangle;
    let lanes = S::u32s::LEN;
    let per_vector = lanes / PARTS_PER_TILE;
    if tiles.across < per_vector {
        return is_behind_all_plain(tiles, rectangle, covered);
    }
    let coverage: &[u32] = bytemuck::cast_slice(tiles.coverage);
    let depths = tiles.depths.as_flattened();
    let (first, last) = ((x[0] / TILE_SIZE) as usize, (x[1] / TILE_SIZE) as usize);
    // The columns of the first vector and of the last one, which ends with the last tile if there is room for that; all of
    // those between belong to the rectangle.
    let first_at = first.min(tiles.across - per_vector);
    let last_at = (last + 1).saturating_sub(per_vector).max(first_at);
    let masks = StripMasks::new(simd);
    let first_columns = masks.of_columns(x, first_at);
    let last_columns = masks.of_columns(x, last_at);
    let depth = S::f32s::splat(simd, nearest);
    // Lane by lane: its part.
    let part = S::u32s::from_fn(simd, |i| 0_u32.wrapping_sub((i % PARTS_PER_TILE) as u32));
    for tile_y in y[0] / TILE_SIZE..=y[1] / TILE_SIZE {
        let above = (y[0] - tile_y * TILE_SIZE).max(0);
        let below = (TILE_SIZE - 1 - (y[1] - tile_y * TILE_SIZE)).max(0);
        let rows = (u64::MAX << (8 * above)) & (u64::MAX >> (8 * below));
        let upper = S::u32s::splat(simd, rows as u32);
        let lower = S::u32s::splat(simd, (rows >> 32) as u32);
        let rows = (upper & !part) | (lower & part);
        let from = tile_y as usize * tiles.across * PARTS_PER_TILE;
        let until = from + tiles.across * PARTS_PER_TILE;
        let row = Parts {
            coverage: &coverage[from..until],
            depths: &depths[from..until],
        };
        let first_needed = needed::<S>(simd, first_columns & rows, covered);
        let last_needed = needed::<S>(simd, last_columns & rows, covered);
        let mut open = row.open::<S>(simd, first_needed, depth, first_at)
            | row.open::<S>(simd, last_needed, depth, last_at);
        if first_at + per_vector < last_at {
            let needed = needed::<S>(simd, rows, covered);
            let mut tile = first_at + per_vector;
            while tile < last_at {
                open |= row.open::<S>(simd, needed, depth, tile);
                tile += per_vector;
            }
        }
        if !open.simd_eq(S::u32s::splat(simd, 0)).all_true() {
            return false;
        }
    }
    true
}

/// The samples that have to be covered, of those asked for in each part.
#[inline(always)]
fn needed<S: Simd>(simd: S, asked: S::u32s, covered: Covered) -> S::u32s {
    let none = S::u32s::splat(simd, 0);
    match covered {
        Covered::Samples => asked,
        Covered::Parts => asked
            .simd_eq(none)
            .select(none, S::u32s::splat(simd, u32::MAX)),
    }
}

/// A row of tiles, part by part.
#[derive(Clone, Copy)]
struct Parts<'a> {
    coverage: &'a [u32],
    depths: &'a [f32],
}

impl Parts<'_> {
    /// The samples of `needed`, of the tiles from `tile`, that are not covered, or not by parts nearer than `depth`.
    #[inline(always)]
    fn open<S: Simd>(&self, simd: S, needed: S::u32s, depth: S::f32s, tile: usize) -> S::u32s {
        let at = tile * PARTS_PER_TILE;
        let range = at..at + S::u32s::LEN;
        let coverage = S::u32s::from_slice(simd, &self.coverage[range.clone()]);
        let nearer = S::f32s::from_slice(simd, &self.depths[range]).simd_gt(depth);
        nearer.select(needed & !coverage, needed)
    }
}
