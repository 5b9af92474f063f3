//! However much a file claims, loading it takes less than ten times its size plus 64 MiB, and ends soon.
//!
//! Peak memory is a process's, so each file is loaded by a child: this program once more, told the file's name.
#![cfg(target_os = "linux")]

mod scene_files;

use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use antumbra::scene::Scene;
use scene_files::*;
use serde_json::json;

const FILE: &str = "ANTUMBRA_TEST_LOADS";

/// Not a claim of its own: what the other tests run in a process of its own, with a file to load.
#[test]
fn child() {
    let Some(path) = std::env::var_os(FILE) else {
        return;
    };
    let result = Scene::load(Path::new(&path))
        .map(|scene| scene.objects().len())
        .map_err(|error| error.to_string());
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .unwrap()
        .replace("kB", "");
    println!("\npeak {} {result:?}", peak.trim());
}

#[track_caller]
fn assert_modest(name: &str, bytes: impl AsRef<[u8]>, expected: &str) {
    let (folder, bytes) = (Folder::new(), bytes.as_ref());
    let path = folder.write(name, bytes);
    let begun = Instant::now();
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "child", "--nocapture"])
        .env(FILE, &path)
        .output()
        .unwrap();
    let took = begun.elapsed();
    let output = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    let line = output
        .lines()
        .find_map(|line| line.strip_prefix("peak "))
        .unwrap_or_else(|| panic!("{output}"));
    let (peak, result) = line.split_once(' ').unwrap();
    let peak: usize = peak.parse::<usize>().unwrap() * 1024;
    let limit = 10 * bytes.len() + (64 << 20);
    eprintln!(
        "{:>6} KiB file, peak {:>6} KiB of {:>6}, {took:?}: {result}",
        bytes.len() >> 10,
        peak >> 10,
        limit >> 10
    );
    assert!(result.contains(expected), "{result}");
    assert!(peak < limit, "{peak} bytes for a file of {}", bytes.len());
    assert!(took < Duration::from_secs(20), "{took:?}");
}

fn repeated(text: &str, bytes: usize) -> String {
    text.repeat(bytes / text.len())
}

#[test]
fn records_of_three_bytes() {
    let list = repeated("{},", 6_000_000);
    for kind in ["nodes", "materials", "scenes", "unknown"] {
        let json = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"{kind}\":[{list}{{}}]}}");
        assert_modest("scene.gltf", json, "its JSON: would take");
    }
    let numbers = repeated("0,", 6_000_000);
    for (before, after) in [
        ("\"scenes\":[{\"nodes\":[", "0]}]"),
        ("\"nodes\":[{\"weights\":[", "0]}]"),
        ("\"x\":[", "0]"),
    ] {
        let json = format!("{{\"asset\":{{\"version\":\"2.0\"}},{before}{numbers}{after}}}");
        assert_modest("scene.gltf", json, "");
    }
}

#[test]
fn small_records_that_are_just_allowed() {
    let nodes: Vec<String> = (1..200_000)
        .map(|i| format!("{{\"children\":[{i}]}}"))
        .collect();
    let json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{},{{}}]}}",
        nodes.join(",")
    );
    assert_modest("scene.gltf", json, "");
    let mut gltf = Gltf::triangle();
    let instance = json!({"mesh": 0});
    gltf.json["nodes"]
        .as_array_mut()
        .unwrap()
        .extend(std::iter::repeat_n(instance, 60_000));
    gltf.json["scenes"][0]["nodes"] = json!((0..60_000).collect::<Vec<_>>());
    assert_modest("scene.glb", gltf.glb(), "Ok(60000)");
}

#[test]
fn counts_beyond_reason() {
    let mut gltf = Gltf::new();
    let (at, values) = (gltf.view(&[0]), gltf.view(&[0; 12]));
    for count in [3_000_000_000u64, u64::MAX / 3 * 3] {
        let mut gltf = gltf.clone();
        let position = gltf.raw_accessor(json!({"componentType": FLOAT, "type": "VEC3", "count": count,
            "sparse": {"count": 1, "indices": {"bufferView": at, "componentType": UNSIGNED_BYTE}, "values": {"bufferView": values}}}));
        let mesh = gltf.mesh("m", json!([{"attributes": {"POSITION": position}}]));
        gltf.root(json!({"mesh": mesh}));
        assert_modest("scene.glb", gltf.glb(), "would take");
        // Or that many instances, or an index into that many vertices.
        let mut gltf = Gltf::triangle();
        gltf.json["accessors"].as_array_mut().unwrap().push(json!({"componentType": FLOAT, "type": "VEC3", "count": count,
            "sparse": {"count": 0, "indices": {"bufferView": 0, "componentType": UNSIGNED_BYTE}, "values": {"bufferView": 0}}}));
        let mut placed = gltf.clone();
        placed.json["nodes"][0]["extensions"] =
            json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}});
        assert_modest("scene.glb", placed.glb(), "its instances: would take");
        gltf.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(2);
        assert_modest("scene.glb", gltf.glb(), "Ok(1)");
    }
}

