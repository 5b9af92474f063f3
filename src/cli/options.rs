//! Options that several commands share, and how their values are read.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Duration;

use antumbra::cull::Level;
use antumbra::cull::Settings;
use antumbra::occluders::{Budget, FramesBack, Selection, Weighing};
use antumbra::occlusion::{Accuracy, Approximation};
use antumbra::prepare::{Prepared, StaticCriteria};
use antumbra::view::{CameraPath, MapScale, PictureSize, Slack};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::failure::Failure;
use super::{output, progress};

/// What may be lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AccuracyName {
    /// Nothing that owns a pixel is ever culled
    Exact,
    /// Small holes between occluders are ignored
    Approximate,
}

/// How to cull, but for the choice of occluders.
#[derive(Clone, Copy, Debug, Args)]
pub struct CullOptions {
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x768", value_parser = parse_size)]
    pub size: PictureSize,

    /// What may be lost
    #[arg(long, value_enum, default_value = "exact")]
    pub accuracy: AccuracyName,

    /// With approximate accuracy: uncovered pixels that are ignored in any window of 8x8, or of what --base-level says
    #[arg(long, value_name = "PX", default_value_t = Approximation::default().hole)]
    pub hole: u32,

    /// With approximate accuracy: windows of 8x8 pixels (0), 16x16 (1), and so on
    #[arg(long, value_name = "LEVEL", default_value_t = Approximation::default().base_level, value_parser = clap::value_parser!(u8).range(0..=12))]
    pub base_level: u8,

    /// With approximate accuracy: how favourably holes are assumed to be distributed, from 1 (the hole's size is a promise) to 4
    #[arg(long, value_name = "D", default_value_t = Approximation::default().distribution, value_parser = parse_distribution)]
    pub distribution: f64,

    /// With approximate accuracy: what covers less of its surroundings is not looked at closely, from 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = Approximation::default().transparency, value_parser = parse_transparency)]
    pub transparency: f64,

    /// With approximate accuracy: translucent surfaces are occluders too, whose opacities combine
    #[arg(long)]
    pub translucent: bool,

    /// Pixels of the picture along the edge of an occlusion map's pixel: 1, 2 or 4 [default: 1; with approximate accuracy 4]
    #[arg(long, value_name = "SCALE")]
    pub map_scale: Option<MapScale>,

    /// Keep exact culling right for a final pass other than the CPU picture's, whose vertices and samples are up to this many pixels
    /// away from ours: 0 to 4 [default: 0; for a picture by the GPU 0.125]
    #[arg(long, value_name = "PX", value_parser = parse_slack)]
    pub slack: Option<Slack>,

    /// Threads to use [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Instruction set: scalar, sse4.2, avx2, avx512 or neon [default: the best that is there]
    #[arg(long, value_name = "LEVEL")]
    pub simd: Option<Level>,
}

/// Which occluders to draw.
#[derive(Clone, Copy, Debug, Args)]
pub struct OccluderOptions {
    /// How occluders are chosen
    #[arg(long, value_name = "SELECTION", default_value = "contribution", value_parser = selections())]
    pub occluders: Selection,

    /// Triangles that may be drawn as occluders in a frame: a number, all, or auto: those that pay. Or the time until which those
    /// that pay are drawn, as in 200us or 0.2ms; results depend on the machine then
    #[arg(long, value_name = "TRIANGLES|all|auto|TIME", default_value = "auto", value_parser = parse_budget)]
    pub budget: Budget,

    #[command(flatten)]
    pub choice: ChoiceOptions,
}

impl OccluderOptions {
    /// These settings, with occluders so chosen.
    pub fn of(self, settings: Settings) -> Settings {
        Settings {
            occluders: self.occluders,
            budget: self.budget,
            ..self.choice.of(settings)
        }
    }
}

/// What the selections of the papers take for an occluder.
#[derive(Clone, Copy, Debug, Args)]
pub struct ChoiceOptions {
    /// But by contribution: objects are unfit to be occluders by size, locality, complexity, redundancy, or all of these
    #[arg(long, value_name = "CRITERIA", num_args = 0..=1, require_equals = true, default_value = "none", default_missing_value = "all", value_parser = parse_criteria)]
    pub static_criteria: StaticCriteria,

    /// By weight: what fills less of its box is no occluder, from 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = Weighing::default().least_compactness, value_parser = parse_share)]
    pub compactness: f32,

    /// By weight: objects that are drawn at the most [default: as many as the budget allows]
    #[arg(long, value_name = "N")]
    pub active: Option<u32>,

