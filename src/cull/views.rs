//! Views of the world: a camera's buffer, and what its frames remember; and several of them at once.

use std::time::Instant;

use rayon::prelude::*;

use super::frame::Memory;
use super::reuse::Region;
use super::world::World;
use super::{Culler, Frame, Remembered, Settings, Skip, VisibleSet, in_tasks};
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
    /// Whether it looked for what is hidden: what did not leaves nothing to go on with.
    looked: bool,
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
                region.filter(|_| frame.can_be_in_part() && last.looked && last.parts < MOST_PARTS)
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
            looked: false,
        });
        last.camera = *camera;
        last.parts = if found.statistics.skipped.has(Skip::Elsewhere) {
            last.parts + 1
        } else {
            0
        };
        last.changes = world.changes.count();
        last.looked = !found.statistics.skipped.has_occlusion();
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

impl Culler {
    /// Adds a view of the same scene: another camera's frames, with a buffer and a memory of their own, such as those of a shadow
    /// map, a probe, or half of a split screen. Its settings are its own but for the threads, which are shared. Returns its number
    /// for [`Culler::cull_view`]; the culler's own view has number 0.
    ///
    /// What a view takes is in ARCHITECTURE.md, under "Memory"; the scene and what is known of it are not copied.
    ///
    /// ```
    /// # use antumbra::cull::{Culler, Settings, VisibleSet};
    /// # use antumbra::glam::{DAffine3, DVec3};
    /// # use antumbra::scene::{Material, Mesh, Object, Scene, Surface};
    /// # use antumbra::view::{Camera, PictureSize, Projection};
    /// # let wall = Mesh {
    /// #     name: String::new(),
    /// #     positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [0.0, 3.0, 0.0]].into(),
    /// #     triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
    /// #     surfaces: vec![Surface { triangles: 0..2, material: Material::default() }],
    /// # };
    /// # let object = Object {
    /// #     name: String::new(), mesh: 0, world_from_local: DAffine3::IDENTITY,
    /// #     never_cull: false, never_occlude: false, occluder_proxy: None,
    /// # };
    /// # let scene = Scene::new(vec![wall], vec![object])?;
    /// let settings = Settings::new(PictureSize::new(1280, 720)?);
    /// let mut culler = Culler::new(scene.into(), settings)?;
    /// let shadows = culler.add_view(Settings { size: PictureSize::new(1024, 1024)?, ..settings });
    ///
    /// let projection = Projection::Perspective { fov_y: 1.0, near: 0.1, far: None };
    /// let eye = Camera::look_at(DVec3::new(2.0, 1.0, 9.0), DVec3::new(2.0, 1.0, 0.0), DVec3::Y, projection)?;
    /// let sun = Camera::look_at(DVec3::new(20.0, 30.0, 40.0), DVec3::ZERO, DVec3::Y,
    ///     Projection::Orthographic { height: 50.0, near: 0.0, far: Some(100.0) })?;
    /// let mut found = [VisibleSet::default(), VisibleSet::default()];
    /// culler.cull_views(&[eye, sun], &mut found);
    /// assert_eq!(found[shadows].visible, [0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn add_view(&mut self, settings: Settings) -> usize {
        match &self.threads {
            Some(threads) => self
                .world
                .prepare_for(&settings, |work| threads.install(work)),
            None => self.world.prepare_for(&settings, |work| work()),
        }
        self.others.push(View::new(settings));
        self.others.len()
    }

    /// How many views there are: one, and those that were added.
    pub fn views(&self) -> usize {
        1 + self.others.len()
    }

    /// What the last frame of a view drew; none before its first.
    ///
    /// # Panics
    /// If there is no such view.
    pub fn buffer_of(&self, view: usize) -> Option<&OcclusionBuffer> {
        let view = match view {
            0 => &self.view,
            other => &self.others[other - 1],
        };
        view.buffer.as_ref()
    }

    /// Finds what a camera may see, as the next frame of a view.
    ///
    /// # Panics
    /// If there is no such view.
    pub fn cull_view(&mut self, view: usize, camera: &Camera, found: &mut VisibleSet) {
        let world = &self.world;
        let view = match view {
            0 => &mut self.view,
            other => &mut self.others[other - 1],
        };
        in_tasks(&self.threads, |tasks| {
            view.frame(world, tasks, camera, found);
        });
    }

    /// Finds what each view's camera may see: the next frame of all of them, at once. Where there are as many views as threads, each
    /// is one thread's work; else each is all threads' work, one after another. The answers are the same.
    ///
    /// # Panics
    /// If there are not as many cameras and sets as views.
    pub fn cull_views(&mut self, cameras: &[Camera], found: &mut [VisibleSet]) {
        let world = &self.world;
        let views = std::iter::once(&mut self.view).chain(&mut self.others);
        let mut views: Vec<&mut View> = views.collect();
        assert!(views.len() == cameras.len() && views.len() == found.len());
        let threads = { self.threads.as_ref() }
            .filter(|threads| views.len() >= threads.current_num_threads());
        let frames = views.par_iter_mut().zip(cameras).zip(&mut *found);
        match threads {
            Some(threads) => threads.install(|| {
                frames.for_each(|((view, camera), found)| {
                    view.frame(world, Tasks::ALONE, camera, found);
                });
            }),
            None => {
                for ((view, camera), found) in views.iter_mut().zip(cameras).zip(found) {
                    in_tasks(&self.threads, |tasks| {
                        view.frame(world, tasks, camera, found);
                    });
                }
            }
        }
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
