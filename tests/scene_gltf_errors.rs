//! Damaged glTF: each error names the file, the object and the cause.

mod scene_files;

use scene_files::*;
use serde_json::json;

/// Changes the one-triangle file and checks what is said about it.
#[track_caller]
fn refused(change: impl FnOnce(&mut Gltf), parts: &[&str]) {
    let mut gltf = Gltf::triangle();
    change(&mut gltf);
    assert_refused("broken.glb", gltf.glb(), parts);
}

#[test]
fn a_missing_file() {
    let folder = Folder::new();
    let error = antumbra::scene::Scene::load(&folder.path().join("nowhere.glb"))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("nowhere.glb: cannot be read: No such file"),
        "{error}"
    );
}

#[test]
fn a_file_of_another_kind_and_a_folder() {
    assert_refused(
        "picture.png",
        "",
        &["not a kind of scene that can be read; give a .glb, .gltf, .obj or .antumbra file"],
    );
    assert_refused(
        "scene.gltf",
        "solid cube",
        &["neither binary glTF", "nor JSON"],
    );
    assert_refused("scene.glb", "", &["the file is empty"]);
    let folder = Folder::new();
    folder.write("scene.glb/inner", "");
    let error = antumbra::scene::Scene::load(&folder.path().join("scene.glb"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("scene.glb: cannot be read"), "{error}");
}

#[test]
fn a_truncated_file_wherever_it_ends() {
    let whole = Gltf::triangle().glb();
    for length in 0..whole.len() {
        let message = assert_refused("cut.glb", &whole[..length], &[]);
        assert!(
            message.contains("copy or download it again") || message.contains("neither binary"),
            "{length}: {message}"
        );
    }
}

#[test]
fn a_header_that_lies() {
    let with = |at: usize, value: u32| {
        let mut file = Gltf::triangle().glb();
        file[at..at + 4].copy_from_slice(&value.to_le_bytes());
        file
    };
    assert_refused(
        "old.glb",
        with(4, 1),
        &["header", "it is glTF 1", "convert it to glTF 2.0"],
    );
    assert_refused(
        "long.glb",
        with(8, u32::MAX),
        &["header", "should have 4294967295 bytes"],
    );
    assert_refused("short.glb", with(8, 3), &["the first chunk is not JSON"]);
    assert_refused(
        "chunk.glb",
        with(12, u32::MAX - 4),
        &["the chunk at byte 12 claims 4294967291 bytes"],
    );
    assert_refused("kind.glb", with(16, 0), &["the first chunk is not JSON"]);
}

#[test]
fn json_that_does_not_parse() {
    assert_refused(
        "a.gltf",
        "{\"asset\": ",
        &["its JSON", "EOF while parsing", "line 1"],
    );
    assert_refused("b.gltf", "{}", &["its JSON", "missing field `asset`"]);
    assert_refused(
        "c.gltf",
        "{\"asset\":{\"version\":\"3.1\"}}",
        &["asset", "it is glTF 3.1", "convert it to glTF 2.0"],
    );
    let deep = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{}1{}}}",
        "[".repeat(100_000),
        "]".repeat(100_000)
    );
    assert_refused("d.gltf", deep, &["the scene has no triangles"]);
    let deep = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":{}1{}}}",
        "[".repeat(100_000),
        "]".repeat(100_000)
    );
    assert_refused("e.gltf", deep, &["its JSON"]);
    assert_refused(
        "f.gltf",
        b"{\"asset\":{\"version\":\"\xff\"}}",
        &["its JSON"],
    );
}

