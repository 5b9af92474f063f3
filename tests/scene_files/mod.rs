//! Small scene files made in code, in a folder that goes away with its test.

#![allow(dead_code, reason = "each test program uses its own part of this")]

pub mod garbage;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use antumbra::scene::{Scene, SceneError};
use serde_json::{Value, json};

/// A folder of its own for one test.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Folder {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let unique = format!(
            "antumbra-scene-{}-{}",
            std::process::id(),
            COUNT.fetch_add(1, Ordering::Relaxed)
        );
        let path = std::env::temp_dir().join(unique);
        std::fs::create_dir_all(&path).expect("the temporary folder can be written");
        Folder(path)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().expect("inside the folder"))
            .expect("the folder can be made");
        std::fs::write(&path, bytes).expect("the temporary folder can be written");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Loads one file from a folder of its own.
pub fn load(name: &str, bytes: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    Scene::load(&folder.write(name, bytes))
}

/// The scene of a sound file.
#[track_caller]
pub fn loaded(gltf: &Gltf) -> Scene {
    load("scene.glb", gltf.glb()).unwrap_or_else(|error| panic!("{error}"))
}

/// The names of its objects, in order.
pub fn names(scene: &Scene) -> Vec<&str> {
    scene.objects().iter().map(|o| o.name.as_str()).collect()
}

/// The message of the error that loading ends in, which must name the file and each of `parts`.
#[track_caller]
pub fn assert_refused(name: &str, bytes: impl AsRef<[u8]>, parts: &[&str]) -> String {
    let message = load(name, bytes)
        .expect_err("the file should be refused")
        .to_string();
    for part in [&[name], parts].concat() {
        assert!(message.contains(part), "{part:?} is missing in: {message}");
    }
    message
}

pub const BYTE: u32 = 5120;
pub const UNSIGNED_BYTE: u32 = 5121;
pub const SHORT: u32 = 5122;
pub const UNSIGNED_SHORT: u32 = 5123;
pub const UNSIGNED_INT: u32 = 5125;
pub const FLOAT: u32 = 5126;

/// A glTF file under construction; its one buffer is `bin`.
#[derive(Clone)]
pub struct Gltf {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl Gltf {
    pub fn new() -> Gltf {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
            "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}],
        });
        Gltf {
            json,
            bin: Vec::new(),
        }
    }

    /// A file that places one triangle, (0 0 0) (1 0 0) (0 1 0), with 16-bit indices.
    pub fn triangle() -> Gltf {
        let mut gltf = Gltf::new();
        let mesh = gltf.triangle_mesh("wedge");
        gltf.root(json!({"name": "roof", "mesh": mesh}));
        gltf
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.bin.len().is_multiple_of(4) {
            self.bin.push(0);
        }
        let offset = self.bin.len();
        self.bin.extend(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}),
        )
    }

    pub fn accessor(&mut self, bytes: &[u8], component: u32, element: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": component, "type": element, "count": count}))
    }

    pub fn floats(&mut self, values: &[f32], element: &str, count: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, FLOAT, element, count)
    }

    pub fn positions(&mut self, points: &[[f32; 3]]) -> usize {
        self.floats(points.as_flattened(), "VEC3", points.len())
    }

    pub fn indices(&mut self, component: u32, values: &[u32]) -> usize {
        let width = match component {
            UNSIGNED_BYTE => 1,
            UNSIGNED_SHORT => 2,
            _ => 4,
        };
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|v| v.to_le_bytes()[..width].to_vec())
            .collect();
        self.accessor(&bytes, component, "SCALAR", values.len())
    }

    pub fn raw_accessor(&mut self, value: Value) -> usize {
        self.push("accessors", value)
    }

    pub fn mesh(&mut self, name: &str, primitives: Value) -> usize {
        self.push("meshes", json!({"name": name, "primitives": primitives}))
    }

    pub fn triangle_mesh(&mut self, name: &str) -> usize {
        let position = self.positions(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let indices = self.indices(UNSIGNED_SHORT, &[0, 1, 2]);
        self.mesh(
            name,
            json!([{"attributes": {"POSITION": position}, "indices": indices}]),
        )
    }

    pub fn material(&mut self, value: Value) -> usize {
        if self.json.get("materials").is_none() {
            self.json["materials"] = json!([]);
        }
        self.push("materials", value)
    }

    /// A node that nothing refers to yet.
    pub fn node(&mut self, value: Value) -> usize {
        self.push("nodes", value)
    }

    /// A node at the root of the first scene.
    pub fn root(&mut self, value: Value) -> usize {
        let node = self.node(value);
        self.json["scenes"][0]["nodes"]
            .as_array_mut()
            .expect("a list")
            .push(json!(node));
        node
    }

    /// The file in one.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"][0]["byteLength"] == 0 {
            json["buffers"][0]["byteLength"] = json!(self.bin.len());
        }
        glb(json.to_string().as_bytes(), &self.bin)
    }

    /// The JSON of a file whose buffer is found at `uri`.
    pub fn text(&self, uri: &str) -> String {
        let mut json = self.json.clone();
        json["buffers"][0] = json!({"byteLength": self.bin.len(), "uri": uri});
        json.to_string()
    }
}

/// Puts the two parts of a binary file together.
pub fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, chunk, filler) in [(b"JSON", json, b' '), (b"BIN\0", bin, 0)] {
        let padded = chunk.len().next_multiple_of(4);
        body.extend((padded as u32).to_le_bytes());
        body.extend(kind);
        body.extend(chunk);
        body.resize(body.len() + padded - chunk.len(), filler);
    }
    let mut file = b"glTF".to_vec();
    file.extend(2u32.to_le_bytes());
    file.extend((12 + body.len() as u32).to_le_bytes());
    file.extend(body);
    file
}

/// The corners of a mesh's triangles.
pub fn corners(scene: &Scene, mesh: usize) -> Vec<[[f32; 3]; 3]> {
    let mesh = &scene.meshes()[mesh];
    mesh.triangles
        .iter()
        .map(|t| t.map(|i| mesh.positions[i as usize]))
        .collect()
}
