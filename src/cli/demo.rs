//! `antumbra demo`: everything at once, from nothing.

use std::cmp::Reverse;
use std::path::PathBuf;
use std::time::Instant;

use antumbra::cull::{Culler, Settings};
use antumbra::final_pass::Image;
use antumbra::measure::{MeasureSettings, run};
use antumbra::prepare::Prepared;
use antumbra::view::{CameraPath, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};
use clap::Args;

use super::demo_report::{Pictures, report_page};
use super::failure::Failure;
use super::final_pass::FinalPass;
use super::generate::write_fixture;
use super::options::{load_path, load_scene, make_folder};
use super::output::{percent, say, thousands};
use super::progress;
use super::render::{draw_frame, no_threads, save};

const EXAMPLES: &str = "\
Examples:
  antumbra demo
  antumbra demo --out /tmp/city";

/// Columns of the contact sheet, and by what its pictures are shrunk.
const SHEET_COLUMNS: usize = 4;
const SHEET_SHRINK: usize = 4;
const SHEET_GAP: usize = 8;
const SHEET_GROUND: [u8; 3] = [18, 21, 26];
/// So many frames, those in which most is culled, get an overlay.
const OVERLAYS: usize = 3;

/// Make a city, walk through it, and show what culling does there: pictures and a report
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Demo {
    /// Folder for the pictures and the report
    #[arg(long, value_name = "DIR", default_value = "antumbra-demo")]
    out: PathBuf,

    /// How many frames of the walk to show
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,

    /// Triangles of the city [default: as in Zhang's dissertation, 312,524]
    #[arg(long, value_name = "N")]
    triangles: Option<u64>,
}

impl Demo {
    /// Runs it all.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        make_folder(&self.out)?;
        let city = self.out.join("city.glb");
        let recipe = Recipe {
            triangles: self.triangles,
            ..Recipe::new(Kind::City)
        };
        let fixture = generate(&recipe).map_err(|e| Failure::Failed(e.to_string()))?;
        let path_file = write_fixture(&fixture, &city)?;
        drop(fixture);
        let prepared = load_scene(&city)?;
        let scene = prepared.scene();
        let walk = load_path(&path_file)?;
        say(format_args!(
            "a city of {} objects and {} triangles",
            thousands(scene.objects().len() as u64),
            thousands(scene.triangle_count()),
        ))?;

        let size = PictureSize::new(1280, 768).map_err(|e| Failure::Failed(e.to_string()))?;
        let cull = Settings::new(size);
        let every = walk.cameras().len().div_ceil(self.frames as usize).max(1);
        let pictures = self.draw(&prepared, &walk, cull, every)?;

        let settings = MeasureSettings {
            cull,
            cold: false,
            every,
            animate: None,
            simulate_threads: false,
        };
        let bar = progress::bar("judging", 0);
        let report = run(&prepared, &walk, &settings, |done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        });
        bar.finish_and_clear();
        let report = report.map_err(no_threads)?;

        let page = self.out.join("index.html");
        std::fs::write(&page, report_page(&report, &pictures))
            .map_err(|e| Failure::with_file(&page, "cannot be written", e))?;
        let sum = |of: fn(&antumbra::measure::FrameReport) -> u64| -> u64 {
            report.frames.iter().map(of).sum()
        };
        let (culled, hidden) = (sum(|f| f.culled), sum(|f| f.exactly_hidden));
        say(format_args!(
            "{} frames: {} of {} hidden objects culled ({:.1} %), {} wrong pixels, {:.2} ms a frame",
            report.frames.len(),
            thousands(culled),
            thousands(hidden),
            percent(culled, hidden),
            report.totals.wrong_pixels,
            report.totals.time_us_mean.total / 1000.0,
        ))?;
        say(format_args!(
            "done in {:.1} s: open {}",
            start.elapsed().as_secs_f64(),
            page.display()
        ))
    }

    /// Writes the pictures.
    fn draw(
        &self,
        prepared: &Prepared,
        walk: &CameraPath,
        cull: Settings,
        every: usize,
    ) -> Result<Pictures, Failure> {
        let mut culler = Culler::with_prepared(prepared, cull).map_err(no_threads)?;
        let pool = rayon::ThreadPoolBuilder::new()
            .build()
            .map_err(no_threads)?;
        let frames: Vec<_> = walk.cameras().iter().enumerate().step_by(every).collect();
        let mut pictures = Pictures {
            sheet: "contact_sheet.png".into(),
            ..Pictures::default()
        };
        let (mut small, mut culled) = (Vec::new(), Vec::new());
        let bar = progress::bar("drawing", frames.len());
        for &(frame, camera) in &frames {
            let drawn = draw_frame(&mut culler, &mut FinalPass::Cpu, &pool, camera, None)?;
            let name = format!("frame_{frame:04}.png");
            save(&drawn.picture, &self.out.join(&name))?;
            pictures.frames.push(name);
            small.push(drawn.picture.shrunk(SHEET_SHRINK));
            culled.push((drawn.in_frustum - drawn.objects.len(), frame, camera));
            bar.inc(1);
        }
        bar.finish_and_clear();
        if let Some(sheet) = contact_sheet(&small) {
            save(&sheet, &self.out.join(&pictures.sheet))?;
        }

        culled.sort_by_key(|&(count, frame, _)| (Reverse(count), frame));
        culled.truncate(OVERLAYS);
        culled.sort_by_key(|&(_, frame, _)| frame);
        let bar = progress::bar("explaining", culled.len());
        for (_, frame, camera) in culled {
            let drawn = draw_frame(
                &mut culler,
                &mut FinalPass::Cpu,
                &pool,
                camera,
                Some(("city", frame)),
            )?;
            if let Some(sheet) = &drawn.overlay {
                let name = format!("overlay_{frame:04}.png");
                save(sheet, &self.out.join(&name))?;
                pictures.overlays.push(name);
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(pictures)
    }
}

/// All pictures, of one size, on one sheet.
fn contact_sheet(pictures: &[Image]) -> Option<Image> {
    let first = pictures.first()?;
    let columns = SHEET_COLUMNS.min(pictures.len());
    let (width, height) = (first.width() + SHEET_GAP, first.height() + SHEET_GAP);
    let rows = pictures.len().div_ceil(columns);
    let mut sheet = Image::filled(
        columns * width + SHEET_GAP,
        rows * height + SHEET_GAP,
        SHEET_GROUND,
    );
    let across = sheet.width();
    for (i, picture) in pictures.iter().enumerate() {
        let (left, top) = (
            i % columns * width + SHEET_GAP,
            i / columns * height + SHEET_GAP,
        );
        for (row, pixels) in picture.pixels().chunks_exact(picture.width()).enumerate() {
            let at = (top + row) * across + left;
            sheet.pixels_mut()[at..at + pixels.len()].copy_from_slice(pixels);
        }
    }
    Some(sheet)
}
