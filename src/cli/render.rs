//! `antumbra render`: pictures of the survivors.

use std::path::{Path, PathBuf};
use std::time::Duration;

use antumbra::cull::{Culler, Settings};
use antumbra::final_pass::{Image, PictureFrame, overlay_image, render_image};
use antumbra::scene::Scene;
use antumbra::view::{Camera, CameraPath};
use clap::Args;

use super::failure::Failure;
use super::final_pass::{FinalPass, FinalPassName};
use super::options::{
    CullOptions, FrameOptions, OccluderOptions, load_path, load_scene, make_folder,
};
use super::output::{count_of, percent, say, thousands};
use super::outside::camera_outside;
use super::progress;

const EXAMPLES: &str = "\
Examples:
  antumbra render castle.glb
      one picture from a camera outside, out/frame_0000.png
  antumbra render castle.glb --path castle.path.json --every 8 --overlay --out pictures
      every eighth frame of a path, each also with what the culling did
  antumbra render castle.glb --path castle.path.json --final-pass gpu --check --compare
      the same by a graphics processor, and how far its pictures are from the CPU's
  antumbra render castle.glb --path castle.path.json --check
      proves that culling changes no pixel; exit code 1 if it does";

/// Draw what culling leaves of a scene, as PNG files
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Render {
    /// Scene file: .glb, .gltf, .obj or .antumbra
    scene: PathBuf,

    /// Camera path (JSON) [default: one camera that shows the whole scene from outside]
    #[arg(long, value_name = "PATH.json")]
    path: Option<PathBuf>,

    /// Also write overlay_NNNN.png: the picture, the scene from behind the camera, the occlusion maps
    #[arg(long)]
    overlay: bool,

    /// Also draw without culling, and fail if one byte differs
    #[arg(long)]
    check: bool,

    /// Who draws the pictures
    #[arg(long, value_enum, value_name = "cpu|gpu", default_value = "cpu")]
    final_pass: FinalPassName,

    /// Also draw the pictures by the CPU, say how many pixels differ, and mark them in compared_NNNN.png
    #[arg(long)]
    compare: bool,

    /// Folder for the pictures
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,

    #[command(flatten)]
    cull: CullOptions,

    #[command(flatten)]
    occluders: OccluderOptions,

    #[command(flatten)]
    frames: FrameOptions,
}

impl Render {
    /// Draws all frames.
    pub fn run(self) -> Result<(), Failure> {
        let settings = Settings {
            slack: self.cull.slack.unwrap_or(self.final_pass.slack()),
            ..self.occluders.of(self.cull.settings()?)
        };
        let path = self.path.as_deref().map(load_path).transpose()?;
        let prepared = load_scene(&self.scene)?;
        let scene = prepared.scene();
        let path = match path {
            Some(path) => path,
            None => CameraPath::still(
                camera_outside(scene.bounds(), settings.size.aspect()).map_err(|e| {
                    let file = self.scene.display();
                    Failure::Failed(format!(
                        "{file}: no camera shows the whole scene ({e}): give one with --path"
                    ))
                })?,
            ),
        };
        make_folder(&self.out)?;
        let mut culler = Culler::with_prepared(&prepared, settings).map_err(no_threads)?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads);
        let pool = pool.build().map_err(no_threads)?;
        let mut pass = FinalPass::open(self.final_pass, scene)?;

