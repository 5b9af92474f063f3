//! Which of a tile's 64 pixel centres a triangle covers.
//!
//! ```text
//! bit = 8·row + column          column 0 1 2 3 4 5 6 7
//!                          row 0   ░ ░ ░ ░ ░ ░ ░ ░      ░ part 0: the lower 32 bits
//!                              …
//!                          row 4   ▓ ▓ ▓ ▓ ▓ ▓ ▓ ▓      ▓ part 1: the upper 32 bits
//! ```

use crate::triangle::Triangle;
use crate::{PARTS_PER_TILE, TILE_SIZE};

/// The samples of each depth part.
pub const PART_MASKS: [u64; PARTS_PER_TILE] = [0xffff_ffff, 0xffff_ffff << 32];

/// The mask of the samples in columns `x` and rows `y` of a tile, ends included and within 0 to 7.
#[inline]
pub fn rectangle_mask(x: [i32; 2], y: [i32; 2]) -> u64 {
    debug_assert!(0 <= x[0] && x[0] <= x[1] && x[1] < TILE_SIZE);
    debug_assert!(0 <= y[0] && y[0] <= y[1] && y[1] < TILE_SIZE);
    let columns = (0xff_u64 >> (7 - (x[1] - x[0]))) << x[0];
    let rows = (u64::MAX >> (8 * (7 - (y[1] - y[0])))) << (8 * y[0]);
    columns.wrapping_mul(0x0101_0101_0101_0101) & rows
}

/// The samples of tile (`tile_x`, `tile_y`) that the triangle covers.
#[inline]
pub fn coverage_of_tile(triangle: &Triangle, tile_x: i32, tile_y: i32) -> u64 {
    let (x0, y0) = (tile_x * TILE_SIZE, tile_y * TILE_SIZE);
    let last = i64::from(TILE_SIZE - 1);
    let mut partial = [(0, 0, 0); 3];
    for (e, out) in triangle.edges.iter().zip(&mut partial) {
        let at_corner = e.a * i64::from(x0) + e.b * i64::from(y0) + e.c;
        if at_corner + last * (e.a.max(0) + e.b.max(0)) < 0 {
            return 0;
        }
        // An edge that the whole tile lies inside of stays at 0, which is inside.
        if at_corner + last * (e.a.min(0) + e.b.min(0)) < 0 {
            *out = (e.a, e.b, at_corner);
        }
    }
    let columns = [
        (triangle.x[0] - x0).max(0),
        (triangle.x[1] - x0).min(TILE_SIZE - 1),
    ];
    let rows = [
        (triangle.y[0] - y0).max(0),
        (triangle.y[1] - y0).min(TILE_SIZE - 1),
    ];
    if columns[0] > columns[1] || rows[0] > rows[1] {
        return 0;
    }
    let inside = rectangle_mask(columns, rows);
    if partial == [(0, 0, 0); 3] {
        return inside;
    }
    let mut mask = 0_u64;
    for row in rows[0]..=rows[1] {
        let [mut e0, mut e1, mut e2] = partial.map(|(_, b, c)| c + b * i64::from(row));
        let mut outside = 0_u64;
        for column in 0..TILE_SIZE {
            outside |= ((e0 | e1 | e2) as u64 >> 63) << column;
            e0 += partial[0].0;
            e1 += partial[1].0;
            e2 += partial[2].0;
        }
        mask |= (outside ^ 0xff) << (8 * row);
    }
    mask & inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_mask_holds_just_the_samples_of_the_rectangle() {
        for x0 in 0..8 {
            for x1 in x0..8 {
                for y0 in 0..8 {
                    for y1 in y0..8 {
                        let mut expected = 0_u64;
                        for y in y0..=y1 {
                            for x in x0..=x1 {
                                expected |= 1 << (8 * y + x);
                            }
                        }
                        assert_eq!(rectangle_mask([x0, x1], [y0, y1]), expected);
                    }
                }
            }
        }
    }
}
