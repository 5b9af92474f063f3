//! `antumbra cull`: the visible set of every frame, for whoever wants to use it or to compare it.

use std::fmt::Write;
use std::path::PathBuf;

use antumbra::cull::{Culler, VisibleSet};
use clap::Args;

use super::depth_options::DepthOptions;
use super::failure::Failure;
use super::options::{CullOptions, FrameOptions, OccluderOptions, load_path, load_scene};
use super::output::say;
use super::render::no_threads;

const EXAMPLES: &str = "\
Examples:
  antumbra cull castle.glb --path castle.path.json
      a line for each frame: its number, and the objects that its camera may see, by their places in the file
  antumbra cull castle.glb --path castle.path.json --cold --every 6
      every sixth frame, and nothing remembered of those before";

/// Print which objects the cameras of a path may see
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Cull {
    /// Scene file: .glb, .gltf, .obj or .antumbra
    scene: PathBuf,

    /// Camera path (JSON)
    #[arg(long, value_name = "PATH.json")]
    path: PathBuf,

    #[command(flatten)]
    cull: CullOptions,

    #[command(flatten)]
    occluders: OccluderOptions,

    #[command(flatten)]
    frames: FrameOptions,

    #[command(flatten)]
    depth: DepthOptions,

    /// Start every frame without memory of the last
    #[arg(long)]
    cold: bool,
}

impl Cull {
    /// Culls all frames, one after the other.
    pub fn run(self) -> Result<(), Failure> {
        let settings = self.depth.of(self.occluders.of(self.cull.settings()?))?;
        let path = load_path(&self.path)?;
        let prepared = load_scene(&self.scene)?;
        let mut culler = Culler::with_prepared(&prepared, settings).map_err(no_threads)?;
        let mut found = VisibleSet::default();
        let every = self.frames.every.get();
        for (frame, camera) in path.cameras().iter().enumerate().step_by(every) {
            if self.cold {
                culler.forget();
            }
            culler.cull_into(camera, &mut found);
            let mut line = format!("{frame}:");
            for object in &found.visible {
                let _ = write!(line, " {object}");
            }
            say(line)?;
        }
        Ok(())
    }
}
