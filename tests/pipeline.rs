//! Frames in a pipeline: the same as frames one by one, and none of them loses anything.

use std::convert::Infallible;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::cull::{Culler, Settings, Statistics, VisibleSet};
use antumbra::measure::Reference;
use antumbra::occluders::{Budget, DrawnCluster, Selection};
use antumbra::pipeline::{Pipeline, PipelineError, Schedule};
use antumbra::scene::Scene;
use antumbra::view::{Camera, CameraPath, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};

/// What a frame finds.
#[derive(Debug, PartialEq)]
struct Found {
    visible: Vec<u32>,
    occluders: Vec<DrawnCluster>,
    statistics: Statistics,
}

impl From<&VisibleSet> for Found {
    fn from(found: &VisibleSet) -> Found {
        Found {
            visible: found.visible.clone(),
            occluders: found.occluders.clone(),
            statistics: found.statistics,
        }
    }
}

fn city(test: &str) -> (Arc<Scene>, Vec<Camera>) {
    let fixture = generate(&Recipe {
        triangles: Some(60_000),
        ..Recipe::new(Kind::City)
    })
    .expect("enough triangles");
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("pipeline-{test}.glb"));
    let out = std::fs::File::create(&file).expect("the file can be written");
    fixture.write_glb(out).expect("the file can be written");
    let scene = Scene::load(&file).expect("a sound file");
    let _ = std::fs::remove_file(&file);
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
    (Arc::new(scene), path.cameras().to_vec())
}

/// A walk, and then jumps.
fn walk_and_jumps(cameras: &[Camera]) -> Vec<Camera> {
    let walk = cameras.iter().take(30);
    walk.chain(cameras.iter().step_by(17)).copied().collect()
}

fn settings() -> Settings {
    Settings {
        threads: 1,
        ..Settings::new(PictureSize::new(637, 411).expect("a size"))
    }
}

fn run(pipeline: &mut Pipeline, cameras: &[Camera]) -> Vec<Found> {
    let mut all = Vec::new();
    let done = pipeline.run(cameras.iter().copied(), |frame| {
        assert_eq!(frame.number, all.len() as u64, "frames come in order");
        assert_eq!(
            frame.camera,
            &cameras[all.len()],
            "each with its own camera"
        );
        all.push(Found::from(frame.found));
        Ok::<(), Infallible>(())
    });
    done.expect("threads");
    all
}

/// Every selection that works differently from stage to stage.
fn ways() -> Vec<Settings> {
    let way = |occluders, budget| Settings {
        occluders,
        budget,
        ..settings()
    };
    vec![
        way(Selection::Contribution, Budget::Auto),
        way(Selection::Contribution, Budget::Triangles(2_000)),
        way(Selection::Contribution, Budget::All),
        way(Selection::Nearest, Budget::Triangles(2_000)),
        way(Selection::PreviousVisible, Budget::All),
        way(Selection::Coherent, Budget::Triangles(2_000)),
    ]
}

/// Who does what when has no part in it: as many cullers as a frame looks back, each with every so many-th frame, find the same.
#[test]
fn finds_what_cullers_in_turns_find_on_any_number_of_threads() {
    let (scene, cameras) = city("turns");
    let cameras = walk_and_jumps(&cameras);
    let first = Culler::new(scene, settings()).expect("threads");
    for settings in ways() {
        for (name, schedule) in Schedule::NAMED {
            let mut cullers: Vec<Culler> = (0..schedule.frames_back)
                .map(|_| first.another(settings).expect("threads"))
                .collect();
            let count = cullers.len();
            let expected: Vec<Found> = (0..)
                .zip(&cameras)
                .map(|(frame, camera): (usize, _)| {
                    Found::from(&cullers[frame % count].cull(camera))
                })
                .collect();
            for threads in 1..=schedule.threads() {
                let culler = first.another(settings).expect("threads");
                let mut pipeline = Pipeline::new(culler, schedule.on_threads(threads));
                for _ in 0..2 {
                    let found = run(&mut pipeline, &cameras);
                    let same = found == expected;
                    assert!(same, "{name} on {threads}, {settings:?}");
                }
            }
        }
    }
}

