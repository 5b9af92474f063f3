//! What a frame did.

use antumbra::cull::{Skip, VisibleSet};
use bytemuck::{Pod, Zeroable};

/// What a frame did not do, and why.
#[repr(C)]
#[derive(Clone, Copy)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraSkips {
    /// The whole frame: neither the camera nor anything in the scene has changed since the last one, whose answer holds.
    ANTUMBRA_SKIPPED_EVERYTHING = 1,
    /// All of the picture but what objects touch that have moved: nothing else has.
    ANTUMBRA_SKIPPED_ELSEWHERE = 2,
    /// Occlusion: what is in the frustum covers too little of the picture to hide much.
    ANTUMBRA_SKIPPED_LITTLE_COVERS = 4,
    /// Occlusion: in the last frames that tried, what was hidden would have cost less to draw than it cost to find.
    ANTUMBRA_SKIPPED_LITTLE_HIDDEN = 8,
    /// Asking about objects one by one that cost less to draw.
    ANTUMBRA_SKIPPED_DEARER_THAN_DRAWING = 16,
    /// The pyramid of occlusion maps: nothing needs it where no hole may be ignored.
    ANTUMBRA_SKIPPED_PYRAMID = 32,
}

use AntumbraSkips::*;

const SKIPS: [(AntumbraSkips, Skip); 6] = [
    (ANTUMBRA_SKIPPED_EVERYTHING, Skip::Everything),
    (ANTUMBRA_SKIPPED_ELSEWHERE, Skip::Elsewhere),
    (ANTUMBRA_SKIPPED_LITTLE_COVERS, Skip::OcclusionLittleCovers),
    (ANTUMBRA_SKIPPED_LITTLE_HIDDEN, Skip::OcclusionLittleHidden),
    (
        ANTUMBRA_SKIPPED_DEARER_THAN_DRAWING,
        Skip::QuestionsDearerThanDrawing,
    ),
    (ANTUMBRA_SKIPPED_PYRAMID, Skip::Pyramid),
];

/// Counts and times of one frame. Later versions may have more fields at the end.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct AntumbraStatistics {
    /// Objects that are not culled.
    pub objects_visible: u64,
    /// Occluder candidates that were asked before being drawn.
    pub occluders_asked: u64,
    /// Triangles of the clusters that were drawn as occluders, before clipping and culling by facing.
    pub occluder_triangles: u64,
    /// Clusters that were drawn because the last frame needed them.
    pub clusters_remembered: u64,
    /// Objects that showed themselves after that and were not seen before.
    pub objects_in_question: u64,
    /// Passes over these, each of which drew what might hide some of them.
    pub passes: u64,
    /// Boxes of inner nodes of the hierarchy that were tested.
    pub nodes_tested: u64,
    /// Boxes of inner nodes that were hidden, and ended their subtrees.
    pub nodes_hidden: u64,
    /// Objects that were asked by their rectangles.
    pub objects_asked: u64,
    /// Of these, those that were hidden, and all objects below hidden nodes, in the frustum or not.
    pub objects_hidden: u64,
    /// Boxes of objects that were tested more closely.
    pub objects_tested: u64,
    /// Pixels of holes that approximate accuracy ignored.
    pub ignored_pixels: u64,
    /// The steps that the frame skipped: AntumbraSkips, added up.
    pub skipped: u64,
    /// Nanoseconds for frustum culling, and choosing and sorting occluders. The four times together are the whole frame.
    pub select_ns: u64,
    /// Nanoseconds for asking and drawing occluders.
    pub raster_ns: u64,
    /// Nanoseconds for ending the drawing.
    pub pyramid_ns: u64,
    /// Nanoseconds for testing boxes down the hierarchy.
    pub test_ns: u64,
}

impl AntumbraStatistics {
    pub fn of(found: &VisibleSet) -> AntumbraStatistics {
        let (counts, times) = (&found.statistics, &found.times);
        let ns = |time: std::time::Duration| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        AntumbraStatistics {
            objects_visible: counts.objects_visible,
            occluders_asked: counts.occluders_asked,
            occluder_triangles: counts.occluder_triangles,
            clusters_remembered: counts.clusters_remembered,
            objects_in_question: counts.objects_in_question,
            passes: counts.passes,
            nodes_tested: counts.nodes_tested,
            nodes_hidden: counts.nodes_hidden,
            objects_asked: counts.objects_asked,
            objects_hidden: counts.objects_hidden,
            objects_tested: counts.objects_tested,
            ignored_pixels: counts.ignored_pixels,
            skipped: { SKIPS.iter() }
                .filter(|(_, skip)| counts.skipped.has(*skip))
                .map(|(flag, _)| *flag as u64)
                .sum(),
            select_ns: ns(times.select),
            raster_ns: ns(times.raster),
            pyramid_ns: ns(times.pyramid),
            test_ns: ns(times.test),
        }
    }
}
