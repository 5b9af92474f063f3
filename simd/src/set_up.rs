//! Sets quadrilaterals up, those of a block at once: their depth planes (`planes`) and edges solved for x (`crossings`).
//!
//! The plain form is [`Quad::new`](crate::quad::Quad::new). What is exact in f32 is found there: differences of coordinates on
//! the grid, extents, and how far samples are from a corner, which are multiples of a sub-pixel below 2²⁴ of them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};

use crate::assemble::Drawing;
use crate::crossings::{find_crossings, find_small_crossings};
use crate::planes::{Outlines, Planes, find_planes};
use crate::project::Vertices;
use crate::small::SMALL;
use crate::spans::{BLOCK, SpanBlock, SpanBlocks};
use crate::{SUBPIXELS, TILE_SIZE};

/// Memory to work in. Where a block is not full, numbers of earlier ones stand.
#[derive(Clone, Debug, Default)]
pub(crate) struct SetUpMemory {
    /// The places of four corners each.
    places: [[[f32; 2]; BLOCK]; 4],
    outlines: Outlines,
}

/// Appends a block of the quadrilaterals of a list that are named; names those that cannot be drawn as one.
#[inline(always)]
pub(crate) fn set_up_block<S: Simd>(
    simd: S,
    quads: &[[u8; 4]],
    named: &[u8],
    drawing: Drawing<'_>,
    vertices: &Vertices,
    memory: &mut SetUpMemory,
    blocks: &mut SpanBlocks,
) -> u64 {
    let SetUpMemory { places, outlines } = memory;
    for (i, &quad) in named.iter().enumerate() {
        let [a, b, c, d] = quads[usize::from(quad)].map(usize::from);
        places[0][i] = vertices.place[a];
        places[1][i] = vertices.place[b];
        places[2][i] = vertices.place[c];
        places[3][i] = vertices.place[d];
        outlines.depth[0][i] = vertices.depth[a];
        outlines.depth[1][i] = vertices.depth[b];
        outlines.depth[2][i] = vertices.depth[c];
        outlines.depth[3][i] = vertices.depth[d];
    }
    let block = blocks.append();
    let [x0, y0] = coordinates(simd, &places[0]);
    let [x1, y1] = coordinates(simd, &places[1]);
    let [x2, y2] = coordinates(simd, &places[2]);
    let [x3, y3] = coordinates(simd, &places[3]);
    let (x, y) = ([x0, x1, x2, x3], [y0, y1, y2, y3]);
    let named_bits = (1_u16 << named.len()) - 1;
    let corner = find_extents(simd, x, y, drawing, outlines, block);
    block.small &= named_bits as u8;
    let mut planes = Planes::default();
    for first in (0..named.len()).step_by(S::f64s::LEN) {
        let found = find_planes(simd, outlines, first, drawing.inset, block);
        planes.whole |= found.whole;
        planes.turned |= found.turned;
    }
    if block.small != 0 {
        let [column, row] = corner;
        let x = [x0 - column, x1 - column, x2 - column, x3 - column];
        let y = [y0 - row, y1 - row, y2 - row, y3 - row];
        let turn = mask32x8::from_bitmask(simd, planes.turned);
        find_small_crossings(simd, x, y, turn, drawing.inset, block);
    }
    let large = named_bits as u8 & !block.small;
    if large != 0 {
        let (mut wide_x, mut wide_y) = ([[0.0; BLOCK]; 4], [[0.0; BLOCK]; 4]);
        for corner in 0..4 {
            store_wide(simd, x[corner], &mut wide_x[corner]);
            store_wide(simd, y[corner], &mut wide_y[corner]);
        }
        for first in (0..BLOCK).step_by(S::f64s::LEN) {
            if u64::from(large) >> first & ((1 << S::f64s::LEN) - 1) != 0 {
                find_crossings(
                    simd,
                    &wide_x,
                    &wide_y,
                    first,
                    planes.turned,
                    drawing.inset,
                    block,
                );
            }
        }
    }
    block.present = planes.whole as u8 & named_bits as u8;
    let mut missing = !planes.whole & u64::from(named_bits);
    let mut apart = 0;
    while missing != 0 {
        apart |= 1 << named[missing.trailing_zeros() as usize];
        missing &= missing - 1;
    }
    apart
}

