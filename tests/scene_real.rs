//! The real scenes, where the folder named by `ANTUMBRA_SCENES` (default `../shared/scenes`) has them.

use std::path::PathBuf;
use std::time::Instant;

use antumbra::scene::{Alpha, Scene};

fn scene(name: &str) -> Option<Scene> {
    let folder = std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    );
    let path = folder.join(name);
    if !path.exists() {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    }
    let begun = Instant::now();
    let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    eprintln!(
        "{name}: {:?}, hierarchy {} levels deep",
        begun.elapsed(),
        scene.bvh().depth()
    );
    assert_eq!(scene.warnings(), [""; 0]);
    assert_eq!(scene.bvh().validate(scene.bounds()), Ok(()));
    Some(scene)
}

#[test]
fn every_object_and_triangle_is_there() {
    for (name, objects, triangles) in [
        ("castle.glb", 2_510, 48_700),
        ("sponza.glb", 6_353, 262_266),
        ("clinic.glb", 10_157, 1_353_299),
        ("cistern.glb", 357, 67_887),
        ("delft.glb", 570, 36_267),
    ] {
        let Some(scene) = scene(name) else { continue };
        assert_eq!(
            (scene.objects().len(), scene.triangle_count()),
            (objects, triangles),
            "{name}"
        );
    }
}

#[test]
fn instances_share_their_meshes_and_may_be_mirrored() {
    let Some(scene) = scene("falcon.glb") else {
        return;
    };
    assert_eq!((scene.objects().len(), scene.meshes().len()), (5_342, 252));
    assert_eq!(
        scene.objects().iter().filter(|o| o.is_mirrored()).count(),
        42
    );
    assert_eq!((scene.triangle_count() + 5_000) / 10_000, 516);
}

#[test]
fn translucent_objects_are_told_apart() {
    for (name, translucent) in [("clinic.glb", 937), ("cistern.glb", 44)] {
        let Some(scene) = scene(name) else { continue };
        let blends = |mesh: usize| {
            scene.meshes()[mesh]
                .surfaces
                .iter()
                .any(|s| s.material.alpha == Alpha::Blend)
        };
        assert_eq!(
            scene.objects().iter().filter(|o| blends(o.mesh)).count(),
            translucent,
            "{name}"
        );
    }
}
