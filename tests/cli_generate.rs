//! `generate` and `demo` make something out of nothing.

mod cli;

use cli::{Folder, antumbra, stderr, stdout, succeed};

#[test]
fn a_generated_scene_renders_along_its_own_path() {
    let folder = Folder::new("generate_city");
    let (scene, path) = (folder.file("town.glb"), folder.file("town.path.json"));
    let text = stdout(&succeed(&[
        "generate",
        "city",
        "--triangles",
        "30000",
        "--seed",
        "7",
        "-o",
        &scene,
    ]));
    assert!(text.contains("30,000 triangles"), "{text}");
    assert!(text.contains("town.path.json"), "{text}");
    let out = folder.file("out");
    let text = stdout(&succeed(&[
        "render", &scene, "--path", &path, "--size", "320x192", "--every", "60", "--check",
        "--out", &out,
    ]));
    assert!(text.contains("30,000 triangles"), "{text}");
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let folder = Folder::new("generate_seed");
    let bytes = |name: &str, seed: &str| {
        let file = folder.file(name);
        succeed(&[
            "generate",
            "city",
            "--triangles",
            "20000",
            "--seed",
            seed,
            "-o",
            &file,
        ]);
        std::fs::read(&file).expect("the scene")
    };
    let first = bytes("a.glb", "3");
    assert!(first == bytes("b.glb", "3"));
    assert!(first != bytes("c.glb", "4"));
}

#[test]
fn a_count_that_cannot_be_met_is_an_error() {
    let folder = Folder::new("generate_few");
    let output = antumbra(&[
        "generate",
        "city",
        "--triangles",
        "5",
        "-o",
        &folder.file("x.glb"),
    ]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).starts_with("error: city"),
        "{}",
        stderr(&output)
    );
    assert!(folder.names().is_empty());
}

#[test]
fn the_demo_leaves_pictures_and_a_page_that_shows_them() {
    let folder = Folder::new("demo");
    let out = folder.file("walk");
    let text = stdout(&succeed(&[
        "demo",
        "--frames",
        "2",
        "--triangles",
        "30000",
        "--out",
        &out,
    ]));
    assert!(text.contains("0 wrong pixels"), "{text}");
    assert!(text.contains("index.html"), "{text}");
    let page = std::fs::read_to_string(format!("{out}/index.html")).expect("the page");
    let mut shown = 0;
    for link in page.split("src=\"").skip(1) {
        let name = link.split('"').next().expect("a name");
        image::open(format!("{out}/{name}")).expect("a picture");
        shown += 1;
    }
    assert!(shown >= 2, "{page}");
}
