//! Merges a triangle into a tile: coverage, and one conservative depth for each part.
//!
//! A part's depth is the farthest depth of the nearest occluder surfaces over its covered samples (HOM §6.4), never
//! nearer than that. With `old` the samples already covered, at depths not farther than `O`, and `new` those of the
//! triangle, not farther than `T`, the nearest surface is
//!
//! * not farther than `O` where only the old covers,
//! * not farther than `T` where only the triangle covers,
//! * not farther than the *nearer* of the two where both cover,
//!
//! and the part keeps the farthest of those three that have a sample. Depths are the larger the nearer.

use crate::coverage::PART_MASKS;
use crate::triangle::Triangle;
use crate::{PART_SIZE, PARTS_PER_TILE, TILE_SIZE};

/// The depth of a part without coverage: nearest possible, so that the depth test ignores it (HOM §6.4) and the
/// overlap test decides.
pub const UNCOVERED: f32 = f32::INFINITY;

/// Merges the samples `mask` of a triangle, all in tile (`tile_x`, `tile_y`), into the tile's coverage and depths.
#[inline]
pub fn merge(
    coverage: &mut u64,
    depths: &mut [f32; PARTS_PER_TILE],
    mask: u64,
    triangle: &Triangle,
    tile_x: i32,
    tile_y: i32,
) {
    for (part, (depth, part_mask)) in depths.iter_mut().zip(PART_MASKS).enumerate() {
        let new = mask & part_mask;
        if new == 0 {
            continue;
        }
        let old = *coverage & part_mask;
        let column = part as i32 % (TILE_SIZE / PART_SIZE);
        let row = part as i32 / (TILE_SIZE / PART_SIZE);
        let (x, y) = (
            tile_x * TILE_SIZE + column * PART_SIZE,
            tile_y * TILE_SIZE + row * PART_SIZE,
        );
        // No covered sample lies outside the triangle's own extent.
        let triangle_depth = triangle.depth.farthest_over(
            [x.max(triangle.x[0]), (x + PART_SIZE - 1).min(triangle.x[1])],
            [y.max(triangle.y[0]), (y + PART_SIZE - 1).min(triangle.y[1])],
        );
        *depth = merged_depth(*depth, old, triangle_depth, new);
    }
    *coverage |= mask;
}

/// The rule at the head of this file, for one part.
#[inline]
fn merged_depth(old_depth: f32, old: u64, new_depth: f32, new: u64) -> f32 {
    let mut farthest = UNCOVERED;
    let mut take = |samples: u64, depth: f32| {
        if samples != 0 && depth < farthest {
            farthest = depth;
        }
    };
    take(old & !new, old_depth);
    take(new & !old, new_depth);
    take(
        old & new,
        if new_depth > old_depth {
            new_depth
        } else {
            old_depth
        },
    );
    farthest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_keeps_the_farthest_of_the_nearest_surfaces() {
        let (near, far) = (0.75, 0.25);
        // The first triangle is all there is.
        assert_eq!(merged_depth(UNCOVERED, 0, far, 0b11), far);
        // A nearer one in front of all of it moves the part nearer; in front of half of it, it does not.
        assert_eq!(merged_depth(far, 0b11, near, 0b11), near);
        assert_eq!(merged_depth(far, 0b11, near, 0b01), far);
        // A farther one behind it changes nothing; beside it, it moves the part away.
        assert_eq!(merged_depth(near, 0b11, far, 0b01), near);
        assert_eq!(merged_depth(near, 0b11, far, 0b110), far);
    }
}
