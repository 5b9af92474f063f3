//! Scenes made in memory.

use std::ffi::c_char;
use std::mem::{MaybeUninit, take};
use std::sync::Arc;

use antumbra::prepare::Prepared;
use antumbra::scene::{Material, Mesh, Object, Scene, Surface};

use crate::arguments::{empty, placement, required};
use crate::borrow::{handle, list, string};
use crate::handle::Locked;
use crate::material::AntumbraMaterial;
use crate::occluder::positions;
use crate::scene::{AntumbraScene, threads};
use crate::status::{AntumbraStatus, Error, guard};

/// What an object is besides a placed mesh: any of these, or 0.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraObjectFlags {
    /// Always in the visible set while its box meets the frustum.
    ANTUMBRA_OBJECT_NEVER_CULL = 1,
    /// Never drawn as an occluder.
    ANTUMBRA_OBJECT_NEVER_OCCLUDE = 2,
}

use AntumbraObjectFlags::*;

/// A scene that is being put together: meshes, and objects that place them in the world.
pub struct AntumbraSceneBuilder(Locked<Parts>);

#[derive(Default)]
struct Parts {
    meshes: Vec<Mesh>,
    objects: Vec<Object>,
}

fn count(things: usize, what: &str) -> Result<u32, Error> {
    u32::try_from(things).map_err(|_| Error::invalid(format_args!("too many {what}")))
}

impl Parts {
    fn mesh(&mut self, mesh: u32) -> Result<&mut Mesh, Error> {
        let count = self.meshes.len();
        let found = self.meshes.get_mut(mesh as usize);
        found.ok_or_else(|| Error::out_of_range("mesh", mesh, count))
    }

    fn object(&mut self, object: u32) -> Result<&mut Object, Error> {
        let count = self.objects.len();
        let found = self.objects.get_mut(object as usize);
        found.ok_or_else(|| Error::out_of_range("object", object, count))
    }
}

/// Begins a scene.
///
/// @param builder Is given a builder, to be destroyed by antumbra_scene_builder_destroy; NULL if there is an error.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_builder_create(
    builder: Option<&mut MaybeUninit<Option<Box<AntumbraSceneBuilder>>>>,
) -> AntumbraStatus {
    guard(|| {
        let place = empty(builder, "builder")?;
        let parts = Locked::new(Parts::default());
        *place = Some(Box::new(AntumbraSceneBuilder(parts)));
        Ok(())
    })
}

/// Ends a builder. NULL is fine. Scenes that it built go on.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_builder_destroy(builder: Option<Box<AntumbraSceneBuilder>>) {
    drop(builder);
}

/// Adds a mesh: positions, which are copied. antumbra_scene_builder_add_surface gives it triangles.
///
/// @param positions x, y and z of each vertex, local units, stride bytes from one to the next; a multiple of 4, at least 12.
/// @param mesh Is given the mesh's number, counted from 0.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if there is no such stride. Numbers that are not finite are found by
/// antumbra_scene_builder_build.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_builder_add_mesh(
    builder: *mut AntumbraSceneBuilder,
    positions: *const f32,
    vertex_count: usize,
    stride: usize,
    mesh: Option<&mut MaybeUninit<u32>>,
) -> AntumbraStatus {
    guard(|| {
        let mut parts = handle(builder, "builder")?.0.write()?;
        let place = required(mesh, "mesh")?;
        let number = count(parts.meshes.len(), "meshes")?;
        let floats = self::positions(positions, vertex_count, stride)?;
        let positions = floats.chunks(stride / size_of::<f32>());
        parts.meshes.push(Mesh {
            positions: positions
                .filter_map(|floats| floats.first_chunk().copied())
                .collect(),
            ..Mesh::default()
        });
        place.write(number);
        Ok(())
    })
}

/// Adds triangles of one material to a mesh.
///
/// @param indices Three vertices of the mesh each, counter-clockwise at the front; copied.
/// @param material NULL for an opaque, single-sided one.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such mesh or vertex, ANTUMBRA_ERROR_INVALID_ARGUMENT if index_count is no
/// multiple of 3 or there is no such material.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_builder_add_surface(
    builder: *mut AntumbraSceneBuilder,
    mesh: u32,
    indices: *const u32,
    index_count: usize,
    material: Option<&AntumbraMaterial>,
) -> AntumbraStatus {
    guard(|| {
        let mut parts = handle(builder, "builder")?.0.write()?;
        let mesh = parts.mesh(mesh)?;
        let material = material.map_or(Ok(Material::default()), AntumbraMaterial::checked)?;
        let indices = list(indices, index_count, "indices")?;
        let (triangles, rest) = indices.as_chunks();
        if !rest.is_empty() {
            let message = format_args!("{index_count} indices are not a multiple of 3");
            return Err(Error::invalid(message));
        }
        let vertices = mesh.positions.len();
        if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
            return Err(Error::out_of_range("vertex", index, vertices));
        }
        let first = mesh.triangles.len();
        mesh.triangles.to_mut().extend_from_slice(triangles);
        mesh.surfaces.push(Surface {
            triangles: first..mesh.triangles.len(),
            material,
        });
        Ok(())
    })
}

