//! The third criterion of HOM §7.1: what takes long to draw for what it covers.
//!
//! The paper counts polygons. A large object may well have many, so they are counted here for the area that its box
//! has, and held against the mean of the scene. What is drawn as a proxy counts by the proxy's triangles, as the paper would have
//! it. One cluster is never too much.

use super::{Candidate, half_area};
use crate::prepare::TRIANGLES_PER_CLUSTER;

/// So many times the triangles that the scene has for an area on average are too many.
const TOO_MANY: f64 = 16.0;

/// The objects that have too many triangles.
pub fn unfit(candidates: &[Candidate<'_>]) -> Vec<u32> {
    let area: f64 = candidates.iter().map(|c| half_area(c.bounds)).sum();
    let triangles: usize = candidates.iter().map(|c| c.triangles).sum();
    let limit = TOO_MANY * triangles as f64 / area;
    let is_unfit = |c: &&Candidate<'_>| {
        c.triangles > TRIANGLES_PER_CLUSTER && c.triangles as f64 > limit * half_area(c.bounds)
    };
    candidates
        .iter()
        .filter(is_unfit)
        .map(|c| c.object)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{boxes, candidates};
    use super::*;

    #[test]
    fn many_triangles_are_too_many_where_they_cover_little() {
        let all = boxes(&[
            [5.0, 3.0, 1.0],
            [0.3, 0.3, 0.4],
            [0.3, 0.3, 0.4],
            [9.0, 9.0, 1.0],
        ]);
        assert_eq!(unfit(&candidates(&all, &[12, 900, 64, 900])), [1]);
        assert!(unfit(&[]).is_empty());
    }
}
