//! `antumbra pipeline`: frames one by one, and frames that overlap: how many a second, and how late.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::thread::available_parallelism;
use std::time::Duration;

use antumbra::measure::{FinalDraw, Flow, FlowReport, ThroughputSettings, throughput};
use antumbra::pipeline::Schedule;
use antumbra::view::Camera;
use clap::Args;
use clap::builder::PossibleValuesParser;
use serde::Serialize;

use super::failure::Failure;
use super::options::{
    CullOptions, FrameOptions, OccluderOptions, load_path, load_scene, parse_time,
};
use super::output::{count_of, say};
use super::progress;
use super::render::file_name;

const EXAMPLES: &str = "\
Examples:
  antumbra pipeline castle.glb --path castle.walk.json
      frames culled and drawn one by one, on one thread and on all, and every schedule, with pictures drawn by the CPU
  antumbra pipeline castle.glb --path castle.walk.json --schedule two-stage --draw 2ms
      as if the pictures were drawn elsewhere, in two milliseconds each
  antumbra pipeline castle.glb --path castle.walk.json --draw nothing --json -
      culling alone, as JSON on stdout";

/// Compare frames one by one with frames in a pipeline: throughput and latency
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Pipeline {
    /// Scene file: .glb, .gltf, .obj or .antumbra
    scene: PathBuf,

    /// Camera path (JSON)
    #[arg(long, value_name = "PATH.json")]
    path: PathBuf,

    /// Schedules to compare with frames one by one, with commas between [default: all]
    #[arg(long, value_name = "SCHEDULE,...", value_delimiter = ',', value_parser = schedules())]
    schedule: Vec<String>,

    /// What the final draw is: a picture by the CPU, nothing, or a time in which pictures are drawn elsewhere, as in 2ms
    #[arg(long, value_name = "picture|nothing|TIME", default_value = "picture", value_parser = parse_draw)]
    draw: Draw,

    /// Threads that draw the pictures of a pipeline
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    picture_threads: u16,

    /// How often the path is taken
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    repeats: u16,

    #[command(flatten)]
    cull: CullOptions,

    #[command(flatten)]
    occluders: OccluderOptions,

    #[command(flatten)]
    frames: FrameOptions,

    /// Write the report as JSON to a file, or alone to stdout (-)
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

/// The final draw, as it is asked for.
#[derive(Clone, Copy, Debug)]
enum Draw {
    Picture,
    Elsewhere(Duration),
}

#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    frames: usize,
    repeats: u16,
    size: [usize; 2],
    simd: String,
    occluders: String,
    budget: String,
    draw: String,
    flows: &'a [FlowReport],
}

impl Pipeline {
    /// Measures, and reports.
    pub fn run(self) -> Result<(), Failure> {
        let cull = self.occluders.of(self.cull.settings()?);
        let threads = match cull.threads {
            0 => available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        let picture_threads = usize::from(self.picture_threads);
        let settings = ThroughputSettings {
            cull,
            flows: flows(&self.schedule, threads),
            final_draw: match self.draw {
                Draw::Picture => FinalDraw::Picture {
                    threads: picture_threads,
                },
                Draw::Elsewhere(time) => FinalDraw::Elsewhere(time),
            },
            repeats: usize::from(self.repeats),
        };
        let path = load_path(&self.path)?;
        let every = self.frames.every.get();
        let cameras: Vec<Camera> = path.cameras().iter().step_by(every).copied().collect();
        let prepared = load_scene(&self.scene)?;
        let bar = progress::bar("running", 0);
        let reports = throughput(&prepared, &cameras, &settings, |done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        });
        bar.finish_and_clear();
        let flows = reports.map_err(|error| Failure::Failed(error.to_string()))?;
        let name = file_name(&self.scene);
        let report = Report {
            scene: &name,
            frames: cameras.len(),
            repeats: self.repeats,
            size: [cull.size.width(), cull.size.height()],
            simd: cull.level.to_string(),
            occluders: cull.occluders.to_string(),
            budget: cull.budget.to_string(),
            draw: self.draw.to_string(),
            flows: &flows,
        };
        let Some(file) = self.json else {
            return say(table(&report));
        };
        let json = serde_json::to_string_pretty(&report)
            .map_err(|e| Failure::Failed(format!("the report cannot be written as JSON: {e}")))?;
        if file.as_os_str() == "-" {
            return say(json);
        }
        std::fs::write(&file, json + "\n")
            .map_err(|e| Failure::with_file(&file, "cannot be written", e))?;
        say(table(&report))?;
        say(format_args!("report in {}", file.display()))
    }
}

