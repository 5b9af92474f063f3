//! Loads an archive: from bytes that anyone may have written to a scene and clusters that are valid.

use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;
use rayon::prelude::*;

use super::error::{ArchiveError, Fault};
use super::mapping::Mapping;
use super::records::{Element, Fields, MeshSizes, ObjectRecord, Record, SurfaceRecord};
use super::table::Table;
use super::{
    CLUSTER_QUADS, CLUSTER_X, CLUSTER_Y, CLUSTER_Z, CLUSTERS, HIERARCHY, Kind, MAGIC, MESHES,
    NAMES, OBJECTS, ORDER, POSITIONS, SURFACES, TRIANGLES, VISIBILITY, WARNINGS,
};
use crate::prepare::clusters::ClusterOutline;
use crate::prepare::likeness::TriangleHash;
use crate::prepare::{ClusteredMesh, ClusteredScene, Prepared, VisibilityGrid};
use crate::scene::{Alpha, Array, Hierarchy, Material, Mesh, Object, Scene, Surface};

/// The most levels of a hierarchy that is read. Those that are made have some dozens; to walk one that is a chain of all
/// objects would take for ever.
const MOST_LEVELS: usize = 4096;

/// Whether a file is an archive, by its first bytes. False if it cannot be read.
pub(in crate::prepare) fn is_archive(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    // What is no regular file may never end, or wait for ever.
    path.is_file()
        && File::open(path)
            .and_then(|mut file| file.read_exact(&mut magic))
            .is_ok()
        && magic == MAGIC
}

/// Loads an archive.
pub(in crate::prepare) fn load(path: &Path) -> Result<Prepared, ArchiveError> {
    let unreadable = |source| ArchiveError::Read {
        file: path.to_path_buf(),
        source,
    };
    let file = File::open(path).map_err(unreadable)?;
    if !file.metadata().map_err(unreadable)?.is_file() {
        let cause = "it is not a regular file";
        let error = std::io::Error::new(std::io::ErrorKind::InvalidInput, cause);
        return Err(unreadable(error));
    }
    let mapping = Mapping::open(file, path).map_err(unreadable)?;
    read(Arc::new(mapping)).map_err(|fault| fault.in_file(path))
}

fn read(mapping: Arc<Mapping>) -> Result<Prepared, Fault> {
    let table = Table::check(mapping.bytes())?;
    let mut source = Source::new(&mapping, &table)?;
    let sizes: Vec<MeshSizes> = source.all(MESHES)?;
    let mut parts = Vec::with_capacity(sizes.len());
    for (index, sizes) in sizes.iter().enumerate() {
        let part = source.next_mesh(sizes);
        parts.push(
            part.map_err(|(kind, cause)| Fault::at(kind.name, format!("mesh {index}: {cause}")))?,
        );
    }
    let mut objects = Vec::new();
    for (index, record) in source.all(OBJECTS)?.iter().enumerate() {
        let object = source.next_object(record);
        objects.push(
            object.map_err(|cause| Fault::at(NAMES.name, format!("object {index}: {cause}")))?,
        );
    }
    source.finish()?;
    let hierarchy = Hierarchy {
        links: source.all(HIERARCHY)?,
        objects: source.all(ORDER)?,
    };
    let warnings = source.warnings()?;

    let (meshes, clusters): (Vec<Mesh>, Vec<Clusters>) = parts.into_iter().unzip();
    let scene = Scene::restored(meshes, objects, hierarchy, warnings).map_err(Fault::Scene)?;
    if scene.bvh().depth() > MOST_LEVELS {
        let cause = format!("it has more than {MOST_LEVELS} levels");
        return Err(Fault::at(HIERARCHY.name, cause));
    }
    let occluders = restored(&scene, clusters)?;
    let prepared = Prepared::of(Arc::new(scene), Arc::new(occluders));
    let grid = &mapping.bytes()[table.find(VISIBILITY).unwrap_or_default()];
    if grid.is_empty() {
        return Ok(prepared);
    }
    VisibilityGrid::from_bytes(grid)
        .and_then(|grid| prepared.with_visibility_grid(Arc::new(grid)))
        .map_err(|cause| Fault::at(VISIBILITY.name, cause))
}

/// The clusters of a mesh before they have been checked.
struct Clusters {
    outlines: Vec<ClusterOutline>,
    vertices: [Array<f32>; 3],
    quads: Array<[u8; 4]>,
}

