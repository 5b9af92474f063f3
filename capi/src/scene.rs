//! Scenes from files, and what is known of a scene.

use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::sync::{Arc, OnceLock};

use antumbra::prepare::{ArchiveError, Prepared};
use antumbra::scene::{Scene, SceneError};
use antumbra::threads::Threads;

use crate::arguments::{empty, required, within};
use crate::borrow::path;
use crate::handle::is_shared_by_threads;
use crate::questions::AntumbraBox;
use crate::settings::MOST_THREADS;
use crate::status::AntumbraStatus::{
    ANTUMBRA_ERROR_FILE, ANTUMBRA_ERROR_IO, ANTUMBRA_ERROR_SCENE, ANTUMBRA_ERROR_THREADS,
};
use crate::status::{AntumbraStatus, Error, c_string, guard};

/// A scene that is ready for culling. It never changes: any number of threads and cullers may use it at once, and it may be destroyed before
/// the cullers that were made of it.
pub struct AntumbraScene {
    pub(crate) prepared: Prepared,
    /// What cullers of this scene have in common, also when its objects have moved.
    pub(crate) identity: Arc<()>,
    /// Strings for C, made when somebody asks for them.
    names: OnceLock<Vec<CString>>,
    warnings: OnceLock<Vec<CString>>,
}

const _: () = is_shared_by_threads::<AntumbraScene>();

impl From<Prepared> for AntumbraScene {
    fn from(prepared: Prepared) -> AntumbraScene {
        AntumbraScene {
            prepared,
            identity: Arc::new(()),
            names: OnceLock::new(),
            warnings: OnceLock::new(),
        }
    }
}

impl AntumbraScene {
    fn scene(&self) -> &Arc<Scene> {
        self.prepared.scene()
    }
}

impl From<SceneError> for Error {
    fn from(error: SceneError) -> Error {
        let status = match &error {
            SceneError::Read { .. } => ANTUMBRA_ERROR_IO,
            SceneError::Invalid { file: None, .. } | SceneError::NoTriangles { file: None } => {
                ANTUMBRA_ERROR_SCENE
            }
            _ => ANTUMBRA_ERROR_FILE,
        };
        Error::new(status, error)
    }
}

impl From<ArchiveError> for Error {
    fn from(error: ArchiveError) -> Error {
        match error {
            ArchiveError::Scene(error) => error.into(),
            ArchiveError::Read { .. } | ArchiveError::Write { .. } => {
                Error::new(ANTUMBRA_ERROR_IO, error)
            }
            error => Error::new(ANTUMBRA_ERROR_FILE, error),
        }
    }
}

/// Threads for the time of a call; 0: as many as the machine runs at once.
pub fn threads(count: u32) -> Result<Threads, Error> {
    let count = within(count, 0..=MOST_THREADS, "threads")?;
    Threads::new(count as usize).map_err(no_threads)
}

pub fn no_threads(error: impl std::fmt::Display) -> Error {
    let message = format_args!("no threads to be had: {error}");
    Error::new(ANTUMBRA_ERROR_THREADS, message)
}

/// Loads a scene (.glb, .gltf or .obj) and prepares it, which takes seconds for a million triangles; or an archive, which
/// antumbra_scene_save or `antumbra prepare` wrote, in a fraction of that. An object is a node with a mesh, or a group of an OBJ
/// file.
///
/// @param file UTF-8. An archive is mapped into memory: nobody may write into the file while the scene or a culler of it lives
///     (to replace it is fine).
/// @param threads How many may work at it, up to 1024; 0 for as many as the machine runs at once. They have ended when the
///     call has. The result is the same for any number.
/// @param scene Is given a scene, to be destroyed by antumbra_scene_destroy; NULL if there is an error.
///
/// Errors: ANTUMBRA_ERROR_UTF8, ANTUMBRA_ERROR_IO, ANTUMBRA_ERROR_FILE, ANTUMBRA_ERROR_THREADS.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_load(
    file: *const c_char,
    threads: u32,
    scene: Option<&mut MaybeUninit<Option<Box<AntumbraScene>>>>,
) -> AntumbraStatus {
    guard(|| {
        let place = empty(scene, "scene")?;
        let file = path(file, "file")?;
        let prepared = self::threads(threads)?.install(|| Prepared::load(file))?;
        *place = Some(Box::new(prepared.into()));
        Ok(())
    })
}

