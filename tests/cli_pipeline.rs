//! `pipeline` compares frames one by one with frames in a pipeline.

mod cli;

use cli::{Folder, antumbra, stderr, stdout, succeed};
use serde_json::Value;

/// The path has three frames.
fn run_yard(folder: &Folder, more: &[&str]) -> String {
    let (scene, path) = (folder.file("yard.obj"), folder.file("yard.path.json"));
    let fixed = ["pipeline", &scene, "--path", &path, "--size", "320x192"];
    stdout(&succeed(&[&fixed[..], more].concat()))
}

#[test]
fn every_schedule_is_compared_with_frames_one_by_one() {
    let folder = Folder::new("pipeline").with_scene();
    let json = run_yard(
        &folder,
        &["--threads", "2", "--repeats", "2", "--json", "-"],
    );
    let report: Value = serde_json::from_str(&json).expect("JSON alone");
    let flows = report["flows"].as_array().expect("a list");
    let of = |flow: &Value| (flow["name"].to_string(), flow["threads"].as_u64());
    let names: Vec<_> = flows.iter().map(of).collect();
    let expected = [
        ("frame by frame", 1),
        ("frame by frame", 2),
        ("sequential", 1),
        ("two-stage", 2),
        ("three-stage", 3),
        ("three-processes", 3),
    ];
    let expected = expected.map(|(name, threads)| (format!("{name:?}"), Some(threads)));
    assert_eq!(names, expected);
    for flow in flows {
        // The wall and, in two of three frames, the box beside it.
        let visible = flow["objects_visible"].as_f64().expect("a number");
        assert!((visible - 4.0 / 3.0).abs() < 1e-9, "{flow}");
        let stages = flow["stages_us"].as_array().expect("a list");
        let all: f64 = stages.iter().filter_map(Value::as_f64).sum();
        let longest = flow["longest_place_us"].as_f64().expect("a number");
        assert!(longest <= all * 1.000_001 && all <= longest * 3.0, "{flow}");
        for times in ["frame_us", "latency_us", "latency_95_us"] {
            let time = |which: &str| flow[times][which].as_f64().expect("a number");
            assert!(
                0.0 < time("least") && time("least") <= time("median"),
                "{flow}"
            );
        }
    }
}

#[test]
fn a_final_draw_elsewhere_takes_its_time() {
    let folder = Folder::new("pipeline-elsewhere").with_scene();
    let arguments = [
        "--schedule",
        "two-stage",
        "--draw",
        "3ms",
        "--threads",
        "1",
        "--json",
    ];
    let file = folder.file("flows.json");
    let said = run_yard(&folder, &[&arguments[..], &[&file]].concat());
    assert!(said.contains("final draw: 3000us"), "{said}");
    let json = std::fs::read_to_string(&file).expect("a report");
    let report: Value = serde_json::from_str(&json).expect("JSON");
    let flows = report["flows"].as_array().expect("a list");
    assert_eq!(flows.len(), 2);
    for flow in flows {
        assert!(
            said.contains(flow["name"].as_str().expect("a name")),
            "{said}"
        );
        assert!(flow["frame_us"]["least"].as_f64() >= Some(3000.0), "{flow}");
    }
}

#[test]
fn an_unknown_schedule_or_draw_is_a_usage_error() {
    for wrong in [["--schedule", "four-stage"], ["--draw", "3"]] {
        let fixed = ["pipeline", "a.glb", "--path", "p.json"];
        let output = antumbra(&[&fixed[..], &wrong].concat());
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
        assert!(stderr(&output).contains(wrong[1]), "{wrong:?}");
    }
}
