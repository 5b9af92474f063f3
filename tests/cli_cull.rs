//! `cull` prints the visible sets that the library finds.

mod cli;

use std::path::Path;

use antumbra::cull::{Culler, Settings};
use antumbra::scene::Scene;
use antumbra::view::{CameraPath, PictureSize};
use cli::{Folder, stdout, succeed};

fn cull_yard(folder: &Folder, more: &[&str]) -> String {
    let (scene, path) = (folder.file("yard.obj"), folder.file("yard.path.json"));
    let fixed = ["cull", &scene, "--path", &path, "--size", "320x192"];
    stdout(&succeed(&[&fixed[..], more].concat()))
}

#[test]
fn a_line_a_frame_names_the_visible_objects() {
    let folder = Folder::new("cull").with_scene();
    // The wall and what is beside it; the last frame looks away.
    assert_eq!(cull_yard(&folder, &[]), "0: 0 2\n1: 0 2\n2:\n");
    let cold = cull_yard(
        &folder,
        &["--cold", "--every", "2", "--occluders", "nearest"],
    );
    assert_eq!(cold, "0: 0 2\n2:\n");
}

#[test]
fn the_library_finds_the_same() {
    let folder = Folder::new("cull-library").with_scene();
    let file = folder.file("yard.obj");
    let scene = Scene::load(Path::new(&file)).expect("a scene");
    let path = CameraPath::load(Path::new(&folder.file("yard.path.json"))).expect("a path");
    let size = PictureSize::new(320, 192).expect("a size");
    let mut culler = Culler::new(scene.into(), Settings::new(size)).expect("threads");
    let line = |(frame, camera)| {
        let visible = culler.cull(camera).visible;
        let objects: Vec<_> = visible.iter().map(|o| format!(" {o}")).collect();
        format!("{frame}:{}\n", objects.concat())
    };
    let lines: String = path.cameras().iter().enumerate().map(line).collect();
    assert_eq!(cull_yard(&folder, &[]), lines);
}
