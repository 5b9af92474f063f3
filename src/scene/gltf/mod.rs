//! glTF 2.0, as JSON with buffers beside it or as one binary file.
//!
//! **Problem.** Everything in the file refers to everything else by number, and any number may be wrong. The gltf
//! crate gives the format's vocabulary ([`::gltf::json`]: component types, element types, modes); its readers and its
//! validation panic on some damaged files, so the records are our own ([`document`]) and each number is checked where
//! it is used. They also keep node transforms in f64, which the crate rounds to f32, and leave out every field that
//! places no triangle, so that the JSON's size bounds their memory.
//!
//! **Way of the data.** [`container`]: bytes to JSON and binary chunk. [`document`]: JSON to records. [`nodes`]: the
//! tree, walked in depth-first order, gives placements; each asks [`meshes`] for its mesh, which is decoded the first
//! time ([`topology`], [`accessor`], [`buffers`]), and changed if it is deformed ([`pose`]).
//!
//! Source: Khronos Group, *glTF 2.0 Specification*, revision 2.0.1; sections are quoted as glTF §3.7.

mod accessor;
mod buffers;
mod container;
mod document;
mod materials;
mod meshes;
mod nodes;
mod pose;
mod topology;

use std::path::Path;

use super::error::{Fault, Label};
use super::load_budget::LoadBudget;
use super::warnings::Warnings;
use super::{Mesh, Object};

type Result<T> = std::result::Result<T, Fault>;

/// Everything the steps share while one file is read.
struct Source<'a> {
    document: &'a document::Document,
    buffers: buffers::Buffers<'a>,
    budget: &'a LoadBudget,
}

/// Reads a `.gltf` or `.glb` file; which of the two is told by its first bytes.
pub(super) fn read(
    bytes: Vec<u8>,
    folder: &Path,
    budget: &LoadBudget,
    warnings: &mut Warnings,
) -> Result<(Vec<Mesh>, Vec<Object>)> {
    let parts = container::split(&bytes, warnings)?;
    let document = document::parse(parts.json, budget)?;
    document::check_extensions(&document)?;
    let buffers = buffers::Buffers::new(&document, parts.binary, folder, budget);
    let source = Source {
        document: &document,
        buffers,
        budget,
    };
    nodes::place(&source, warnings)
}

fn label<'a>(kind: &'a str, index: u32, name: Option<&'a str>) -> Label<'a> {
    Label {
        kind,
        index: index as usize,
        name: name.unwrap_or_default(),
    }
}

/// What a number in the file refers to, or why it refers to nothing.
fn lookup<'a, T>(records: &'a [T], index: u32, kind: &str) -> Result<&'a T> {
    records.get(index as usize).ok_or_else(|| {
        Fault::damaged(
            format_args!("{kind} {index}"),
            format_args!("there is none: the file has {} of them", records.len()),
        )
    })
}