#[test]
fn many_meshes_over_the_same_bytes() {
    for mode in [4, 5] {
        let mut gltf = Gltf::new();
        let position = gltf.positions(&vec![[1.0, 2.0, 3.0]; 30_000]);
        let indices = gltf.indices(UNSIGNED_SHORT, &(0..30_000).collect::<Vec<_>>());
        for _ in 0..3_000 {
            let mesh = gltf.mesh(
                "m",
                json!([{"attributes": {"POSITION": position}, "indices": indices, "mode": mode}]),
            );
            gltf.root(json!({"mesh": mesh}));
        }
        assert_modest("scene.glb", gltf.glb(), "would take");
    }
}

#[test]
fn sharing_that_doubles_with_every_level() {
    let mut gltf = Gltf::new();
    let mesh = gltf.triangle_mesh("m");
    gltf.root(json!({"children": [1, 1]}));
    for i in 1..60 {
        gltf.node(json!({"children": [i + 1, i + 1]}));
    }
    gltf.node(json!({"mesh": mesh}));
    assert_modest("scene.glb", gltf.glb(), "would take");
    gltf.json["nodes"]
        .as_array_mut()
        .unwrap()
        .last_mut()
        .unwrap()
        .as_object_mut()
        .unwrap()
        .remove("mesh");
    assert_modest("scene.glb", gltf.glb(), "would take");
}

#[test]
fn large_data_uris_and_texts() {
    let mut gltf = Gltf::triangle();
    gltf.bin.resize(6_000_000, 0);
    use base64::Engine;
    let uri = format!(
        "data:;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(&gltf.bin)
    );
    assert_modest("scene.gltf", gltf.text(&uri), "Ok(1)");
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["name"] = json!("x".repeat(6_000_000));
    gltf.json["nodes"][0]["extras"] = json!([vec!["antumbra"; 500_000], [1]]);
    assert_modest("scene.glb", gltf.glb(), "Ok(1)");
}

#[test]
fn dense_but_sound_files_load() {
    // Strips of bytes over shared vertices: nothing grows more.
    let mut gltf = Gltf::new();
    let points: Vec<u8> = (0..250u32)
        .flat_map(|i| [i as u8, (i * 7) as u8, (i * 13) as u8, 0])
        .collect();
    let order: Vec<u32> = (0..500).map(|i| i / 2).collect();
    for _ in 0..8_000 {
        let position = gltf.accessor(&points, UNSIGNED_BYTE, "VEC3", 250);
        gltf.json["bufferViews"]
            .as_array_mut()
            .unwrap()
            .last_mut()
            .unwrap()["byteStride"] = json!(4);
        let indices = gltf.indices(UNSIGNED_BYTE, &order);
        let mesh = gltf.mesh(
            "m",
            json!([{"attributes": {"POSITION": position}, "indices": indices, "mode": 5}]),
        );
        gltf.root(json!({"mesh": mesh}));
    }
    gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    assert_modest("scene.glb", gltf.glb(), "Ok(8000)");
}

#[test]
fn obj_statements_of_few_bytes() {
    let vertices = repeated("v 0 0 0\n", 6_000_000);
    assert_modest("scene.obj", format!("{vertices}f 1 2 3\n"), "");
    assert_modest(
        "scene.obj",
        format!("v 0 0 0\n{}", repeated("f 1 1 1\n", 9_000_000)),
        "would take",
    );
    assert_modest(
        "scene.obj",
        format!("v 0 0 0\nf{}\n", repeated(" 1", 6_000_000)),
        "would take",
    );
    assert_modest(
        "scene.obj",
        format!(
            "v 0 0 0\n{}",
            repeated("f 1 1 1\no a\nf 1 1 1\no b\n", 6_000_000)
        ),
        "would take",
    );
    assert_modest(
        "scene.obj",
        format!("v 0 0 0\n{}", repeated("f -1 -1 -1 -1\n", 1_000_000)),
        "Ok(1)",
    );
    assert_modest("scene.obj", repeated("\\\n", 6_000_000), "no triangles");
    assert_modest("scene.obj", repeated("x\n", 6_000_000), "no triangles");
}

#[test]
fn an_ordinary_obj_loads_however_large() {
    let mut text = String::new();
    for i in 0..150_000 {
        let _ = writeln!(text, "v {}.{:06} {}.5 1.25", i % 997, i, i / 997);
    }
    for i in 1..149_000 {
        let _ = writeln!(
            text,
            "f {} {} {}\nf {} {} {}",
            i,
            i + 1,
            i + 997,
            i + 1,
            i + 998,
            i + 997
        );
    }
    assert_modest("scene.obj", text, "Ok(1)");
}

#[test]
fn long_names_met_very_often() {
    let mut gltf = Gltf::new();
    let position = gltf.positions(&[[0.0; 3]; 3]);
    let name = "x".repeat(1_000_000);
    let lines = gltf.mesh(
        &name,
        json!([{"attributes": {"POSITION": position}, "mode": 1}]),
    );
    let shared = gltf.node(json!({"name": name, "mesh": lines}));
    gltf.root(json!({"children": vec![shared; 500_000]}));
    assert_modest("scene.glb", gltf.glb(), "");
    let faces: String = (1..100_000).map(|i| format!("f 1 2 {i}\n")).collect();
    assert_modest(
        "scene.obj",
        format!("g {name}\n{faces}"),
        "vertex 99999, but the file has 0",
    );
}
