//! What a frame did, and how long each stage took.

use std::time::Duration;

use super::Skips;

/// Counts of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
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
    /// Boxes of inner nodes that were tested.
    pub nodes_tested: u64,
    /// Boxes of inner nodes that were hidden, and ended their subtrees.
    pub nodes_hidden: u64,
    /// Boxes of objects that were tested.
    pub objects_tested: u64,
    /// Pixels of holes that approximate accuracy ignored: see
    /// [`OcclusionBuffer::ignored_pixels`](crate::occlusion::OcclusionBuffer::ignored_pixels).
    pub ignored_pixels: u64,
    /// The steps that the frame skipped, and why.
    pub skipped: Skips,
}

/// How long the stages of a frame took; together, the whole frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Frustum culling, and choosing and sorting occluders.
    pub select: Duration,
    /// Asking and drawing occluders.
    pub raster: Duration,
    /// Ending the drawing: covering the holes that may be ignored.
    pub pyramid: Duration,
    /// Testing boxes down the hierarchy.
    pub test: Duration,
}

impl StageTimes {
    /// The whole frame.
    pub fn total(&self) -> Duration {
        self.select + self.raster + self.pyramid + self.test
    }
}