    /// By what was previously visible: whether in the last frame, or in the one before it (1 or 2)
    #[arg(long, value_name = "FRAMES", default_value = "1", value_parser = parse_frames_back)]
    pub frames_back: FramesBack,

    /// By contribution: passes of a frame at the most: 1 draws what is remembered, 2 look again once, and so on
    /// [default: as many as pay]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub passes: Option<u32>,
}

impl ChoiceOptions {
    /// These settings, with such occluders.
    pub fn of(self, settings: Settings) -> Settings {
        Settings {
            static_criteria: self.static_criteria,
            weighing: Weighing {
                least_compactness: self.compactness,
                most_active: self.active,
            },
            frames_back: self.frames_back,
            most_passes: self.passes.unwrap_or(u32::MAX),
            ..settings
        }
    }
}

impl CullOptions {
    /// The settings asked for.
    ///
    /// # Errors
    /// If the instruction set cannot be had here.
    pub fn settings(&self) -> Result<Settings, Failure> {
        let accuracy = match self.accuracy {
            AccuracyName::Exact => Accuracy::Exact,
            AccuracyName::Approximate => Accuracy::Approximate(Approximation {
                hole: self.hole,
                base_level: self.base_level,
                distribution: self.distribution,
                transparency: self.transparency,
                ..Approximation::default()
            }),
        };
        let map_scale = self.map_scale.unwrap_or(accuracy.map_scale());
        let level = match self.simd {
            Some(level) => level.require()?,
            None => Level::best(),
        };
        Ok(Settings {
            accuracy,
            translucent: self.translucent,
            map_scale,
            slack: self.slack.unwrap_or_default(),
            threads: self.threads.map_or(0, usize::from),
            level,
            ..Settings::new(self.size)
        })
    }
}

/// Which frames of a path to take.
#[derive(Clone, Copy, Debug, Args)]
pub struct FrameOptions {
    /// Take frames 0, N, 2N ... of the path
    #[arg(long, value_name = "N", default_value = "1")]
    pub every: NonZeroUsize,
}

fn parse_size(text: &str) -> Result<PictureSize, String> {
    let sides = text
        .split_once('x')
        .and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let (width, height) = sides.ok_or("give the width and the height in pixels, as in 1280x768")?;
    PictureSize::new(width, height).map_err(|e| e.to_string())
}

/// Reads the name of a selection.
fn selections() -> impl TypedValueParser<Value = Selection> {
    PossibleValuesParser::new(Selection::ALL.map(Selection::name)).map(|name| {
        let named = |selection: &Selection| selection.name() == name;
        Selection::ALL.into_iter().find(named).unwrap_or_default()
    })
}

/// Reads names with commas between.
fn parse_criteria(text: &str) -> Result<StaticCriteria, String> {
    let named = |name: &str| match name {
        "none" => Ok(StaticCriteria::NONE),
        "all" => Ok(StaticCriteria::ALL),
        name => {
            let known = StaticCriteria::NAMED
                .iter()
                .find(|(known, _)| *known == name);
            known.map(|(_, criterion)| *criterion).ok_or(())
        }
    };
    text.split(',').try_fold(StaticCriteria::NONE, |all, name| {
        named(name).map(|criterion| all.and(criterion)).map_err(|()| {
            "give size, locality, complexity, redundancy, several of these with commas between, all or none"
                .to_owned()
        })
    })
}

fn parse_frames_back(text: &str) -> Result<FramesBack, String> {
    let known = [FramesBack::One, FramesBack::Two];
    let named = known
        .into_iter()
        .find(|back| back.count().to_string() == text);
    named.ok_or_else(|| "give 1 or 2".to_owned())
}

fn parse_distribution(text: &str) -> Result<f64, String> {
    let factor = text.parse().ok();
    let factor = factor.filter(|factor| (1.0..=4.0).contains(factor));
    factor.ok_or_else(|| "give a number from 1 to 4".to_owned())
}

fn parse_slack(text: &str) -> Result<Slack, String> {
    let pixels = text.parse().map_err(|_| "give a number of pixels")?;
    if pixels == 0.0 {
        return Ok(Slack::NONE);
    }
    Slack::new(pixels, Slack::GPU.position(), Slack::GPU.depth()).map_err(|e| e.to_string())
}

fn parse_transparency(text: &str) -> Result<f64, String> {
    parse_share(text).map(f64::from)
}

fn parse_share(text: &str) -> Result<f32, String> {
    let share = text.parse().ok();
    let share = share.filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "give a number from 0 to 1".to_owned())
}

