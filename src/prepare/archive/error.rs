//! What can be wrong with an archive.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::VERSION;
use crate::scene::SceneError;

/// Why a scene cannot be loaded or an archive not be written. Each names the file, what is wrong, and what to do.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// The file is no archive, and no scene either; or an archive of a scene that makes no sense.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The archive cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// Another version of Antumbra made the archive.
    #[error(
        "{file}: an archive of version {found}, but this build reads version {VERSION}; run `antumbra prepare` again on the \
         scene that it was made of"
    )]
    Version {
        /// The file.
        file: PathBuf,
        /// Its version.
        found: u32,
    },
    /// The archive is truncated, was changed, or was never right.
    #[error(
        "{file}: {place}: {cause}; copy the archive again, or run `antumbra prepare` again on the scene that it was made of"
    )]
    Damaged {
        /// The file.
        file: PathBuf,
        /// Where in the file.
        place: String,
        /// What is wrong there.
        cause: String,
    },
    /// The archive cannot be written.
    #[error("{file}: cannot be written: {source}")]
    Write {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
}

/// Something wrong within an archive, before it is known which file it is.
#[derive(Debug)]
pub(super) enum Fault {
    Version(u32),
    Damaged { place: String, cause: String },
    Scene(SceneError),
}

impl Fault {
    pub(super) fn at(place: impl ToString, cause: impl ToString) -> Fault {
        Fault::Damaged {
            place: place.to_string(),
            cause: cause.to_string(),
        }
    }

    /// The finished error.
    pub(super) fn in_file(self, file: &Path) -> ArchiveError {
        let path = file.to_path_buf();
        match self {
            Fault::Version(found) => ArchiveError::Version { file: path, found },
            Fault::Damaged { place, cause } => ArchiveError::Damaged {
                file: path,
                place,
                cause,
            },
            Fault::Scene(error) => ArchiveError::Scene(error.in_file(file)),
        }
    }
}
