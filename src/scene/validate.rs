//! The border that a scene crosses once: after this, indices are in range and numbers finite.
//!
//! Nothing behind it checks again, so the hot paths cannot fail.

use glam::DAffine3;

use super::error::Label;
use super::{Mesh, Object, SceneError};

/// The largest coordinate a scene may have, and the largest entry of a matrix: far enough below the largest f32 that
/// the difference of two, turned by any view matrix, is still finite there.
pub const MAX_COORDINATE: f64 = (1u128 << 100) as f64;

fn invalid(object: String, cause: String) -> SceneError {
    SceneError::Invalid {
        file: None,
        object,
        cause,
    }
}

pub(super) fn mesh_label(index: usize, mesh: &Mesh) -> String {
    Label {
        kind: "mesh",
        index,
        name: &mesh.name,
    }
    .to_string()
}

pub(super) fn object_label(index: usize, object: &Object) -> String {
    Label {
        kind: "object",
        index,
        name: &object.name,
    }
    .to_string()
}

/// Everything that can be checked without a vertex transformed.
pub(super) fn check(meshes: &[Mesh], objects: &[Object]) -> Result<(), SceneError> {
    for (i, mesh) in meshes.iter().enumerate() {
        check_mesh(mesh).map_err(|cause| invalid(mesh_label(i, mesh), cause))?;
    }
    if objects.len() > (u32::MAX / 2) as usize {
        return Err(invalid(
            format!("{} objects", objects.len()),
            "more than 32-bit indices can hold".to_owned(),
        ));
    }
    let mut any_triangle = false;
    for (i, object) in objects.iter().enumerate() {
        check_object(object, meshes).map_err(|cause| invalid(object_label(i, object), cause))?;
        any_triangle |= !meshes[object.mesh].triangles.is_empty();
    }
    if !any_triangle {
        return Err(SceneError::NoTriangles { file: None });
    }
    // Said last, so that a scene of nothing but empty objects is called what it is.
    match objects
        .iter()
        .enumerate()
        .find(|(_, o)| meshes[o.mesh].triangles.is_empty())
    {
        Some((i, o)) => Err(invalid(
            object_label(i, o),
            format!(
                "{} has no triangles, so the object has no place in the world; leave it out",
                { mesh_label(o.mesh, &meshes[o.mesh]) }
            ),
        )),
        None => Ok(()),
    }
}

fn check_mesh(mesh: &Mesh) -> Result<(), String> {
    let vertices = mesh.positions.len();
    if vertices > u32::MAX as usize {
        return Err(format!(
            "{vertices} vertices are more than 32-bit indices can hold; split the mesh"
        ));
    }
    if let Some(v) = mesh
        .positions
        .iter()
        .position(|p| !p.iter().all(|c| c.is_finite()))
    {
        return Err(format!(
            "vertex {v} has a position that is not finite: {:?}",
            mesh.positions[v]
        ));
    }
    // A branch-free maximum first: only a mesh that fails is searched for the triangle to blame.
    let highest = mesh.triangles.iter().flatten().copied().max();
    if highest.is_some_and(|h| h as usize >= vertices) {
        let bad = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= vertices);
        let t = mesh.triangles.iter().position(bad).unwrap_or(0);
        return Err(format!(
            "triangle {t} has an index out of range: {:?}, but there are {vertices} vertices",
            mesh.triangles[t]
        ));
    }
    let mut covered = 0;
    for (s, surface) in mesh.surfaces.iter().enumerate() {
        if surface.triangles.start != covered || surface.triangles.end < covered {
            return Err(format!(
                "surface {s} is triangles {:?}, but must start at {covered}, where the last one ends",
                surface.triangles
            ));
        }
        covered = surface.triangles.end;
        if !surface.material.color.iter().all(|c| c.is_finite()) {
            return Err(format!(
                "surface {s} has a colour that is not finite: {:?}",
                surface.material.color
            ));
        }
    }
    if covered != mesh.triangles.len() {
        return Err(format!(
            "its surfaces end at triangle {covered}, but it has {}",
            mesh.triangles.len()
        ));
    }
    Ok(())
}

fn check_object(object: &Object, meshes: &[Mesh]) -> Result<(), String> {
    for (what, index) in [
        ("mesh", Some(object.mesh)),
        ("occluder proxy", object.occluder_proxy),
    ] {
        if let Some(index) = index.filter(|&i| i >= meshes.len()) {
            return Err(format!(
                "its {what} is mesh {index}, but there are {}",
                meshes.len()
            ));
        }
    }
    check_placement(&object.world_from_local)
}

pub(super) fn check_placement(world_from_local: &DAffine3) -> Result<(), String> {
    let matrix = world_from_local.to_cols_array();
    if !matrix.iter().all(|m| m.is_finite()) {
        return Err(format!("its matrix is not finite: {matrix:?}"));
    }
    if let Some(m) = matrix.iter().find(|m| m.abs() > MAX_COORDINATE) {
        return Err(format!(
            "its matrix has an entry of {m:e}, beyond {MAX_COORDINATE:e}; scale the scene down"
        ));
    }
    Ok(())
}
