//! How a command can fail.

use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

use antumbra::cull::LevelUnavailable;
use thiserror::Error;

/// Why a command ended early.
#[derive(Debug, Error)]
pub enum Failure {
    /// What was asked for cannot be done; the message says what and why.
    #[error("{0}")]
    Failed(String),
    /// Options that do not go together; the message says why, and what does.
    #[error("{0}")]
    Usage(String),
    /// This machine or build lacks what was asked for; the message says what it is, and how to get it.
    #[error("{0}")]
    Lacking(String),
    /// The instruction set is not to be had.
    #[error("{0}")]
    Level(#[from] LevelUnavailable),
}

impl Failure {
    /// A failure with a file.
    pub fn with_file(file: &Path, what: &str, cause: impl Display) -> Failure {
        Failure::Failed(format!("{}: {what}: {cause}", file.display()))
    }

    /// What the process ends with; see the help.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Failure::Failed(_) => 1,
            Failure::Usage(_) => 2,
            Failure::Level(_) | Failure::Lacking(_) => 3,
        })
    }
}
