//! Ways to damage scene files, the same on every machine.

use serde_json::json;

use super::{FLOAT, Gltf, UNSIGNED_BYTE, UNSIGNED_INT, UNSIGNED_SHORT, glb};

/// A xorshift generator: the same mutations on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % bound.max(1)
    }

    pub fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let (a, b) = (self.below(length + 1), self.below(length + 1));
        a.min(b)..a.max(b)
    }
}

/// One of everything.
pub fn rich() -> Gltf {
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

/// One of everything, as text.
pub const OBJ: &str = "# two rooms\nmtllib paint.mtl\no hall\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0 0.5 0.5 0.5\nvt 0 0\nvn 0 0 1\n\
    usemtl red\nf 1/1/1 2/1/1 3/1/1\ng door\nf -4//1 -3//1 -2//1 -1//1\nl 1 2 3\ns off\nusemtl glass\no cellar\n\
    v 0 0 -1\nf 1 2 3 4 5\nf 1 2 \\\n3\n";
/// The materials that [`OBJ`] names.
pub const MTL: &str =
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
pub fn change_number(text: &mut Vec<u8>, random: &mut Random) {
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

/// Changes numbers a little: another digit in place of one.
pub fn change_digit(text: &mut [u8], random: &mut Random) {
    let digits: Vec<usize> = (0..text.len())
        .filter(|&i| text[i].is_ascii_digit())
        .collect();
    if !digits.is_empty() {
        text[digits[random.below(digits.len())]] = b'0' + random.below(10) as u8;
    }
}

/// Damages bytes of any kind.
pub fn change_bytes(bytes: &mut Vec<u8>, random: &mut Random) {
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

/// Values that are seldom meant: not finite, huge, tiny, negative zero, the last of an index type.
const WORDS: [u32; 14] = [
    0,
    0x8000_0000, // -0
    0x7f80_0000, // infinite
    0xff80_0000,
    0x7fc0_0000, // not a number
    0x7f7f_ffff, // the largest
    0xff7f_ffff,
    0x7149_f2ca, // 1e30
    0xce6e_6b28, // -1e9
    0x4e6e_6b28,
    0x0000_0001, // the smallest
    0x3380_0000, // 6e-8
    0xffff_ffff,
    0x0000_ffff,
];

/// Changes a few floats or indices: half of them become strange, half move a little.
pub fn change_words(bytes: &mut [u8], random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len() / 4) * 4;
        let Some(word) = bytes.get_mut(at..at + 4) else {
            continue;
        };
        if random.below(2) == 0 {
            word.copy_from_slice(&WORDS[random.below(WORDS.len())].to_le_bytes());
        } else {
            let bit = random.below(23);
            word[bit / 8] ^= 1 << (bit % 8);
        }
    }
}

/// A sound file to damage.
pub struct Seed {
    /// Its name; the extension says what it is.
    pub name: &'static str,
    /// All of it, or its JSON chunk.
    pub json_or_text: Vec<u8>,
    /// Its binary chunk.
    pub bin: Option<Vec<u8>>,
}

impl Seed {
    pub fn glb(gltf: &Gltf) -> Seed {
        let mut json = gltf.json.clone();
        json["buffers"][0]["byteLength"] = json!(gltf.bin.len());
        Seed {
            name: "scene.glb",
            json_or_text: json.to_string().into_bytes(),
            bin: Some(gltf.bin.clone()),
        }
    }

    /// The parts of a sound GLB file.
    pub fn of_glb(name: &'static str, file: &[u8]) -> Seed {
        let chunk = |at: usize| {
            let length = u32::from_le_bytes(file[at..at + 4].try_into().expect("4 bytes"));
            file[at + 8..][..length as usize].to_vec()
        };
        let json = chunk(12);
        let bin = chunk(20 + json.len());
        Seed {
            name,
            json_or_text: json,
            bin: Some(bin),
        }
    }

    /// The file as it was.
    pub fn whole(&self) -> Vec<u8> {
        match &self.bin {
            Some(bin) => glb(&self.json_or_text, bin),
            None => self.json_or_text.clone(),
        }
    }

    /// The file with one to three changes.
    pub fn mutated(&self, random: &mut Random) -> Vec<u8> {
        let (mut text, mut bin) = (self.json_or_text.clone(), self.bin.clone());
        for _ in 0..=random.below(2) {
            match (random.below(6), &mut bin) {
                (0 | 1, Some(bin)) => change_words(bin, random),
                (2, Some(bin)) => change_bytes(bin, random),
                (3, _) => change_bytes(&mut text, random),
                (4, _) => change_number(&mut text, random),
                _ => change_digit(&mut text, random),
            }
        }
        let mut file = bin.map_or(text.clone(), |bin| glb(&text, &bin));
        if random.below(8) == 0 {
            change_bytes(&mut file, random);
        }
        file
    }
}
