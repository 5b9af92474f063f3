//! `antumbra measure`: is the culling right, how much does it find, what does it cost?

use std::path::PathBuf;

use antumbra::measure::{MeasureSettings, Moving, Prediction, Report, run};
use antumbra::occluders::Selection;
use clap::Args;

use super::depth_options::DepthOptions;
use super::failure::Failure;
use super::options::{CullOptions, FrameOptions, OccluderOptions, load_path, load_scene};
use super::output::{self, count_of, percent, say};
use super::progress;
use super::render::{file_name, no_threads};

const EXAMPLES: &str = "\
Examples:
  antumbra measure castle.glb --path castle.path.json
      a table: objects, culled, errors and times, frame by frame
  antumbra measure castle.glb --path castle.path.json --threads 1 --cold --every 6 --json -
      the same as JSON alone on stdout, for scripts
  antumbra measure castle.glb --path castle.path.json --cold --every 6 --simulate-threads
      also what 2 to 64 threads would make of it, and what keeps them from doing better";

const NO_GRID: &str = "no visibility was sampled of this scene, so the nearest occluders are drawn; \
                       make an archive with `antumbra prepare --visibility-grid`";

/// Judge culling against an exact picture of the whole scene, frame by frame
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Measure {
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

    /// Move objects from frame to frame: doors (one in 64 turns about an edge) or all
    #[arg(long, value_name = "WHAT")]
    animate: Option<Moving>,

    /// Which objects move, and how
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Predict what frames would take on 2 to 64 threads, from what each task takes on one
    #[arg(long)]
    simulate_threads: bool,

    /// Write the report as JSON to a file, or alone to stdout (-)
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

impl Measure {
    /// Measures, and reports.
    pub fn run(self) -> Result<(), Failure> {
        let settings = MeasureSettings {
            cull: self.depth.of(self.occluders.of(self.cull.settings()?))?,
            cold: self.cold,
            every: self.frames.every.get(),
            animate: self.animate.map(|moving| (moving, self.seed)),
            simulate_threads: self.simulate_threads,
        };
        let path = load_path(&self.path)?;
        let prepared = load_scene(&self.scene)?;
        let takes_samples = settings.cull.occluders == Selection::Sampled;
        if takes_samples && prepared.visibility_grid().is_none() {
            output::complain("warning", NO_GRID);
        }
        let bar = progress::bar("measuring", 0);
        let report = run(&prepared, &path, &settings, |done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        });
        bar.finish_and_clear();
        let report = report.map_err(no_threads)?;
        let Some(file) = self.json else {
            return say(table(&file_name(&self.scene), &report));
        };
        let json = serde_json::to_string_pretty(&report)
            .map_err(|e| Failure::Failed(format!("the report cannot be written as JSON: {e}")))?;
        if file.as_os_str() == "-" {
            return say(json);
        }
        std::fs::write(&file, json + "\n")
            .map_err(|e| Failure::with_file(&file, "cannot be written", e))?;
        say(table(&file_name(&self.scene), &report))?;
        say(format_args!("report in {}", file.display()))
    }
}

/// The report for people.
fn table(name: &str, report: &Report) -> String {
    let s = &report.settings;
    let mut out = format!(
        "{name}: {}, {}; {}x{}, {}, budget {}, {}, {}\n\n",
        count_of(report.scene.objects, "object"),
        count_of(report.scene.triangles, "triangle"),
        s.size[0],
        s.size[1],
        s.accuracy,
        s.budget,
        count_of(s.threads as u64, "thread"),
        s.simd,
    );
    out += " frame | in frustum  visible   hidden   culled      % | false   wrong px |   select   raster  \
            pyramid     test    total us\n";
    for f in &report.frames {
        let t = &f.time_us;
        out += &format!(
            "{:6} | {:10} {:8} {:8} {:8} {:6.1} | {:5} {:10} | {:8.0} {:8.0} {:8.0} {:8.0} {:8.0}\n",
            f.frame,
            f.in_frustum,
            f.exactly_visible,
            f.exactly_hidden,
            f.culled,
            percent(f.culled, f.exactly_hidden),
            f.false_culls,
            f.wrong_pixels,
            t.select,
            t.raster,
            t.pyramid,
            t.test,
            t.total,
        );
    }
    let t = &report.totals;
    let ideal = |of_hidden: f64| {
        if of_hidden > 0.0 {
            t.culled_of_hidden / of_hidden
        } else {
            1.0
        }
    };
    let mean = &t.time_us_mean;
    out += &format!(
        "\nculled of the exactly hidden: {:.2} %, {:.3} of the ideal box test, {:.3} of the ideal face test\n\
         false culls: {}; wrong pixels: {} ({:.4} %)\n\
         mean time: {:.0} us = {:.0} select + {:.0} raster + {:.0} pyramid + {:.0} test",
        t.culled_of_hidden * 100.0,
        ideal(t.ideal_box_culled_of_hidden),
        ideal(t.ideal_face_culled_of_hidden),
        t.false_culls,
        t.wrong_pixels,
        t.wrong_pixel_fraction * 100.0,
        mean.total,
        mean.select,
        mean.raster,
        mean.pyramid,
        mean.test,
    );
    out += &predictions(&report.simulated);
    out
}

/// What more threads would do, for people; nothing if nobody asked.
fn predictions(simulated: &[Prediction]) -> String {
    let mut out = String::new();
    if !simulated.is_empty() {
        out += "\n\n threads |  total us  speed-up | threads wait most in";
    }
    for p in simulated {
        out += &format!(
            "\n{:8} | {:9.0} {:9.2} | {}, {:.0} % of the time",
            p.threads,
            p.time_us,
            p.speed_up,
            p.limited_by,
            p.limited_share * 100.0,
        );
    }
    out
}