/// The columns and the rows of the places of a block.
#[inline(always)]
pub(crate) fn coordinates<S: Simd>(simd: S, places: &[[f32; 2]; BLOCK]) -> [f32x8<S>; 2] {
    let flat = places.as_flattened();
    let low = f32x8::from_slice(simd, &flat[..BLOCK]);
    let high = f32x8::from_slice(simd, &flat[BLOCK..]);
    let (x, y) = low.deinterleave(high);
    [x, y]
}

/// How far four corners reach along an axis, and the first and the last of `count` samples that lie between their extremes by
/// at least `inset` sub-pixels.
#[inline(always)]
pub(crate) fn extent<S: Simd>(
    [a, b, c, d]: [f32x8<S>; 4],
    count: i32,
    inset: i32,
) -> (f32x8<S>, [f32x8<S>; 2]) {
    let simd = a.token();
    let least = a.min(b).min(c.min(d));
    let largest = a.max(b).max(c.max(d));
    let per_subpixel = 1.0 / SUBPIXELS as f32;
    let inset = inset as f32;
    let first = ((least + inset) * per_subpixel - 0.5).ceil();
    let last = ((largest - inset) * per_subpixel - 0.5).floor();
    let end = f32x8::splat(simd, (count - 1) as f32);
    let samples = [first.max(f32x8::splat(simd, 0.0)), last.min(end)];
    (largest - least, samples)
}

#[inline(always)]
fn store_wide<S: Simd>(simd: S, v: f32x8<S>, into: &mut [f64; BLOCK]) {
    let (low, high) = v.widen();
    simd.combine_f64x4(low, high).store_array(into);
}

/// Finds which samples quadrilaterals may cover, which of them are small, and what their planes need; says where their first
/// tiles are, in sub-pixels.
#[inline(always)]
fn find_extents<S: Simd>(
    simd: S,
    [x0, x1, x2, x3]: [f32x8<S>; 4],
    [y0, y1, y2, y3]: [f32x8<S>; 4],
    drawing: Drawing<'_>,
    outlines: &mut Outlines,
    block: &mut SpanBlock,
) -> [f32x8<S>; 2] {
    let (across, [first_x, last_x]) = extent([x0, x1, x2, x3], drawing.width, drawing.inset);
    let (down, [first_y, last_y]) = extent([y0, y1, y2, y3], drawing.height, drawing.inset);
    first_x.store_array(&mut block.x[0]);
    last_x.store_array(&mut block.x[1]);
    first_y.store_array(&mut block.y[0]);
    last_y.store_array(&mut block.y[1]);

    let limit = SMALL as f32;
    block.small = (across.simd_le(limit) & down.simd_le(limit)).to_bitmask() as u8;
    store_wide(simd, across, &mut outlines.extent[0]);
    store_wide(simd, down, &mut outlines.extent[1]);
    store_wide(simd, x1 - x0, &mut outlines.b[0]);
    store_wide(simd, y1 - y0, &mut outlines.b[1]);
    store_wide(simd, x2 - x0, &mut outlines.c[0]);
    store_wide(simd, y2 - y0, &mut outlines.c[1]);
    store_wide(simd, x3 - x0, &mut outlines.d[0]);
    store_wide(simd, y3 - y0, &mut outlines.d[1]);

    // The samples of the first column of tiles, or of the extent if that is all there is: see `PartDepth::new`.
    let (per_tile, tile) = (1.0 / TILE_SIZE as f32, TILE_SIZE as f32);
    let first_tile = (first_x * per_tile).floor();
    let is_column = first_tile.simd_eq((last_x * per_tile).floor());
    let column = first_tile * tile;
    let left = is_column.select(first_x, column);
    let right = is_column.select(last_x, column + (tile - 1.0));
    let half = (SUBPIXELS / 2) as f32;
    let per_subpixel = 1.0 / SUBPIXELS as f32;
    let (origin_x, origin_y) = ((x0 - half) * per_subpixel, (y0 - half) * per_subpixel);
    store_wide(simd, left - origin_x, &mut outlines.columns[0]);
    store_wide(simd, right - origin_x, &mut outlines.columns[1]);
    store_wide(simd, first_y - origin_y, &mut outlines.first_row);
    let row = (first_y * per_tile).floor() * tile;
    let subpixels = SUBPIXELS as f32;
    [column * subpixels, row * subpixels]
}
