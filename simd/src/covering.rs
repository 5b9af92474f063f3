//! Which of many rectangles hold a sample and reach nearer than something there: one sample against sixteen at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};

use crate::Level;

/// Rectangles in a block.
pub const BLOCK: usize = 16;

/// Some rectangles of samples, each with its nearest depth; structure of arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangleBlock {
    /// First and last columns.
    pub x: [[i32; BLOCK]; 2],
    /// First and last rows.
    pub y: [[i32; BLOCK]; 2],
    /// Nothing in a rectangle is nearer.
    pub nearest: [f32; BLOCK],
}

impl RectangleBlock {
    /// No rectangle.
    pub const EMPTY: RectangleBlock = RectangleBlock {
        x: [[0; BLOCK], [-1; BLOCK]],
        y: [[0; BLOCK], [-1; BLOCK]],
        nearest: [f32::NEG_INFINITY; BLOCK],
    };

    fn covers(&self, i: usize, column: i32, row: i32, depth: f32) -> bool {
        self.x[0][i] <= column
            && column <= self.x[1][i]
            && self.y[0][i] <= row
            && row <= self.y[1][i]
            && self.nearest[i] > depth
    }
}

/// Appends a mask for each block to `covering`: bit `i` says whether rectangle `i` holds a sample and may reach nearer than
/// `depth`.
pub fn covering(
    level: Level,
    blocks: &[RectangleBlock],
    [column, row]: [i32; 2],
    depth: f32,
    covering: &mut Vec<u16>,
) {
    match level.token() {
        None => covering.extend(blocks.iter().map(|block| {
            (0..BLOCK).fold(0, |mask, i| {
                mask | u16::from(block.covers(i, column, row, depth)) << i
            })
        })),
        Some(token) => {
            dispatch!(token, simd => covering_vector(simd, blocks, [column, row], depth, covering));
        }
    }
}

#[inline(always)]
fn covering_vector<S: Simd>(
    simd: S,
    blocks: &[RectangleBlock],
    [column, row]: [i32; 2],
    depth: f32,
    covering: &mut Vec<u16>,
) {
    let lanes = S::i32s::LEN;
    let column = S::i32s::splat(simd, column);
    let row = S::i32s::splat(simd, row);
    let depth = S::f32s::splat(simd, depth);
    covering.reserve(blocks.len());
    for block in blocks {
        let mut mask = 0;
        for first in (0..BLOCK).step_by(lanes) {
            let at = first..first + lanes;
            let holds = S::i32s::from_slice(simd, &block.x[0][at.clone()]).simd_le(column)
                & S::i32s::from_slice(simd, &block.x[1][at.clone()]).simd_ge(column)
                & S::i32s::from_slice(simd, &block.y[0][at.clone()]).simd_le(row)
                & S::i32s::from_slice(simd, &block.y[1][at.clone()]).simd_ge(row)
                & S::f32s::from_slice(simd, &block.nearest[at]).simd_gt(depth);
            mask |= holds.to_bitmask() << first;
        }
        covering.push(mask as u16);
    }
}
