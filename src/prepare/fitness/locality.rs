//! The second criterion of HOM §7.1: an occluder's box should say where the occluder is.
//!
//! A box that reaches through much of the scene, or is drawn out, puts a depth far from most of what is in it. That is so where a
//! depth stands for a whole object, as in the paper's depth estimation buffer. Here it stands for a part of a tile at the most,
//! so the criterion has little to win; walls and floors, the best occluders of a building, are what it takes away.

use super::{Candidate, around};

/// A box whose diagonal is longer than this share of the scene's is oversized,
const OVERSIZED: f64 = 0.5;
/// and one that is so many times as long as it is wide is drawn out. (Its thickness is left out: a wall is no less local
/// for being thin.)
const DRAWN_OUT: f64 = 16.0;

/// The objects that are not local.
pub fn unfit(candidates: &[Candidate<'_>]) -> Vec<u32> {
    let limit = OVERSIZED * around(candidates).size().length();
    let is_unfit = |candidate: &&Candidate<'_>| {
        let size = candidate.bounds.size();
        let mut sides = size.to_array();
        sides.sort_by(f64::total_cmp);
        let [_, width, length] = sides;
        candidates.len() > 1 && size.length() > limit || length > DRAWN_OUT * width
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
    fn what_reaches_through_the_scene_or_is_drawn_out_is_unfit() {
        // Beside each other: the scene is 100 or so across. A ground, a wall, a wire.
        let sizes = [[90.0, 0.1, 90.0], [5.0, 3.0, 0.2], [8.0, 0.1, 0.1]];
        let all = boxes(&sizes);
        assert_eq!(unfit(&candidates(&all, &[12; 3])), [0, 2]);
        // What is alone is the scene.
        let alone = boxes(&sizes[..1]);
        assert!(unfit(&candidates(&alone, &[12])).is_empty());
        assert!(unfit(&[]).is_empty());
    }
}
