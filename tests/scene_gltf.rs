//! What glTF can say, and what becomes of it.

mod scene_files;

use antumbra::scene::{Alpha, Scene};
use glam::DVec3;
use scene_files::*;
use serde_json::json;

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn a_binary_file_carries_its_buffer() {
    let scene = loaded(&Gltf::triangle());
    assert_eq!((scene.objects().len(), scene.triangle_count()), (1, 1));
    assert_eq!(
        (
            scene.objects()[0].name.as_str(),
            scene.meshes()[0].name.as_str()
        ),
        ("roof", "wedge")
    );
    assert_eq!(corners(&scene, 0), [CORNERS]);
    assert_eq!(scene.warnings(), [""; 0]);
}

#[test]
fn a_buffer_may_lie_beside_the_file_under_an_encoded_name() {
    let (folder, gltf) = (Folder::new(), Gltf::triangle());
    folder.write("my parts/ä.bin", &gltf.bin);
    let path = folder.write("scene.gltf", gltf.text("my%20parts/%C3%A4.bin"));
    assert_eq!(corners(&Scene::load(&path).unwrap(), 0), [CORNERS]);
}

#[test]
fn a_buffer_may_be_a_data_uri_with_or_without_padding() {
    use base64::Engine;
    let gltf = Gltf::triangle();
    for text in [
        base64::engine::general_purpose::STANDARD.encode(&gltf.bin),
        base64::engine::general_purpose::STANDARD_NO_PAD.encode(&gltf.bin),
    ] {
        let uri = format!("data:application/octet-stream;base64,{text}");
        assert_eq!(
            corners(&load("scene.gltf", gltf.text(&uri)).unwrap(), 0),
            [CORNERS]
        );
    }
}

#[test]
fn a_buffer_that_only_pictures_use_may_be_missing() {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({"byteLength": 9, "uri": "pictures.bin"}));
    loaded(&gltf);
}

#[test]
fn every_index_type_and_none_give_the_same_triangles() {
    let quad = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let order = [0, 1, 2, 0, 2, 3];
    let mut expected = None;
    for component in [
        Some(UNSIGNED_BYTE),
        Some(UNSIGNED_SHORT),
        Some(UNSIGNED_INT),
        None,
    ] {
        let mut gltf = Gltf::new();
        let mesh = match component {
            Some(component) => {
                let (position, indices) = (gltf.positions(&quad), gltf.indices(component, &order));
                gltf.mesh(
                    "m",
                    json!([{"attributes": {"POSITION": position}, "indices": indices}]),
                )
            }
            None => {
                let position = gltf.positions(&order.map(|i| quad[i as usize]));
                gltf.mesh("m", json!([{"attributes": {"POSITION": position}}]))
            }
        };
        gltf.root(json!({"mesh": mesh}));
        let corners = corners(&loaded(&gltf), 0);
        assert_eq!(corners.len(), 2);
        assert_eq!(
            &corners,
            expected.get_or_insert_with(|| corners.clone()),
            "{component:?}"
        );
    }
}

fn normal_z([a, b, c]: [[f32; 3]; 3]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[test]
fn strips_and_fans_keep_the_winding_of_their_first_triangle() {
    let zigzag = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 2.0, 0.0],
        [1.0, 2.0, 0.0],
    ];
    let circle = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [1.5, 1.5, 0.0],
        [0.0, 2.0, 0.0],
        [-1.5, 1.5, 0.0],
    ];
    for (mode, points, triangles) in [(5, &zigzag[..], 4), (6, &circle[..], 3)] {
        for indexed in [false, true] {
            let mut gltf = Gltf::new();
            let position = gltf.positions(points);
            let mut primitive = json!({"attributes": {"POSITION": position}, "mode": mode});
            if indexed {
                primitive["indices"] = json!(
                    gltf.indices(UNSIGNED_BYTE, &(0..points.len() as u32).collect::<Vec<_>>())
                );
            }
            let mesh = gltf.mesh("m", json!([primitive]));
            gltf.root(json!({"mesh": mesh}));
            let corners = corners(&loaded(&gltf), 0);
            assert_eq!(corners.len(), triangles);
            assert!(
                corners.iter().all(|&t| normal_z(t) > 0.0),
                "mode {mode}: {corners:?}"
            );
        }
    }
}