fn loses_nothing(culler: &Culler, cameras: &[Camera], judge_every: usize) {
    let size = culler.settings().size;
    let is_judged = |frame: usize| frame.is_multiple_of(judge_every);
    let references: Vec<Option<Reference>> = (0..)
        .zip(cameras)
        .map(|(frame, camera)| {
            is_judged(frame).then(|| Reference::new(culler.scene(), camera, size))
        })
        .collect();
    for (name, schedule) in Schedule::NAMED {
        let culler = culler.another(*culler.settings()).expect("threads");
        let found = run(&mut Pipeline::new(culler, schedule), cameras);
        for (frame, (found, reference)) in found.iter().zip(&references).enumerate() {
            let Some(reference) = reference else { continue };
            let is_lost = |object: &u32| found.visible.binary_search(object).is_err();
            let lost: Vec<u32> = reference.visible_objects().filter(is_lost).collect();
            assert!(lost.is_empty(), "{name}, frame {frame} lost {lost:?}");
        }
    }
}

#[test]
fn loses_no_visible_object_of_a_city() {
    let (scene, cameras) = city("loses");
    let cameras = walk_and_jumps(&cameras);
    let first = Culler::new(scene, settings()).expect("threads");
    for settings in ways() {
        let culler = first.another(settings).expect("threads");
        loses_nothing(&culler, &cameras, 3);
    }
}

fn scenes() -> PathBuf {
    std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    )
}

#[test]
fn loses_no_visible_object_of_real_scenes() {
    for name in ["castle", "sponza", "clinic"] {
        let file = scenes().join(format!("{name}.glb"));
        if !file.exists() {
            eprintln!("skipped: there is no {}", file.display());
            continue;
        }
        let scene = Arc::new(Scene::load(&file).expect("a scene"));
        let path = CameraPath::load(&file.with_extension("walk.json")).expect("a path");
        let size = PictureSize::new(1280, 768).expect("a size");
        let settings = Settings {
            threads: 1,
            ..Settings::new(size)
        };
        let culler = Culler::new(scene, settings).expect("threads");
        loses_nothing(&culler, path.cameras(), 24);
    }
}

#[test]
fn an_error_ends_it_and_it_can_begin_again() {
    let (scene, cameras) = city("error");
    let first = Culler::new(scene, settings()).expect("threads");
    for (name, schedule) in Schedule::NAMED {
        let mut pipeline = Pipeline::new(first.another(settings()).expect("threads"), schedule);
        let before = run(&mut pipeline, &cameras[..12]);
        let mut drawn = 0;
        // Cameras without end: only the error ends it.
        let done = pipeline.run(cameras.iter().cycle().copied(), |_| {
            drawn += 1;
            if drawn == 7 {
                Err("the window is gone")
            } else {
                Ok(())
            }
        });
        let is_passed_on = matches!(done, Err(PipelineError::FinalDraw("the window is gone")));
        assert!(is_passed_on, "{name}");
        assert_eq!(drawn, 7, "{name}: nothing is drawn after an error");
        assert!(run(&mut pipeline, &cameras[..12]) == before, "{name}");
    }
}

#[test]
fn a_panic_of_the_caller_ends_it_and_it_can_begin_again() {
    let (scene, cameras) = city("panic");
    let first = Culler::new(scene, settings()).expect("threads");
    for (name, schedule) in Schedule::NAMED {
        let mut pipeline = Pipeline::new(first.another(settings()).expect("threads"), schedule);
        let before = run(&mut pipeline, &cameras[..12]);
        let in_final_draw = catch_unwind(AssertUnwindSafe(|| {
            pipeline.run(cameras.iter().cycle().copied(), |frame| {
                if frame.number == 5 {
                    std::panic::resume_unwind(Box::new("final draw"));
                }
                Ok::<(), Infallible>(())
            })
        }));
        let in_camera = catch_unwind(AssertUnwindSafe(|| {
            let mut cameras = cameras.iter().copied();
            let until_panic = std::iter::from_fn(|| {
                if cameras.len() == 100 {
                    std::panic::resume_unwind(Box::new("camera"));
                }
                cameras.next()
            });
            pipeline.run(until_panic, |_| Ok::<(), Infallible>(()))
        }));
        for (caught, what) in [(in_final_draw, "final draw"), (in_camera, "camera")] {
            let panic = caught.expect_err("a panic");
            assert_eq!(panic.downcast_ref::<&str>(), Some(&what), "{name}");
        }
        assert!(run(&mut pipeline, &cameras[..12]) == before, "{name}");
    }
}

#[test]
fn no_cameras_are_no_frames() {
    let (scene, _) = city("none");
    let culler = Culler::new(scene, settings()).expect("threads");
    let mut pipeline = Pipeline::new(culler, Schedule::THREE_STAGE);
    assert!(run(&mut pipeline, &[]).is_empty());
}
