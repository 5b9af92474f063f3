//! How the input of `scene_files` is laid out: a byte for the kind of file, then what the file is made of. Checksums and lengths
//! that a change would break are made anew, so that changes get past them.
//!
//! ```text
//!   0  a GLB file as it is                 3  the sections of an archive: kind, flags, length (4 bytes), bytes
//!   1  a glTF file's text                  4  an archive as it is
//!   2  an OBJ file, a zero, its materials  5  a GLB file's JSON, a zero, its binary chunk
//! ```

use super::archives::{Section, put_together};
use super::scene_files::glb;

/// The name of a file and its bytes, and the bytes of the materials that stand beside it.
pub struct SceneBytes {
    pub name: &'static str,
    pub file: Vec<u8>,
    pub materials: Vec<u8>,
}

fn split_at_zero(bytes: &[u8]) -> (&[u8], &[u8]) {
    match bytes.iter().position(|&b| b == 0) {
        Some(at) => (&bytes[..at], &bytes[at + 1..]),
        None => (bytes, &[]),
    }
}

fn sections(mut bytes: &[u8]) -> Vec<Section> {
    let mut sections = Vec::new();
    while let Some((&[kind, flags, a, b, c, d], rest)) = bytes.split_first_chunk::<6>() {
        let length = (u32::from_le_bytes([a, b, c, d]) as usize).min(rest.len());
        sections.push(Section {
            kind: kind.into(),
            flags: flags.into(),
            bytes: rest[..length].to_vec(),
        });
        bytes = &rest[length..];
    }
    sections
}

#[allow(dead_code, reason = "only seeds are made of sound archives")]
/// The input for an archive of these sections.
pub fn input_of_sections(sections: &[Section]) -> Vec<u8> {
    let mut input = vec![3];
    for section in sections {
        input.extend([section.kind as u8, section.flags as u8]);
        input.extend((section.bytes.len() as u32).to_le_bytes());
        input.extend(&section.bytes);
    }
    input
}

/// The file that an input stands for.
pub fn scene_bytes(input: &[u8]) -> Option<SceneBytes> {
    let (&kind, rest) = input.split_first()?;
    let (name, file, materials) = match kind % 6 {
        0 => ("scene.glb", rest.to_vec(), Vec::new()),
        1 => ("scene.gltf", rest.to_vec(), Vec::new()),
        2 => {
            let (text, materials) = split_at_zero(rest);
            ("scene.obj", text.to_vec(), materials.to_vec())
        }
        3 => (
            "scene.antumbra",
            put_together(1, &sections(rest)),
            Vec::new(),
        ),
        4 => ("scene.antumbra", rest.to_vec(), Vec::new()),
        _ => {
            let (json, bin) = split_at_zero(rest);
            ("scene.glb", glb(json, bin), Vec::new())
        }
    };
    Some(SceneBytes {
        name,
        file,
        materials,
    })
}
