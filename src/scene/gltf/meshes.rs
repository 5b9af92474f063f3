//! One mesh of the file becomes one [`Mesh`], however many nodes place it (glTF §3.7.2).
//!
//! **Problem.** A primitive's indices point into an accessor that it may share with a thousand other meshes, so a mesh
//! keeps only the vertices that its triangles use, in their order; primitives that share an accessor share them.
//!
//! **Invariant.** Memory is reserved before it is taken, and the time spent is in proportion to it: the table from old
//! index to new is as long as the accessor only if the accessor is hardly longer than the indices, otherwise the
//! indices are sorted.

use std::collections::HashMap;
use std::ops::Range;

use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::json::mesh::Mode;
use ::gltf::json::validation::Checked;

use super::accessor::Elements;
use super::document::{self, Attributes, Primitive};
use super::pose::{Deform, Pose, PoseKey};
use super::{Result, Source, label, lookup, materials, topology};
use crate::scene::error::{Fault, Label};
use crate::scene::warnings::Warnings;
use crate::scene::{Mesh, Surface};

const INDEX_COMPONENTS: &[ComponentType] =
    &[ComponentType::U8, ComponentType::U16, ComponentType::U32];
const FLOAT: &[ComponentType] = &[ComponentType::F32];
/// What KHR_mesh_quantization adds.
const QUANTIZED: &[ComponentType] = &[
    ComponentType::F32,
    ComponentType::I8,
    ComponentType::U8,
    ComponentType::I16,
    ComponentType::U16,
];

/// The meshes decoded so far.
pub(super) struct Meshes<'a, 's> {
    source: &'a Source<'s>,
    decoded: Vec<Mesh>,
    /// Where each mesh of the file, in each pose, is in `decoded`, or that it has no triangles.
    places: HashMap<(u32, PoseKey), Option<usize>>,
}

/// Primitives of one mesh that share their vertices.
struct Shared<'a> {
    primitive: &'a Primitive,
    runs: Vec<Range<usize>>,
}

impl<'a, 's> Meshes<'a, 's> {
    pub(super) fn new(source: &'a Source<'s>) -> Meshes<'a, 's> {
        Meshes {
            source,
            decoded: Vec::new(),
            places: HashMap::new(),
        }
    }

    pub(super) fn into_decoded(self) -> Vec<Mesh> {
        self.decoded
    }

    /// The mesh's place among the decoded ones, or `None` if it has no triangles. Each pose is a mesh of its own.
    pub(super) fn get(
        &mut self,
        index: u32,
        pose: Option<&Pose>,
        warnings: &mut Warnings,
    ) -> Result<Option<usize>> {
        let key = (index, pose.map(Pose::key).unwrap_or_default());
        if let Some(&place) = self.places.get(&key) {
            return Ok(place);
        }
        let record = lookup(&self.source.document.meshes, index, "mesh")?;
        let name = label("mesh", index, record.name.as_deref());
        let mesh = self
            .decode(record, pose, &name, warnings)
            .map_err(|fault| fault.within(&name))?;
        let place = (!mesh.triangles.is_empty()).then_some(self.decoded.len());
        if place.is_some() {
            self.decoded.push(mesh);
        }
        self.places.insert(key, place);
        Ok(place)
    }

    fn decode(
        &self,
        record: &'a document::Mesh,
        pose: Option<&Pose>,
        name: &Label,
        warnings: &mut Warnings,
    ) -> Result<Mesh> {
        let mut mesh = Mesh {
            name: record.name.as_deref().unwrap_or_default().to_owned(),
            ..Mesh::default()
        };
        self.source
            .budget
            .reserve((size_of::<Mesh>() + mesh.name.len()) as u64, "mesh")?;
        let mut shared: Vec<Shared> = Vec::new();
        let mut shared_with: HashMap<(Attributes, &[document::Target]), usize> = HashMap::new();
        for (p, primitive) in record.primitives.iter().enumerate() {
            let place = format!("primitive {p}");
            let mut left_out = |kind| warnings.note(kind, format_args!("{name}, {place}"));
            let Checked::Valid(mode) = primitive.mode else {
                return Err(Fault::damaged(place, "its mode is none that glTF knows"));
            };
            if matches!(
                mode,
                Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip
            ) {
                left_out("it draws points or lines, which are left out");
                continue;
            }
            let Some(position) = primitive.attributes.position else {
                left_out("it has no POSITION attribute and is left out");
                continue;
            };
            let run = self
                .push_triangles(primitive, mode, position, &mut mesh)
                .map_err(|f| f.within(&place))?;
            if run.is_empty() {
                left_out("it has no vertices and is left out");
                continue;
            }
            let material = materials::material(self.source, primitive.material)
                .map_err(|f| f.within(&place))?;
            mesh.surfaces.push(Surface {
                triangles: run.clone(),
                material,
            });
            // Undeformed, only the positions matter.
            let key = match pose {
                None => (Attributes::only_position(position), [].as_slice()),
                Some(_) => (primitive.attributes, &*primitive.targets),
            };
            let group = *shared_with.entry(key).or_insert(shared.len());
            if group == shared.len() {
                shared.push(Shared {
                    primitive,
                    runs: Vec::new(),
                });
            }
            shared[group].runs.push(run);
        }
        for group in shared {
            self.gather(group, pose, &mut mesh)?;
        }
        Ok(mesh)
    }

