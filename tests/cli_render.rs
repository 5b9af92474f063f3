//! `render` writes pictures, and fails with the file's name where it cannot.

mod cli;

use cli::{Folder, antumbra, stderr, stdout, succeed};

#[test]
fn writes_one_picture_a_frame_and_says_what_was_culled() {
    let folder = Folder::new("render_path").with_scene();
    let out = folder.file("pictures");
    let output = succeed(&[
        "render",
        &folder.file("yard.obj"),
        "--path",
        &folder.file("yard.path.json"),
        "--size",
        "211x97",
        "--out",
        &out,
    ]);
    let text = stdout(&output);
    assert!(text.contains("3 objects, 36 triangles; 3 frames"), "{text}");
    assert!(text.contains("2 culled"), "{text}");
    assert!(stderr(&output).is_empty(), "{}", stderr(&output));
    for frame in 0..3 {
        let picture = image::open(format!("{out}/frame_{frame:04}.png")).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (211, 97));
    }
}

#[test]
fn the_picture_with_culling_is_the_picture_without() {
    let folder = Folder::new("render_check").with_scene();
    let (scene, path) = (folder.file("yard.obj"), folder.file("yard.path.json"));
    let out = folder.file("out");
    let arguments = [
        "render", &scene, "--path", &path, "--check", "--size", "320x200", "--out", &out,
    ];
    let text = stdout(&succeed(&arguments));
    assert!(text.contains("byte for byte"), "{text}");
}

#[test]
fn shows_the_scene_from_outside_without_a_path() {
    let folder = Folder::new("render_outside").with_scene();
    let out = folder.file("out");
    succeed(&[
        "render",
        &folder.file("yard.obj"),
        "--size",
        "320x200",
        "--out",
        &out,
    ]);
    let picture = image::open(format!("{out}/frame_0000.png"))
        .expect("a picture")
        .to_rgb8();
    // The middle is not the sky above it.
    assert_ne!(picture.get_pixel(160, 100), picture.get_pixel(160, 2));
}

#[test]
fn every_takes_every_nth_frame_and_overlay_draws_sheets_beside() {
    let folder = Folder::new("render_overlay").with_scene();
    let pictures = Folder::new("render_overlay_out");
    succeed(&[
        "render",
        &folder.file("yard.obj"),
        "--path",
        &folder.file("yard.path.json"),
        "--size",
        "200x120",
        "--every",
        "2",
        "--overlay",
        "--out",
        &pictures.file(""),
    ]);
    let names = [
        "frame_0000.png",
        "frame_0002.png",
        "overlay_0000.png",
        "overlay_0002.png",
    ];
    assert_eq!(pictures.names(), names);
    let sheet = image::open(pictures.file("overlay_0000.png")).expect("a picture");
    assert!(sheet.width() > 200 && sheet.height() > 120);
}

#[test]
fn any_number_of_threads_draws_the_same_bytes() {
    let folder = Folder::new("render_threads").with_scene();
    let (scene, path) = (folder.file("yard.obj"), folder.file("yard.path.json"));
    let bytes_with = |threads: &str| {
        let out = folder.file(threads);
        let arguments = [
            "render",
            &scene,
            "--path",
            &path,
            "--size",
            "300x200",
            "--threads",
            threads,
            "--every",
            "9",
            "--out",
            &out,
        ];
        succeed(&arguments);
        std::fs::read(format!("{out}/frame_0000.png")).expect("a picture")
    };
    let one = bytes_with("1");
    for threads in ["2", "5"] {
        assert!(bytes_with(threads) == one, "{threads} threads");
    }
}

#[test]
fn errors_name_the_file_and_exit_with_1() {
    let folder = Folder::new("render_errors").with_scene();
    let garbage = folder.file("garbage.glb");
    std::fs::write(&garbage, b"glTF and then nothing").expect("written");
    let no_path = folder.file("no.path.json");
    std::fs::write(
        &no_path,
        r#"{"fov_y_degrees": 60, "near": 0.1, "frames": []}"#,
    )
    .expect("written");
    let (scene, missing) = (folder.file("yard.obj"), folder.file("missing.glb"));
    // A folder cannot be made where a file is.
    let taken = folder.file("yard.path.json");
    let wrong: [(&[&str], &str); 5] = [
        (&["render", &missing], "missing.glb"),
        (&["render", &garbage], "garbage.glb"),
        (&["render", &scene, "--path", &no_path], "no.path.json"),
        (&["render", &scene, "--path", &missing], "missing.glb"),
        (
            &["render", &scene, "--size", "8x8", "--out", &taken],
            "yard.path.json",
        ),
    ];
    for (arguments, name) in wrong {
        let output = antumbra(arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let text = stderr(&output);
        assert!(text.starts_with("error: "), "{text}");
        assert!(text.contains(name), "{text}");
        assert!(!text.contains("panicked"), "{text}");
    }
}

#[cfg(not(feature = "gpu"))]
#[test]
fn a_build_without_the_gpu_pass_says_how_to_get_it_and_exits_with_3() {
    let folder = Folder::new("render_no_gpu").with_scene();
    let output = antumbra(&["render", &folder.file("yard.obj"), "--final-pass", "gpu"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(
        stderr(&output).contains("--features gpu"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn pictures_by_the_cpu_compare_as_equal() {
    let folder = Folder::new("render_compare").with_scene();
    let arguments = [
        "render",
        &folder.file("yard.obj"),
        "--size",
        "99x77",
        "--compare",
    ];
    let out = folder.file("out");
    let text = stdout(&succeed(&[&arguments[..], &["--out", &out]].concat()));
    assert!(text.contains("0.0000 % of the pixels differ"), "{text}");
}
