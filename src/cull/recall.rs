//! The clusters that are remembered, on their way into the buffer.

use super::Frame;
use super::waiting::{Waiting, WaitingCluster};
use crate::occluders::Contributions;
use crate::occlusion::{Footprint, Screen};
use crate::prepare::ClusteredMesh;

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct RecallMemory {
    /// Places of the memory of contribution.
    chosen: Vec<u32>,
    footprints: Vec<Footprint>,
}

/// Lets the clusters wait that are remembered and not left out. Returns whether more than one in four of them is out of the picture:
/// it shows something else than the last.
pub fn recall(
    frame: &Frame<'_>,
    contributions: &mut Contributions,
    screen: &Screen,
    memory: &mut RecallMemory,
    waiting: &mut Waiting,
) -> bool {
    let RecallMemory { chosen, footprints } = memory;
    if frame.region.is_none() {
        contributions.choose(frame.settings.budget, chosen);
    } else {
        contributions.choose_all(chosen);
    }
    let object_of = |&place: &u32| contributions.id(place).object;
    let mut in_picture = 0;
    for places in chosen.chunk_by(|a, b| object_of(a) == object_of(b)) {
        let number = object_of(&places[0]);
        let number_of = |&place: &u32| contributions.id(place).cluster;
        let bounds = &frame.scene.bounds()[number as usize];
        if { frame.region }.is_some_and(|region| region.misses(screen.footprint_of_aabb(bounds))) {
            continue;
        }
        let numbers = places.iter().map(number_of);
        let Some((placed, mesh)) =
            place_clusters(frame, number, numbers, screen, waiting, footprints)
        else {
            continue;
        };
        let mut are_none = true;
        for (place, &footprint) in places.iter().zip(&*footprints) {
            if footprint == Footprint::Nowhere || { frame.region }
                .is_some_and(|region| region.misses(footprint))
            {
                continue;
            }
            are_none = false;
            in_picture += 1;
            let cluster = number_of(place);
            waiting.push(WaitingCluster {
                placed,
                cluster,
                triangles: u32::from(mesh.clusters()[cluster as usize].triangle_count),
                // What a part of a frame gains says nothing of the whole.
                known: frame.region.is_none().then_some(*place),
                footprint,
                asked_before: None,
            });
        }
        if are_none {
            waiting.settle(placed, &mut |_| {});
        }
    }
    in_picture * 4 < chosen.len() * 3
}

/// Places an object, and finds where some of its clusters may be drawn. None if it hides nothing from here.
pub fn place_clusters<'a>(
    frame: &Frame<'a>,
    number: u32,
    clusters: impl Iterator<Item = u32>,
    screen: &Screen,
    waiting: &mut Waiting,
    footprints: &mut Vec<Footprint>,
) -> Option<(u32, &'a ClusteredMesh)> {
    let object = &frame.scene.objects()[number as usize];
    let mesh = frame.occluders.mesh_of(object)?;
    let bounds = &frame.scene.bounds()[number as usize];
    // A proxy hides nothing while its object reaches the near plane.
    if object.occluder_proxy.is_some() && screen.footprint_of_aabb(bounds) == Footprint::Unbounded {
        return None;
    }
    let placed = waiting.place(frame, number, true, screen);
    let boxes = clusters.map(|cluster| mesh.clusters()[cluster as usize].bounds());
    footprints.clear();
    screen.footprints_of_local_boxes(
        frame.settings.level,
        waiting.screen_of(placed),
        bounds,
        boxes,
        footprints,
    );
    Some((placed, mesh))
}
