//! What glTF can say of nodes and scenes, and what becomes of it.

mod scene_files;

use glam::{DMat3, DVec3};
use scene_files::*;
use serde_json::{Value, json};

#[test]
fn transforms_are_composed_down_the_tree_in_f64() {
    let mut gltf = Gltf::new();
    let mesh = gltf.triangle_mesh("m");
    // A quarter turn about z, then twice as wide, then mirrored: none of it commutes.
    let leaf = gltf.node(json!({"mesh": mesh, "scale": [2, 1, 1]}));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turn = gltf.node(json!({"rotation": [0.0, 0.0, half, half], "children": [leaf]}));
    gltf.root(
        json!({"children": [turn], "matrix": [-1,0,0,0, 0,1,0,0, 0,0,3,0, 300000.015625,0,-0.1,1]}),
    );
    let scene = loaded(&gltf);
    let object = &scene.objects()[0];
    let place = |x, y, z| {
        object
            .world_from_local
            .transform_point3(DVec3::new(x, y, z))
    };
    assert!(
        (place(1.0, 0.0, 0.0) - DVec3::new(300_000.015_625, 2.0, -0.1)).length() < 1e-9,
        "{object:?}"
    );
    assert!(
        (place(0.0, 1.0, 1.0) - DVec3::new(300_001.015_625, 0.0, 2.9)).length() < 1e-9,
        "{object:?}"
    );
    assert!(object.is_mirrored());
}

#[test]
fn uneven_scale_and_shear_survive() {
    let mut gltf = Gltf::new();
    let mesh = gltf.triangle_mesh("m");
    let inner = gltf.node(json!({"mesh": mesh, "rotation": [0, 0, 0.6, 0.8]}));
    gltf.root(json!({"scale": [1, 10, 1], "children": [inner]}));
    let scene = loaded(&gltf);
    let turn = DMat3::from_quat(glam::DQuat::from_xyzw(0.0, 0.0, 0.6, 0.8));
    let expected = DMat3::from_diagonal(DVec3::new(1.0, 10.0, 1.0)) * turn;
    assert!(
        scene.objects()[0]
            .world_from_local
            .matrix3
            .abs_diff_eq(expected, 1e-12)
    );
}

#[test]
fn a_rotation_that_is_not_quite_of_unit_length_does_not_scale() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["rotation"] = json!([0, 0, 0.61, 0.81]);
    let m = loaded(&gltf).objects()[0].world_from_local.matrix3;
    assert!((m.determinant() - 1.0).abs() < 1e-12);
}

#[test]
fn objects_come_depth_first_in_the_order_of_the_file() {
    let mut gltf = Gltf::new();
    let mesh = gltf.triangle_mesh("m");
    let c = gltf.node(json!({"name": "c", "mesh": mesh}));
    let d = gltf.node(json!({"name": "d", "mesh": mesh}));
    let b = gltf.node(json!({"name": "b", "mesh": mesh, "children": [c]}));
    gltf.root(json!({"name": "a", "mesh": mesh, "children": [b, d]}));
    gltf.root(json!({"mesh": mesh}));
    assert_eq!(names(&loaded(&gltf)), ["a", "b", "c", "d", "node 4"]);
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_is_walked() {
    let mut gltf = Gltf::new();
    let mesh = gltf.triangle_mesh("m");
    let last = 100_000;
    gltf.root(json!({"translation": [1, 0, 0], "children": [1]}));
    let nodes = gltf.json["nodes"].as_array_mut().unwrap();
    nodes.extend((1..last).map(|i| json!({"translation": [1, 0, 0], "children": [i + 1]})));
    nodes.push(json!({"mesh": mesh}));
    assert_eq!(
        loaded(&gltf).objects()[0].world_from_local.translation,
        DVec3::X * f64::from(last)
    );
}

#[test]
fn the_default_scene_is_read_and_others_are_mentioned() {
    let mut gltf = Gltf::triangle();
    let other = gltf.node(json!({"name": "other", "mesh": 0}));
    gltf.json["scenes"]
        .as_array_mut()
        .unwrap()
        .push(json!({"nodes": [other]}));
    for (scene, name) in [
        (json!(0), "roof"),
        (json!(1), "other"),
        (Value::Null, "roof"),
    ] {
        gltf.json["scene"] = scene;
        let scene = loaded(&gltf);
        assert_eq!(names(&scene), [name]);
        assert!(
            scene.warnings()[0].contains("other scenes are left out"),
            "{:?}",
            scene.warnings()
        );
    }
}

#[test]
fn without_scenes_every_root_is_read() {
    let mut gltf = Gltf::triangle();
    gltf.node(json!({"name": "parent", "children": [0]}));
    gltf.node(json!({"name": "alone", "mesh": 0}));
    let json = gltf.json.as_object_mut().unwrap();
    json.remove("scene");
    json.remove("scenes");
    assert_eq!(names(&loaded(&gltf)), ["roof", "alone"]);
}

#[test]
fn a_node_with_two_parents_is_placed_for_each_and_mentioned() {
    let mut gltf = Gltf::new();
    let mesh = gltf.triangle_mesh("m");
    let shared = gltf.node(json!({"name": "shared", "mesh": mesh}));
    gltf.root(json!({"translation": [1, 0, 0], "children": [shared]}));
    gltf.root(json!({"translation": [2, 0, 0], "children": [shared]}));
    let scene = loaded(&gltf);
    let places: Vec<f64> = scene
        .objects()
        .iter()
        .map(|o| o.world_from_local.translation.x)
        .collect();
    assert_eq!(places, [1.0, 2.0]);
    assert!(
        scene.warnings()[0].contains("\"shared\": it has more than one parent"),
        "{:?}",
        scene.warnings()
    );
}
