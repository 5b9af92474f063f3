//! `prepare` writes an archive, and every command takes it in place of a scene.

mod cli;

use cli::{Folder, antumbra, stderr, stdout, succeed};

/// A report without what differs from run to run.
fn without_times(json: &str) -> serde_json::Value {
    let mut report: serde_json::Value = serde_json::from_str(json).expect("JSON");
    for frame in report["frames"].as_array_mut().expect("frames") {
        frame["time_us"].take();
    }
    report["totals"]["time_us_mean"].take();
    report
}

#[test]
fn an_archive_measures_as_its_scene_does() {
    let folder = Folder::new("prepare_measure").with_scene();
    let (scene, archive) = (folder.file("yard.obj"), folder.file("yard.antumbra"));
    let text = stdout(&succeed(&["prepare", &scene, "-o", &archive]));
    let bytes = std::fs::metadata(&archive).expect("written").len();
    let bytes = format!("{},{:03} bytes", bytes / 1000, bytes % 1000);
    for part in ["3 objects", "36 triangles", "3 clusters of 36", &bytes] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    let path = folder.file("yard.path.json");
    let measured = |scene: &str| {
        let arguments = [
            "measure", scene, "--path", &path, "--size", "320x192", "--json", "-",
        ];
        without_times(&stdout(&succeed(&arguments)))
    };
    let from_scene = measured(&scene);
    assert_eq!(measured(&archive), from_scene);
    assert!(from_scene["frames"][0]["culled"].as_u64() > Some(0));
    // Not the name tells.
    let unnamed = folder.file("yard");
    std::fs::copy(&archive, &unnamed).expect("copied");
    assert_eq!(measured(&unnamed), from_scene);
}

#[test]
fn an_archive_renders_sweeps_and_prepares() {
    let folder = Folder::new("prepare_others").with_scene();
    let (scene, archive) = (folder.file("yard.obj"), folder.file("yard.antumbra"));
    succeed(&["prepare", &scene, "-o", &archive]);
    let (path, out) = (folder.file("yard.path.json"), folder.file("out"));
    succeed(&[
        "render", &archive, "--path", &path, "--size", "160x96", "--check", "--out", &out,
    ]);
    succeed(&[
        "sweep",
        &archive,
        "--path",
        &path,
        "--size",
        "160x96",
        "--budgets",
        "10",
        "--out",
        &out,
    ]);
    let again = folder.file("again.antumbra");
    succeed(&["prepare", &archive, "-o", &again]);
    let read = |file: &str| std::fs::read(file).expect("written");
    assert!(read(&again) == read(&archive));
}

#[test]
fn what_cannot_be_prepared_is_said_and_nothing_is_lost() {
    let folder = Folder::new("prepare_failures").with_scene();
    let (scene, archive) = (folder.file("yard.obj"), folder.file("yard.antumbra"));
    succeed(&["prepare", &scene, "-o", &archive]);
    let before = folder.names();
    let fails = |arguments: &[&str], cause: &str| {
        let output = antumbra(arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(stderr(&output).contains(cause), "{}", stderr(&output));
    };
    let read = |file: &str| std::fs::read(file).expect("there");
    let [text, sound] = [&scene, &archive].map(|file| read(file));
    fails(&["prepare", &scene, "-o", &scene], "would be replaced");
    fails(&["prepare", &archive, "-o", &archive], "would be replaced");
    fails(
        &["prepare", &folder.file("none.glb"), "-o", &archive],
        "none.glb",
    );
    fails(
        &["prepare", &scene, "-o", &folder.file("none/yard.antumbra")],
        "cannot be written",
    );
    assert!(read(&scene) == text && read(&archive) == sound);
    assert_eq!(folder.names(), before);

    let mut damaged = sound;
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    std::fs::write(&archive, damaged).expect("written");
    fails(&["render", &archive], "antumbra prepare");
}
