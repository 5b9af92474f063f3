//! A frame like the last one allocates nothing.
//!
//! Every allocation of the process is counted, whichever thread makes it; so this file has a single test. On one thread there
//! is none. On several, rayon allocates for itself: a frame is handed to the threads in a job on the heap, and jobs pass
//! through queues that get and free a block of 1.5 KiB every 63 of them. It does so for a frame that does nothing, too.
//! So a few small allocations a frame are allowed. Ours would show: a frame has dozens of stages, each with a task for
//! every thread at least, so one allocation a task would be hundreds a frame, and a single block of triangles takes more than
//! the bytes that are allowed.

use std::alloc::System;
use std::convert::Infallible;
use std::path::Path;
use std::sync::Arc;

use antumbra::cull::{Culler, Level, Settings, VisibleSet};
use antumbra::pipeline::{Pipeline, Schedule};
use antumbra::scene::Scene;
use antumbra::view::{Camera, CameraPath, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, Stats, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// What rayon may take for a frame, on average.
const ALLOCATIONS_OF_RAYON: usize = 3;
const BYTES_OF_RAYON: usize = 1024;

/// What 24 frames of a pipeline may take, together: a list that grows a little. A frame's buffer alone is ten times that.
const BYTES_OF_PIPELINE: usize = 16 * 1024;

#[test]
fn a_steady_frame_allocates_nothing() {
    let fixture = generate(&Recipe {
        triangles: Some(60_000),
        ..Recipe::new(Kind::City)
    })
    .expect("enough triangles");
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("steady.glb");
    let out = std::fs::File::create(&file).expect("the file can be written");
    fixture.write_glb(out).expect("the file can be written");
    let scene = Arc::new(Scene::load(&file).expect("a sound file"));
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
    let frames = &path.cameras()[40..60];

    for &level in Level::available() {
        if level == Level::Scalar {
            // The plain form of the loops is there to define them, and takes what memory it likes.
            continue;
        }
        for threads in [1, 2, 5] {
            let settings = Settings {
                threads,
                level,
                ..Settings::new(PictureSize::new(640, 400).expect("a size"))
            };
            let mut culler = Culler::new(scene.clone(), settings).expect("threads");
            let mut found = VisibleSet::default();
            let mut walk = || -> Stats {
                let region = Region::new(ALLOCATOR);
                for camera in frames {
                    culler.cull_into(camera, &mut found);
                }
                region.change()
            };
            // Once along the way without memory and once with it, and all that is kept is as large as it will be.
            let first = walk();
            assert!(first.allocations > 10, "the counter counts");
            walk();
            // The thread of a pool that made a culler may end meanwhile, and free what it had.
            let walks = (0..3).map(|_| walk());
            let again = walks
                .min_by_key(|stats| stats.allocations + stats.reallocations)
                .expect("three walks");
            let allowed = if threads == 1 { 0 } else { frames.len() };
            let said = format!("{level}, {threads} threads: {again:?}");
            let taken = again.allocations + again.reallocations;
            assert!(taken <= allowed * ALLOCATIONS_OF_RAYON, "{said}");
            assert!(again.bytes_allocated <= allowed * BYTES_OF_RAYON, "{said}");
            assert!(found.statistics.occluder_triangles > 1_000);
        }
    }

    // So many frames that each memory and each frame under way comes to the same cameras again.
    let frames = &path.cameras()[36..60];
    for (name, schedule) in Schedule::NAMED {
        let again = pipelined(&scene, frames, schedule);
        let said = format!("{name}: {again:?}");
        assert!(again.bytes_allocated <= BYTES_OF_PIPELINE, "{said}");
    }
}

/// What a pipeline takes on its fourth time along a way, all threads together.
fn pipelined(scene: &Arc<Scene>, frames: &[Camera], schedule: Schedule) -> Stats {
    let settings = Settings {
        threads: 1,
        ..Settings::new(PictureSize::new(640, 400).expect("a size"))
    };
    let culler = Culler::new(scene.clone(), settings).expect("threads");
    let mut pipeline = Pipeline::new(culler, schedule);
    let ways = 4 * frames.len();
    let begin = 3 * frames.len() as u64;
    let mut region = Region::new(ALLOCATOR);
    let mut taken = Stats::default();
    let cameras = frames.iter().cycle().take(ways).copied();
    let done = pipeline.run(cameras, |frame| {
        if frame.number == begin {
            region.reset();
        }
        taken = region.change();
        Ok::<(), Infallible>(())
    });
    done.expect("threads");
    taken
}
