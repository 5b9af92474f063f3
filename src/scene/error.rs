//! What can be wrong with a scene.
//!
//! Whoever meets an error should know where to look and what to do without opening the file in an editor. So each one
//! names the file, the object inside it, the cause, and a remedy; the loaders build that path from the inside out
//! ([`Fault::within`]), since the code that finds a bad accessor does not know which mesh asked for it.

use std::fmt;
use std::path::{Path, PathBuf};

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
    /// The file's name does not end like a scene's.
    #[error(
        "{file}: not a kind of scene that can be read; give a .glb, .gltf, .obj or .antumbra file"
    )]
    UnknownKind {
        /// The file.
        file: PathBuf,
    },
    /// The file is an archive, which holds more than a scene.
    #[error("{file}: an archive: load it with `Prepared::load`")]
    Archive {
        /// The file.
        file: PathBuf,
    },
    /// The file is truncated, contradicts itself, or holds a number that cannot be.
    #[error("{file}: {object}: {cause}; {remedy}")]
    Damaged {
        /// The file.
        file: PathBuf,
        /// Where in the file, from the outside in.
        object: String,
        /// What is wrong there.
        cause: String,
        /// What to do about it.
        remedy: String,
    },
    /// The file may be sound, but asks for something that is not built in.
    #[error("{file}: {object}: {cause}; {remedy}")]
    Unsupported {
        /// The file.
        file: PathBuf,
        /// Where in the file, from the outside in.
        object: String,
        /// What is asked for.
        cause: String,
        /// What to do about it.
        remedy: String,
    },
    /// The file claims to hold far more than its size can justify.
    #[error(
        "{file}: {object}: would take {needed} bytes of memory, the limit for a file of this size is {limit}; \
         if the file is sound, split it into several"
    )]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// What in the file makes the claim.
        object: String,
        /// Bytes that reading on would take.
        needed: u64,
        /// Bytes that a file of this size may take.
        limit: u64,
    },
    /// A mesh or an object that makes no sense, whether from a file or made in memory.
    #[error("{}{object}: {cause}", place(file))]
    Invalid {
        /// The file, if it came from one.
        file: Option<PathBuf>,
        /// The mesh or object.
        object: String,
        /// What is wrong with it, and what would be right.
        cause: String,
    },
    /// Nothing to see: no object has a triangle.
    #[error(
        "{}the scene has no triangles; give a scene that places at least one mesh with triangles",
        place(file)
    )]
    NoTriangles {
        /// The file, if it came from one.
        file: Option<PathBuf>,
    },
}

fn place(file: &Option<PathBuf>) -> String {
    file.as_ref()
        .map_or_else(String::new, |f| format!("{}: ", f.display()))
}

impl SceneError {
    /// The same error, naming the file the scene came from.
    pub(crate) fn in_file(mut self, path: &Path) -> SceneError {
        if let SceneError::Invalid { file, .. } | SceneError::NoTriangles { file } = &mut self {
            file.get_or_insert_with(|| path.to_path_buf());
        }
        self
    }
}

/// How an error calls a thing: `mesh 3 "door"`, or without a name `mesh 3`. Of a long name the beginning is enough.
pub(super) struct Label<'a> {
    pub kind: &'a str,
    pub index: usize,
    pub name: &'a str,
}

impl fmt::Display for Label<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} {}", self.kind, self.index)?;
        match self.name.char_indices().nth(80) {
            None if self.name.is_empty() => Ok(()),
            None => write!(f, " {:?}", self.name),
            Some((end, _)) => write!(f, " {:?}…", &self.name[..end]),
        }
    }
}

/// An error inside a file, while its place is still being put together.
#[derive(Debug)]
pub(super) struct Fault {
    object: String,
    kind: FaultKind,
}

#[derive(Debug)]
enum FaultKind {
    Damaged { cause: String, remedy: &'static str },
    Unsupported { cause: String, remedy: &'static str },
    TooLarge { needed: u64, limit: u64 },
    NoTriangles,
}

/// What to do about a file that contradicts itself.
const EXPORT_AGAIN: &str = "export the scene again, or repair the file";
/// What to do about a file whose end is missing.
pub(super) const COPY_AGAIN: &str = "the file looks truncated: copy or download it again";

impl Fault {
    /// Something in the file cannot be.
    pub(super) fn damaged(object: impl fmt::Display, cause: impl fmt::Display) -> Fault {
        Fault::damaged_so(object, cause, EXPORT_AGAIN)
    }

    /// Something in the file cannot be, and there is a better remedy than to export it again.
    pub(super) fn damaged_so(
        object: impl fmt::Display,
        cause: impl fmt::Display,
        remedy: &'static str,
    ) -> Fault {
        Fault {
            object: object.to_string(),
            kind: FaultKind::Damaged {
                cause: cause.to_string(),
                remedy,
            },
        }
    }

    /// Something in the file is not built in.
    pub(super) fn unsupported(
        object: impl fmt::Display,
        cause: impl fmt::Display,
        remedy: &'static str,
    ) -> Fault {
        Fault {
            object: object.to_string(),
            kind: FaultKind::Unsupported {
                cause: cause.to_string(),
                remedy,
            },
        }
    }

    /// Something in the file is out of proportion to it.
    pub(super) fn too_large(object: impl fmt::Display, needed: u64, limit: u64) -> Fault {
        Fault {
            object: object.to_string(),
            kind: FaultKind::TooLarge { needed, limit },
        }
    }

    /// Nothing in the file can be seen.
    pub(super) fn no_triangles() -> Fault {
        Fault {
            object: String::new(),
            kind: FaultKind::NoTriangles,
        }
    }

    /// The same fault, seen from one step further out.
    pub(super) fn within(mut self, outer: impl fmt::Display) -> Fault {
        self.object = format!("{outer}, {}", self.object);
        self
    }

    /// The finished error.
    pub(super) fn in_file(self, path: &Path) -> SceneError {
        let (file, object) = (path.to_path_buf(), self.object);
        match self.kind {
            FaultKind::Damaged { cause, remedy } => SceneError::Damaged {
                file,
                object,
                cause,
                remedy: remedy.to_owned(),
            },
            FaultKind::Unsupported { cause, remedy } => SceneError::Unsupported {
                file,
                object,
                cause,
                remedy: remedy.to_owned(),
            },
            FaultKind::TooLarge { needed, limit } => SceneError::TooLarge {
                file,
                object,
                needed,
                limit,
            },
            FaultKind::NoTriangles => SceneError::NoTriangles { file: Some(file) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_reads_file_object_cause_remedy() {
        let fault = Fault::damaged("accessor 7", "reaches past its view").within("mesh 2 \"door\"");
        assert_eq!(
            fault.in_file(Path::new("house.glb")).to_string(),
            "house.glb: mesh 2 \"door\", accessor 7: reaches past its view; export the scene again, or repair the file"
        );
    }

    #[test]
    fn an_error_made_in_memory_names_no_file_until_it_has_one() {
        let error = SceneError::NoTriangles { file: None };
        assert!(error.to_string().starts_with("the scene has no triangles"));
        assert!(
            error
                .in_file(Path::new("a.obj"))
                .to_string()
                .starts_with("a.obj: the scene has no triangles")
        );
    }
}
