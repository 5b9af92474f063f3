//! The clusters that are seen from the nearest viewpoint of a grid, on their way into the buffer (HOM §7.5).

use super::Frame;
use super::recall::place_clusters;
use super::waiting::{Waiting, WaitingCluster};
use crate::occluders::Budget;
use crate::occlusion::{Footprint, Screen};
use crate::prepare::SampledCluster;
use crate::view::{Camera, Containment, Planes, Projection};

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct SampledMemory {
    in_frustum: Vec<Candidate>,
    footprints: Vec<Footprint>,
}

/// A cluster that may be drawn.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// The larger, the more it may hide for what it costs.
    worth: f32,
    cluster: WaitingCluster,
}

/// What is seen from the viewpoint that a camera's eye snaps to. None if there is no grid, or no viewpoint near the eye; nor for a
/// camera that sees along parallel lines, which start from no eye.
pub fn seen_nearby<'a>(frame: &Frame<'a>, camera: &Camera) -> Option<&'a [SampledCluster]> {
    let grid = frame.visibility_grid?;
    if !matches!(camera.projection(), Projection::Perspective { .. }) {
        return None;
    }
    let viewpoint = grid.viewpoint_near(camera.eye())?;
    Some(grid.seen_from(viewpoint))
}

/// Lets the clusters wait that are seen from a viewpoint and are in the frustum: all, or those that hide most for what they cost, as
/// far as the budget goes.
pub fn sampled(
    frame: &Frame<'_>,
    seen: &[SampledCluster],
    screen: &Screen,
    memory: &mut SampledMemory,
    waiting: &mut Waiting,
) {
    let SampledMemory {
        in_frustum,
        footprints,
    } = memory;
    in_frustum.clear();
    let frustum = frame.frustum(screen.camera());
    for of_object in seen.chunk_by(|a, b| a.id.object == b.id.object) {
        let number = of_object[0].id.object;
        let bounds = &frame.scene.bounds()[number as usize];
        if frustum.contains(bounds, Planes::ALL) == Containment::Outside {
            continue;
        }
        let numbers = of_object.iter().map(|seen| seen.id.cluster);
        let Some((placed, mesh)) =
            place_clusters(frame, number, numbers, screen, waiting, footprints)
        else {
            continue;
        };
        for (seen, &footprint) in of_object.iter().zip(&*footprints) {
            if footprint == Footprint::Nowhere {
                continue;
            }
            let cluster = seen.id.cluster;
            let triangles = u32::from(mesh.clusters()[cluster as usize].triangle_count);
            in_frustum.push(Candidate {
                worth: seen.worth(triangles),
                cluster: WaitingCluster {
                    placed,
                    cluster,
                    triangles,
                    known: None,
                    footprint,
                    asked_before: None,
                },
            });
        }
    }
    if let Budget::Triangles(mut left) = frame.settings.budget {
        // Numbers that are not negative sort as their bits do.
        let key = |c: &Candidate| (!c.worth.to_bits(), c.cluster.placed, c.cluster.cluster);
        in_frustum.sort_unstable_by_key(key);
        let within = in_frustum.iter().take_while(|candidate| {
            let triangles = u64::from(candidate.cluster.triangles);
            let fits = triangles <= left;
            left = left.saturating_sub(triangles);
            fits
        });
        let count = within.count();
        in_frustum.truncate(count);
    }
    for candidate in &*in_frustum {
        waiting.push(candidate.cluster);
    }
}
