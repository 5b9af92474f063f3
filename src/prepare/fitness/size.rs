//! The first criterion of HOM §7.1: what is very small hides next to nothing.
//!
//! Small means beside the other occluders of the scene, whose units and extent may be any: a box with less than a hundredth of
//! the area that boxes have on average. In a row of equal objects none is small.

use super::{Candidate, half_area};

/// A box with less than this share of the mean area is small.
const SMALL: f64 = 0.01;

/// The objects that are too small.
pub fn unfit(candidates: &[Candidate<'_>]) -> Vec<u32> {
    let areas = candidates.iter().map(|c| half_area(c.bounds));
    let mean = areas.sum::<f64>() / candidates.len().max(1) as f64;
    let small = candidates
        .iter()
        .filter(|c| half_area(c.bounds) < SMALL * mean);
    small.map(|c| c.object).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{boxes, candidates};
    use super::*;

    #[test]
    fn bolts_are_too_small_among_walls() {
        let walls = boxes(&[
            [5.0, 3.0, 0.2],
            [4.0, 3.0, 0.2],
            [0.05, 0.05, 0.1],
            [1.0, 2.0, 0.1],
        ]);
        assert_eq!(unfit(&candidates(&walls, &[12; 4])), [2]);
        let bolts = boxes(&[[0.05, 0.05, 0.1]; 3]);
        assert!(unfit(&candidates(&bolts, &[12; 3])).is_empty());
        assert!(unfit(&[]).is_empty());
    }
}
