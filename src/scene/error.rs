//! What can be wrong with a scene.

use std::path::PathBuf;

use thiserror::Error;

/// Why a scene cannot be used. Each names the file, the object and the cause, as far as they are known.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
}