        let name = file_name(&self.scene);
        let mut sum = Sum::default();
        let mut difference = Difference::default();
        let every = self.frames.every.get();
        let frames: Vec<_> = path.cameras().iter().enumerate().step_by(every).collect();
        let bar = progress::bar("drawing", frames.len());
        for &(frame, camera) in &frames {
            let drawn = draw_frame(
                &mut culler,
                &mut pass,
                &pool,
                camera,
                self.overlay.then_some((name.as_str(), frame)),
            )?;
            sum.add(&drawn);
            let file = self.out.join(format!("frame_{frame:04}.png"));
            save(&drawn.picture, &file)?;
            if let Some(sheet) = &drawn.overlay {
                save(sheet, &self.out.join(format!("overlay_{frame:04}.png")))?;
            }
            if self.check {
                let all: Vec<u32> = (0..scene.objects().len() as u32).collect();
                let whole = pass.picture(&pool, scene, camera, settings.size, &all)?;
                self.check(frame, &drawn.picture, &whole)?;
            }
            if self.compare {
                let objects = &drawn.objects;
                let by_cpu = pool.install(|| render_image(scene, camera, settings.size, objects));
                difference.add(&drawn.picture, &by_cpu);
                let file = self.out.join(format!("compared_{frame:04}.png"));
                save(&drawn.picture.difference(&by_cpu), &file)?;
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        say(sum.describe(&name, scene, frames.len()))?;
        if self.check {
            say("the pictures with culling equal those without, byte for byte")?;
        }
        if let Some(device) = pass.device() {
            say(format_args!("drawn by {device}"))?;
        }
        if self.compare {
            say(difference.describe())?;
        }
        say(format_args!("pictures in {}", self.out.display()))
    }

    /// Fails, and leaves all there is to see, if the two pictures of a frame differ.
    fn check(&self, frame: usize, culled: &Image, whole: &Image) -> Result<(), Failure> {
        let differing = culled.differing_pixels(whole);
        if differing == 0 {
            return Ok(());
        }
        let unculled = self.out.join(format!("frame_{frame:04}.unculled.png"));
        let difference = self.out.join(format!("frame_{frame:04}.difference.png"));
        save(whole, &unculled)?;
        save(&culled.difference(whole), &difference)?;
        Err(Failure::Failed(format!(
            "{}: frame {frame}: culling changes {differing} pixels: compare {} and {}",
            self.scene.display(),
            unculled.display(),
            difference.display(),
        )))
    }
}

/// A frame that has been culled and drawn.
pub struct DrawnFrame {
    pub in_frustum: usize,
    /// Those that are visible.
    pub objects: Vec<u32>,
    pub time: Duration,
    pub picture: Image,
    pub overlay: Option<Image>,
}

/// Culls and draws a frame, for an overlay too if it is given the scene's name and the frame's number.
pub fn draw_frame(
    culler: &mut Culler,
    pass: &mut FinalPass,
    pool: &rayon::ThreadPool,
    camera: &Camera,
    overlay: Option<(&str, usize)>,
) -> Result<DrawnFrame, Failure> {
    let set = culler.cull(camera);
    let in_frustum = culler.in_frustum(camera);
    let size = culler.settings().size;
    let scene: &Scene = culler.scene();
    let picture = pass.picture(pool, scene, camera, size, &set.visible)?;
    let overlay = overlay
        .zip(culler.buffer())
        .map(|((name, number), buffer)| {
            let frame = PictureFrame {
                scene,
                camera,
                size,
                in_frustum: &in_frustum,
                set: &set,
                map: buffer.map(),
            };
            let title = format!(
                "{name}, frame {number}, {}x{}: what is left after culling",
                size.width(),
                size.height()
            );
            pool.install(|| overlay_image(&frame, &picture, &title))
        });
    Ok(DrawnFrame {
        in_frustum: in_frustum.len(),
        time: set.times.total(),
        objects: set.visible,
        picture,
        overlay,
    })
}

/// What all frames together came to.
#[derive(Default)]
struct Sum {
    in_frustum: u64,
    visible: u64,
    time: Duration,
}

impl Sum {
    fn add(&mut self, frame: &DrawnFrame) {
        self.in_frustum += frame.in_frustum as u64;
        self.visible += frame.objects.len() as u64;
        self.time += frame.time;
    }

    fn describe(&self, name: &str, scene: &Scene, frames: usize) -> String {
        let culled = self.in_frustum.saturating_sub(self.visible);
        format!(
            "{name}: {}, {}; {}: {} in the frustum, {} culled ({:.1} %), {} visible; culling took {:.2} ms a frame",
            count_of(scene.objects().len() as u64, "object"),
            count_of(scene.triangle_count(), "triangle"),
            count_of(frames as u64, "frame"),
            count_of(self.in_frustum, "object"),
            thousands(culled),
            percent(culled, self.in_frustum),
            thousands(self.visible),
            self.time.as_secs_f64() * 1000.0 / frames.max(1) as f64,
        )
    }
}

/// How far pictures are from the CPU's.
#[derive(Default)]
struct Difference {
    pixels: u64,
    /// Those that differ, and those that differ by more than a little.
    differing: [u64; 2],
}

impl Difference {
    /// Up to this, of 255, is a little: a rounding or two.
    const LITTLE: u8 = 2;

    fn add(&mut self, picture: &Image, by_cpu: &Image) {
        self.pixels += picture.pixels().len() as u64;
        for (sum, by) in self.differing.iter_mut().zip([0, Difference::LITTLE]) {
            *sum += picture.pixels_differing_by_more(by_cpu, by) as u64;
        }
    }

    fn describe(&self) -> String {
        let share = self
            .differing
            .map(|d| 100.0 * d as f64 / self.pixels.max(1) as f64);
        format!(
            "{:.4} % of the pixels differ from the CPU pictures, {:.4} % by more than {} of 255",
            share[0],
            share[1],
            Difference::LITTLE,
        )
    }
}

/// The name of a file without its folders.
pub fn file_name(file: &Path) -> String {
    file.file_name().map_or_else(
        || file.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// Writes a PNG.
pub fn save(image: &Image, file: &Path) -> Result<(), Failure> {
    image
        .save_png(file)
        .map_err(|e| Failure::with_file(file, "cannot be written", e))
}

/// The operating system gives no threads.
pub fn no_threads(error: rayon::ThreadPoolBuildError) -> Failure {
    Failure::Failed(format!("no threads to be had: {error}"))
}
