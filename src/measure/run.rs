//! Measures a path, frame by frame.

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::ThreadPoolBuildError;
use rayon::prelude::*;

use super::{
    Animation, FrameReport, Moving, Reference, Report, SceneReport, SettingsReport, Simulation,
    Totals, ideal_box_test, ideal_face_test,
};
use crate::cull::{Culler, Remembered, Settings, VisibleSet};
use crate::prepare::Prepared;
use crate::view::{Camera, CameraPath};

/// A frame is repeated at least so often,
const LEAST_REPEATS: usize = 5;
/// and at least so long,
const LEAST_TIME: Duration = Duration::from_millis(20);
/// but no oftener than this.
const MOST_REPEATS: usize = 50;

/// How to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasureSettings {
    /// How to cull.
    pub cull: Settings,
    /// Whether each frame starts without memory of the last.
    pub cold: bool,
    /// Frames 0, N, 2N … are judged; at least 1.
    pub every: usize,
    /// What moves from frame to frame, if something does, and the seed that says how.
    pub animate: Option<(Moving, u64)>,
    /// Whether to predict what the frames would take on more threads than the machine has.
    pub simulate_threads: bool,
}

/// Measures a scene on a path; calls `on_frame` with the number of judged frames done and of all, first with 0.
///
/// # Errors
/// If the operating system gives no threads.
pub fn run(
    prepared: &Prepared,
    path: &CameraPath,
    settings: &MeasureSettings,
    mut on_frame: impl FnMut(usize, usize),
) -> Result<Report, ThreadPoolBuildError> {
    let scene = prepared.scene();
    let mut culler = Culler::with_prepared(prepared, settings.cull)?;
    let every = settings.every.max(1);
    let judged = path.cameras().len().div_ceil(every);
    let animation = settings.animate.map(|(moving, seed)| {
        let up = path.cameras().first().map_or(DVec3::Y, Camera::up);
        Animation::new(scene, moving, up, seed)
    });
    let mut moves = Vec::new();
    let mut frames = Vec::with_capacity(judged);
    let mut simulation = Simulation::default();
    on_frame(0, judged);
    for (frame, camera) in path.cameras().iter().enumerate() {
        let mut move_us = 0.0;
        if let Some(animation) = &animation {
            animation.moves(frame, &mut moves);
            let start = Instant::now();
            { culler.move_objects(&moves) }
                .expect("what sways about its place stays within the world");
            move_us = start.elapsed().as_nanos() as f64 / 1000.0;
        }
        if frame % every == 0 {
            if settings.cold {
                culler.forget();
            }
            let before = culler.remembered().clone();
            frames.push(FrameReport {
                moved: moves.len() as u64,
                move_us,
                ..measure_frame(&mut culler, &before, frame, camera)
            });
            if settings.simulate_threads {
                simulation.add_frame(&mut culler, &before, camera);
            }
            on_frame(frames.len(), judged);
        } else if !settings.cold {
            culler.cull(camera);
        }
    }
    let size = culler.settings().size;
    let totals = Totals::of(&frames, (size.width() * size.height()) as u64);
    let objects = scene.objects().len() as u64;
    let scene = SceneReport {
        objects,
        triangles: scene.triangle_count(),
    };
    Ok(Report {
        scene,
        settings: describe(&culler, settings),
        frames,
        totals,
        simulated: if settings.simulate_threads {
            simulation.predictions()
        } else {
            Vec::new()
        },
    })
}

