//! Writes an archive, section by section.
//!
//! The file appears under its name only when it is complete and on disk: until then it has another, in the same folder.
//! So a file of that name that was there before is whole until the new one takes its place, and whoever has mapped it
//! keeps it.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::error::ArchiveError;
use super::records::{Element, MeshSizes, ObjectRecord, Record, SurfaceRecord, put};
use super::table::Draft;
use super::{
    CLUSTER_QUADS, CLUSTER_X, CLUSTER_Y, CLUSTER_Z, CLUSTERS, HIERARCHY, KINDS, Kind, MESHES,
    NAMES, OBJECTS, ORDER, POSITIONS, SURFACES, TRIANGLES, VISIBILITY, WARNINGS,
};
use crate::prepare::{ClusteredMesh, Prepared};
use crate::scene::{Alpha, Mesh, Object, Surface};

/// So many drafts of a file may lie beside it, being written or left behind by who was ended.
const MOST_DRAFTS: u32 = 100;

/// Writes what has been prepared to a file; gives its length in bytes.
pub(in crate::prepare) fn save(prepared: &Prepared, file: &Path) -> Result<u64, ArchiveError> {
    let written = create_draft(file).and_then(|(draft, out)| {
        let written = write(prepared, out).and_then(|length| {
            std::fs::rename(&draft, file)?;
            Ok(length)
        });
        if written.is_err() {
            // Nothing is lost with it, and there is nothing to do if it stays.
            let _ = std::fs::remove_file(&draft);
        }
        written
    });
    written.map_err(|source| ArchiveError::Write {
        file: file.to_path_buf(),
        source,
    })
}

/// A file beside the one that is meant, and its name: one that nobody else is writing.
fn create_draft(file: &Path) -> io::Result<(PathBuf, File)> {
    let mut attempt = 0;
    loop {
        let mut name = std::ffi::OsString::from(".");
        name.push(file.file_name().unwrap_or_default());
        name.push(format!(".{}-{attempt}.tmp", std::process::id()));
        let name = file.with_file_name(name);
        match File::create_new(&name) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists && attempt < MOST_DRAFTS => {
                attempt += 1;
            }
            created => return created.map(|out| (name, out)),
        }
    }
}

fn write(prepared: &Prepared, mut out: File) -> io::Result<u64> {
    let mut table = Draft::of(KINDS.len());
    for kind in KINDS {
        let bytes = section(kind, prepared);
        // What lies between is never written, and so is zeros.
        out.seek(SeekFrom::Start(table.next_offset()))?;
        out.write_all(&bytes)?;
        table.add(kind, &bytes);
    }
    let (head, length) = table.finish();
    // The last section may be empty.
    out.set_len(length)?;
    out.rewind()?;
    out.write_all(&head)?;
    out.sync_all()?;
    Ok(length)
}

/// A section's bytes.
fn section(kind: Kind, prepared: &Prepared) -> Vec<u8> {
    let (scene, occluders) = (prepared.scene(), prepared.occluders());
    let meshes = || scene.meshes().iter();
    let objects = || scene.objects().iter();
    let clustered = || meshes().enumerate().filter_map(|(i, _)| occluders.mesh(i));
    let axis = |axis: usize| elements(clustered().map(|mesh| mesh.vertices()[axis]));
    match kind {
        MESHES => records(
            meshes()
                .enumerate()
                .map(|(i, mesh)| sizes(mesh, occluders.mesh(i))),
        ),
        SURFACES => records(meshes().flat_map(|mesh| &mesh.surfaces).map(surface)),
        POSITIONS => elements(meshes().map(|mesh| &mesh.positions[..])),
        TRIANGLES => elements(meshes().map(|mesh| &mesh.triangles[..])),
        OBJECTS => records(objects().map(object)),
        NAMES => {
            let names = meshes().map(|mesh| &mesh.name);
            names
                .chain(objects().map(|object| &object.name))
                .flat_map(|name| name.bytes())
                .collect()
        }
        HIERARCHY => records(
            scene
                .bvh()
                .nodes
                .iter()
                .map(|node| [node.first, node.count]),
        ),
        ORDER => records(scene.bvh().objects.iter().copied()),
        CLUSTERS => records(
            clustered()
                .flat_map(|mesh| mesh.clusters())
                .map(|c| c.outline()),
        ),
        CLUSTER_X => axis(0),
        CLUSTER_Y => axis(1),
        CLUSTER_Z => axis(2),
        CLUSTER_QUADS => elements(clustered().map(ClusteredMesh::quads)),
        WARNINGS => {
            let mut bytes = Vec::new();
            for warning in scene.warnings() {
                put(&mut bytes, (warning.len() as u32).to_le_bytes());
                bytes.extend_from_slice(warning.as_bytes());
            }
            bytes
        }
        VISIBILITY => {
            let grid = prepared.visibility_grid();
            grid.map_or_else(Vec::new, |grid| grid.to_bytes())
        }
        // There is none but the above.
        _ => Vec::new(),
    }
}

fn records<R: Record>(records: impl Iterator<Item = R>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(records.size_hint().0 * R::BYTES);
    for record in records {
        let end = bytes.len() + R::BYTES;
        record.put(&mut bytes);
        debug_assert_eq!(bytes.len(), end);
    }
    bytes
}

fn elements<'a, E: Element>(parts: impl Iterator<Item = &'a [E]>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for part in parts {
        if cfg!(target_endian = "little") {
            bytes.extend_from_slice(bytemuck::cast_slice(part));
        } else {
            part.iter()
                .for_each(|e| bytes.extend_from_slice(bytemuck::bytes_of(&e.little_endian())));
        }
    }
    bytes
}

fn sizes(mesh: &Mesh, clustered: Option<&ClusteredMesh>) -> MeshSizes {
    MeshSizes {
        name: mesh.name.len() as u64,
        positions: mesh.positions.len() as u64,
        triangles: mesh.triangles.len() as u64,
        surfaces: mesh.surfaces.len() as u64,
        clusters: clustered.map_or(0, |c| c.clusters().len() as u64),
        cluster_vertices: clustered.map_or(0, |c| c.vertices()[0].len() as u64),
        cluster_quads: clustered.map_or(0, |c| c.quads().len() as u64),
    }
}

fn surface(surface: &Surface) -> SurfaceRecord {
    SurfaceRecord {
        triangles: surface.triangles.len() as u64,
        alpha: match surface.material.alpha {
            Alpha::Opaque => 0,
            Alpha::Mask => 1,
            Alpha::Blend => 2,
        },
        double_sided: u32::from(surface.material.double_sided),
        color: surface.material.color,
    }
}

fn object(object: &Object) -> ObjectRecord {
    ObjectRecord {
        mesh: object.mesh as u32,
        proxy: object.occluder_proxy.map_or(u32::MAX, |proxy| proxy as u32),
        never_cull: object.never_cull,
        never_occlude: object.never_occlude,
        name: object.name.len() as u32,
        matrix: object.world_from_local.to_cols_array(),
    }
}