#[test]
fn references_to_nothing() {
    let mesh = "node 0 \"roof\", mesh 0 \"wedge\", primitive 0, ";
    refused(
        |g| g.json["scene"] = json!(5),
        &["scene 5: there is none: the file has 1"],
    );
    refused(
        |g| g.json["scenes"][0]["nodes"] = json!([7]),
        &["scene 0, node 7: there is none"],
    );
    refused(
        |g| g.json["nodes"][0]["children"] = json!([9]),
        &["node 0 \"roof\", node 9: there is none"],
    );
    refused(
        |g| g.json["nodes"][0]["mesh"] = json!(4),
        &["node 0 \"roof\", mesh 4: there is none"],
    );
    refused(
        |g| g.json["nodes"][0]["skin"] = json!(4),
        &["node 0 \"roof\", skin 4: there is none"],
    );
    refused(
        |g| g.json["meshes"][0]["primitives"][0]["material"] = json!(0),
        &[mesh, "material 0: there is none: the file has 0"],
    );
    refused(
        |g| g.json["meshes"][0]["primitives"][0]["indices"] = json!(99),
        &[mesh, "accessor 99: there is none"],
    );
    refused(
        |g| g.json["accessors"][0]["bufferView"] = json!(99),
        &[mesh, "accessor 0, buffer view 99: there is none"],
    );
    refused(
        |g| g.json["bufferViews"][0]["buffer"] = json!(3),
        &[mesh, "buffer view 0, buffer 3: there is none"],
    );
}

#[test]
fn an_index_out_of_range() {
    let mut gltf = Gltf::new();
    let (position, indices) = (
        gltf.positions(&[[0.0; 3]; 3]),
        gltf.indices(UNSIGNED_INT, &[0, 1, 2, 2, 3, 0]),
    );
    let mesh = gltf.mesh(
        "door",
        json!([{"attributes": {"POSITION": position}, "indices": indices}]),
    );
    gltf.root(json!({"name": "front door", "mesh": mesh}));
    assert_refused(
        "broken.glb",
        gltf.glb(),
        &[
            "node 0 \"front door\", mesh 0 \"door\", primitive 0",
            "triangle 1 has an index out of range: [2, 3, 0]",
            "3 vertices",
        ],
    );
}

#[test]
fn a_position_that_is_not_finite() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut gltf = Gltf::new();
        let position = gltf.positions(&[[0.0; 3], [0.0, bad, 0.0], [0.0; 3]]);
        let mesh = gltf.mesh("door", json!([{"attributes": {"POSITION": position}}]));
        gltf.root(json!({"mesh": mesh}));
        let parts = [
            "node 0, mesh 0 \"door\"",
            "vertex 1 has a position that is not finite",
        ];
        assert_refused("broken.glb", gltf.glb(), &parts);
    }
}

#[test]
fn views_and_accessors_that_reach_too_far() {
    refused(
        |g| g.json["bufferViews"][0]["byteLength"] = json!(1000),
        &["buffer view 0: 1000 bytes from byte 0 on reach past the end of buffer 0"],
    );
    refused(
        |g| g.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
        &["buffer view 0", "reach past the end"],
    );
    refused(
        |g| g.json["accessors"][0]["count"] = json!(4),
        &[
            "accessor 0: 4 elements of 12 bytes",
            "do not fit into buffer view 0, which has 36 bytes",
        ],
    );
    refused(
        |g| g.json["accessors"][0]["count"] = json!(u64::MAX),
        &["accessor 0", "do not fit"],
    );
    refused(
        |g| g.json["accessors"][0]["byteOffset"] = json!(u64::MAX),
        &["accessor 0", "do not fit"],
    );
    refused(
        |g| g.json["bufferViews"][0]["byteStride"] = json!(u64::MAX),
        &["accessor 0", "do not fit"],
    );
    refused(
        |g| g.json["bufferViews"][0]["byteStride"] = json!(8),
        &["accessor 0", "stride 8", "do not fit"],
    );
    refused(
        |g| g.json["buffers"][0]["byteLength"] = json!(100_000),
        &["buffer 0: it should have 100000 bytes but has 44"],
    );
}

#[test]
fn accessors_of_the_wrong_kind() {
    refused(
        |g| g.json["accessors"][0]["type"] = json!("VEC5"),
        &["accessor 0", "none that glTF knows"],
    );
    refused(
        |g| g.json["accessors"][0]["componentType"] = json!(5124),
        &["accessor 0", "none that glTF knows"],
    );
    refused(
        |g| g.json["accessors"][0]["type"] = json!("VEC2"),
        &["accessor 0: a position cannot be Vec2"],
    );
    refused(
        |g| g.json["accessors"][0]["componentType"] = json!(UNSIGNED_SHORT),
        &["accessor 0: a position cannot be Vec3 of U16"],
    );
    refused(
        |g| g.json["accessors"][1]["componentType"] = json!(SHORT),
        &["accessor 1: an index cannot be Scalar of I16"],
    );
    refused(
        |g| g.json["meshes"][0]["primitives"][0]["mode"] = json!(7),
        &["primitive 0", "its mode is none that glTF knows"],
    );
    refused(
        |g| {
            g.json["accessors"][0]
                .as_object_mut()
                .unwrap()
                .remove("bufferView");
        },
        &["accessor 0", "neither a buffer view nor sparse values"],
    );
}

