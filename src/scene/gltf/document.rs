//! JSON to records: of each glTF object, the fields that can move a triangle or let light through it.
//!
//! **Invariant.** The records take no more memory than [`parse`] has reserved, by counting the JSON's marks: a record
//! is at most [`RECORD_BYTES`], a list element 8. (The shortest record, `{}`, takes three bytes of text.) So lists
//! inside records are boxed slices, which have no spare room.

use ::gltf::json::accessor::{GenericComponentType, IndexComponentType, Type};
use ::gltf::json::material::AlphaMode;
use ::gltf::json::mesh::Mode;
use ::gltf::json::validation::Checked;
use serde::Deserialize;
use serde_json::value::RawValue;

use super::Result;
use crate::scene::error::Fault;
use crate::scene::load_budget::LoadBudget;

/// What one record may take, its name's allocation included.
const RECORD_BYTES: u64 = 176;
const _: () = assert!(size_of::<Node>() <= 136 && size_of::<Accessor>() <= 136);
const _: () = assert!(
    size_of::<Material>() <= 136 && size_of::<Mesh>() <= 136 && size_of::<Primitive>() <= 136
);

pub(super) type Name = Option<Box<str>>;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub asset: Asset,
    pub scene: Option<u32>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub skins: Vec<Skin>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub extensions_used: Vec<Box<str>>,
    #[serde(default)]
    pub extensions_required: Vec<Box<str>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Asset {
    pub version: Box<str>,
    pub min_version: Name,
}

#[derive(Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub nodes: Box<[u32]>,
}

#[derive(Deserialize)]
pub(super) struct Node {
    pub name: Name,
    pub mesh: Option<u32>,
    pub skin: Option<u32>,
    #[serde(default)]
    pub children: Box<[u32]>,
    pub matrix: Option<Box<[f64; 16]>>,
    pub translation: Option<Box<[f64; 3]>>,
    pub rotation: Option<Box<[f64; 4]>>,
    pub scale: Option<Box<[f64; 3]>>,
    pub weights: Option<Box<[f64]>>,
    pub extensions: Option<Box<NodeExtensions>>,
    pub extras: Option<Box<RawValue>>,
}

#[derive(Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
}

#[derive(Deserialize)]
pub(super) struct Instancing {
    #[serde(default)]
    pub attributes: InstanceAttributes,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct InstanceAttributes {
    pub translation: Option<u32>,
    pub rotation: Option<u32>,
    pub scale: Option<u32>,
}

#[derive(Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "yes")]
    pub visible: bool,
}

fn yes() -> bool {
    true
}

/// What a node's `extras` may say to Antumbra: `{"antumbra": {"never_cull": true}}`.
#[derive(Default, Deserialize)]
pub(super) struct Extras {
    pub antumbra: Option<Flags>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Flags {
    #[serde(default)]
    pub never_cull: bool,
    #[serde(default)]
    pub never_occlude: bool,
    pub occluder_proxy: Option<String>,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub name: Name,
    pub primitives: Box<[Primitive]>,
    pub weights: Option<Box<[f64]>>,
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<u32>,
    pub material: Option<u32>,
    #[serde(default)]
    pub mode: Checked<Mode>,
    #[serde(default)]
    pub targets: Box<[Target]>,
}

/// Two sets of joints, which make eight to a vertex.
#[derive(Clone, Copy, Deserialize, PartialEq, Eq, Hash)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<u32>,
    #[serde(rename = "JOINTS_0")]
    pub joints_0: Option<u32>,
    #[serde(rename = "WEIGHTS_0")]
    pub weights_0: Option<u32>,
    #[serde(rename = "JOINTS_1")]
    pub joints_1: Option<u32>,
    #[serde(rename = "WEIGHTS_1")]
    pub weights_1: Option<u32>,
}

impl Attributes {
    pub(super) fn only_position(position: u32) -> Attributes {
        Attributes {
            position: Some(position),
            joints_0: None,
            weights_0: None,
            joints_1: None,
            weights_1: None,
        }
    }
}

