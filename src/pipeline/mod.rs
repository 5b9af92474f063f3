//! Frames in a pipeline: while one is drawn, the next are culled (HOM §8.1, GigaWalk §5).
//!
//! `schedule` says which stage waits for which, `places` are the threads that keep to it, and the stages are those of a
//! [`Culler`]'s frame, done one by one (`cull::staged`).
//!
//! **Invariant.** A visible set loses nothing that is exactly visible, by whatever schedule: what a frame knows of earlier ones
//! chooses occluders and hides nothing. And it is the same, to the bit, for any number of threads: frames know what the frame
//! [`Schedule::frames_back`] before them needed, as if so many cullers took them in turns.

mod places;
mod schedule;

use std::io;
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::cull::{Culler, Remembered, StagedFrame, VisibleSet};
use crate::view::Camera;

pub use schedule::{Schedule, Stage};

/// Why a pipeline ended early.
#[derive(Debug, Error)]
pub enum PipelineError<E> {
    /// The operating system gives no threads.
    #[error("there are no threads for a pipeline: {0}")]
    NoThreads(io::Error),
    /// The final draw failed.
    #[error("{0}")]
    FinalDraw(E),
}

/// A frame that is ready for its final draw.
#[derive(Clone, Copy, Debug)]
pub struct CulledFrame<'a> {
    /// Its number, from 0 on.
    pub number: u64,
    /// What it is seen by.
    pub camera: &'a Camera,
    /// What may be seen.
    pub found: &'a VisibleSet,
    /// How long the stages before took, in the order of [`Stage::ALL`]; what a frame waits between them is in none.
    pub stage_times: [Duration; 3],
    /// When its camera was taken: until now, and the final draw, is its latency.
    pub camera_in: Instant,
}

/// Culls frames while those before them are drawn.
///
/// ```
/// use std::convert::Infallible;
/// use std::sync::Arc;
///
/// use antumbra::cull::{Culler, Settings};
/// use antumbra::glam::{DAffine3, DVec3};
/// use antumbra::pipeline::{Pipeline, Schedule};
/// use antumbra::scene::{Material, Mesh, Object, Scene, Surface};
/// use antumbra::view::{Camera, PictureSize, Projection};
///
/// // A square of side 2, once large and once small behind it.
/// let square = Mesh {
///     name: "square".into(),
///     positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]].into(),
///     triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
///     surfaces: vec![Surface { triangles: 0..2, material: Material::default() }],
/// };
/// let object = |z: f64, scale: f64| Object {
///     name: format!("{z} away"),
///     mesh: 0,
///     world_from_local: DAffine3::from_translation(DVec3::Z * -z) * DAffine3::from_scale(DVec3::splat(scale)),
///     never_cull: false,
///     never_occlude: false,
///     occluder_proxy: None,
/// };
/// let scene = Arc::new(Scene::new(vec![square], vec![object(5.0, 4.0), object(9.0, 1.0)])?);
///
/// let projection = Projection::Perspective { fov_y: 1.0, near: 0.1, far: None };
/// let camera = |x: f64| Camera::look_at(DVec3::X * x, DVec3::new(x, 0.0, -1.0), DVec3::Y, projection);
/// let walk: Vec<Camera> = (0..10).map(|i| camera(0.1 * f64::from(i))).collect::<Result<_, _>>()?;
///
/// let settings = Settings { threads: 1, ..Settings::new(PictureSize::new(640, 480)?) };
/// let mut pipeline = Pipeline::new(Culler::new(scene, settings)?, Schedule::TWO_STAGE);
/// let mut drawn = 0;
/// pipeline.run(walk, |frame| {
///     // Draw the objects in `frame.found.visible` here.
///     assert_eq!(frame.found.visible, [0]);
///     drawn += 1;
///     Ok::<(), Infallible>(())
/// })?;
/// assert_eq!(drawn, 10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Pipeline {
    culler: Culler,
    schedule: Schedule,
    /// Those that are not under way.
    frames: Vec<StagedFrame>,
}

impl Pipeline {
    /// A pipeline for a culler's scene and settings. By contribution culls best, since what it remembers is put right within the
    /// frame; with [`Selection::PreviousVisible`](crate::occluders::Selection::PreviousVisible), the occluders are the visible
    /// objects of the frame [`Schedule::frames_back`] before (GigaWalk §5.2), so leave
    /// [`Settings::frames_back`](crate::cull::Settings::frames_back) at one. Each stage is one thread's work, so the culler's own threads have none;
    /// [`Settings::threads`](crate::cull::Settings::threads) had better be 1. A budget of time counts the stages, not what a frame
    /// waits between them.
    pub fn new(culler: Culler, schedule: Schedule) -> Pipeline {
        Pipeline {
            culler,
            schedule,
            frames: Vec::new(),
        }
    }

    /// The culler.
    pub fn culler(&self) -> &Culler {
        &self.culler
    }

    /// The schedule.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// Culls and draws a frame for each camera, in their order; the first knows nothing of earlier frames. Ends when there are no
    /// more cameras and all frames are drawn.
    ///
    /// Cameras are taken, and frames drawn, on the calling thread: a camera is asked for as soon as there is room for its frame,
    /// and frames before it wait until it is there. Threads of the other places live as long as this call; it leaves none behind,
    /// however it ends.
    ///
    /// # Errors
    /// The error of `final_draw`, as soon as it has one; frames that are under way are not drawn then. Or if there are no threads.
    ///
    /// # Panics
    /// If `cameras` or `final_draw` do: with what they panic with.
    pub fn run<E>(
        &mut self,
        cameras: impl IntoIterator<Item = Camera>,
        mut final_draw: impl FnMut(CulledFrame<'_>) -> Result<(), E>,
    ) -> Result<(), PipelineError<E>> {
        let Pipeline {
            culler,
            schedule,
            frames,
        } = self;
        let mut cameras = cameras.into_iter().peekable();
        let Some(first) = cameras.peek() else {
            return Ok(());
        };
        frames.resize_with(schedule.in_flight(), || culler.staged_frame(first));
        let culler = &*culler;
        places::run(
            schedule,
            frames,
            |frame| {
                let camera = cameras.next();
                if let Some(camera) = camera {
                    frame.camera = camera;
                }
                camera.is_some()
            },
            |stage, frame, remembered: &mut Remembered| match stage {
                Stage::Select => culler.select_staged(frame, remembered),
                Stage::DrawOccluders => culler.draw_staged(frame, remembered),
                Stage::Cull => culler.ask_staged(frame, remembered),
                Stage::FinalDraw => {}
            },
            |under_way| {
                final_draw(CulledFrame {
                    number: under_way.number,
                    camera: &under_way.frame.camera,
                    found: &under_way.frame.found,
                    stage_times: under_way.frame.stage_times,
                    camera_in: under_way.camera_in,
                })
            },
        )
    }
}
