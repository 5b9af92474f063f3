//! The pyramid of occlusion maps: each cell of a level sums four of the level below.
//!
//! HOM §4.2 averages opacities. Here a cell keeps the *count* of its uncovered picture pixels, in which the average
//! is a sum: no rounding, so that "fully opaque" is exactly 0 at every level, border cells included.

use fearless_simd::dispatch;

use crate::Level;

/// How many of the `picture` samples of each tile are uncovered.
///
/// # Panics
/// If the slices differ in length.
pub fn uncovered(level: Level, coverage: &[u64], picture: &[u64], counts: &mut [u32]) {
    assert!(coverage.len() == picture.len() && coverage.len() == counts.len());
    match level.token() {
        None => count(coverage, picture, counts),
        // The compiler makes vectors of it, and knows the instruction that counts bits.
        Some(token) => dispatch!(token, _ => count(coverage, picture, counts)),
    }
}

#[inline(always)]
fn count(coverage: &[u64], picture: &[u64], counts: &mut [u32]) {
    for ((&c, &p), count) in coverage.iter().zip(picture).zip(counts) {
        *count = (p & !c).count_ones();
    }
}

/// Sums 2×2 cells of a level of `width` columns into the next, of `⌈width / 2⌉` columns. A cell beyond the border
/// counts 0.
///
/// # Panics
/// If `fine` is not whole rows, or `coarse` does not have `⌈width / 2⌉ · ⌈height / 2⌉` cells.
pub fn sum_2x2(level: Level, fine: &[u32], width: usize, coarse: &mut [u32]) {
    assert!(fine.len().is_multiple_of(width));
    assert_eq!(
        coarse.len(),
        width.div_ceil(2) * (fine.len() / width).div_ceil(2)
    );
    match level.token() {
        None => sum(fine, width, coarse),
        Some(token) => dispatch!(token, _ => sum(fine, width, coarse)),
    }
}

#[inline(always)]
fn sum(fine: &[u32], width: usize, coarse: &mut [u32]) {
    for (pair, out) in fine
        .chunks(2 * width)
        .zip(coarse.chunks_exact_mut(width.div_ceil(2)))
    {
        let (upper, lower) = pair.split_at(width);
        let (upper, upper_last) = upper.as_chunks::<2>();
        for (cell, [a, b]) in out.iter_mut().zip(upper) {
            *cell = a + b;
        }
        if let (Some(cell), [last]) = (out.last_mut(), upper_last) {
            *cell = *last;
        }
        // The last row may have no partner.
        let (lower, lower_last) = lower.as_chunks::<2>();
        for (cell, [a, b]) in out.iter_mut().zip(lower) {
            *cell += a + b;
        }
        if let (Some(cell), [last]) = (out.last_mut(), lower_last) {
            *cell += *last;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_sizes_lose_no_cell() {
        let fine: Vec<u32> = (1..=15).collect();
        let mut coarse = [0; 6];
        sum_2x2(Level::Scalar, &fine, 5, &mut coarse);
        assert_eq!(
            coarse,
            [1 + 2 + 6 + 7, 3 + 4 + 8 + 9, 5 + 10, 11 + 12, 13 + 14, 15]
        );
    }
}