#[derive(Deserialize, PartialEq, Eq, Hash)]
pub(super) struct Target {
    #[serde(rename = "POSITION")]
    pub position: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    pub name: Name,
    #[serde(default)]
    pub double_sided: bool,
    #[serde(default)]
    pub alpha_mode: Checked<AlphaMode>,
    pub pbr_metallic_roughness: Option<Box<Pbr>>,
    pub extensions: Option<Box<MaterialExtensions>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Pbr {
    pub base_color_factor: Option<[f32; 4]>,
}

#[derive(Deserialize)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_transmission")]
    pub transmission: Option<Transmission>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Transmission {
    #[serde(default)]
    pub transmission_factor: f32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub name: Name,
    pub joints: Box<[u32]>,
    pub inverse_bind_matrices: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<u32>,
    #[serde(default)]
    pub byte_offset: u64,
    pub count: u64,
    pub component_type: Checked<GenericComponentType>,
    #[serde(rename = "type")]
    pub element: Checked<Type>,
    #[serde(default)]
    pub normalized: bool,
    pub sparse: Option<Box<Sparse>>,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub buffer_view: u32,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: Checked<IndexComponentType>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub buffer_view: u32,
    #[serde(default)]
    pub byte_offset: u64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: u32,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    #[serde(default)]
    pub byte_stride: u64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub byte_length: u64,
    pub uri: Name,
}

/// Reads the records, having reserved what they take.
pub(super) fn parse(json: &[u8], budget: &LoadBudget) -> Result<Document> {
    budget.reserve(memory_of_records(json), "its JSON")?;
    let document: Document =
        serde_json::from_slice(json).map_err(|error| Fault::damaged("its JSON", error))?;
    let version = &document.asset.version;
    let lowest = document.asset.min_version.as_deref().unwrap_or("2.0");
    if version.split('.').next() != Some("2") || !(lowest == "2.0" || lowest.starts_with("1.")) {
        return Err(Fault::unsupported(
            "asset",
            format!("it is glTF {version}, for readers of {lowest} or later"),
            "convert it to glTF 2.0",
        ));
    }
    Ok(document)
}

/// An upper bound, from the JSON's marks outside strings.
fn memory_of_records(json: &[u8]) -> u64 {
    let (mut records, mut lists, mut commas) = (0u64, 0u64, 0u64);
    let (mut in_string, mut escaped) = (false, false);
    for &byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            _ if in_string => {}
            b'{' => records += 1,
            b'[' => lists += 1,
            b',' => commas += 1,
            _ => {}
        }
    }
    // The text once more: names, URIs and extras are copied from it.
    records * RECORD_BYTES + lists * 32 + commas * 8 + json.len() as u64
}

/// Extensions that may be required of us: those we read, and those that touch neither geometry nor what is opaque.
const UNDERSTOOD: &[&str] = &[
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
    "KHR_node_visibility",
    "KHR_lights_punctual",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "EXT_mesh_features",
    "EXT_instance_features",
    "EXT_structural_metadata",
    "MSFT_texture_dds",
    "GODOT_single_root",
];
const UNDERSTOOD_FAMILIES: &[&str] = &[
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "EXT_lights_",
];

/// Refuses a file that requires what we lack: it would not look as its author meant.
pub(super) fn check_extensions(document: &Document) -> Result<()> {
    for name in &document.extensions_required {
        let name: &str = name;
        if UNDERSTOOD.contains(&name)
            || UNDERSTOOD_FAMILIES
                .iter()
                .any(|family| name.starts_with(family))
        {
            continue;
        }
        let remedy = match name {
            "KHR_draco_mesh_compression"
            | "EXT_meshopt_compression"
            | "KHR_meshopt_compression" => {
                "decompress it first, for example with: gltf-transform copy IN.glb OUT.glb"
            }
            _ => "export the scene without it",
        };
        return Err(Fault::unsupported(
            "extensionsRequired",
            format!("it requires {name:?}"),
            remedy,
        ));
    }
    Ok(())
}

impl Document {
    /// Whether the file says that it uses an extension.
    pub(super) fn uses(&self, extension: &str) -> bool {
        self.extensions_used
            .iter()
            .chain(&self.extensions_required)
            .any(|e| **e == *extension)
    }
}