#[test]
fn lists_that_do_not_make_triangles() {
    refused(
        |g| g.json["accessors"][1]["count"] = json!(2),
        &["it draws triangles, but has 2 vertices or indices, not a multiple of three"],
    );
    refused(
        |g| {
            g.json["accessors"][1]["count"] = json!(2);
            g.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
        },
        &["a strip or fan needs three vertices, but it has 2"],
    );
}

#[test]
fn sparse_indices_that_do_not_increase_or_go_too_far() {
    for (bytes, what) in [([1u8, 1], "index 1 is 1"), ([1, 3], "index 1 is 3")] {
        refused(
            |g| {
                let (at, values) = (g.view(&bytes), g.view(&[0; 24]));
                g.json["accessors"][0]["sparse"] = json!({"count": 2, "values": {"bufferView": values},
                    "indices": {"bufferView": at, "componentType": UNSIGNED_BYTE}});
            },
            &[
                "accessor 0, sparse",
                what,
                "they must increase and stay below 3",
            ],
        );
    }
    refused(
        |g| {
            let at = g.view(&[0]);
            g.json["accessors"][0]["sparse"] = json!({"count": u64::MAX, "values": {"bufferView": at},
                "indices": {"bufferView": at, "componentType": UNSIGNED_BYTE}});
        },
        &["accessor 0, sparse", "do not fit into their buffer views"],
    );
}

#[test]
fn nodes_in_a_cycle() {
    refused(
        |g| g.json["nodes"][0]["children"] = json!([0]),
        &["node 0 \"roof\": it is its own ancestor"],
    );
    refused(
        |g| {
            g.json["nodes"][0]["children"] = json!([1]);
            g.node(json!({"name": "b", "children": [2]}));
            g.node(json!({"name": "c", "children": [1, 3]}));
            g.node(json!({"name": "only below the cycle"}));
        },
        &["it is its own ancestor: the nodes form a cycle"],
    );
}

#[test]
fn transforms_that_are_none() {
    refused(
        |g| g.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
        &["node 0 \"roof\"", "its rotation is no rotation"],
    );
    refused(
        |g| g.json["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
        &[
            "node 0 \"roof\"",
            "the last row of its matrix is [1.0, 0.0, 0.0, 1.0]",
        ],
    );
    refused(
        |g| g.json["nodes"][0]["matrix"] = json!([1, 2, 3]),
        &["its JSON", "expected an array of length 16"],
    );
    refused(
        |g| g.json["nodes"][0]["scale"] = json!([1e300, 1, 1]),
        &["object 0 \"roof\"", "beyond", "scale the scene down"],
    );
    refused(
        |g| g.json["nodes"][0]["translation"] = json!([0, 1e308, 0]),
        &["object 0 \"roof\"", "beyond"],
    );
}

#[test]
fn a_scene_without_triangles() {
    refused(
        |g| g.json["scenes"][0]["nodes"] = json!([]),
        &["the scene has no triangles"],
    );
    refused(
        |g| g.json["meshes"][0]["primitives"][0]["mode"] = json!(0),
        &["the scene has no triangles"],
    );
    refused(
        |g| g.json["meshes"][0]["primitives"] = json!([]),
        &["the scene has no triangles"],
    );
}

#[test]
fn extensions_that_are_required_and_lacking() {
    refused(
        |g| g.json["extensionsRequired"] = json!(["ACME_voxels"]),
        &["extensionsRequired: it requires \"ACME_voxels\"; export the scene without it"],
    );
    refused(
        |g| g.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
        &["decompress it first"],
    );
    refused(
        |g| g.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]),
        &["decompress it first"],
    );
}

