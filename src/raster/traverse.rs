//! The tiles that a triangle touches.

use std::ops::Range;

use antumbra_simd::TILE_SIZE;
use antumbra_simd::coverage::coverage_of_tile;
use antumbra_simd::triangle::Triangle;

/// Calls `visit` with the column, the row and the covered samples of each tile in `tile_rows` of which the triangle
/// covers any, row by row. The triangle's extent must lie within the picture.
#[inline]
pub fn for_each_tile(
    triangle: &Triangle,
    tile_rows: Range<i32>,
    mut visit: impl FnMut(i32, i32, u64),
) {
    let first = (triangle.y[0] / TILE_SIZE).max(tile_rows.start);
    let last = (triangle.y[1] / TILE_SIZE).min(tile_rows.end - 1);
    for tile_y in first..=last {
        for tile_x in triangle.x[0] / TILE_SIZE..=triangle.x[1] / TILE_SIZE {
            let mask = coverage_of_tile(triangle, tile_x, tile_y);
            if mask != 0 {
                visit(tile_x, tile_y, mask);
            } else if row_is_done(triangle, tile_x, tile_y) {
                break;
            }
        }
    }
}

/// Calls `visit` with the column, the row and the depth of each sample in `rows` that the triangle covers. `rows`
/// starts and ends with a row of tiles, or at the picture's edge.
#[inline]
pub fn for_each_sample(
    triangle: &Triangle,
    rows: Range<i32>,
    mut visit: impl FnMut(i32, i32, f32),
) {
    for_each_tile(
        triangle,
        rows.start / TILE_SIZE..(rows.end + TILE_SIZE - 1) / TILE_SIZE,
        |tile_x, tile_y, mask| {
            let mut left = mask;
            while left != 0 {
                let bit = left.trailing_zeros() as i32;
                left &= left - 1;
                let (x, y) = (
                    tile_x * TILE_SIZE + bit % TILE_SIZE,
                    tile_y * TILE_SIZE + bit / TILE_SIZE,
                );
                visit(x, y, triangle.depth.at(x, y));
            }
        },
    );
}

/// Whether nothing of the triangle lies to the right of a tile, in its row: an edge whose inside is on the left has
/// the whole tile outside.
fn row_is_done(triangle: &Triangle, tile_x: i32, tile_y: i32) -> bool {
    let (x0, y0) = (i64::from(tile_x * TILE_SIZE), i64::from(tile_y * TILE_SIZE));
    let last = i64::from(TILE_SIZE - 1);
    triangle
        .edges
        .iter()
        .any(|e| e.a <= 0 && e.a * x0 + e.b * y0 + e.c + last * e.b.max(0) < 0)
}
