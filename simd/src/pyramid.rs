//! The pyramid of occlusion maps: each cell of a level sums four of the level below.
//!
//! HOM §4.2 averages opacities. Here a cell keeps the *count* of its uncovered picture pixels, in which the average
//! is a sum: no rounding, so that "fully opaque" is exactly 0 at every level, border cells included.

/// How many of the `picture` samples of each tile are uncovered.
///
/// # Panics
/// If the slices differ in length.
pub fn uncovered(coverage: &[u64], picture: &[u64], counts: &mut [u32]) {
    assert!(coverage.len() == picture.len() && coverage.len() == counts.len());
    for ((&c, &p), count) in coverage.iter().zip(picture).zip(counts) {
        *count = (p & !c).count_ones();
    }
}

/// Sums 2×2 cells of a level of `width` columns into the next, of `⌈width / 2⌉` columns. A cell beyond the border
/// counts 0.
///
/// # Panics
/// If `fine` is not whole rows, or `coarse` does not have `⌈width / 2⌉ · ⌈height / 2⌉` cells.
pub fn sum_2x2(fine: &[u32], width: usize, coarse: &mut [u32]) {
    assert!(fine.len().is_multiple_of(width));
    let coarse_width = width.div_ceil(2);
    assert_eq!(
        coarse.len(),
        coarse_width * (fine.len() / width).div_ceil(2)
    );
    for (pair, out) in fine
        .chunks(2 * width)
        .zip(coarse.chunks_exact_mut(coarse_width))
    {
        for (x, cell) in out.iter_mut().enumerate() {
            *cell = pair
                .chunks_exact(width)
                .flat_map(|row| row[2 * x..].iter().take(2))
                .sum();
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
        sum_2x2(&fine, 5, &mut coarse);
        assert_eq!(
            coarse,
            [1 + 2 + 6 + 7, 3 + 4 + 8 + 9, 5 + 10, 11 + 12, 13 + 14, 15]
        );
    }
}