fn describe(culler: &Culler, settings: &MeasureSettings) -> SettingsReport {
    let Settings {
        size,
        accuracy,
        translucent,
        map_scale,
        slack,
        depth,
        occluders,
        budget,
        static_criteria,
        weighing,
        frames_back,
        most_passes,
        level,
        ..
    } = *culler.settings();
    let approximation = accuracy.approximation();
    SettingsReport {
        size: [size.width(), size.height()],
        threads: culler.threads(),
        simd: level.to_string(),
        accuracy: approximation.map_or("exact", |_| "approximate").into(),
        hole: approximation.map_or(0, |a| a.hole),
        base_level: approximation.map(|a| a.base_level),
        distribution: approximation.map(|a| a.distribution),
        transparency: approximation.map(|a| a.transparency),
        translucent: translucent && approximation.is_some(),
        occluders: occluders.to_string(),
        budget: budget.to_string(),
        static_criteria: static_criteria.to_string(),
        least_compactness: weighing.least_compactness,
        most_active: weighing.most_active,
        frames_back: frames_back.count(),
        most_passes: (most_passes < u32::MAX).then_some(most_passes),
        viewpoints: culler
            .visibility_grid()
            .map_or(0, |grid| grid.layout().viewpoints()),
        cold: settings.cold,
        depth: depth.to_string(),
        nth: depth.nth(),
        map_scale: map_scale.pixels(),
        slack: slack.pixels(),
        every: settings.every,
        animate: settings.animate.map(|(moving, _)| moving.to_string()),
        seed: settings.animate.map(|(_, seed)| seed),
    }
}

/// Culls a frame until its time is known, each time with what is known of the frames before it; gives the repeat that took least.
fn repeat(culler: &mut Culler, before: &Remembered, camera: &Camera) -> VisibleSet {
    let start = Instant::now();
    let mut best = culler.cull(camera);
    let mut set = VisibleSet::default();
    for count in 1..MOST_REPEATS {
        if count >= LEAST_REPEATS && start.elapsed() >= LEAST_TIME {
            break;
        }
        culler.recall(before);
        culler.cull_into(camera, &mut set);
        if set.times.total() < best.times.total() {
            std::mem::swap(&mut set, &mut best);
        }
    }
    best
}

fn measure_frame(
    culler: &mut Culler,
    before: &Remembered,
    frame: usize,
    camera: &Camera,
) -> FrameReport {
    let set = repeat(culler, before, camera);
    let in_frustum = culler.in_frustum(camera);
    let scene = culler.scene().clone();
    let size = culler.settings().size;
    let reference = Reference::new(&scene, camera, size);
    let survives = |object: &u32| set.visible.binary_search(object).is_ok();
    let hidden: Vec<u32> = in_frustum
        .iter()
        .copied()
        .filter(|&o| !reference.is_visible(o))
        .collect();
    let count = |test: &(dyn Fn(u32) -> bool + Sync)| {
        hidden.par_iter().filter(|&&object| test(object)).count() as u64
    };
    let bounds = |object: u32| &scene.bounds()[object as usize];
    let triangles = |objects: &[u32]| -> u64 {
        let of = |&o: &u32| {
            scene.meshes()[scene.objects()[o as usize].mesh]
                .triangles
                .len() as u64
        };
        objects.iter().map(of).sum()
    };
    FrameReport {
        frame,
        time_us: set.times.into(),
        moved: 0,
        move_us: 0.0,
        in_frustum: in_frustum.len() as u64,
        exactly_visible: (in_frustum.len() - hidden.len()) as u64,
        exactly_hidden: hidden.len() as u64,
        sampleless: count(&|o| !reference.is_sampled(o)),
        culled: count(&|o| !survives(&o)),
        ignored_pixels: set.statistics.ignored_pixels,
        ideal_box_culled: count(&|o| ideal_box_test(reference.depths(), camera, bounds(o))),
        ideal_face_culled: count(&|o| ideal_face_test(reference.depths(), camera, bounds(o))),
        false_culls: reference.visible_objects().filter(|o| !survives(o)).count() as u64,
        wrong_pixels: reference.wrong_pixels(&scene, camera, &set.visible),
        triangles_in_frustum: triangles(&in_frustum),
        triangles_drawn: triangles(&set.visible),
        occluder_triangles: set.statistics.occluder_triangles,
        skipped: { set.statistics.skipped.iter() }
            .map(|skip| skip.to_string())
            .collect(),
        buffer_hash: format!("{:016x}", culler.buffer().map_or(0, |b| b.tiles().hash())),
    }
}