#[test]
fn buffers_that_cannot_be_had() {
    let gltf = Gltf::triangle();
    for (uri, cause) in [
        ("parts.bin", "uri \"parts.bin\""),
        (
            "https://example.org/parts.bin",
            "only files beside the scene are read",
        ),
        ("/etc/passwd", "it is an absolute path"),
        ("a%zz.bin", "percent-encoding is broken"),
        ("data:text/plain,hello", "it is not base64"),
        ("data:text/plain;base64", "no comma"),
        ("data:;base64,!!!!", "its base64 is broken"),
        ("data:;base64,AAAA", "it should have 42 bytes but has 3"),
    ] {
        let message = assert_refused("scene.gltf", gltf.text(uri), &["buffer 0", cause]);
        assert!(
            message.contains("node 0 \"roof\", mesh 0 \"wedge\", primitive 0, accessor 0"),
            "{message}"
        );
    }
    let folder = Folder::new();
    folder.write("parts.bin", [0; 9]);
    let error = antumbra::scene::Scene::load(&folder.write("scene.gltf", gltf.text("parts.bin")))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("buffer 0: it should have 42 bytes but has 9; the file looks truncated"),
        "{error}"
    );
    assert_refused(
        "scene.gltf",
        gltf.json.to_string(),
        &["buffer 0", "no binary chunk"],
    );
}

#[test]
fn flags_and_proxies_that_make_no_sense() {
    refused(
        |g| g.json["nodes"][0]["extras"] = json!({"antumbra": {"never_cull": "yes"}}),
        &["node 0 \"roof\", its extras", "never_cull"],
    );
    refused(
        |g| g.json["nodes"][0]["extras"] = json!({"antumbra": {"nevr_cull": true}}),
        &["node 0 \"roof\", its extras", "nevr_cull"],
    );
    refused(
        |g| g.json["nodes"][0]["extras"] = json!({"antumbra": {"occluder_proxy": "hull"}}),
        &["node 0 \"roof\", its occluder_proxy: no mesh is named \"hull\""],
    );
}

#[test]
fn deformations_that_do_not_fit() {
    refused(
        |g| g.json["nodes"][0]["weights"] = json!([1.0]),
        &[
            "mesh 0 \"wedge\"",
            "its morph targets: 0 targets, but 1 weights",
        ],
    );
    refused(
        |g| {
            g.json["skins"] = json!([{"joints": [0]}]);
            g.json["nodes"][0]["skin"] = json!(0);
        },
        &[
            "mesh 0 \"wedge\"",
            "a skinned primitive needs JOINTS and WEIGHTS",
        ],
    );
    refused(
        |g| {
            g.json["skins"] = json!([{"name": "rig", "joints": []}]);
            g.json["nodes"][0]["skin"] = json!(0);
        },
        &["node 0 \"roof\", skin 0 \"rig\": it has no joints"],
    );
    refused(
        |g| {
            let joints = g.accessor(&[9; 12], UNSIGNED_BYTE, "VEC4", 3);
            let weights = g.floats(&[1.0; 12], "VEC4", 3);
            g.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
            g.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
            g.json["skins"] = json!([{"joints": [0]}]);
            g.json["nodes"][0]["skin"] = json!(0);
        },
        &["vertex 0", "joint 9, but the skin has 1"],
    );
}

#[test]
fn instances_that_do_not_fit() {
    let instancing = |g: &mut Gltf, attributes| {
        g.json["nodes"][0]["extensions"] =
            json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    };
    refused(
        |g| instancing(g, json!({})),
        &["node 0 \"roof\", EXT_mesh_gpu_instancing: it has none of TRANSLATION"],
    );
    refused(
        |g| {
            let (a, b) = (g.positions(&[[0.0; 3]; 2]), g.positions(&[[0.0; 3]; 3]));
            instancing(g, json!({"TRANSLATION": a, "SCALE": b}));
        },
        &["EXT_mesh_gpu_instancing: its attributes have different counts: [2, 3]"],
    );
    refused(
        |g| {
            let translation = g.positions(&[[0.0; 3], [f32::NAN, 0.0, 0.0]]);
            instancing(g, json!({"TRANSLATION": translation}));
        },
        &["object 1 \"roof[1]\": its matrix is not finite"],
    );
}
