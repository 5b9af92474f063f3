//! `measure` keeps its contract: the keys of its JSON, and nothing else on stdout.

mod cli;

use cli::{Folder, antumbra, stderr, stdout, succeed};
use serde_json::Value;

fn measure(folder: &Folder, more: &[&str]) -> std::process::Output {
    let (scene, path) = (folder.file("yard.obj"), folder.file("yard.path.json"));
    let mut arguments = vec!["measure", &scene, "--path", &path, "--size", "320x192"];
    arguments.extend(more);
    succeed(&arguments)
}

#[test]
fn json_on_stdout_is_alone_and_has_the_keys_of_the_contract() {
    let folder = Folder::new("measure_json").with_scene();
    let output = measure(&folder, &["--json", "-"]);
    assert!(stderr(&output).is_empty(), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON alone");

    let has = |value: &Value, keys: &[&str]| {
        for key in keys {
            assert!(value.get(key).is_some(), "no {key} in {value}");
        }
    };
    const TIMES: [&str; 5] = ["select", "raster", "pyramid", "test", "total"];
    has(&report, &["scene", "settings", "frames", "totals"]);
    has(&report["scene"], &["objects", "triangles"]);
    has(
        &report["totals"],
        &[
            "time_us_mean",
            "culled_of_hidden",
            "ideal_box_culled_of_hidden",
            "ideal_face_culled_of_hidden",
            "false_culls",
            "wrong_pixels",
            "wrong_pixel_fraction",
        ],
    );
    has(&report["totals"]["time_us_mean"], &TIMES);
    let frames = report["frames"].as_array().expect("a list");
    assert_eq!(frames.len(), 3);
    for frame in frames {
        has(
            frame,
            &[
                "time_us",
                "in_frustum",
                "exactly_visible",
                "exactly_hidden",
                "sampleless",
                "culled",
                "false_culls",
                "wrong_pixels",
                "triangles_in_frustum",
                "triangles_drawn",
                "occluder_triangles",
                "buffer_hash",
            ],
        );
        has(&frame["time_us"], &TIMES);
        let hash = frame["buffer_hash"].as_str().expect("a text");
        assert!(
            hash.len() == 16 && hash.chars().all(|c| c.is_ascii_hexdigit()),
            "{hash}"
        );
        let stages: f64 = TIMES[..4]
            .iter()
            .map(|s| frame["time_us"][s].as_f64().expect("a time"))
            .sum();
        let total = frame["time_us"]["total"].as_f64().expect("a time");
        assert!((stages - total).abs() < 0.01, "{stages} is not {total}");
    }
    assert_eq!(report["scene"]["objects"], 3);
    assert_eq!(report["scene"]["triangles"], 36);
    assert_eq!(frames[0]["exactly_hidden"], 1);
    assert_eq!(frames[0]["culled"], 1);
    assert_eq!(report["totals"]["false_culls"], 0);
    assert_eq!(report["totals"]["wrong_pixels"], 0);
}

#[test]
fn every_option_of_the_contract_is_taken() {
    let folder = Folder::new("measure_options").with_scene();
    let output = measure(
        &folder,
        &[
            "--threads",
            "1",
            "--simd",
            "scalar",
            "--accuracy",
            "approximate",
            "--hole",
            "16",
            "--occluders",
            "nearest",
            "--budget",
            "24",
            "--cold",
            "--depth",
            "no-background",
            "--map-scale",
            "1",
            "--every",
            "2",
            "--json",
            "-",
        ],
    );
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let settings = &report["settings"];
    assert_eq!(settings["threads"], 1);
    assert_eq!(settings["simd"], "scalar");
    assert_eq!(settings["accuracy"], "approximate");
    assert_eq!(settings["hole"], 16);
    assert_eq!(settings["budget"], "24");
    assert_eq!(settings["cold"], true);
    assert_eq!(settings["every"], 2);
    let frames = report["frames"].as_array().expect("a list");
    assert_eq!(frames.len(), 2);
    for frame in frames {
        assert!(frame["occluder_triangles"].as_u64().expect("a count") <= 24);
    }
}

#[test]
fn every_depth_representation_is_taken_and_reported() {
    let folder = Folder::new("measure_depth").with_scene();
    for depth in ["plane", "estimation", "no-background", "hierarchical"] {
        let output = measure(&folder, &["--depth", depth, "--json", "-"]);
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(report["settings"]["depth"], depth);
        assert_eq!(report["settings"]["nth"], 1);
        assert_eq!(report["totals"]["false_culls"], 0);
    }
    let approximate = ["--accuracy", "approximate", "--json", "-"];
    let nth = ["--depth", "hierarchical", "--nth", "4", "--map-scale", "1"];
    let output = measure(&folder, &[&approximate[..], &nth].concat());
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report["settings"]["nth"], 4);
}