fn parse_budget(text: &str) -> Result<Budget, String> {
    match text {
        "all" => Ok(Budget::All),
        "auto" => Ok(Budget::Auto),
        text => parse_time(text)
            .map(Budget::Time)
            .or_else(|| text.parse().ok().map(Budget::Triangles))
            .ok_or_else(|| {
                "give a number of triangles, `all`, `auto`, or a time with its unit, `us` or `ms`"
                    .into()
            }),
    }
}

/// Reads a time in microseconds or milliseconds.
pub fn parse_time(text: &str) -> Option<Duration> {
    let (number, unit_s) = match (text.strip_suffix("us"), text.strip_suffix("ms")) {
        (Some(number), _) => (number, 1e-6),
        (_, Some(number)) => (number, 1e-3),
        _ => return None,
    };
    let number: f64 = number.parse().ok()?;
    Duration::try_from_secs_f64(number * unit_s).ok()
}

/// Loads a scene and prepares it, or an archive, with its warnings on stderr.
///
/// # Errors
/// If the file is no scene.
pub fn load_scene(file: &Path) -> Result<Prepared, Failure> {
    let spinner = progress::spinner(format!("reading {}", file.display()));
    let prepared = Prepared::load(file);
    spinner.finish_and_clear();
    let prepared = prepared.map_err(|e| Failure::Failed(e.to_string()))?;
    output::warn(prepared.scene().warnings());
    Ok(prepared)
}

/// Loads a camera path.
///
/// # Errors
/// If the file is no path.
pub fn load_path(file: &Path) -> Result<CameraPath, Failure> {
    CameraPath::load(file).map_err(|e| Failure::Failed(e.to_string()))
}

/// Makes a folder and those above it.
///
/// # Errors
/// If it cannot be made.
pub fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|e| Failure::with_file(folder, "the folder cannot be made", e))
}

/// Where the camera path beside a scene file goes: `city.glb` has `city.path.json`.
pub fn path_beside(scene: &Path) -> PathBuf {
    scene.with_extension("path.json")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_with_an_x() {
        let size = parse_size("1280x768").expect("the default");
        assert_eq!((size.width(), size.height()), (1280, 768));
        for bad in [
            "", "1280", "1280x", "x768", "0x10", "10x-1", "1e3x10", "99999x10",
        ] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn criteria_are_names_with_commas_between() {
        assert_eq!(parse_criteria("none"), Ok(StaticCriteria::NONE));
        let [(size, only_size), _, _, (redundancy, only_redundancy)] = StaticCriteria::NAMED;
        assert_eq!(parse_criteria(size), Ok(only_size));
        assert_eq!(
            parse_criteria(&format!("{redundancy},{size}")),
            Ok(only_size.and(only_redundancy))
        );
        assert_eq!(
            parse_criteria(&StaticCriteria::ALL.to_string()),
            Ok(StaticCriteria::ALL)
        );
        assert!(parse_criteria("").is_err());
        assert!(parse_criteria("size;locality").is_err());
    }

    #[test]
    fn frames_back_are_one_or_two() {
        assert_eq!(parse_frames_back("1"), Ok(FramesBack::One));
        assert_eq!(parse_frames_back("2"), Ok(FramesBack::Two));
        for bad in ["0", "3", "", "one"] {
            assert!(parse_frames_back(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn shares_are_from_0_to_1() {
        assert_eq!(parse_share("0.55"), Ok(0.55));
        for bad in ["-0.1", "1.5", "NaN", "half"] {
            assert!(parse_share(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn budgets_are_a_number_all_auto_or_a_time() {
        assert_eq!(parse_budget("all"), Ok(Budget::All));
        assert_eq!(parse_budget("auto"), Ok(Budget::Auto));
        assert_eq!(parse_budget("5000"), Ok(Budget::Triangles(5000)));
        let us = |us| Ok(Budget::Time(Duration::from_micros(us)));
        assert_eq!(parse_budget("200us"), us(200));
        assert_eq!(parse_budget("0.2ms"), us(200));
        assert_eq!(parse_budget("0us"), us(0));
        for text in ["200us", "0.5us", "1500us"] {
            assert_eq!(
                parse_budget(text).map(|budget| budget.to_string()),
                Ok(text.to_owned())
            );
        }
        for bad in ["us", "-1us", "NaNms", "infms", "200s", "200 us"] {
            assert!(parse_budget(bad).is_err(), "{bad}");
        }
        assert!(parse_budget("some").is_err());
        assert!(parse_budget("-1").is_err());
    }
}