/// Checks the clusters of all meshes, on the current threads.
fn restored(scene: &Scene, clusters: Vec<Clusters>) -> Result<ClusteredScene, Fault> {
    let occludes = ClusteredScene::occluding_meshes(scene);
    let hash = TriangleHash::drawn();
    let meshes = clusters.into_par_iter().zip(scene.meshes()).zip(occludes);
    let mesh = |(index, ((clusters, mesh), occludes)): (usize, ((Clusters, &Mesh), bool))| {
        let fault = |cause: String| Fault::at(CLUSTERS.name, format!("mesh {index}: {cause}"));
        let Clusters {
            outlines,
            vertices,
            quads,
        } = clusters;
        let clustered = ClusteredMesh::restored(outlines, vertices, quads).map_err(fault)?;
        let is_none = clustered.clusters().is_empty();
        let is_right = if occludes {
            hash.is_alike(mesh, &clustered)
        } else {
            is_none
        };
        if !is_right {
            let cause = "they do not hold the triangles that it occludes by".to_owned();
            return Err(fault(cause));
        }
        Ok((!is_none).then_some(clustered))
    };
    let meshes: Result<Vec<_>, Fault> = meshes.enumerate().map(mesh).collect();
    meshes.map(ClusteredScene::of)
}

/// A section that is handed out piece by piece.
struct Cursor {
    kind: Kind,
    left: Range<usize>,
}

impl Cursor {
    /// The next `count` things of so many bytes.
    fn next(&mut self, count: u64, bytes: usize) -> Result<Range<usize>, (Kind, &'static str)> {
        let length = usize::try_from(count)
            .ok()
            .and_then(|count| count.checked_mul(bytes));
        let length = length.filter(|&length| length <= self.left.len());
        let length = length.ok_or((self.kind, "there is less than it should have"))?;
        let start = self.left.start;
        self.left.start += length;
        Ok(start..self.left.start)
    }
}

/// The sections, as far as they have been handed out.
struct Source<'a> {
    mapping: &'a Arc<Mapping>,
    table: &'a Table,
    names: Cursor,
    surfaces: Cursor,
    positions: Cursor,
    triangles: Cursor,
    clusters: Cursor,
    vertices: [Cursor; 3],
    quads: Cursor,
}

type Piece<T> = Result<T, (Kind, String)>;

