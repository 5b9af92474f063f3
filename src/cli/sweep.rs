//! `antumbra sweep`: what each way to choose occluders hides, for how many triangles.

use std::path::{Path, PathBuf};

use antumbra::measure::{Sweep as Swept, SweepSettings, sweep};
use clap::Args;

use super::failure::Failure;
use super::options::{
    ChoiceOptions, CullOptions, FrameOptions, load_path, load_scene, make_folder,
};
use super::output::say;
use super::progress;
use super::render::{file_name, no_threads};
use super::sweep_chart::{Against, chart};
use super::sweep_page::sweep_page;

const EXAMPLES: &str = "\
Examples:
  antumbra sweep castle.glb --path castle.walk.json --threads 1 --every 8
      a page with charts (sweep.html), and its figures as CSV and JSON, in antumbra-sweep/";

/// Compare the ways to choose occluders: what they hide, for how many triangles
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Sweep {
    /// Scene file: .glb, .gltf, .obj or .antumbra
    scene: PathBuf,

    /// Camera path (JSON)
    #[arg(long, value_name = "PATH.json")]
    path: PathBuf,

    /// Where to put the results
    #[arg(long, value_name = "DIR", default_value = "antumbra-sweep")]
    out: PathBuf,

    /// Budgets to try, in triangles
    #[arg(long, value_name = "TRIANGLES,...", value_delimiter = ',', default_values_t = [500, 1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000])]
    budgets: Vec<u64>,

    #[command(flatten)]
    cull: CullOptions,

    #[command(flatten)]
    choice: ChoiceOptions,

    #[command(flatten)]
    frames: FrameOptions,
}

impl Sweep {
    /// Sweeps, and writes what came of it.
    pub fn run(self) -> Result<(), Failure> {
        let settings = SweepSettings {
            cull: self.choice.of(self.cull.settings()?),
            budgets: self.budgets.clone(),
            every: self.frames.every.get(),
        };
        let path = load_path(&self.path)?;
        let prepared = load_scene(&self.scene)?;
        make_folder(&self.out)?;
        let bar = progress::bar("sweeping", 0);
        let swept = sweep(&prepared, &path, &settings, |done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        });
        bar.finish_and_clear();
        let swept = swept.map_err(no_threads)?;
        let name = file_name(&self.scene);
        let json = serde_json::to_string_pretty(&swept)
            .map_err(|e| Failure::Failed(format!("the figures cannot be written as JSON: {e}")))?;
        let drawn = |against| {
            chart(&name, &swept, against)
                .map_err(|e| Failure::Failed(format!("the chart cannot be drawn: {e}")))
        };
        let (by_triangles, by_time) = (drawn(Against::Triangles)?, drawn(Against::Time)?);
        self.write("sweep.json", &(json + "\n"))?;
        self.write("sweep.csv", &csv(&swept))?;
        self.write("sweep.svg", &by_triangles)?;
        self.write("sweep-time.svg", &by_time)?;
        let page = sweep_page(
            &name,
            &file_name(&self.path),
            &swept,
            [&by_triangles, &by_time],
        );
        self.write("sweep.html", &page)?;
        say(table(&name, &swept))?;
        say(format_args!("charts and figures in {}", self.out.display()))
    }

    fn write(&self, file: &str, text: &str) -> Result<(), Failure> {
        let file: &Path = &self.out.join(file);
        std::fs::write(file, text).map_err(|e| Failure::with_file(file, "cannot be written", e))
    }
}

fn csv(swept: &Swept) -> String {
    let mut out =
        "occluders,budget,occluder_triangles,culled_of_hidden,time_us,false_culls\n".to_owned();
    for p in &swept.points {
        out += &format!(
            "{},{},{:.1},{:.6},{:.1},{}\n",
            p.occluders,
            p.budget,
            p.occluder_triangles,
            p.culled_of_hidden,
            p.time_us,
            p.false_culls
        );
    }
    out
}

/// The figures for people.
fn table(name: &str, swept: &Swept) -> String {
    let mut out = format!(
        "{name}, {} frames\n\n        occluders |   budget | triangles drawn |  culled | us a frame\n",
        swept.frames
    );
    for p in &swept.points {
        out += &format!(
            "{:>17} | {:>8} | {:>15.0} | {:>5.1} % | {:>10.0}\n",
            p.occluders,
            p.budget,
            p.occluder_triangles,
            100.0 * p.culled_of_hidden,
            p.time_us
        );
    }
    out
}
