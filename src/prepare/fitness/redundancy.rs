//! The fourth criterion of HOM §7.1: what is attached to something larger hides little that this does not hide as well.
//!
//! The paper has no algorithm for it, only the example of a clock on a wall. Here an object is redundant if there is a larger one
//! whose surface covers it from behind or from before: looked at along an axis of the larger one's tight box, the object's box
//! lies within the face and over covered samples of it alone ([`Silhouette`]), not over a window. The larger one has to be thin
//! along that axis, as a wall is: what stands in a room is within its box, too, and hidden by none of its sides from within. And the
//! object has to be attached: it lies within half of what it measures across from one of the two large faces. So a clock or a
//! picture on a wall is redundant, and a chair before it is not.
//!
//! Only what is clearly larger counts, so that no two objects make each other redundant. That what covers an object may be
//! redundant itself does no harm: something larger then covers both.

use glam::DVec3;
use rayon::prelude::*;

use super::compactness::BoxedMesh;
use super::silhouette::Silhouette;
use super::{Candidate, half_area};
use crate::scene::{Aabb, Object, Scene};

/// What covers an object has a box of at least so many times its area.
const LARGER: f64 = 4.0;

/// It is thin if its thickness is no more than this share of what its face measures across.
const THIN: f64 = 0.25;

/// An object is attached if it is no farther from a face anywhere than this share of what it measures across.
const STICKS_OUT: f64 = 0.5;

/// For each candidate, the largest object that makes it redundant, if there is one; `boxed` gives what an object is drawn as when
/// it is an occluder.
pub fn covered_by<'a>(
    scene: &Scene,
    candidates: &[Candidate<'_>],
    boxed: impl Fn(&Object) -> Option<&'a BoxedMesh> + Sync,
) -> Vec<Option<u32>> {
    let area = |object: u32| half_area(&scene.bounds()[object as usize]);
    let cover_of = |candidate: &Candidate<'_>| {
        let least = LARGER * half_area(candidate.bounds);
        let mut near = near(scene, candidate.bounds);
        near.retain(|&other| other != candidate.object && area(other) >= least);
        near.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));
        near.into_iter().find(|&other| {
            let object = &scene.objects()[other as usize];
            boxed(object).is_some_and(|boxed| covers(object, boxed, candidate.bounds))
        })
    };
    candidates.par_iter().map(cover_of).collect()
}

/// The objects whose boxes come as near to a box as something attached may be.
fn near(scene: &Scene, bounds: &Aabb) -> Vec<u32> {
    let reach = bounds.grown(STICKS_OUT * bounds.size().max_element());
    let meets = |other: &Aabb| other.min.cmple(reach.max).all() && other.max.cmpge(reach.min).all();
    let bvh = scene.bvh();
    let (mut found, mut nodes) = (Vec::new(), vec![0]);
    while let Some(node) = nodes.pop() {
        let node = &bvh.nodes[node as usize];
        if !meets(&node.bounds()) {
            continue;
        }
        if node.is_leaf() {
            let of_leaf = &bvh.objects[node.first as usize..][..node.count as usize];
            let near = of_leaf.iter().copied();
            found.extend(near.filter(|&object| meets(&scene.bounds()[object as usize])));
        } else {
            nodes.extend([node.first, node.first + 1]);
        }
    }
    found
}

/// Whether an object's surface covers what is in a box and attached to it.
fn covers(object: &Object, boxed: &BoxedMesh, other: &Aabb) -> bool {
    let matrix = object.world_from_local.matrix3;
    let determinant = matrix.determinant();
    if determinant == 0.0 || !determinant.is_finite() {
        return false;
    }
    let local_from_world = object.world_from_local.inverse();
    let corners = other
        .corners()
        .map(|c| local_from_world.transform_point3(c));
    let bounds = &boxed.bounds;
    // The other box along the axes of this one.
    let spans = bounds.axes.map(|axis: DVec3| {
        corners
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], &corner| {
                let at = axis.dot(corner);
                [
                    if at < min { at } else { min },
                    if at > max { at } else { max },
                ]
            })
    });
    // Axes may be scaled unevenly in the world.
    let scales = bounds.axes.map(|axis| (matrix * axis).length());
    (0..3).any(|k| {
        let silhouette: &Silhouette = match &boxed.silhouettes[k] {
            Some(silhouette) => silhouette,
            None => return false,
        };
        let (size, face) = (bounds.size(), [(k + 1) % 3, (k + 2) % 3]);
        let shares = face.map(|axis| spans[axis].map(|at| (at - bounds.min[axis]) / size[axis]));
        let is_within = shares.iter().all(|&[from, to]| from >= 0.0 && to <= 1.0);
        let is_thin = face
            .iter()
            .all(|&axis| size[k] * scales[k] <= THIN * size[axis] * scales[axis]);
        let across = face.map(|axis| (spans[axis][1] - spans[axis][0]) * scales[axis]);
        let reach = STICKS_OUT
            * if across[1] < across[0] {
                across[1]
            } else {
                across[0]
            };
        let is_attached = [bounds.min[k], bounds.max[k]].iter().any(|plane| {
            let off = spans[k].map(|at| ((at - plane) * scales[k]).abs());
            off[0] <= reach && off[1] <= reach
        });
        is_within && is_thin && is_attached && silhouette.is_covered(shares[0], shares[1])
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{candidates, room};
    use super::*;

    /// Of a wall with a window in it and something else, whether that is redundant.
    fn is_redundant(min: [f64; 3], max: [f64; 3]) -> bool {
        let scene = room(&[(min, max)]);
        let boxed = BoxedMesh::around(&super::super::tests::corners_of(&scene.meshes()[0]));
        let boxed = boxed.expect("a box");
        let all = candidates(scene.bounds(), &[8, 12]);
        let is_wall = |object: &Object| (object.mesh == 0).then_some(&boxed);
        covered_by(&scene, &all, is_wall) == [None, Some(0)]
    }

    #[test]
    fn a_clock_on_the_wall_is_redundant_and_what_stands_before_it_is_not() {
        // The wall is 8 × 4 at z = 0 to 0, the window from (2, 1) to (6, 3).
        assert!(is_redundant([0.5, 2.0, 0.0], [1.0, 2.5, 0.1]), "a clock");
        assert!(
            is_redundant([0.5, 2.0, -0.1], [1.0, 2.5, 0.0]),
            "on the other side"
        );
        assert!(
            is_redundant([3.0, 3.3, 0.01], [5.0, 3.6, 0.05]),
            "above the window"
        );
        assert!(is_redundant([0.7, 2.0, 0.0], [0.72, 2.01, 0.004]), "a nail");
        assert!(
            !is_redundant([3.0, 1.5, 0.0], [4.0, 2.5, 0.1]),
            "in the window"
        );
        assert!(
            !is_redundant([1.5, 2.0, 0.0], [2.5, 2.5, 0.1]),
            "half in the window"
        );
        assert!(
            !is_redundant([0.5, 0.0, 0.5], [1.0, 1.0, 1.0]),
            "a chair before the wall"
        );
        assert!(
            !is_redundant([0.5, 2.0, 0.0], [1.0, 2.5, 0.9]),
            "what sticks out"
        );
        assert!(
            !is_redundant([-0.2, 2.0, 0.0], [0.3, 2.5, 0.1]),
            "over the edge"
        );
        assert!(
            !is_redundant([0.5, 0.1, 0.0], [7.5, 3.9, 0.1]),
            "as large as the wall"
        );
    }
}
