//! The same input gives the same bits: on every level of the machine, on any number of threads, on every processor family.

use std::path::Path;
use std::sync::Arc;

use antumbra::cull::{Culler, Level, Settings};
use antumbra::occluders::{Budget, DrawnCluster};
use antumbra::scene::Scene;
use antumbra::view::{CameraPath, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};

/// The hash of frame 60 of the generated city's walk, as `antumbra measure --budget all` prints it: the same wherever this test runs.
const CITY: u64 = 0x96b5_bb18_597c_bfd7;

/// What a frame finds.
#[derive(Debug, PartialEq)]
struct Found {
    visible: Vec<u32>,
    occluders: Vec<DrawnCluster>,
    buffer_hash: u64,
}

fn generated(kind: Kind, triangles: u64) -> (Arc<Scene>, CameraPath) {
    let fixture = generate(&Recipe {
        triangles: Some(triangles),
        ..Recipe::new(kind)
    })
    .expect("enough triangles");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    // Tests run at once: each has a file of its own.
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("main");
    let file = folder.join(format!("{test}-{kind}.glb"));
    let out = std::fs::File::create(&file).expect("the file can be written");
    fixture.write_glb(out).expect("the file can be written");
    let scene = Scene::load(&file).expect("a sound file");
    let _ = std::fs::remove_file(&file);
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
    (Arc::new(scene), path)
}

fn cull(
    scene: &Arc<Scene>,
    path: &CameraPath,
    frames: &[usize],
    budget: Budget,
    level: Level,
    threads: usize,
) -> Vec<Found> {
    let settings = Settings {
        budget,
        level,
        threads,
        ..Settings::new(PictureSize::new(637, 411).expect("a size"))
    };
    let mut culler = Culler::new(scene.clone(), settings).expect("threads");
    let found = frames.iter().map(|&frame| {
        let set = culler.cull(&path.cameras()[frame]);
        Found {
            visible: set.visible,
            occluders: set.occluders,
            buffer_hash: culler.buffer().expect("a frame was culled").tiles().hash(),
        }
    });
    found.collect()
}

#[test]
fn same_bits_on_every_level_and_for_any_thread_count() {
    for (kind, triangles) in [(Kind::City, 60_000), (Kind::PowerPlant, 150_000)] {
        let (scene, path) = generated(kind, triangles);
        let count = path.cameras().len();
        // Cuts, and some steps of a walk, of which the next frame remembers something.
        let walk = count / 3..count / 3 + 12;
        let frames: Vec<usize> = [0, count / 2, count - 1].into_iter().chain(walk).collect();
        for budget in [Budget::All, Budget::Auto, Budget::Triangles(2_000)] {
            let plain = cull(&scene, &path, &frames, budget, Level::Scalar, 1);
            for &level in Level::available() {
                for threads in [1, 2, 5] {
                    let found = cull(&scene, &path, &frames, budget, level, threads);
                    let said = format!("{kind}: {budget:?}, {level}, {threads} threads");
                    assert!(found == plain, "{said}");
                }
            }
        }
    }
}

#[test]
fn a_frame_of_the_city_has_the_same_hash_everywhere() {
    let (scene, path) = generated(Kind::City, 60_000);
    let found = cull(&scene, &path, &[60], Budget::All, Level::best(), 2);
    assert_eq!(
        format!("{:016x}", found[0].buffer_hash),
        format!("{CITY:016x}")
    );
}