#[test]
fn depth_options_that_do_not_go_together_are_usage_errors() {
    let folder = Folder::new("measure_depth_errors").with_scene();
    let (scene, path) = (folder.file("yard.obj"), folder.file("yard.path.json"));
    for (options, named) in [
        (&["--depth", "plane", "--map-scale", "2"][..], "--map-scale"),
        (&["--depth", "hierarchical", "--nth", "2"], "approximate"),
        (
            &["--nth", "2", "--accuracy", "approximate"],
            "--depth hierarchical",
        ),
        (&["--depth", "hierarchical", "--nth", "0"], "--nth"),
        (&["--depth", "w-buffer"], "estimation"),
    ] {
        let arguments = ["measure", &scene, "--path", &path];
        let output = antumbra(&[&arguments[..], options].concat());
        assert_eq!(output.status.code(), Some(2), "{options:?}");
        let said = stderr(&output);
        assert!(said.contains(named), "{options:?}: {said}");
    }
}

#[test]
fn people_get_a_table_and_files_get_the_json() {
    let folder = Folder::new("measure_table").with_scene();
    let file = folder.file("report.json");
    let table = stdout(&measure(&folder, &["--json", &file]));
    assert!(table.contains("3 objects, 36 triangles"), "{table}");
    assert!(table.contains("wrong pixels: 0"), "{table}");
    let json = std::fs::read(&file).expect("the report");
    serde_json::from_slice::<Value>(&json).expect("JSON");
    assert!(stdout(&measure(&folder, &[])).contains("false culls: 0"));
}

#[cfg(unix)]
#[test]
fn a_reader_that_leaves_does_not_make_it_panic() {
    use std::process::{Command, Stdio};

    let folder = Folder::new("measure_pipe").with_scene();
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let output = Command::new(cli::EXE)
        .args([
            "measure",
            &folder.file("yard.obj"),
            "--path",
            &folder.file("yard.path.json"),
        ])
        .args(["--size", "64x64", "--json", "-"])
        .stdout(writer)
        .stderr(Stdio::piped())
        .output()
        .expect("the command starts");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn more_threads_are_simulated_on_request() {
    let folder = Folder::new("measure_simulated").with_scene();
    let output = measure(&folder, &["--json", "-"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(report.get("simulated").is_none());

    let output = measure(&folder, &["--simulate-threads", "--json", "-"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let simulated = report["simulated"].as_array().expect("a list");
    let threads: Vec<u64> = simulated
        .iter()
        .map(|prediction| prediction["threads"].as_u64().expect("a number"))
        .collect();
    assert_eq!(threads, [2, 4, 8, 16, 32, 64]);
    for prediction in simulated {
        assert!(prediction["time_us"].as_f64().expect("a time") > 0.0);
        assert!(prediction["speed_up"].as_f64().expect("a ratio") > 0.0);
        let share = prediction["limited_share"].as_f64().expect("a share");
        assert!((0.0..=1.0).contains(&share), "{share}");
        assert!(
            !prediction["limited_by"]
                .as_str()
                .expect("a text")
                .is_empty()
        );
    }

    let output = measure(&folder, &["--simulate-threads"]);
    assert!(stdout(&output).contains("speed-up"), "{}", stdout(&output));
}

#[test]
fn settings_say_how_occluders_were_chosen() {
    let folder = Folder::new("measure_choice").with_scene();
    let settings = |more: &[&str]| {
        let mut arguments = vec!["--json", "-"];
        arguments.extend(more);
        let output = measure(&folder, &arguments);
        let mut report: Value = serde_json::from_slice(&output.stdout).expect("JSON alone");
        assert_eq!(report["totals"]["false_culls"], 0, "{more:?}");
        report["settings"].take()
    };
    let plain = settings(&[]);
    assert_eq!(plain["budget"], "auto");
    assert_eq!(plain["static_criteria"], "none");
    assert_eq!(plain["frames_back"], 1);
    assert_eq!(plain["most_active"], Value::Null);
    let least = plain["least_compactness"].as_f64().expect("a number");
    assert!((least - 0.3).abs() < 1e-6, "{least}");
    let by_time = settings(&["--budget", "0.2ms"]);
    assert_eq!(by_time["budget"], "200us");
    assert_eq!(settings(&["--budget", "0us"])["budget"], "0us");
    let all = settings(&["--occluders", "nearest", "--static-criteria"]);
    assert_eq!(
        all["static_criteria"],
        "size,locality,complexity,redundancy"
    );
    let some = settings(&[
        "--occluders",
        "weight",
        "--static-criteria=size,redundancy",
        "--compactness",
        "0.5",
        "--active",
        "20",
    ]);
    assert_eq!(some["static_criteria"], "size,redundancy");
    assert_eq!(some["least_compactness"], 0.5);
    assert_eq!(some["most_active"], 20);
    let back = settings(&["--occluders", "previous-visible", "--frames-back", "2"]);
    assert_eq!(back["frames_back"], 2);
}
