//! A frame like the last one allocates nothing.

use std::path::Path;
use std::sync::Arc;

use antumbra::cull::{Culler, Level, Settings, VisibleSet};
use antumbra::scene::Scene;
use antumbra::view::{CameraPath, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};

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
        let settings = Settings {
            threads: 1,
            level,
            ..Settings::new(PictureSize::new(640, 400).expect("a size"))
        };
        let mut culler = Culler::new(scene.clone(), settings).expect("threads");
        let mut found = VisibleSet::default();
        let mut walk = || {
            allocation_counter::measure(|| {
                for camera in frames {
                    culler.cull_into(camera, &mut found);
                }
            })
        };
        // Once along the way, and all memory is as large as it will be.
        let first = walk();
        assert!(first.count_total > 10, "the counter counts");
        let again = walk();
        assert_eq!(again.count_total, 0, "{level}: {again:?}");
        assert!(found.statistics.occluder_triangles > 1_000);
    }
}
