//! What a frame did, and how long each stage took.

use std::time::{Duration, Instant};

use super::{Skips, VisibleSet};

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
    /// Objects that were asked by their rectangles.
    pub objects_asked: u64,
    /// Of these, those that were hidden, and all objects below hidden nodes, in the frustum or not.
    pub objects_hidden: u64,
    /// Boxes of objects that were tested more closely.
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

/// Tells how long stages take.
pub struct Clock {
    since: Instant,
    pub times: StageTimes,
}

impl Clock {
    pub fn start() -> Clock {
        Clock {
            since: Instant::now(),
            times: StageTimes::default(),
        }
    }

    /// Goes on with a frame that other stages have begun.
    pub fn go_on(found: &VisibleSet) -> Clock {
        Clock {
            since: Instant::now(),
            times: found.times,
        }
    }

    /// Ends a frame.
    pub fn end(mut self, found: &mut VisibleSet) {
        found.statistics.objects_visible = found.visible.len() as u64;
        self.lap(|times| &mut times.test);
        found.times = self.times;
    }

    /// Adds the time since the last lap to a stage's.
    pub fn lap(&mut self, stage: impl FnOnce(&mut StageTimes) -> &mut Duration) {
        let now = Instant::now();
        *stage(&mut self.times) += now - self.since;
        self.since = now;
    }
}
