//! Objects asked cluster by cluster, down the hierarchy above their clusters.
//!
//! What is large or reaches everywhere, a run of pipes through a whole building, is hardly ever hidden as one. Most of its clusters
//! are; and if all are, so is the object.

use super::Frame;
use super::waiting::facing;
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::prepare::{ClusterId, ClusteredMesh};
use crate::scene::{Aabb, OwnBox};

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
                mesh.clusters().len() > 1 && self.visit(frame, buffer, object, mesh, |_, _| false)
            })
    }

    /// Appends those clusters of a visible object that their boxes do not hide, in their order. Whether these are all there is of the
    /// object; if not, there are none.
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
        if mesh.clusters().len() == 1 {
            found.push(ClusterId { object, cluster: 0 });
            return true;
        }
        self.visit(frame, buffer, object, mesh, |cluster, footprint| {
            let bounds = mesh.clusters()[cluster as usize].bounds();
            let own = OwnBox::placed(&bounds, &placed.world_from_local);
            if !buffer.hides_own_box(&own.shape, own.growth, footprint) {
                found.push(ClusterId { object, cluster });
            }
            true
        })
    }

    /// Calls `visit` with each of an object's clusters that may show a front and that its rectangle does not hide, in their order,
    /// until it says that this is enough. Whether it never did.
    fn visit(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        object: u32,
        mesh: &ClusteredMesh,
        mut visit: impl FnMut(u32, Footprint) -> bool,
    ) -> bool {
        let ClusterWalk {
            pending,
            boxes,
            footprints,
        } = self;
        let (tree, screen) = (mesh.tree(), buffer.screen());
        let placed = &frame.scene.objects()[object as usize];
        let bounds = &frame.scene.bounds()[object as usize];
        let from_local = screen.screen_from_local(&placed.world_from_local, bounds);
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
            let facing = match height {
                // Which side of what is seen edge-on shows, a final pass that is not ours decides.
                0 if frame.settings.slack.is_none() => facing(
                    &mesh.clusters()[children.clone()],
                    screen.camera(),
                    &placed.world_from_local,
                ),
                _ => u64::MAX,
            };
            for (i, (child, &footprint)) in children.zip(&*footprints).enumerate() {
                let looks_away = facing >> i & 1 == 0;
                if looks_away || footprint == Footprint::Nowhere || buffer.hides(footprint) {
                    continue;
                }
                if height > 0 {
                    pending.push((height - 1, child));
                } else if !visit(child as u32, footprint) {
                    return false;
                }
            }
            pending[first..].reverse();
        }
        true
    }
}
