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

/// A [`Ray`] in single precision.
#[derive(Clone, Copy, Debug)]
struct Single {
    origin: [f32; 3],
    start: f32,
    time: [f32; 3],
    /// Something on the ray is at least as near as asked if this, with what is in it multiplied by the place on the ray, is not
    /// negative.
    ahead: [f32; 2],
}

impl Single {
    fn new(ray: &Ray, depth: f64) -> Single {
        let ahead = |i: usize| (ray.depth[i] - depth * ray.w[i]) as f32;
        Single {
            origin: ray.origin.map(|v| v as f32),
            start: ray.start as f32,
            time: ray.time.map(|v| v as f32),
            ahead: [ahead(0), ahead(1)],
        }
    }

    /// Whether it may meet something between two corners of a box that is nearer than asked.
    #[inline(always)]
    fn may_be_in(&self, low: [f32; 3], high: [f32; 3]) -> bool {
        let (mut entry, mut exit) = (self.start, f32::INFINITY);
        for axis in 0..3 {
            let low = (low[axis] - self.origin[axis]) * self.time[axis];
            let high = (high[axis] - self.origin[axis]) * self.time[axis];
            let (first, last) = if low < high { (low, high) } else { (high, low) };
            entry = if first > entry { first } else { entry };
            exit = if last < exit { last } else { exit };
        }
        let ahead = self.ahead[0] + self.ahead[1] * entry;
        entry <= exit && (entry == self.start || ahead >= 0.0)
    }
}

/// Appends the numbers of the leaves to `found`, in ascending order, that a ray may enter nearer than at `depth`; `pending` is
/// memory to work in.
///
/// The answer is not exact, but as good as single precision is. Nothing may rest on it but what to draw.
pub fn descend(
    level: Level,
    tree: Tree<'_>,
    ray: &Ray,
    depth: f64,
    pending: &mut Vec<(u32, u32)>,
    found: &mut Vec<u32>,
) {
    let ray = Single::new(ray, depth);
    match level.token() {
        None => descend_by(tree, pending, found, |block| {
            (0..WIDTH).fold(0, |mask, i| {
                let corner = |of: &[[f32; WIDTH]; 3]| of.map(|axis| axis[i]);
                let is_in = ray.may_be_in(corner(&block.min), corner(&block.max));
                mask | u32::from(is_in) << i
            })
        }),
        Some(token) => {
            dispatch!(token, simd => descend_vector(simd, tree, &ray, pending, found));
        }
    }
}

#[inline(always)]
fn descend_vector<S: Simd>(
    simd: S,
    tree: Tree<'_>,
    ray: &Single,
    pending: &mut Vec<(u32, u32)>,
    found: &mut Vec<u32>,
) {
    descend_by(
        tree,
        pending,
        found,
        #[inline(always)]
        |block| entered(simd, ray, block),
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

/// [`Single::may_be_in`] for the boxes of a block, a bit for each.
#[inline(always)]
fn entered<S: Simd>(simd: S, ray: &Single, block: &Block) -> u32 {
    let lanes = S::f32s::LEN;
    let start = S::f32s::splat(simd, ray.start);
    let mut mask = 0;
    for first in (0..WIDTH).step_by(lanes) {
        let (mut entry, mut exit) = (start, S::f32s::splat(simd, f32::INFINITY));
        for axis in 0..3 {
            let at = first..first + lanes;
            let low = S::f32s::from_slice(simd, &block.min[axis][at.clone()]);
            let high = S::f32s::from_slice(simd, &block.max[axis][at]);
            let low = (low - ray.origin[axis]) * ray.time[axis];
            let high = (high - ray.origin[axis]) * ray.time[axis];
            let is_upwards = low.simd_lt(high);
            let (near, far) = (is_upwards.select(low, high), is_upwards.select(high, low));
            entry = near.simd_gt(entry).select(near, entry);
            exit = far.simd_lt(exit).select(far, exit);
        }
        let ahead = entry * ray.ahead[1] + ray.ahead[0];
        let is_ahead = entry.simd_eq(start) | ahead.simd_ge(S::f32s::splat(simd, 0.0));
        mask |= (entry.simd_le(exit) & is_ahead).to_bitmask() << first;
    }
    mask as u32
}