impl std::fmt::Display for Draw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Draw::Picture => f.write_str("picture"),
            Draw::Elsewhere(Duration::ZERO) => f.write_str("nothing"),
            Draw::Elsewhere(time) => write!(f, "{}us", time.as_micros()),
        }
    }
}

/// Frames one by one, and the schedules that are asked for, or all.
fn flows(asked: &[String], threads: usize) -> Vec<(String, Flow)> {
    let alone = BTreeSet::from([1, threads]).into_iter();
    let alone = alone.map(|threads| ("frame by frame".to_owned(), Flow::FrameByFrame { threads }));
    let is_asked = |name: &str| asked.is_empty() || asked.iter().any(|asked| asked == name);
    let named = Schedule::NAMED
        .into_iter()
        .filter(|(name, _)| is_asked(name));
    let schedules = named.map(|(name, schedule)| (name.to_owned(), Flow::Pipeline(schedule)));
    alone.chain(schedules).collect()
}

fn schedules() -> PossibleValuesParser {
    PossibleValuesParser::new(Schedule::NAMED.map(|(name, _)| name))
}

fn parse_draw(text: &str) -> Result<Draw, String> {
    match text {
        "picture" => Ok(Draw::Picture),
        "nothing" => Ok(Draw::Elsewhere(Duration::ZERO)),
        text => parse_time(text).map(Draw::Elsewhere).ok_or_else(|| {
            "give `picture`, `nothing`, or a time with its unit, `us` or `ms`".into()
        }),
    }
}

/// The report for people.
fn table(report: &Report<'_>) -> String {
    let [width, height] = report.size;
    let mut out = format!(
        "{}: {}, {}; {width}x{height}, {}, occluders by {}, budget {}, final draw: {}\n\n",
        report.scene,
        count_of(report.frames as u64, "frame"),
        count_of(u64::from(report.repeats), "repeat"),
        report.simd,
        report.occluders,
        report.budget,
        report.draw,
    );
    out += "                         |      us a frame |   frames |  us of latency     95 in 100   |   visible  occluder | \
            select    draw    cull   final | longest\n\
            flow             threads |  least   median | a second |  least  median   least  median |   objects triangles | \
            \x20                           us |   place\n";
    for flow in report.flows {
        let [select, draw, cull, last] = flow.stages_us;
        out += &format!(
            "{:16} {:7} | {:6.0} {:8.0} | {:8.1} | {:6.0} {:7.0} {:7.0} {:7.0} | {:9.1} {:9.0} | {:6.0} {:7.0} {:7.0} {:7.0} | {:7.0}\n",
            flow.name,
            flow.threads,
            flow.frame_us.least,
            flow.frame_us.median,
            flow.frames_per_second(),
            flow.latency_us.least,
            flow.latency_us.median,
            flow.latency_95_us.least,
            flow.latency_95_us.median,
            flow.objects_visible,
            flow.occluder_triangles,
            select,
            draw,
            cull,
            last,
            flow.longest_place_us,
        );
    }
    out += "\nThe least and the median are of the repeats. The longest place is what a frame would take if each thread had a \
            processor to itself,\nfrom the stages' means: what frames take beyond it is waiting for each other, and for the \
            processors.";
    out
}
