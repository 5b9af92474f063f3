//! Camera paths from files.

use std::ffi::c_char;
use std::mem::MaybeUninit;

use antumbra::view::{CameraPath, PathError};

use crate::arguments::{empty, required};
use crate::borrow::path;
use crate::camera::AntumbraCamera;
use crate::handle::is_shared_by_threads;
use crate::status::AntumbraStatus::{ANTUMBRA_ERROR_FILE, ANTUMBRA_ERROR_IO};
use crate::status::{AntumbraStatus, Error, guard};

/// The cameras of consecutive frames, from a file. It never changes: any number of threads may use it at once.
pub struct AntumbraCameraPath(CameraPath);

const _: () = is_shared_by_threads::<AntumbraCameraPath>();

/// Reads a camera path as the antumbra command takes it: JSON with "fov_y_degrees" (or "height" for an orthographic view),
/// "near", "far" (may be left out: infinite) and "frames" of "eye", "target" and "up".
///
/// @param file UTF-8.
/// @param path Is given a path, to be destroyed by antumbra_camera_path_destroy; NULL if there is an error.
///
/// Errors: ANTUMBRA_ERROR_UTF8, ANTUMBRA_ERROR_IO, ANTUMBRA_ERROR_FILE.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_camera_path_load(
    file: *const c_char,
    path: Option<&mut MaybeUninit<Option<Box<AntumbraCameraPath>>>>,
) -> AntumbraStatus {
    guard(|| {
        let place = empty(path, "path")?;
        let loaded = CameraPath::load(self::path(file, "file")?);
        let loaded = loaded.map_err(|error| {
            let status = match error {
                PathError::Read { .. } => ANTUMBRA_ERROR_IO,
                _ => ANTUMBRA_ERROR_FILE,
            };
            Error::new(status, error)
        })?;
        *place = Some(Box::new(AntumbraCameraPath(loaded)));
        Ok(())
    })
}

/// Ends a path. NULL is fine.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_camera_path_destroy(path: Option<Box<AntumbraCameraPath>>) {
    drop(path);
}

/// How many frames a path has; 0 if path is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_camera_path_length(path: Option<&AntumbraCameraPath>) -> usize {
    path.map_or(0, |path| path.0.cameras().len())
}

/// The camera of a frame, counted from 0.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_camera_path_frame(
    path: Option<&AntumbraCameraPath>,
    frame: usize,
    camera: Option<&mut MaybeUninit<AntumbraCamera>>,
) -> AntumbraStatus {
    guard(|| {
        let cameras = required(path, "path")?.0.cameras();
        let found = cameras.get(frame);
        let found = found.ok_or_else(|| Error::out_of_range("frame", frame, cameras.len()))?;
        required(camera, "camera")?.write(AntumbraCamera::of(found));
        Ok(())
    })
}
