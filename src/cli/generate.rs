//! `antumbra generate`: scenes to try things on.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use antumbra_fixtures::{Fixture, Kind, Recipe, generate};
use clap::Args;
use clap::builder::PossibleValuesParser;

use super::failure::Failure;
use super::options::path_beside;
use super::output::{say, thousands};
use super::progress;

const EXAMPLES: &str = "\
Examples:
  antumbra generate city -o city.glb
  antumbra generate city --triangles 50000 --seed 7 -o town.glb
  antumbra render city.glb --path city.path.json --overlay";

/// Make a scene and a camera path to walk through it
///
/// The same kind, count and seed give the same bytes on every machine. The path goes beside the scene:
/// city.glb has city.path.json.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Generate {
    /// What to make
    #[arg(value_parser = PossibleValuesParser::new(Kind::ALL.map(Kind::name)))]
    kind: String,

    /// Triangles in all [default: the kind's own number]
    #[arg(long, value_name = "N")]
    triangles: Option<u64>,

    /// Another seed, another scene of the same kind
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,

    /// The scene file to write
    #[arg(short, long = "output", value_name = "FILE.glb")]
    output: PathBuf,
}

impl Generate {
    /// Makes the scene.
    pub fn run(self) -> Result<(), Failure> {
        let failed = |e: &dyn std::error::Error| Failure::Failed(e.to_string());
        let recipe = Recipe {
            kind: self.kind.parse().map_err(|e| failed(&e))?,
            triangles: self.triangles,
            seed: self.seed,
        };
        let spinner = progress::spinner(format!("making {}", recipe.kind));
        let fixture = generate(&recipe).map_err(|e| failed(&e));
        let written = fixture.and_then(|f| write_fixture(&f, &self.output).map(|path| (f, path)));
        spinner.finish_and_clear();
        let (fixture, path) = written?;
        say(format_args!(
            "{}: {} triangles, seed {}\n{}: its camera path",
            self.output.display(),
            thousands(fixture.triangle_count()),
            self.seed,
            path.display(),
        ))
    }
}

/// Writes a scene, and its camera path beside it; gives the path's file.
pub fn write_fixture(fixture: &Fixture, file: &Path) -> Result<PathBuf, Failure> {
    let unwritten = |file: &Path, e| Failure::with_file(file, "cannot be written", e);
    File::create(file)
        .and_then(|f| {
            let mut out = BufWriter::new(f);
            fixture.write_glb(&mut out)?;
            out.flush()
        })
        .map_err(|e| unwritten(file, e))?;
    let path = path_beside(file);
    std::fs::write(&path, fixture.path_json()).map_err(|e| unwritten(&path, e))?;
    Ok(path)
}
