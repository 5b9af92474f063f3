//! `antumbra prepare`: an archive of a scene and all that is found of it once.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::failure::Failure;
use super::options::load_scene;
use super::output::{count_of, say, thousands};
use super::progress;
use super::visibility_grid::GridOptions;

const EXAMPLES: &str = "\
Examples:
  antumbra prepare castle.glb -o castle.antumbra
  antumbra prepare clinic.glb --visibility-grid 2000 -o clinic.antumbra
      also what is seen from 2000 viewpoints, for frames that remember nothing
  antumbra measure castle.antumbra --path castle.path.json
      every command takes the archive in place of the scene";

/// Find once what every run needs to know of a scene, and write it to an archive
///
/// The archive holds the scene as well. It is checked when it is loaded, and mapped into memory. An older file of its name
/// is replaced when the new one is complete.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Prepare {
    /// Scene file: .glb, .gltf, .obj or .antumbra
    scene: PathBuf,

    /// The archive to write
    #[arg(short, long = "output", value_name = "FILE.antumbra")]
    output: PathBuf,

    #[command(flatten)]
    grid: GridOptions,
}

impl Prepare {
    /// Prepares the scene.
    pub fn run(self) -> Result<(), Failure> {
        if is_same(&self.scene, &self.output) {
            return Err(Failure::Failed(format!(
                "{}: would be replaced by the archive; give another name with -o",
                self.scene.display()
            )));
        }
        let begun = Instant::now();
        let prepared = load_scene(&self.scene)?;
        let prepared_in = begun.elapsed();
        let begun = Instant::now();
        let (prepared, sampled) = match self.grid.make(&prepared)? {
            None => (prepared, String::new()),
            Some(grid) => {
                let sampled = format!(
                    "{}, {:.3} apart, that see {} in all, found in {:.2} s\n",
                    count_of(grid.layout().viewpoints(), "viewpoint"),
                    grid.layout().spacing,
                    count_of(grid.len() as u64, "cluster"),
                    begun.elapsed().as_secs_f64(),
                );
                let with_grid = prepared.with_visibility_grid(grid);
                let with_grid = with_grid.map_err(|e| Failure::Failed(e.to_string()))?;
                (with_grid, sampled)
            }
        };
        let spinner = progress::spinner(format!("writing {}", self.output.display()));
        let begun = Instant::now();
        let saved = prepared.save(&self.output);
        spinner.finish_and_clear();
        let bytes = saved.map_err(|e| Failure::Failed(e.to_string()))?;
        let (scene, clusters) = (prepared.scene(), prepared.occluders().memory_use());
        say(format_args!(
            "{}: {}, {}; {} of {}; {} bytes\n{sampled}read and prepared in {:.2} s, written in {:.2} s",
            self.output.display(),
            count_of(scene.objects().len() as u64, "object"),
            count_of(scene.triangle_count(), "triangle"),
            count_of(clusters.clusters as u64, "cluster"),
            count_of(clusters.triangles as u64, "occluding triangle"),
            thousands(bytes),
            prepared_in.as_secs_f64(),
            begun.elapsed().as_secs_f64(),
        ))
    }
}

/// Whether two names are of the same file.
fn is_same(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(|file| file.canonicalize().ok());
    a.is_some() && a == b
}