/// Writes an archive of a scene. A file of that name is replaced when all is written, and stays as it is if that fails. The same
/// scene gives the same bytes on every machine.
///
/// @param file UTF-8; by custom it ends in .antumbra.
///
/// Errors: ANTUMBRA_ERROR_UTF8, ANTUMBRA_ERROR_IO.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_save(
    scene: Option<&AntumbraScene>,
    file: *const c_char,
) -> AntumbraStatus {
    guard(|| {
        let scene = required(scene, "scene")?;
        scene.prepared.save(path(file, "file")?)?;
        Ok(())
    })
}

/// Ends a scene. NULL is fine. Cullers that were made of it go on.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_destroy(scene: Option<Box<AntumbraScene>>) {
    drop(scene);
}

/// How many objects a scene has, which are numbered from 0 in the order of their file or of antumbra_scene_builder_add_object; 0
/// if scene is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_object_count(scene: Option<&AntumbraScene>) -> u32 {
    scene.map_or(0, |scene| scene.scene().objects().len() as u32)
}

/// How many triangles a scene has, a shared mesh counted once for each object that places it; 0 if scene is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_triangle_count(scene: Option<&AntumbraScene>) -> u64 {
    scene.map_or(0, |scene| scene.scene().triangle_count())
}

/// The name of an object in its file, or one made from its place there. UTF-8, valid as long as the scene.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_object_name(
    scene: Option<&AntumbraScene>,
    object: u32,
    name: Option<&mut MaybeUninit<*const c_char>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(name, "name")?.write(c"".as_ptr());
        let scene = required(scene, "scene")?;
        let objects = scene.scene().objects();
        let names = scene.names.get_or_init(|| {
            objects
                .iter()
                .map(|object| c_string(&object.name))
                .collect()
        });
        let found = names.get(object as usize);
        *place = found
            .ok_or_else(|| Error::out_of_range("object", object, objects.len()))?
            .as_ptr();
        Ok(())
    })
}

/// The world box of an object: what is asked about when it is culled.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_object_bounds(
    scene: Option<&AntumbraScene>,
    object: u32,
    bounds: Option<&mut MaybeUninit<AntumbraBox>>,
) -> AntumbraStatus {
    guard(|| {
        let boxes = required(scene, "scene")?.scene().bounds();
        let found = boxes.get(object as usize);
        let found = found.ok_or_else(|| Error::out_of_range("object", object, boxes.len()))?;
        required(bounds, "bounds")?.write(AntumbraBox::of(found));
        Ok(())
    })
}

/// How many sentences there are about what in the file was understood but could not be used; 0 if scene is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_warning_count(scene: Option<&AntumbraScene>) -> usize {
    scene.map_or(0, |scene| scene.scene().warnings().len())
}

/// One of these sentences, counted from 0. UTF-8, valid as long as the scene.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_scene_warning(
    scene: Option<&AntumbraScene>,
    index: usize,
    warning: Option<&mut MaybeUninit<*const c_char>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(warning, "warning")?.write(c"".as_ptr());
        let scene = required(scene, "scene")?;
        let sentences = scene.scene().warnings();
        let warnings = scene.warnings.get_or_init(|| {
            sentences
                .iter()
                .map(|sentence| c_string(sentence))
                .collect()
        });
        let found = warnings.get(index);
        *place = found
            .ok_or_else(|| Error::out_of_range("warning", index, sentences.len()))?
            .as_ptr();
        Ok(())
    })
}