#[test]
fn interleaved_attributes_are_read_with_their_stride() {
    let mut gltf = Gltf::new();
    let bytes: Vec<u8> = CORNERS
        .iter()
        .flat_map(|p| [&p[..], &[9.0; 3]].concat())
        .flat_map(f32::to_le_bytes)
        .collect();
    let position = gltf.accessor(&bytes, FLOAT, "VEC3", 3);
    gltf.json["bufferViews"][0]["byteStride"] = json!(24);
    let mesh = gltf.mesh("m", json!([{"attributes": {"POSITION": position}}]));
    gltf.root(json!({"mesh": mesh}));
    assert_eq!(corners(&loaded(&gltf), 0), [CORNERS]);
}

#[test]
fn a_mesh_shared_by_many_nodes_is_stored_once() {
    let mut gltf = Gltf::triangle();
    for i in 1..100 {
        gltf.root(json!({"mesh": 0, "translation": [i, 0, 0]}));
    }
    let scene = loaded(&gltf);
    assert_eq!(
        (
            scene.objects().len(),
            scene.meshes().len(),
            scene.triangle_count()
        ),
        (100, 1, 100)
    );
    assert!(scene.bounds()[99].contains(antumbra::scene::Aabb {
        min: DVec3::X * 99.0,
        max: DVec3::new(100.0, 1.0, 0.0)
    }));
}

#[test]
fn primitives_become_surfaces_and_share_their_vertices() {
    let mut gltf = Gltf::new();
    let position = gltf.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let (a, b) = (
        gltf.indices(UNSIGNED_BYTE, &[0, 1, 2]),
        gltf.indices(UNSIGNED_BYTE, &[0, 2, 3]),
    );
    let glass = gltf.material(json!({"alphaMode": "BLEND", "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.5, 0.75, 0.5]}}));
    let mesh = gltf.mesh(
        "m",
        json!([{"attributes": {"POSITION": position}, "indices": a},
        {"attributes": {"POSITION": position}, "indices": b, "material": glass}]),
    );
    gltf.root(json!({"mesh": mesh}));
    let scene = loaded(&gltf);
    let mesh = &scene.meshes()[0];
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
    assert_eq!(
        mesh.surfaces
            .iter()
            .map(|s| s.triangles.clone())
            .collect::<Vec<_>>(),
        [0..1, 1..2]
    );
    let [plain, glass] = [0, 1].map(|i| mesh.surfaces[i].material);
    assert_eq!(
        (plain.alpha, plain.double_sided, plain.color),
        (Alpha::Opaque, false, [1.0; 4])
    );
    assert_eq!(
        (glass.alpha, glass.double_sided, glass.color),
        (Alpha::Blend, true, [0.25, 0.5, 0.75, 0.5])
    );
}

#[test]
fn masked_and_transmitting_materials_are_not_opaque() {
    for (material, alpha) in [
        (json!({"alphaMode": "OPAQUE"}), Alpha::Opaque),
        (
            json!({"alphaMode": "MASK", "alphaCutoff": 0.5}),
            Alpha::Mask,
        ),
        (
            json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0}}}),
            Alpha::Blend,
        ),
        (
            json!({"extensions": {"KHR_materials_unlit": {}}}),
            Alpha::Opaque,
        ),
    ] {
        let mut gltf = Gltf::triangle();
        gltf.material(material);
        gltf.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        assert_eq!(loaded(&gltf).meshes()[0].surfaces[0].material.alpha, alpha);
    }
}

#[test]
fn a_mesh_keeps_only_the_vertices_it_uses_of_a_shared_accessor() {
    let mut gltf = Gltf::new();
    let points: Vec<[f32; 3]> = (0..1000).map(|i| [i as f32, (i % 7) as f32, 0.0]).collect();
    let position = gltf.positions(&points);
    for first in [0, 500] {
        // Backwards, so that order and numbering are both tried.
        let indices = gltf.indices(UNSIGNED_SHORT, &[first + 5, first + 3, first + 1]);
        let mesh = gltf.mesh(
            "m",
            json!([{"attributes": {"POSITION": position}, "indices": indices}]),
        );
        gltf.root(json!({"mesh": mesh}));
    }
    let scene = loaded(&gltf);
    for (mesh, first) in [(0, 0), (1, 500)] {
        assert_eq!(
            scene.meshes()[mesh].positions,
            [1, 3, 5].map(|i| points[first + i])
        );
        assert_eq!(
            corners(&scene, mesh),
            [[5, 3, 1].map(|i| points[first + i])]
        );
    }
}

