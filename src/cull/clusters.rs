//! Objects asked cluster by cluster, down the hierarchy above their clusters.
//!
//! What is large or reaches everywhere, a run of pipes through a whole building, is hardly ever hidden as one. Most of its clusters
//! are; and if all are, so is the object.

use super::Frame;
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::prepare::{ClusterId, ClusteredMesh};
use crate::scene::Aabb;

/// Memory that is kept from question to question.
#[derive(Debug, Default)]
pub struct ClusterWalk {
    /// Blocks to visit, by their levels and numbers, the next one last.
    pending: Vec<(usize, usize)>,
    boxes: Vec<Aabb>,
    footprints: Vec<Footprint>,
}

impl ClusterWalk {
    /// Whether an object is nothing but several clusters all of which are hidden by their boxes' rectangles.
    pub fn are_all_hidden(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        object: u32,
    ) -> bool {
        let placed = &frame.scene.objects()[object as usize];
        frame.occluders.is_all_of(object)
            && frame.occluders.mesh_of(placed).is_some_and(|mesh| {
                mesh.clusters().len() > 1 && self.visit(frame, buffer, object, mesh, |_| false)
            })
    }

    /// Appends those clusters of a visible object that their boxes' rectangles do not hide, in their order. None if there is more
    /// to the object than its clusters.
    pub fn find_not_hidden(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        object: u32,
        found: &mut Vec<ClusterId>,
    ) -> bool {
        let placed = &frame.scene.objects()[object as usize];
        if !frame.occluders.is_all_of(object) {
            return false;
        }
        let Some(mesh) = frame.occluders.mesh_of(placed) else {
            return false;
        };
        let mut push = |cluster| {
            found.push(ClusterId { object, cluster });
            true
        };
        if mesh.clusters().len() == 1 {
            return push(0);
        }
        self.visit(frame, buffer, object, mesh, push)
    }

    /// Calls `visit` with each of an object's clusters that is not hidden, in their order, until it says that this is enough.
    /// Whether it never did.
    fn visit(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        object: u32,
        mesh: &ClusteredMesh,
        mut visit: impl FnMut(u32) -> bool,
    ) -> bool {
        let ClusterWalk {
            pending,
            boxes,
            footprints,
        } = self;
        let (tree, screen) = (mesh.tree(), buffer.screen());
        let placed = &frame.scene.objects()[object as usize];
        let from_local = screen.screen_from_local(&placed.world_from_local);
        let bounds = &frame.scene.bounds()[object as usize];
        let level = frame.settings.level;
        pending.clear();
        pending.extend(tree.root());
        while let Some((height, block)) = pending.pop() {
            boxes.clear();
            footprints.clear();
            let children = tree.children(height, block, boxes);
            let boxes = boxes.iter().copied();
            screen.footprints_of_local_boxes(level, &from_local, bounds, boxes, footprints);
            let first = pending.len();
            for (child, &footprint) in children.zip(&*footprints) {
                if footprint == Footprint::Nowhere || buffer.hides(footprint) {
                    continue;
                }
                if height > 0 {
                    pending.push((height - 1, child));
                } else if !visit(child as u32) {
                    return false;
                }
            }
            pending[first..].reverse();
        }
        true
    }
}
