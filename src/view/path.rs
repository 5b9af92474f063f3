//! Camera paths: files that hold one projection and many frames.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;
use thiserror::Error;

use super::{Camera, Projection, ViewError};

/// A camera path that cannot be used.
#[derive(Debug, Error)]
pub enum PathError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is not a camera path.
    #[error("{file}: not a camera path: {source}")]
    Format {
        /// The file.
        file: PathBuf,
        /// What is wrong and where.
        source: serde_json::Error,
    },
    /// Neither or both of `fov_y_degrees` and `height` are given.
    #[error("{file}: a path needs either `fov_y_degrees` (perspective) or `height` (orthographic)")]
    NoProjection {
        /// The file.
        file: PathBuf,
    },
    /// There is no frame.
    #[error("{file}: the path has no frames")]
    Empty {
        /// The file.
        file: PathBuf,
    },
    /// A frame's camera is impossible.
    #[error("{file}: frame {frame}: {source}")]
    Frame {
        /// The file.
        file: PathBuf,
        /// The frame's index.
        frame: usize,
        /// What is wrong with it.
        source: ViewError,
    },
}

#[derive(Deserialize)]
struct PathFile {
    fov_y_degrees: Option<f64>,
    height: Option<f64>,
    near: f64,
    far: Option<f64>,
    frames: Vec<PathFrame>,
}

#[derive(Deserialize)]
struct PathFrame {
    eye: [f64; 3],
    target: [f64; 3],
    #[serde(default = "y_up")]
    up: [f64; 3],
}

fn y_up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

/// The cameras of consecutive frames; never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    cameras: Vec<Camera>,
}

impl CameraPath {
    /// Reads a path file: JSON with `fov_y_degrees` (or `height` for an orthographic view), `near`, `far` (may be
    /// left out: infinite) and `frames` of `eye`, `target` and `up`; right-handed.
    ///
    /// # Errors
    /// If the file cannot be read, is not of that form, or holds an impossible camera.
    pub fn load(file: &Path) -> Result<CameraPath, PathError> {
        let text = std::fs::read_to_string(file).map_err(|source| PathError::Read {
            file: file.into(),
            source,
        })?;
        CameraPath::parse(&text, file)
    }

    /// Reads the text of a path file; `file` is named in errors.
    ///
    /// # Errors
    /// As [`CameraPath::load`].
    pub fn parse(text: &str, file: &Path) -> Result<CameraPath, PathError> {
        let file = || file.to_path_buf();
        let path: PathFile = serde_json::from_str(text).map_err(|source| PathError::Format {
            file: file(),
            source,
        })?;
        let projection = match (path.fov_y_degrees, path.height) {
            (Some(degrees), None) => Projection::Perspective {
                fov_y: degrees.to_radians(),
                near: path.near,
                far: path.far,
            },
            (None, Some(height)) => Projection::Orthographic {
                height,
                near: path.near,
                far: path.far,
            },
            _ => return Err(PathError::NoProjection { file: file() }),
        };
        if path.frames.is_empty() {
            return Err(PathError::Empty { file: file() });
        }
        let cameras = path.frames.iter().enumerate().map(|(frame, f)| {
            Camera::look_at(
                DVec3::from_array(f.eye),
                DVec3::from_array(f.target),
                DVec3::from_array(f.up),
                projection,
            )
            .map_err(|source| PathError::Frame {
                file: file(),
                frame,
                source,
            })
        });
        Ok(CameraPath {
            cameras: cameras.collect::<Result<_, _>>()?,
        })
    }

    /// A path of one frame.
    pub fn still(camera: Camera) -> CameraPath {
        CameraPath {
            cameras: vec![camera],
        }
    }

    /// The cameras, one a frame.
    pub fn cameras(&self) -> &[Camera] {
        &self.cameras
    }
}
