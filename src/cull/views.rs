//! A view of the world: a camera's buffer, and what its frames remember.

use std::time::Instant;

use super::frame::Memory;
use super::world::World;
use super::{Frame, Remembered, Settings, VisibleSet};
use crate::occluders::{Budget, Contributions};
use crate::occlusion::OcclusionBuffer;
use crate::tasks::Tasks;
use crate::view::{Camera, PictureSize};

/// What one camera's frames need besides the world.
#[derive(Debug)]
pub struct View {
    pub settings: Settings,
    pub buffer: Option<OcclusionBuffer>,
    pub remembered: Remembered,
    pub memory: Memory,
}

impl View {
    /// A view that remembers nothing.
    pub fn new(settings: Settings) -> View {
        View {
            settings,
            buffer: None,
            remembered: Remembered::default(),
            memory: Memory::default(),
        }
    }

    /// Makes pictures of another size from the next frame on.
    pub fn resize(&mut self, size: PictureSize) {
        if size != self.settings.size {
            self.settings.size = size;
            self.buffer = None;
        }
    }

    /// Finds what a camera may see.
    pub fn frame(
        &mut self,
        world: &World,
        tasks: Tasks<'_>,
        camera: &Camera,
        found: &mut VisibleSet,
    ) {
        let View {
            settings,
            buffer,
            remembered,
            memory,
        } = self;
        let frame = Frame {
            // A time beyond all times is none.
            ends: settings
                .budget
                .time()
                .and_then(|time| Instant::now().checked_add(time)),
            ..world.frame_of(settings, tasks)
        };
        let buffer = buffer.get_or_insert_with(|| new_buffer(settings, camera));
        frame.run(camera, buffer, remembered, memory, found);
    }

    /// Finds what a camera may see behind given clusters.
    pub fn frame_behind(
        &mut self,
        world: &World,
        tasks: Tasks<'_>,
        camera: &Camera,
        given: &mut Contributions,
        found: &mut VisibleSet,
    ) {
        let settings = Settings {
            // All that is given is drawn.
            budget: Budget::All,
            ..self.settings
        };
        let frame = Frame {
            visibility_grid: None,
            ..world.frame_of(&settings, tasks)
        };
        let buffer = self
            .buffer
            .get_or_insert_with(|| new_buffer(&settings, camera));
        frame.run_behind(camera, buffer, given, &mut self.memory, found);
    }
}

/// An empty buffer as settings want it.
pub fn new_buffer(settings: &Settings, camera: &Camera) -> OcclusionBuffer {
    OcclusionBuffer::with_map_scale(settings.size, *camera, settings.map_scale)
}
