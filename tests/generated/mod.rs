//! Generated scenes for tests, on the way through a file.

use std::path::Path;
use std::sync::Arc;

use antumbra::scene::Scene;
use antumbra::view::CameraPath;
use antumbra_fixtures::{Kind, Recipe, generate};

/// A scene of 60,000 triangles and its path. No two tests at once may give the same name.
pub fn generated(kind: Kind, name: &str) -> (Arc<Scene>, CameraPath) {
    let fixture = generate(&Recipe {
        triangles: Some(60_000),
        ..Recipe::new(kind)
    })
    .expect("enough triangles");
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("generated-{name}.glb"));
    let out = std::fs::File::create(&file).expect("the file can be written");
    fixture.write_glb(out).expect("the file can be written");
    let scene = Scene::load(&file).expect("a sound file");
    let _ = std::fs::remove_file(&file);
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
    (Arc::new(scene), path)
}
