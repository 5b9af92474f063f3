//! Garbage in: however a file is damaged, loading it ends soon, in a scene or in an error.
//!
//! `ANTUMBRA_MUTATIONS` says how many mutations to try (2,000 without it).

mod scene_files;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use antumbra::scene::Scene;
use scene_files::*;
use serde_json::json;

/// A xorshift generator: the same mutations on every machine.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % bound.max(1)
    }

    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let (a, b) = (self.below(length + 1), self.below(length + 1));
        a.min(b)..a.max(b)
    }
}

/// One of everything.
fn rich() -> Gltf {
    let mut gltf = Gltf::triangle();
    let zigzag = gltf.positions(&[
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 2.0, 1.0],
    ]);
    let (strip, fan) = (
        gltf.indices(UNSIGNED_BYTE, &[0, 1, 2, 3, 4]),
        gltf.indices(UNSIGNED_INT, &[4, 3, 2, 1]),
    );
    let glass = gltf.material(
        json!({"name": "glass", "alphaMode": "BLEND", "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4]}}),
    );
    let (at, values) = (gltf.view(&[1, 0, 3, 0]), gltf.view(&[0; 24]));
    let sparse = gltf.raw_accessor(json!({"bufferView": 2, "componentType": FLOAT, "type": "VEC3", "count": 5,
        "sparse": {"count": 2, "indices": {"bufferView": at, "componentType": UNSIGNED_SHORT}, "values": {"bufferView": values}}}));
    let joints = gltf.accessor(&[0, 1, 0, 0].repeat(5), UNSIGNED_BYTE, "VEC4", 5);
    let weights = gltf.floats(&[0.5, 0.5, 0.0, 0.0].repeat(5), "VEC4", 5);
    let binds = gltf.floats(
        &[
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]
        .repeat(2),
        "MAT4",
        2,
    );
    let small = gltf.accessor(
        &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0],
        UNSIGNED_BYTE,
        "VEC3",
        3,
    );
    gltf.json["bufferViews"]
        .as_array_mut()
        .unwrap()
        .last_mut()
        .unwrap()["byteStride"] = json!(4);
    gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    let mesh = gltf.mesh("rich", json!([
        {"attributes": {"POSITION": zigzag}, "indices": strip, "mode": 5, "material": glass},
        {"attributes": {"POSITION": zigzag}, "indices": fan, "mode": 6},
        {"attributes": {"POSITION": sparse, "JOINTS_0": joints, "WEIGHTS_0": weights}, "mode": 5, "targets": [{"POSITION": zigzag}]},
        {"attributes": {"POSITION": small}},
        {"attributes": {"POSITION": zigzag}, "mode": 1},
    ]));
    let limb = gltf.mesh(
        "limb",
        json!([{"attributes": {"POSITION": sparse, "JOINTS_0": joints, "WEIGHTS_0": weights},
        "indices": fan, "mode": 6, "targets": [{"POSITION": zigzag}]}]),
    );
    gltf.json["meshes"][limb]["weights"] = json!([0.25]);
    let knee = gltf.node(json!({"name": "knee", "translation": [0, 1, 0]}));
    let hip = gltf.root(json!({"name": "hip", "rotation": [0, 0, 0.6, 0.8], "scale": [1, -2, 3], "children": [knee]}));
    gltf.json["skins"] = json!([{"joints": [hip, knee], "inverseBindMatrices": binds}]);
    gltf.root(json!({"mesh": limb, "skin": 0}));
    let offsets = gltf.positions(&[[5.0, 0.0, 0.0], [6.0, 0.0, 0.0]]);
    gltf.root(
        json!({"mesh": mesh, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 9, 9, 9, 1],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": offsets}}},
        "extras": {"antumbra": {"never_cull": true, "occluder_proxy": "wedge"}}}),
    );
    gltf
}

const OBJ: &str = "# two rooms\nmtllib paint.mtl\no hall\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0 0.5 0.5 0.5\nvt 0 0\nvn 0 0 1\n\
    usemtl red\nf 1/1/1 2/1/1 3/1/1\ng door\nf -4//1 -3//1 -2//1 -1//1\nl 1 2 3\ns off\nusemtl glass\no cellar\n\
    v 0 0 -1\nf 1 2 3 4 5\nf 1 2 \\\n3\n";
const MTL: &str =
    "newmtl red\nKa 0 0 0\nKd 1 0 0\nd 1\nnewmtl glass\nKd 0.5\nTr 0.25\nmap_d leaf.png\nillum 2\n";

const NUMBERS: &[&str] = &[
    "0",
    "1",
    "-1",
    "2",
    "3",
    "4",
    "5",
    "6",
    "7",
    "12",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "-9223372036854775808",
    "1e308",
    "1e-320",
    "1e39",
    "0.5",
    "5120",
    "5126",
    "null",
    "[]",
    "{}",
    "\"\"",
    "true",
];

/// Damages text where it hurts: another number in place of one.
fn change_number(text: &mut Vec<u8>, random: &mut Random) {
    let is_number = |b: u8| b.is_ascii_digit() || b == b'.' || b == b'-';
    let starts: Vec<usize> = (1..text.len())
        .filter(|&i| is_number(text[i]) && !is_number(text[i - 1]))
        .collect();
    if starts.is_empty() {
        return;
    }
    let start = starts[random.below(starts.len())];
    let end = (start..text.len())
        .find(|&i| !is_number(text[i]))
        .unwrap_or(text.len());
    text.splice(start..end, NUMBERS[random.below(NUMBERS.len())].bytes());
}

