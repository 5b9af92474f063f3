//! Wavefront OBJ, read by tobj.
//!
//! **Problem.** tobj's errors name no line, its faces take a hundred bytes each, it draws polylines as polygons, and
//! it knows no groups of several materials. So [`clean`] first rewrites the text: positions first, then faces of plain
//! absolute indices, and before each run of them one `o` statement that numbers it. What cannot be understood is found
//! there, with its line; what is left tobj reads without fail.
//!
//! **Rules.** Each `o` or `g` statement that faces follow begins an object (one that repeats the last does not). OBJ
//! knows no sidedness, so every surface has two sides. Polygons are cut into fans.

mod clean;
mod material_library;

use std::path::Path;

use glam::DAffine3;
use tobj::LoadOptions;

use super::error::Fault;
use super::load_budget::LoadBudget;
use super::warnings::Warnings;
use super::{Mesh, Object, Surface};

type Result<T> = std::result::Result<T, Fault>;

/// Reads an `.obj` file and the material libraries beside it.
pub(super) fn read(
    bytes: Vec<u8>,
    folder: &Path,
    budget: &LoadBudget,
    warnings: &mut Warnings,
) -> Result<(Vec<Mesh>, Vec<Object>)> {
    let clean = clean::clean(&bytes, folder, budget, warnings)?;
    drop(bytes);
    let options = LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..LoadOptions::default()
    };
    let no_libraries = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut clean.text.as_slice(), &options, no_libraries)
        .map_err(|error| Fault::damaged("its text", error))?;
    drop(clean.text);

    let mut meshes: Vec<Mesh> = Vec::new();
    let mut last_object = None;
    for model in models {
        // Only a file without faces has a model that no run begins.
        let Some(run) = model
            .name
            .parse()
            .ok()
            .and_then(|run: usize| clean.runs.get(run))
        else {
            continue;
        };
        if last_object.replace(run.object) != Some(run.object) {
            meshes.push(Mesh {
                name: clean.objects[run.object].clone(),
                ..Mesh::default()
            });
        }
        let Some(mesh) = meshes.last_mut() else {
            continue;
        };
        let base = u32::try_from(mesh.positions.len()).map_err(|_| {
            Fault::damaged(
                &mesh.name,
                "its vertices are more than 32-bit indices can hold",
            )
        })?;
        let start = mesh.triangles.len();
        mesh.positions
            .to_mut()
            .extend_from_slice(model.mesh.positions.as_chunks().0);
        mesh.triangles.to_mut().extend(
            model
                .mesh
                .indices
                .as_chunks()
                .0
                .iter()
                .map(|t: &[u32; 3]| t.map(|i| base + i)),
        );
        mesh.surfaces.push(Surface {
            triangles: start..mesh.triangles.len(),
            material: run.material,
        });
    }
    if meshes.is_empty() {
        return Err(Fault::no_triangles());
    }
    let place = |(i, mesh): (usize, &Mesh)| Object {
        name: mesh.name.clone(),
        mesh: i,
        world_from_local: DAffine3::IDENTITY,
        never_cull: false,
        never_occlude: false,
        occluder_proxy: None,
    };
    let objects = meshes.iter().enumerate().map(place).collect();
    Ok((meshes, objects))
}
