//! A view of the world: a camera's buffer, and what its frames remember.

use std::time::Instant;

use super::frame::Memory;
use super::reuse::Region;
use super::world::World;
use super::{Frame, Remembered, Settings, Skip, VisibleSet};
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
    last: Option<Last>,
    moved: Vec<u32>,
}

/// The last frame, from which the next one may be made.
#[derive(Debug)]
struct Last {
    camera: Camera,
    /// How many changes there had been.
    changes: u64,
    visible: Vec<u32>,
    ignored_pixels: u64,
    /// How many frames there were in part since the last whole one.
    parts: u32,
}

/// After so many frames in part comes a whole one: it forgets what is not needed any more, and asks about everything.
const MOST_PARTS: u32 = 64;

impl View {
    /// A view that remembers nothing.
    pub fn new(settings: Settings) -> View {
        View {
            settings,
            buffer: None,
            remembered: Remembered::default(),
            memory: Memory::default(),
            last: None,
            moved: Vec::new(),
        }
    }

    /// Makes pictures of another size from the next frame on.
    pub fn resize(&mut self, size: PictureSize) {
        if size != self.settings.size {
            self.settings.size = size;
            self.buffer = None;
            self.last = None;
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
            last,
            moved,
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
        let known = last
            .as_ref()
            .filter(|last| frame.can_be_repeated() && last.camera == *camera);
        let since = known.and_then(|last| Some((last, world.changes.since(last.changes)?)));
        if let Some((last, moves)) = since {
            if moves.clone().next().is_none() {
                return frame.repeat(&last.visible, last.ignored_pixels, found);
            }
            moved.clear();
            moved.extend(moves.clone().map(|(object, _)| *object));
            let bounds = world.scene.bounds();
            let now = moved.iter().map(|&object| &bounds[object as usize]);
            let before = moves.map(|(_, bounds)| bounds);
            let frustum = frame.frustum(camera);
            let region = Region::around(buffer.screen(), &frustum, before.chain(now));
            if let Some(region) =
                region.filter(|_| frame.can_be_in_part() && last.parts < MOST_PARTS)
            {
                frame.run_in_part(
                    region,
                    (&last.visible, moved),
                    buffer,
                    remembered,
                    memory,
                    found,
                );
                return self.note(world, camera, found);
            }
        }
        frame.run(camera, buffer, remembered, memory, found);
        self.note(world, camera, found);
    }

    /// Keeps an answer for the next frame.
    fn note(&mut self, world: &World, camera: &Camera, found: &VisibleSet) {
        let last = self.last.get_or_insert_with(|| Last {
            camera: *camera,
            changes: 0,
            visible: Vec::new(),
            ignored_pixels: 0,
            parts: 0,
        });
        last.camera = *camera;
        last.parts = if found.statistics.skipped.has(Skip::Elsewhere) {
            last.parts + 1
        } else {
            0
        };
        last.changes = world.changes.count();
        last.visible.clone_from(&found.visible);
        last.ignored_pixels = found.statistics.ignored_pixels;
    }

    /// Forgets the last frame's answer: the next one finds its own.
    pub fn forget_answer(&mut self) {
        self.last = None;
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
        self.last = None;
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
    let Settings {
        size,
        map_scale,
        slack,
        ..
    } = *settings;
    OcclusionBuffer::with_slack(size, *camera, map_scale, slack)
}
