//! The clusters that are remembered, on their way into the buffer.

use super::Frame;
use super::waiting::{Waiting, WaitingCluster};
use crate::occluders::Contributions;
use crate::occlusion::{Footprint, Screen};
use crate::prepare::Cluster;

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct RecallMemory {
    /// Places of the memory of contribution.
    chosen: Vec<u32>,
    footprints: Vec<Footprint>,
}

/// Lets the clusters wait that are remembered and not left out.
pub fn recall(
    frame: &Frame<'_>,
    contributions: &mut Contributions,
    screen: &Screen,
    memory: &mut RecallMemory,
    waiting: &mut Waiting,
) {
    let RecallMemory { chosen, footprints } = memory;
    contributions.choose(frame.settings.budget, chosen);
    let object_of = |&place: &u32| contributions.id(place).object;
    for places in chosen.chunk_by(|a, b| object_of(a) == object_of(b)) {
        let number = object_of(&places[0]);
        let object = &frame.scene.objects()[number as usize];
        let Some(mesh) = frame.occluders.mesh_of(object) else {
            continue;
        };
        let bounds = &frame.scene.bounds()[number as usize];
        // A proxy hides nothing while its object reaches the near plane.
        if object.occluder_proxy.is_some()
            && screen.footprint_of_aabb(bounds) == Footprint::Unbounded
        {
            continue;
        }
        let number_of = |&place: &u32| contributions.id(place).cluster;
        let clusters = places
            .iter()
            .map(|place| &mesh.clusters()[number_of(place) as usize]);
        let placed = waiting.place(frame, number, true, screen);
        footprints.clear();
        screen.footprints_of_local_boxes(
            frame.settings.level,
            waiting.screen_of(placed),
            bounds,
            clusters.clone().map(Cluster::bounds),
            footprints,
        );
        let mut are_none = true;
        for ((place, cluster), &footprint) in places.iter().zip(clusters).zip(&*footprints) {
            if footprint == Footprint::Nowhere {
                continue;
            }
            are_none = false;
            waiting.push(WaitingCluster {
                placed,
                cluster: number_of(place),
                triangles: u32::from(cluster.triangle_count),
                known: Some(*place),
                footprint,
                asked_before: None,
            });
        }
        if are_none {
            waiting.settle(placed, &mut |_| {});
        }
    }
}
