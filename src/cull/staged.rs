//! A frame stage by stage: what a pipeline does on several threads, for several frames at once.
//!
//! A frame on its way owns what its stages fill: the buffer, their memory, what is found. What it knows of earlier frames is handed
//! in, and goes on to a later one when the last stage is done. The scene and what is known of it are shared and never change.

use std::time::{Duration, Instant};

use super::frame::Memory;
use super::views::new_buffer;
use super::{Culler, Frame, Remembered, StageTimes, VisibleSet};
use crate::occlusion::OcclusionBuffer;
use crate::tasks::Tasks;
use crate::view::Camera;

/// A frame on its way through its stages, and the memory of those that it was before.
#[derive(Debug)]
pub(crate) struct StagedFrame {
    pub camera: Camera,
    pub found: VisibleSet,
    /// How long each stage took.
    pub stage_times: [Duration; 3],
    buffer: OcclusionBuffer,
    memory: Memory,
}

impl Culler {
    /// A frame to begin.
    pub(crate) fn staged_frame(&self, camera: &Camera) -> StagedFrame {
        StagedFrame {
            camera: *camera,
            found: VisibleSet::default(),
            stage_times: [Duration::ZERO; 3],
            buffer: new_buffer(self.settings(), camera),
            memory: Memory::default(),
        }
    }

    /// First stage: begins a frame, and selects the occluders that it draws.
    pub(crate) fn select_staged(&self, staged: &mut StagedFrame, remembered: &mut Remembered) {
        staged.found.times = StageTimes::default();
        self.stage(0, staged, |frame, staged| {
            let (camera, buffer) = (&staged.camera, &mut staged.buffer);
            let (memory, found) = (&mut staged.memory, &mut staged.found);
            frame.select(camera, buffer, remembered, memory, found);
        });
    }

    /// Second stage: draws them.
    pub(crate) fn draw_staged(&self, staged: &mut StagedFrame, remembered: &mut Remembered) {
        self.stage(1, staged, |frame, staged| {
            let (memory, found) = (&mut staged.memory, &mut staged.found);
            frame.draw(&mut staged.buffer, remembered, memory, found);
        });
    }

    /// Third stage: finds what the camera may see past them.
    pub(crate) fn ask_staged(&self, staged: &mut StagedFrame, remembered: &mut Remembered) {
        self.stage(2, staged, |frame, staged| {
            let (memory, found) = (&mut staged.memory, &mut staged.found);
            frame.ask(&mut staged.buffer, remembered, memory, found);
        });
    }

    /// Does a stage, and notes how long it took.
    fn stage(
        &self,
        number: usize,
        staged: &mut StagedFrame,
        of_frame: impl FnOnce(&Frame<'_>, &mut StagedFrame),
    ) {
        let before = staged.found.times.total();
        of_frame(&self.frame_for(&staged.found), staged);
        staged.stage_times[number] = staged.found.times.total() - before;
    }

    /// A frame whose time ends when the budget is spent, if there is one: the time that it waits between stages does not count.
    fn frame_for(&self, found: &VisibleSet) -> Frame<'_> {
        let time = self.settings().budget.time();
        let left = time.map(|time| time.saturating_sub(found.times.total()));
        Frame {
            ends: left.and_then(|left| Instant::now().checked_add(left)),
            ..self.frame_of(Tasks::ALONE)
        }
    }
}
