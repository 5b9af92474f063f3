//! Down a tree of boxes along a ray: which of many boxes may hold what the ray through a sample meets.
//!
//! The tree has no pointers. Its leaves stand in an order in which neighbours lie near each other, sixteen of them make a block, a
//! block's box is one of sixteen in a block of the level above, and so on up to a single block:
//!
//! ```text
//! level 1 (the root)   [ 0 1 2 ]                            one box for each block of level 0
//! level 0              [ 0 … 15 ] [ 16 … 31 ] [ 32 33 ]     one box for each leaf
//! ```

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};

use crate::Level;
use crate::glance::Ray;
use crate::order::{largest, least};

/// Boxes in a block.
pub const WIDTH: usize = 16;

/// Boxes along the axes, structure of arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The least x, y and z of each.
    pub min: [[f32; WIDTH]; 3],
    /// The largest x, y and z of each.
    pub max: [[f32; WIDTH]; 3],
}

impl Block {
    /// Boxes that hold nothing.
    pub const EMPTY: Block = Block {
        min: [[f32::INFINITY; WIDTH]; 3],
        max: [[f32::NEG_INFINITY; WIDTH]; 3],
    };
}

/// A tree of boxes.
#[derive(Clone, Copy, Debug)]
pub struct Tree<'a> {
    /// The blocks of all levels, leaves first.
    pub blocks: &'a [Block],
    /// Where the blocks of each level begin, and how many boxes are in them.
    pub levels: &'a [(u32, u32)],
}

/// Appends the numbers of the leaves to `found`, in ascending order, that a ray may enter nearer than at `depth`; `pending` is
/// memory to work in.
///
/// The answer is as exact as [`Ray`] is.
pub fn descend(
    level: Level,
    tree: Tree<'_>,
    ray: &Ray,
    depth: f64,
    pending: &mut Vec<(u32, u32)>,
    found: &mut Vec<u32>,
) {
    match level.token() {
        None => descend_by(tree, pending, found, |block| {
            (0..WIDTH).fold(0, |mask, i| {
                let corner = |of: &[[f32; WIDTH]; 3]| of.map(|axis| f64::from(axis[i]));
                let (low, high) = (corner(&block.min), corner(&block.max));
                mask | u32::from(ray.may_be_before(low, high, depth)) << i
            })
        }),
        Some(token) => {
            dispatch!(token, simd => descend_vector(simd, tree, ray, depth, pending, found));
        }
    }
}

#[inline(always)]
fn descend_vector<S: Simd>(
    simd: S,
    tree: Tree<'_>,
    ray: &Ray,
    depth: f64,
    pending: &mut Vec<(u32, u32)>,
    found: &mut Vec<u32>,
) {
    descend_by(
        tree,
        pending,
        found,
        #[inline(always)]
        |block| entered(simd, ray, block, depth),
    );
}

/// Walks down, where `ask` says with a bit for each which boxes of a block are entered.
#[inline(always)]
fn descend_by(
    tree: Tree<'_>,
    pending: &mut Vec<(u32, u32)>,
    found: &mut Vec<u32>,
    ask: impl Fn(&Block) -> u32,
) {
    pending.clear();
    if let Some(top) = tree.levels.len().checked_sub(1) {
        pending.push((top as u32, 0));
    }
    while let Some((level, index)) = pending.pop() {
        let (first, count) = tree.levels[level as usize];
        let before = index * WIDTH as u32;
        // The last block of a level need not be full.
        let there = (1 << (count - before).min(WIDTH as u32)) - 1;
        let mut left = ask(&tree.blocks[(first + index) as usize]) & there;
        if level == 0 {
            while left != 0 {
                found.push(before + left.trailing_zeros());
                left &= left - 1;
            }
        } else {
            // The last one first, so that it is the last to be visited.
            while left != 0 {
                let last = 31 - left.leading_zeros();
                pending.push((level - 1, before + last));
                left ^= 1 << last;
            }
        }
    }
}

/// [`Ray::may_be_before`] for the boxes of a block, a bit for each.
#[inline(always)]
fn entered<S: Simd>(simd: S, ray: &Ray, block: &Block, depth: f64) -> u32 {
    let lanes = S::f64s::LEN;
    let mut mask = 0;
    for first in (0..WIDTH).step_by(2 * lanes) {
        let mut entry = [S::f64s::splat(simd, ray.start); 2];
        let mut exit = [S::f64s::splat(simd, f64::INFINITY); 2];
        for axis in 0..3 {
            let wide = |of: &[f32; WIDTH]| {
                let (low, high) = S::f32s::from_slice(simd, &of[first..first + 2 * lanes]).widen();
                [low, high]
            };
            let (low, high) = (wide(&block.min[axis]), wide(&block.max[axis]));
            for half in 0..2 {
                let low = (low[half] - ray.origin[axis]) * ray.time[axis];
                let high = (high[half] - ray.origin[axis]) * ray.time[axis];
                let is_upwards = low.simd_lt(high);
                entry[half] = largest::<S>(is_upwards.select(low, high), entry[half]);
                exit[half] = least::<S>(is_upwards.select(high, low), exit[half]);
            }
        }
        for half in 0..2 {
            let (entry, exit) = (entry[half], exit[half]);
            let d = entry * ray.depth[1] + ray.depth[0];
            let w = entry * ray.w[1] + ray.w[0];
            let starts_inside = entry.simd_eq(S::f64s::splat(simd, ray.start));
            let is_before = entry.simd_le(exit) & (starts_inside | d.simd_ge(w * depth));
            mask |= is_before.to_bitmask() << (first + half * lanes);
        }
    }
    mask as u32
}
