//! Exact culling on real scenes, where there are any: the folder named by `ANTUMBRA_SCENES`, by default
//! `../shared/scenes`, with a camera path beside each scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::final_pass::render_image;
use antumbra::measure::{MeasureSettings, Totals, run};
use antumbra::occluders::Budget;
use antumbra::prepare::Prepared;
use antumbra::scene::Scene;
use antumbra::view::{CameraPath, MapScale, PictureSize};

fn folder() -> PathBuf {
    std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    )
}

/// A scene and its path; none, with a word about it, if the scene is not there.
fn load(name: &str) -> Option<(Arc<Scene>, CameraPath)> {
    let scene = folder().join(format!("{name}.glb"));
    if !scene.exists() {
        eprintln!("skipped: there is no {}", scene.display());
        return None;
    }
    let path = CameraPath::load(&folder().join(format!("{name}.path.json"))).expect("a path");
    Some((Arc::new(Scene::load(&scene).expect("a scene")), path))
}

fn size() -> PictureSize {
    PictureSize::new(1280, 768).expect("a size")
}

fn measure(name: &str, every: usize, budget: Budget) -> Option<Totals> {
    let (scene, path) = load(name)?;
    let settings = MeasureSettings {
        cull: Settings {
            budget,
            ..Settings::new(size())
        },
        cold: true,
        every,
        animate: None,
        simulate_threads: false,
    };
    let report = run(&Prepared::new(scene), &path, &settings, |_, _| {}).expect("threads");
    Some(report.totals)
}

/// Nothing visible is lost, and at least `share` of what the ideal box test finds is found.
fn loses_nothing(name: &str, every: usize, share: f64) -> Option<Totals> {
    let totals = measure(name, every, Budget::All)?;
    assert_eq!((totals.false_culls, totals.wrong_pixels), (0, 0), "{name}");
    let found = totals.culled_of_hidden / totals.ideal_box_culled_of_hidden;
    assert!(found >= share, "{name}: {found:.4} of the ideal box test");
    Some(totals)
}

fn about(what: &str, measured: f64, expected: f64) {
    assert!(
        (measured - expected).abs() <= 0.005,
        "{what}: {measured:.4}, not {expected}"
    );
}

/// The yardsticks themselves were measured before by other code.
#[test]
fn culls_castle_and_sponza_and_agrees_with_earlier_yardsticks() {
    for (name, ideal_box, ideal_face) in [("castle", 0.938, 1.024), ("sponza", 0.820, 1.059)] {
        if let Some(totals) = loses_nothing(name, 1, 0.95) {
            about(name, totals.ideal_box_culled_of_hidden, ideal_box);
            let face = totals.ideal_face_culled_of_hidden / totals.ideal_box_culled_of_hidden;
            about(name, face, ideal_face);
        }
    }
}

#[test]
fn culls_buildings_a_city_and_an_assembly() {
    loses_nothing("clinic", 18, 0.95);
    loses_nothing("cistern", 12, 0.95);
    loses_nothing("delft", 12, 0.95);
    loses_nothing("falcon", 20, 0.87);
}

/// What a frame needs is remembered: on a flight, few triangles hide as much as all of them.
/// A quarter of the picture's size: coarse, and as exact.
#[test]
fn a_quarter_map_loses_nothing() {
    for name in ["castle", "sponza", "clinic", "falcon", "cistern", "delft"] {
        let Some((scene, path)) = load(name) else {
            return;
        };
        for (every, budget) in [(9, Budget::Auto), (24, Budget::All)] {
            let cull = Settings {
                budget,
                map_scale: MapScale::Quarter,
                ..Settings::new(size())
            };
            let settings = MeasureSettings {
                cull,
                cold: true,
                every,
                animate: None,
                simulate_threads: false,
            };
            let prepared = Prepared::new(scene.clone());
            let totals = run(&prepared, &path, &settings, |_, _| {})
                .expect("threads")
                .totals;
            assert_eq!((totals.false_culls, totals.wrong_pixels), (0, 0), "{name}");
            assert!(totals.culled_of_hidden > 0.0, "{name}");
        }
    }
}

#[test]
fn a_flight_needs_few_occluders() {
    for (name, triangles) in [("castle", 2_000.0), ("clinic", 4_000.0)] {
        let Some((scene, _)) = load(name) else {
            continue;
        };
        let file = folder().join(format!("{name}.walk.json"));
        let prepared = Prepared::new(scene);
        let path = CameraPath::load(&file).expect("a path");
        let report = |budget| {
            let settings = MeasureSettings {
                cull: Settings {
                    budget,
                    ..Settings::new(size())
                },
                cold: false,
                every: 12,
                animate: None,
                simulate_threads: false,
            };
            run(&prepared, &path, &settings, |_, _| {}).expect("threads")
        };
        let (few, all) = (report(Budget::Auto), report(Budget::All));
        let totals = &few.totals;
        assert_eq!((totals.false_culls, totals.wrong_pixels), (0, 0), "{name}");
        let share = totals.culled_of_hidden / all.totals.culled_of_hidden;
        assert!(share > 0.98, "{name}: {share} of what all hide");
        let drawn: u64 = few.frames.iter().map(|f| f.occluder_triangles).sum();
        let drawn = drawn as f64 / few.frames.len() as f64;
        assert!(drawn < triangles, "{name}: {drawn} triangles");
    }
}

#[test]
fn the_picture_with_culling_is_the_picture_without() {
    for name in ["castle", "sponza", "clinic", "cistern", "delft", "falcon"] {
        let Some((scene, path)) = load(name) else {
            continue;
        };
        let all: Vec<u32> = (0..scene.objects().len() as u32).collect();
        let mut culler = Culler::new(scene.clone(), Settings::new(size())).expect("threads");
        for camera in path.cameras().iter().step_by(path.cameras().len() / 3) {
            let visible = culler.cull(camera).visible;
            let pictures = [&visible, &all].map(|o| render_image(&scene, camera, size(), o));
            assert!(pictures[0] == pictures[1], "{name}: the pictures differ");
        }
    }
}
