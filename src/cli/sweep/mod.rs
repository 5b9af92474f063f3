//! `antumbra sweep`, the study: what each setting costs, hides and gets wrong.

mod axis;
mod budget_chart;
mod error_chart;
mod page;
mod path_chart;
mod plot;
mod table;
mod thread_chart;
mod trade_chart;

use std::path::{Path, PathBuf};

use antumbra::measure::{Sweep as Swept, SweepPoint, SweepSettings, sweep};
use antumbra::occlusion::{Accuracy, Approximation, DepthRepresentation};
use antumbra::view::MapScale;
use clap::Args;

use super::failure::Failure;
use super::options::{
    ChoiceOptions, CullOptions, FrameOptions, load_path, load_scene, make_folder,
};
use super::output::{say, thousands};
use super::progress;
use super::render::{file_name, no_threads};
use budget_chart::{Against, budget_chart};
use error_chart::wrong_pixels;
use page::{Header, sweep_page};
use trade_chart::{Error, trade_chart};

const EXAMPLES: &str = "\
Examples:
  antumbra sweep castle.glb --path castle.walk.json --threads 1 --every 8
      a page with charts (sweep.html), and its figures as CSV and JSON, in antumbra-sweep/
  antumbra sweep castle.glb --path castle.walk.json --every 8 --holes 0,64 --map-scales 1,4 --full
      two hole sizes and two scales of the map with every selection and budget, not only with the default ones";

/// Study the settings: what they cost, what they hide and what they get wrong
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

    /// Hole sizes to try, in pixels: 0 is exact, with the others holes between occluders are ignored up to that size
    #[arg(long, value_name = "PX,...", value_delimiter = ',', default_values_t = [0, 16, 64, 256])]
    holes: Vec<u32>,

    /// Scales of the occlusion map to try: 1, 2, 4
    #[arg(long, value_name = "SCALE,...", value_delimiter = ',', default_values_t = MapScale::ALL)]
    map_scales: Vec<MapScale>,

    /// Try all holes and scales with all selections and budgets, which takes long [default: with the default ones]
    #[arg(long)]
    full: bool,

    /// What drawing a triangle costs downstream, in nanoseconds, where frame rates are told
    #[arg(long, value_name = "NS", default_value_t = 5.0, value_parser = parse_price)]
    triangle_ns: f64,

    #[command(flatten)]
    cull: CullOptions,

    #[command(flatten)]
    choice: ChoiceOptions,

    #[command(flatten)]
    frames: FrameOptions,
}

/// Reads a price above 0.
fn parse_price(text: &str) -> Result<f64, String> {
    let price = text.parse().ok();
    let price = price.filter(|price: &f64| *price > 0.0 && price.is_finite());
    price.ok_or_else(|| "give a number of nanoseconds above 0".to_owned())
}

/// A chart of the page.
struct Figure {
    /// Its own file.
    file: &'static str,
    title: &'static str,
    /// What to see in it, HTML.
    caption: String,
    svg: String,
}

/// What a setting goes by on charts.
fn name_of(point: &SweepPoint) -> String {
    let choice = || {
        let budget = point.budget.parse().map_or(point.budget.clone(), thousands);
        format!("{} {budget}", point.occluders)
    };
    let depth = match point.depth.as_str() {
        depth if depth == DepthRepresentation::default().name() => String::new(),
        depth => format!(", {depth}"),
    };
    let hole = match point.hole {
        0 => "exact".to_owned(),
        hole => format!("holes of {hole}"),
    };
    let scale = match point.map_scale {
        1 => "full map".to_owned(),
        scale => format!("map 1/{scale}"),
    };
    if !point.series.is_empty() {
        format!("{hole}, {scale}{depth}")
    } else if point.is_base {
        choice()
    } else {
        format!("{}, {hole}, {scale}{depth}", choice())
    }
}

impl Sweep {
    /// Sweeps, and writes what came of it.
    pub fn run(self) -> Result<(), Failure> {
        let cull = self.choice.of(self.cull.settings()?);
        let settings = SweepSettings {
            cull,
            budgets: self.budgets.clone(),
            holes: self.holes.clone(),
            map_scales: self.map_scales.clone(),
            approximation: match cull.accuracy {
                Accuracy::Approximate(approximation) => approximation,
                Accuracy::Exact => Approximation {
                    base_level: self.cull.base_level,
                    distribution: self.cull.distribution,
                    transparency: self.cull.transparency,
                    ..Approximation::default()
                },
            },
            full: self.full,
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
        let figures = self.figures(&swept);
        self.write("sweep.json", &(json + "\n"))?;
        self.write("sweep.csv", &table::csv(&swept))?;
        self.write("sweep-frames.csv", &table::frames_csv(&swept))?;
        for figure in &figures {
            self.write(figure.file, &figure.svg)?;
        }
        let header = Header {
            scene: &name,
            path: &file_name(&self.path),
        };
        self.write("sweep.html", &sweep_page(&header, &swept, &figures))?;
        say(table::table(&name, &swept))?;
        say(format_args!("charts and figures in {}", self.out.display()))
    }

    fn figures(&self, swept: &Swept) -> Vec<Figure> {
        let mut figures = vec![
            trade_chart(swept, Error::WrongPixels),
            trade_chart(swept, Error::MissedCulls),
        ];
        if let Some(point) = swept.base().or(swept.variants().next()) {
            figures.push(path_chart::frame_rates(swept, point, self.triangle_ns));
            figures.push(path_chart::triangles_left(swept, point));
        }
        let scales = || self.map_scales.iter().map(|scale| scale.pixels());
        let finest = scales().min().unwrap_or(1);
        let coarsest = scales().max().unwrap_or(1);
        figures.extend(wrong_pixels(swept, finest, "sweep-frames.svg"));
        if coarsest > finest {
            figures.extend(wrong_pixels(swept, coarsest, "sweep-frames-coarse.svg"));
        }
        figures.push(thread_chart::thread_chart(swept));
        figures.push(budget_chart(swept, Against::Triangles));
        figures.push(budget_chart(swept, Against::Time));
        figures
    }

    fn write(&self, file: &str, text: &str) -> Result<(), Failure> {
        let file: &Path = &self.out.join(file);
        std::fs::write(file, text).map_err(|e| Failure::with_file(file, "cannot be written", e))
    }
}