#[test]
fn sparse_values_replace_those_beneath_or_zeros() {
    for with_base in [true, false] {
        let mut gltf = Gltf::new();
        let at = gltf.view(&[1, 2]);
        let values: Vec<u8> = CORNERS[1..]
            .as_flattened()
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let values = gltf.view(&values);
        let mut accessor = json!({"componentType": FLOAT, "type": "VEC3", "count": 3,
            "sparse": {"count": 2, "indices": {"bufferView": at, "componentType": UNSIGNED_BYTE}, "values": {"bufferView": values}}});
        if with_base {
            let base: Vec<u8> = [0.0f32, 0.0, 0.0, 7.0, 7.0, 7.0, 7.0, 7.0, 7.0]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect();
            accessor["bufferView"] = json!(gltf.view(&base));
        }
        let position = gltf.raw_accessor(accessor);
        let mesh = gltf.mesh("m", json!([{"attributes": {"POSITION": position}}]));
        gltf.root(json!({"mesh": mesh}));
        assert_eq!(corners(&loaded(&gltf), 0), [CORNERS]);
    }
}

#[test]
fn quantised_positions_are_read_as_integers_or_fractions() {
    let shorts = |values: &[i16]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<_>>()
    };
    for (component, normalized, bytes, far) in [
        (
            SHORT,
            false,
            shorts(&[0, 0, 0, 300, 0, 0, 0, -300, 0]),
            300.0,
        ),
        (
            SHORT,
            true,
            shorts(&[0, 0, 0, 32767, 0, 0, 0, -32768, 0]),
            1.0,
        ),
        (BYTE, true, vec![0, 0, 0, 127, 0, 0, 0, 0x80, 0], 1.0),
        (
            UNSIGNED_BYTE,
            false,
            vec![0, 0, 0, 200, 0, 0, 0, 200, 0],
            200.0,
        ),
        (
            UNSIGNED_BYTE,
            true,
            vec![0, 0, 0, 255, 0, 0, 0, 255, 0],
            1.0,
        ),
        (
            UNSIGNED_SHORT,
            true,
            shorts(&[0, 0, 0, -1, 0, 0, 0, -1, 0]),
            1.0,
        ),
    ] {
        let mut gltf = Gltf::new();
        let position = gltf.accessor(&bytes, component, "VEC3", 3);
        gltf.json["accessors"][0]["normalized"] = json!(normalized);
        let mesh = gltf.mesh("m", json!([{"attributes": {"POSITION": position}}]));
        gltf.root(json!({"mesh": mesh}));
        gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        gltf.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let positions = loaded(&gltf).meshes()[0].positions.clone();
        assert_eq!(
            (positions[1][0], positions[2][1].abs()),
            (far, far),
            "{component} {normalized}"
        );
    }
}

#[test]
fn gpu_instances_are_objects_that_share_a_mesh() {
    let mut gltf = Gltf::triangle();
    let translation = gltf.floats(&[1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0, 0.0], "VEC3", 3);
    let rotation = gltf.accessor(
        &[0, 0, 0, 127, 0, 0, 127, 0, 0, 0, 0, 0x81],
        BYTE,
        "VEC4",
        3,
    );
    gltf.json["accessors"][rotation]["normalized"] = json!(true);
    gltf.json["nodes"][0]["translation"] = json!([0, 10, 0]);
    gltf.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation, "ROTATION": rotation}}});
    gltf.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = loaded(&gltf);
    assert_eq!(names(&scene), ["roof[0]", "roof[1]", "roof[2]"]);
    assert_eq!(scene.meshes().len(), 1);
    let corner = |i: usize| {
        scene.objects()[i]
            .world_from_local
            .transform_point3(DVec3::X)
    };
    assert!((corner(0) - DVec3::new(2.0, 10.0, 0.0)).length() < 1e-9);
    assert!((corner(1) - DVec3::new(1.0, 10.0, 0.0)).length() < 1e-9);
}

#[test]
fn morph_targets_are_applied_at_their_weights() {
    let mut gltf = Gltf::triangle();
    let target = gltf.positions(&[[0.0, 0.0, 4.0], [0.0; 3], [0.0; 3]]);
    gltf.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
    gltf.json["meshes"][0]["weights"] = json!([0.5]);
    gltf.root(json!({"mesh": 0, "weights": [0.0]}));
    gltf.root(json!({"mesh": 0}));
    let scene = loaded(&gltf);
    let heights: Vec<f32> = scene
        .objects()
        .iter()
        .map(|o| scene.meshes()[o.mesh].positions[0][2])
        .collect();
    assert_eq!(heights, [2.0, 0.0, 2.0]);
    assert_eq!(scene.meshes().len(), 2, "equal poses share a mesh");
}