    /// Adds a primitive's triangles, their indices still the file's.
    fn push_triangles(
        &self,
        primitive: &Primitive,
        mode: Mode,
        position: u32,
        mesh: &mut Mesh,
    ) -> Result<Range<usize>> {
        let positions = self.positions(position)?;
        let indices = primitive
            .indices
            .map(|index| Elements::open(self.source, index))
            .transpose()?;
        if let Some(indices) = &indices {
            indices.must_be(Type::Scalar, INDEX_COMPONENTS, "an index")?;
        }
        let listed = indices
            .as_ref()
            .map_or(positions.count, |indices| indices.count);
        let count = topology::triangle_count(mode, listed)
            .map_err(|cause| Fault::damaged("its indices", cause))?;
        self.source
            .budget
            .reserve((count as u64).saturating_mul(12), "its triangles")?;
        self.source
            .budget
            .reserve(size_of::<Surface>() as u64, "its surface")?;
        let triangles = mesh.triangles.to_mut();
        let start = triangles.len();
        triangles.reserve_exact(count);
        match &indices {
            Some(indices) => triangles.extend((0..count).map(|i| {
                topology::corners(mode, i).map(|corner| indices.integers::<1>(corner)[0])
            })),
            None => triangles
                .extend((0..count).map(|i| topology::corners(mode, i).map(|corner| corner as u32))),
        }
        let new = &triangles[start..];
        let out_of_range = |index: u32| index as usize >= positions.count;
        if new
            .iter()
            .flatten()
            .copied()
            .max()
            .is_some_and(out_of_range)
        {
            let triangle = new
                .iter()
                .position(|t| t.iter().copied().any(out_of_range))
                .unwrap_or(0);
            return Err(Fault::damaged(
                "its indices",
                format!(
                    "triangle {triangle} has an index out of range: {:?}, but accessor {position} has {} vertices",
                    new[triangle], positions.count
                ),
            ));
        }
        Ok(start..triangles.len())
    }

    fn positions(&self, index: u32) -> Result<Elements<'a>> {
        let positions = Elements::open(self.source, index)?;
        let quantized = self.source.document.uses("KHR_mesh_quantization");
        positions.must_be(
            Type::Vec3,
            if quantized { QUANTIZED } else { FLOAT },
            "a position",
        )?;
        Ok(positions)
    }

    /// Adds the vertices that a group's triangles use, and makes their indices the mesh's.
    fn gather(&self, group: Shared<'a>, pose: Option<&Pose>, mesh: &mut Mesh) -> Result<()> {
        let Some(position) = group.primitive.attributes.position else {
            return Ok(());
        };
        let positions = self.positions(position)?;
        let deform = pose
            .map(|pose| Deform::new(self.source, pose, group.primitive, positions.count))
            .transpose()?;
        let base = mesh.positions.len();
        let renumber = Renumber::of(&mesh.triangles, &group.runs, positions.count);
        let used = renumber.used().count();
        self.source
            .budget
            .reserve((used as u64).saturating_mul(12), "its vertices")?;
        if base + used > u32::MAX as usize {
            return Err(Fault::damaged(
                "its vertices",
                "they are more than 32-bit indices can hold",
            ));
        }
        let vertices = mesh.positions.to_mut();
        vertices.reserve_exact(used);
        for vertex in renumber.used() {
            let local = positions.floats::<3>(vertex as usize);
            let local = match &deform {
                Some(deform) => deform
                    .apply(vertex as usize, local)
                    .map_err(|f| f.within(format!("vertex {vertex}")))?,
                None => local,
            };
            if !local.iter().all(|c| c.is_finite()) {
                return Err(Fault::damaged(
                    format_args!("accessor {position}"),
                    format!("vertex {vertex} has a position that is not finite: {local:?}"),
                ));
            }
            vertices.push(local);
        }
        let triangles = mesh.triangles.to_mut();
        for run in group.runs {
            for index in triangles[run].as_flattened_mut() {
                *index = base as u32 + renumber.new_index(*index);
            }
        }
        Ok(())
    }
}

/// From the indices of an accessor to those of the vertices in use, in the same order.
enum Renumber {
    /// One entry for each vertex of the accessor; [`UNUSED`] or the new index.
    Table(Vec<u32>),
    /// The used ones, ascending.
    Sorted(Vec<u32>),
}

const UNUSED: u32 = u32::MAX;

impl Renumber {
    fn of(triangles: &[[u32; 3]], runs: &[Range<usize>], vertices: usize) -> Renumber {
        let listed = || {
            runs.iter()
                .flat_map(|run| triangles[run.clone()].as_flattened())
                .copied()
        };
        let indices: usize = runs.iter().map(|run| 3 * run.len()).sum();
        if vertices / 4 > indices {
            let mut used: Vec<u32> = listed().collect();
            used.sort_unstable();
            used.dedup();
            return Renumber::Sorted(used);
        }
        let mut table = vec![UNUSED; vertices];
        listed().for_each(|index| table[index as usize] = 0);
        table
            .iter_mut()
            .filter(|entry| **entry != UNUSED)
            .zip(0..)
            .for_each(|(entry, new)| *entry = new);
        Renumber::Table(table)
    }

    /// The vertices in use, ascending.
    fn used(&self) -> impl Iterator<Item = u32> {
        let (table, sorted): (&[u32], &[u32]) = match self {
            Renumber::Table(table) => (table, &[]),
            Renumber::Sorted(used) => (&[], used),
        };
        let in_table = (0..)
            .zip(table)
            .filter(|&(_, &new)| new != UNUSED)
            .map(|(old, _)| old);
        in_table.chain(sorted.iter().copied())
    }

    fn new_index(&self, old: u32) -> u32 {
        match self {
            Renumber::Table(table) => table[old as usize],
            Renumber::Sorted(used) => used.partition_point(|&u| u < old) as u32,
        }
    }
}