/// Adds an object: a mesh, placed in the world. It is the unit that is culled or kept.
///
/// @param world_from_local 16 numbers, column by column, whose last row is 0 0 0 1; it may mirror and scale unevenly; NULL for
///     the identity.
/// @param flags AntumbraObjectFlags, added up.
/// @param object Is given the object's number, counted from 0; may be NULL.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such mesh, ANTUMBRA_ERROR_INVALID_ARGUMENT if the matrix is not finite and
/// affine or there is no such flag.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_builder_add_object(
    builder: *mut AntumbraSceneBuilder,
    mesh: u32,
    world_from_local: *const f64,
    flags: u32,
    object: Option<&mut MaybeUninit<u32>>,
) -> AntumbraStatus {
    guard(|| {
        let mut parts = handle(builder, "builder")?.0.write()?;
        parts.mesh(mesh)?;
        let number = count(parts.objects.len(), "objects")?;
        let (never_cull, never_occlude) = (
            ANTUMBRA_OBJECT_NEVER_CULL as u32,
            ANTUMBRA_OBJECT_NEVER_OCCLUDE as u32,
        );
        if flags & !(never_cull | never_occlude) != 0 {
            let message = format_args!("flags are {flags:#x}, of which some are none");
            return Err(Error::invalid(message));
        }
        let world_from_local = placement(world_from_local, "world_from_local")?;
        parts.objects.push(Object {
            name: String::new(),
            mesh: mesh as usize,
            world_from_local,
            never_cull: flags & never_cull != 0,
            never_occlude: flags & never_occlude != 0,
            occluder_proxy: None,
        });
        if let Some(place) = object {
            place.write(number);
        }
        Ok(())
    })
}

/// Names an object; messages and antumbra_scene_object_name have the name.
///
/// @param name UTF-8, copied.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE, ANTUMBRA_ERROR_UTF8.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_builder_set_object_name(
    builder: *mut AntumbraSceneBuilder,
    object: u32,
    name: *const c_char,
) -> AntumbraStatus {
    guard(|| {
        let mut parts = handle(builder, "builder")?.0.write()?;
        string(name, "name")?.clone_into(&mut parts.object(object)?.name);
        Ok(())
    })
}

/// Draws another mesh in place of an object's own where it is an occluder, in the same local coordinates. Culling is exact only
/// if the proxy lies inside the object, whose surface is opaque and closed, and so deep that snapping (1/256 of a pixel) does not
/// bring its outline out.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such object or mesh.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_builder_set_occluder_proxy(
    builder: *mut AntumbraSceneBuilder,
    object: u32,
    mesh: u32,
) -> AntumbraStatus {
    guard(|| {
        let mut parts = handle(builder, "builder")?.0.write()?;
        parts.mesh(mesh)?;
        parts.object(object)?.occluder_proxy = Some(mesh as usize);
        Ok(())
    })
}

/// Builds the scene and prepares it, which takes seconds for a million triangles. The builder is empty then, also if
/// the scene makes no sense: another one can be begun with it.
///
/// @param threads How many may work at it, up to 1024; 0 for as many as the machine runs at once. They have ended when the
///     call has. The result is the same for any number.
/// @param scene Is given a scene, to be destroyed by antumbra_scene_destroy; NULL if there is an error.
///
/// Errors: ANTUMBRA_ERROR_SCENE if a position is not finite, an object's mesh has no triangles or reaches beyond coordinates of
/// 2^100, or there is no object; ANTUMBRA_ERROR_THREADS.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_builder_build(
    builder: *mut AntumbraSceneBuilder,
    threads: u32,
    scene: Option<&mut MaybeUninit<Option<Box<AntumbraScene>>>>,
) -> AntumbraStatus {
    guard(|| {
        let place = empty(scene, "scene")?;
        let mut parts = handle(builder, "builder")?.0.write()?;
        let threads = self::threads(threads)?;
        let Parts { meshes, objects } = take(&mut *parts);
        let prepared = threads.install(|| {
            let scene = Scene::new(meshes, objects)?;
            Ok::<_, Error>(Prepared::new(Arc::new(scene)))
        })?;
        *place = Some(Box::new(prepared.into()));
        Ok(())
    })
}