#[test]
fn a_skinned_mesh_stands_where_its_joints_leave_it() {
    let mut gltf = Gltf::triangle();
    let joints = gltf.accessor(
        &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0],
        UNSIGNED_BYTE,
        "VEC4",
        3,
    );
    let weights = gltf.floats(
        &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0],
        "VEC4",
        3,
    );
    let primitive = &mut gltf.json["meshes"][0]["primitives"][0]["attributes"];
    primitive["JOINTS_0"] = json!(joints);
    primitive["WEIGHTS_0"] = json!(weights);
    let hip = gltf.root(json!({"translation": [1000000.25, 0, 0]}));
    let knee = gltf.node(json!({"translation": [0, 0, 8]}));
    gltf.json["nodes"][hip]["children"] = json!([knee]);
    gltf.json["skins"] = json!([{"joints": [hip, knee]}]);
    // The node's own place does not count.
    gltf.json["nodes"][0]["translation"] = json!([5, 5, 5]);
    gltf.json["nodes"][0]["skin"] = json!(0);
    let scene = loaded(&gltf);
    let object = &scene.objects()[0];
    let world = |v: usize| {
        let local = scene.meshes()[object.mesh].positions[v].map(f64::from);
        object.world_from_local.transform_point3(DVec3::from(local))
    };
    assert_eq!(world(0), DVec3::new(1_000_000.25, 0.0, 0.0));
    assert_eq!(world(1), DVec3::new(1_000_001.25, 0.0, 8.0));
    assert_eq!(world(2), DVec3::new(1_000_000.25, 1.0, 4.0));
}

#[test]
fn flags_in_extras_reach_the_object() {
    let mut gltf = Gltf::triangle();
    gltf.triangle_mesh("coarse");
    gltf.json["nodes"][0]["extras"] = json!({"antumbra": {"never_cull": true, "never_occlude": true, "occluder_proxy": "coarse"}, "more": 1});
    gltf.root(json!({"mesh": 0, "extras": "antumbra is mentioned in a text"}));
    gltf.root(json!({"mesh": 0, "extras": [1, 2]}));
    let scene = loaded(&gltf);
    let [flagged, text, list] = scene.objects() else {
        panic!("three objects")
    };
    assert!(flagged.never_cull && flagged.never_occlude);
    assert_eq!(
        flagged
            .occluder_proxy
            .map(|m| scene.meshes()[m].name.as_str()),
        Some("coarse")
    );
    for plain in [text, list] {
        assert!(!plain.never_cull && !plain.never_occlude && plain.occluder_proxy.is_none());
    }
}

#[test]
fn hidden_nodes_are_left_out_with_their_children_and_mentioned() {
    let mut gltf = Gltf::triangle();
    let child = gltf.node(json!({"mesh": 0}));
    gltf.root(json!({"name": "attic", "mesh": 0, "children": [child], "extensions": {"KHR_node_visibility": {"visible": false}}}));
    let scene = loaded(&gltf);
    assert_eq!(names(&scene), ["roof"]);
    assert!(
        scene.warnings()[0].contains("\"attic\""),
        "{:?}",
        scene.warnings()
    );
}

#[test]
fn points_and_lines_are_left_out_and_mentioned() {
    let mut gltf = Gltf::triangle();
    let lines = gltf
        .mesh("wire", json!([{"attributes": {"POSITION": 0}, "mode": 1}, {"attributes": {"POSITION": 0}, "mode": 0}]));
    gltf.root(json!({"name": "fence", "mesh": lines}));
    let scene = loaded(&gltf);
    assert_eq!(names(&scene), ["roof"]);
    assert_eq!(scene.warnings().len(), 2);
    assert!(
        scene.warnings()[0]
            .contains("mesh 1 \"wire\", primitive 0 and 1 more: it draws points or lines"),
        "{:?}",
        scene.warnings()
    );
    assert!(
        scene.warnings()[1].contains("\"fence\": its mesh has no triangles"),
        "{:?}",
        scene.warnings()
    );
}

#[test]
fn extensions_that_change_no_geometry_may_be_required() {
    let mut gltf = Gltf::triangle();
    gltf.json["extensionsRequired"] = json!([
        "KHR_materials_unlit",
        "KHR_texture_transform",
        "EXT_texture_webp",
        "KHR_lights_punctual"
    ]);
    loaded(&gltf);
}