impl<'a> Source<'a> {
    fn new(mapping: &'a Arc<Mapping>, table: &'a Table) -> Result<Source<'a>, Fault> {
        let cursor = |kind| {
            let left = table.get(kind)?;
            Ok(Cursor { kind, left })
        };
        Ok(Source {
            mapping,
            table,
            names: cursor(NAMES)?,
            surfaces: cursor(SURFACES)?,
            positions: cursor(POSITIONS)?,
            triangles: cursor(TRIANGLES)?,
            clusters: cursor(CLUSTERS)?,
            vertices: [cursor(CLUSTER_X)?, cursor(CLUSTER_Y)?, cursor(CLUSTER_Z)?],
            quads: cursor(CLUSTER_QUADS)?,
        })
    }

    /// All records of a section.
    fn all<R: Record>(&self, kind: Kind) -> Result<Vec<R>, Fault> {
        let range = self.table.get(kind)?;
        if range.len() % R::BYTES != 0 {
            return Err(Fault::at(kind.name, "it ends within a record"));
        }
        let records = self.records(range);
        records.map_err(|(index, cause)| Fault::at(kind.name, format!("record {index}: {cause}")))
    }

    fn records<R: Record>(&self, range: Range<usize>) -> Result<Vec<R>, (usize, &'static str)> {
        let records = self.mapping.bytes()[range]
            .chunks_exact(R::BYTES)
            .enumerate();
        let read = |(index, record)| R::read(&mut Fields::of(record)).map_err(|e| (index, e));
        records.map(read).collect()
    }

    /// The next elements, where they lie.
    fn elements<E: Element>(
        mapping: &Arc<Mapping>,
        cursor: &mut Cursor,
        count: u64,
    ) -> Piece<Array<E>> {
        let piece = |(kind, cause): (Kind, &str)| (kind, cause.to_owned());
        let range = cursor.next(count, size_of::<E>()).map_err(piece)?;
        let array = Array::shared(mapping.clone(), |mapping| {
            bytemuck::try_cast_slice(mapping.bytes().get(range)?).ok()
        });
        let mut array: Array<E> = array.ok_or((cursor.kind, "it lies askew".to_owned()))?;
        if cfg!(target_endian = "big") {
            array = array.iter().map(|e: &E| e.little_endian()).collect();
        }
        Ok(array)
    }

    /// The next piece of a section of records.
    fn next_records<R: Record>(&self, cursor: &Cursor, range: Range<usize>) -> Piece<Vec<R>> {
        let records = self.records(range);
        records.map_err(|(index, cause)| (cursor.kind, format!("record {index}: {cause}")))
    }

    fn next_name(&mut self, bytes: u64) -> Result<String, &'static str> {
        let range = self.names.next(bytes, 1).map_err(|(_, cause)| cause)?;
        let name = str::from_utf8(&self.mapping.bytes()[range]);
        name.map(str::to_owned).map_err(|_| "its name is not UTF-8")
    }

    fn next_mesh(&mut self, sizes: &MeshSizes) -> Piece<(Mesh, Clusters)> {
        let piece = |(kind, cause): (Kind, &str)| (kind, cause.to_owned());
        let name = self
            .next_name(sizes.name)
            .map_err(|cause| piece((NAMES, cause)))?;
        let range = self
            .surfaces
            .next(sizes.surfaces, SurfaceRecord::BYTES)
            .map_err(piece)?;
        let surfaces = self.next_records(&self.surfaces, range)?;
        let surfaces = surfaces_of(&surfaces).map_err(|cause| (SURFACES, cause))?;
        let mapping = self.mapping;
        let positions = Source::elements(mapping, &mut self.positions, sizes.positions)?;
        let triangles = Source::elements(mapping, &mut self.triangles, sizes.triangles)?;
        let range = self
            .clusters
            .next(sizes.clusters, ClusterOutline::BYTES)
            .map_err(piece)?;
        let outlines = self.next_records(&self.clusters, range)?;
        let [x, y, z] = &mut self.vertices;
        let axis = |cursor| Source::elements(mapping, cursor, sizes.cluster_vertices);
        let vertices = [axis(x)?, axis(y)?, axis(z)?];
        let quads = Source::elements(mapping, &mut self.quads, sizes.cluster_quads)?;
        let mesh = Mesh {
            name,
            positions,
            triangles,
            surfaces,
        };
        let clusters = Clusters {
            outlines,
            vertices,
            quads,
        };
        Ok((mesh, clusters))
    }

    fn next_object(&mut self, record: &ObjectRecord) -> Result<Object, &'static str> {
        Ok(Object {
            name: self.next_name(u64::from(record.name))?,
            mesh: record.mesh as usize,
            world_from_local: DAffine3::from_cols_array(&record.matrix),
            never_cull: record.never_cull,
            never_occlude: record.never_occlude,
            occluder_proxy: (record.proxy != u32::MAX).then_some(record.proxy as usize),
        })
    }

    /// Makes sure that everything has been handed out.
    fn finish(&self) -> Result<(), Fault> {
        let [x, y, z] = &self.vertices;
        let cursors = [
            &self.names,
            &self.surfaces,
            &self.positions,
            &self.triangles,
            &self.clusters,
            x,
            y,
            z,
            &self.quads,
        ];
        match cursors.iter().find(|cursor| !cursor.left.is_empty()) {
            Some(cursor) => Err(Fault::at(
                cursor.kind.name,
                "there is more than the meshes and objects have",
            )),
            None => Ok(()),
        }
    }

    fn warnings(&self) -> Result<Vec<String>, Fault> {
        let mut left = &self.mapping.bytes()[self.table.find(WARNINGS).unwrap_or_default()];
        let mut warnings = Vec::new();
        while !left.is_empty() {
            let sentence = left.split_first_chunk().and_then(|(length, rest)| {
                let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
                let (sentence, rest) = rest.split_at_checked(length)?;
                left = rest;
                str::from_utf8(sentence).ok()
            });
            let sentence =
                sentence.ok_or_else(|| Fault::at(WARNINGS.name, "they are no sentences"))?;
            warnings.push(sentence.to_owned());
        }
        Ok(warnings)
    }
}

fn surfaces_of(records: &[SurfaceRecord]) -> Result<Vec<Surface>, String> {
    let mut start = 0usize;
    let surface = |(index, record): (usize, &SurfaceRecord)| {
        let alpha = match record.alpha {
            0 => Alpha::Opaque,
            1 => Alpha::Mask,
            2 => Alpha::Blend,
            _ => return Err(format!("surface {index} has an unknown alpha mode")),
        };
        if record.double_sided > 1 {
            return Err(format!("surface {index} has neither one side nor two"));
        }
        let end = usize::try_from(record.triangles)
            .ok()
            .and_then(|count| start.checked_add(count));
        let end = end.ok_or_else(|| format!("surface {index} has too many triangles"))?;
        let triangles = start..end;
        start = end;
        let material = Material {
            alpha,
            double_sided: record.double_sided == 1,
            color: record.color,
        };
        Ok(Surface {
            triangles,
            material,
        })
    };
    records.iter().enumerate().map(surface).collect()
}
