//! `antumbra info`: what this build can use on this machine.

use antumbra::cull::Level;
use clap::Args;

use super::failure::Failure;
use super::output::say;

/// Print the version, the instruction sets found and chosen, and the threads
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  antumbra info")]
pub struct Info {}

impl Info {
    /// Prints it all.
    pub fn run(self) -> Result<(), Failure> {
        let names = |levels: &[Level]| -> String {
            levels
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join(", ")
        };
        say(format_args!("antumbra {}", env!("CARGO_PKG_VERSION")))?;
        say(format_args!(
            "machine: {} {}",
            std::env::consts::OS,
            std::env::consts::ARCH
        ))?;
        say(format_args!(
            "instruction sets found: {}",
            names(Level::available())
        ))?;
        say(format_args!("instruction set chosen: {}", Level::best()))?;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        say(format_args!("threads: {threads}"))
    }
}