/// Damages bytes of any kind.
fn change_bytes(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    match random.below(5) {
        0 => {
            for _ in 0..=random.below(8) {
                let at = random.below(bytes.len());
                bytes[at] ^= 1 << random.below(8);
            }
        }
        1 => {
            let at = random.below(bytes.len());
            bytes[at] = [0, 0xff, 0x7f, 0x80, b'"', b'{', b'\n', b'-'][random.below(8)];
        }
        2 => bytes.truncate(random.below(bytes.len())),
        3 => {
            // Part of the file once more, somewhere else.
            let part = bytes[random.range(bytes.len())].to_vec();
            let at = random.below(bytes.len() + 1);
            bytes.splice(at..at, part);
        }
        _ => {
            bytes.drain(random.range(bytes.len()));
        }
    }
}

struct Seed {
    name: &'static str,
    json_or_text: Vec<u8>,
    bin: Option<Vec<u8>>,
}

impl Seed {
    fn glb(gltf: &Gltf) -> Seed {
        let mut json = gltf.json.clone();
        json["buffers"][0]["byteLength"] = json!(gltf.bin.len());
        Seed {
            name: "scene.glb",
            json_or_text: json.to_string().into_bytes(),
            bin: Some(gltf.bin.clone()),
        }
    }

    fn mutated(&self, random: &mut Random) -> Vec<u8> {
        let (mut text, mut bin) = (self.json_or_text.clone(), self.bin.clone());
        for _ in 0..=random.below(3) {
            match (random.below(4), &mut bin) {
                (0, Some(bin)) => change_bytes(bin, random),
                (1, _) => change_bytes(&mut text, random),
                _ => change_number(&mut text, random),
            }
        }
        let mut file = bin.map_or(text.clone(), |bin| glb(&text, &bin));
        if random.below(4) == 0 {
            change_bytes(&mut file, random);
        }
        file
    }
}

fn mutations() -> usize {
    std::env::var("ANTUMBRA_MUTATIONS")
        .ok()
        .and_then(|count| count.parse().ok())
        .unwrap_or(2_000)
}

/// Loads a file; if that panics or takes long, leaves the file behind and says where.
fn load_within(folder: &Folder, name: &str, bytes: &[u8], limit: Duration, attempt: usize) -> bool {
    let path = folder.write(name, bytes);
    let begun = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| Scene::load(&path)));
    if result.is_err() || begun.elapsed() > limit {
        let kept = std::env::temp_dir().join(format!("antumbra-garbage-{attempt}-{name}"));
        std::fs::write(&kept, bytes).unwrap();
        panic!(
            "mutation {attempt}, kept as {}, took {:?}: {result:?}",
            kept.display(),
            begun.elapsed()
        );
    }
    let scene = result.unwrap();
    if let Ok(scene) = &scene {
        assert_eq!(scene.bvh().validate(scene.bounds()), Ok(()));
    }
    scene.is_ok()
}

#[test]
fn mutated_files_end_in_a_scene_or_an_error() {
    let folder = Folder::new();
    let gltf = rich();
    let data_uri = {
        use base64::Engine;
        format!(
            "data:;base64,{}",
            base64::engine::general_purpose::STANDARD.encode(&gltf.bin)
        )
    };
    let seeds = [
        Seed::glb(&Gltf::triangle()),
        Seed::glb(&gltf),
        Seed {
            name: "scene.gltf",
            json_or_text: gltf.text(&data_uri).into_bytes(),
            bin: None,
        },
        Seed {
            name: "scene.obj",
            json_or_text: OBJ.into(),
            bin: None,
        },
    ];
    folder.write("paint.mtl", MTL);
    let mut random = Random(0x9e37_79b9);
    let mut sound = 0;
    for seed in &seeds {
        let file = seed.bin.as_ref().map_or(seed.json_or_text.clone(), |bin| {
            glb(&seed.json_or_text, bin)
        });
        assert!(
            load_within(&folder, seed.name, &file, Duration::from_secs(2), 0),
            "{} is sound",
            seed.name
        );
    }
    for attempt in 0..mutations() {
        let seed = &seeds[attempt % seeds.len()];
        if seed.name == "scene.obj" {
            let mut library = MTL.as_bytes().to_vec();
            change_bytes(&mut library, &mut random);
            folder.write("paint.mtl", library);
        }
        let file = seed.mutated(&mut random);
        sound += usize::from(load_within(
            &folder,
            seed.name,
            &file,
            Duration::from_secs(2),
            attempt,
        ));
    }
    eprintln!("{sound} of {} mutations still load", mutations());
}

#[test]
fn a_mutated_real_scene_ends_in_a_scene_or_an_error() {
    let folder = std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    );
    let Ok(whole) = std::fs::read(folder.join("delft.glb")) else {
        eprintln!("skipped: no delft.glb in {}", folder.display());
        return;
    };
    let (folder, mut random) = (Folder::new(), Random(11));
    for attempt in 0..mutations() / 100 {
        let mut file = whole.clone();
        change_bytes(&mut file, &mut random);
        load_within(&folder, "delft.glb", &file, Duration::from_secs(5), attempt);
    }
}
