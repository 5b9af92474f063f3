//! On request, clusters are named: every one that owns a pixel, and most others are not.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use antumbra::cull::{Culler, Effort, Settings, VisibleSet};
use antumbra::measure::Oracle;
use antumbra::prepare::ClusterId;
use antumbra::scene::Scene;
use antumbra::view::{CameraPath, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};

/// A generated scene, and its path.
fn generated(kind: Kind, triangles: u64) -> (Arc<Scene>, CameraPath) {
    let fixture = generate(&Recipe {
        triangles: Some(triangles),
        ..Recipe::new(kind)
    });
    let fixture = fixture.expect("enough triangles");
    let file =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("clusters-{kind}-{triangles}.glb"));
    let out = BufWriter::new(File::create(&file).expect("a file"));
    fixture.write_glb(out).expect("the file can be written");
    let scene = Scene::load(&file).expect("a scene");
    std::fs::remove_file(&file).expect("its file");
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
    (Arc::new(scene), path)
}

#[test]
fn every_cluster_that_owns_a_pixel_is_named() {
    let size = PictureSize::new(320, 192).expect("a size");
    for (kind, triangles) in [(Kind::PowerPlant, 300_000), (Kind::City, 100_000)] {
        let (scene, path) = generated(kind, triangles);
        // A few hidden objects are not worth finding, but hidden clusters are what this is about.
        let settings = Settings {
            threads: 1,
            effort: Effort::FULL,
            ..Settings::new(size)
        };
        let mut culler = Culler::new(scene.clone(), settings).expect("threads");
        let clusters = culler.clusters().clone();
        let oracle = Oracle::new(&scene, &clusters);
        let mut found = VisibleSet::default();
        let (mut named, mut of_objects, mut owners) = (0, 0, 0);
        for camera in path.cameras().iter().step_by(12) {
            culler.cull_into(camera, &mut found);
            let mut whole = Vec::new();
            let visible = culler.visible_clusters(&found, &mut whole);
            assert!(visible.is_sorted_by(|a, b| a < b));
            let several = |object: u32| match culler.occluder_of(object) {
                Some(mesh) if mesh.clusters().len() > 1 => mesh.clusters().len(),
                _ => 0,
            };
            for owner in oracle.owners(camera, size) {
                let is_named = visible.binary_search(&owner.id).is_ok()
                    || whole.binary_search(&owner.id.object).is_ok();
                assert!(is_named, "{kind}: {:?} owns {}", owner.id, owner.pixels);
                owners += usize::from(several(owner.id.object) > 0);
            }
            let objects = found.visible.iter().filter(|o| !whole.contains(o));
            of_objects += objects.map(|&object| several(object)).sum::<usize>();
            let of_several = visible.iter().filter(|id| several(id.object) > 0);
            named += of_several.count();
            for &ClusterId { object, .. } in &visible {
                assert!(found.visible.binary_search(&object).is_ok());
            }
        }
        // Of the plant, whose pipes reach everywhere, more than half of those that own nothing are not.
        let (left_out, own_nothing) = (of_objects - named, of_objects - owners);
        let most = if kind == Kind::PowerPlant {
            own_nothing / 2
        } else {
            0
        };
        assert!(
            named >= owners && left_out > most,
            "{kind}: {named} of {of_objects}, {owners} own pixels"
        );
    }
}

#[test]
fn nothing_is_named_before_the_first_frame() {
    let (scene, _) = generated(Kind::City, 20_000);
    let size = PictureSize::new(64, 64).expect("a size");
    let culler = Culler::new(scene, Settings::new(size)).expect("threads");
    let mut whole = Vec::new();
    let visible = culler.visible_clusters(&VisibleSet::default(), &mut whole);
    assert!(visible.is_empty() && whole.is_empty());
}
