//! Sampled visibility on the command line: how it is asked for, made, kept and read. Where it is kept is decided here alone.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use antumbra::cull::{Culler, Settings};
use antumbra::occluders::{GridLayout, VisibilityGrid};
use antumbra::sampling::{SamplingSettings, sample_visibility};
use antumbra::scene::Aabb;
use antumbra::view::PictureSize;
use clap::Args;

use super::failure::Failure;
use super::options::load_scene;
use super::output::{count_of, say};
use super::progress;
use super::render::no_threads;

/// How sampled visibility is asked for.
#[derive(Clone, Copy, Debug, Args)]
pub struct GridOptions {
    /// Distance between neighbouring viewpoints, in scene units
    #[arg(long, value_name = "UNITS")]
    spacing: Option<f64>,

    /// Viewpoints at most, as dense as that allows
    #[arg(
        long,
        value_name = "COUNT",
        default_value_t = 2_000,
        conflicts_with = "spacing"
    )]
    viewpoints: u64,

    /// Least and largest coordinates of the box to fill, in scene units [default: around all objects]
    #[arg(long = "grid-box", value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true, value_parser = parse_box)]
    bounds: Option<Aabb>,

    /// Pixels along the edge of each face of a viewpoint's cube
    #[arg(long, value_name = "PX", default_value_t = 256, value_parser = clap::value_parser!(u32).range(8..=4096))]
    face: u32,

    /// Clusters that are kept of what a viewpoint sees, at most
    #[arg(long, value_name = "COUNT", default_value_t = 2_048)]
    most_clusters: usize,
}

impl GridOptions {
    /// Samples the visibility of a culler's scene.
    pub fn make(self, culler: &Culler) -> Result<VisibilityGrid, Failure> {
        let failed = |e: &dyn std::error::Error| Failure::Failed(e.to_string());
        let all = culler.scene().bvh().nodes[0].bounds();
        let bounds = self.bounds.unwrap_or(all);
        let layout = match self.spacing {
            Some(spacing) => GridLayout::with_spacing(&bounds, spacing),
            None => GridLayout::with_viewpoints(&bounds, self.viewpoints),
        };
        let settings = SamplingSettings {
            face: PictureSize::new(self.face, self.face).map_err(|e| failed(&e))?,
            most_clusters: self.most_clusters,
            ..SamplingSettings::new(layout.map_err(|e| failed(&e))?)
        };
        let bar = progress::bar("sampling", 0);
        let grid = sample_visibility(culler, &settings, |done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        });
        bar.finish_and_clear();
        grid.map_err(|e| failed(&e))
    }
}

/// Sample a scene's visibility from viewpoints on a grid
#[derive(Debug, Args)]
pub struct PrepareGrid {
    /// Scene file: .glb, .gltf or .obj
    scene: PathBuf,

    #[command(flatten)]
    grid: GridOptions,

    /// The file to write
    #[arg(short, long = "output", value_name = "FILE")]
    output: PathBuf,
}

impl PrepareGrid {
    /// Samples, and writes.
    pub fn run(self) -> Result<(), Failure> {
        let scene = load_scene(&self.scene)?;
        let size = PictureSize::new(8, 8).map_err(|e| Failure::Failed(e.to_string()))?;
        let culler = Culler::new(scene, Settings::new(size)).map_err(no_threads)?;
        let start = Instant::now();
        let grid = self.grid.make(&culler)?;
        let seconds = start.elapsed().as_secs_f64();
        let bytes = grid.to_bytes();
        std::fs::write(&self.output, &bytes)
            .map_err(|e| Failure::with_file(&self.output, "cannot be written", e))?;
        let layout = grid.layout();
        say(format_args!(
            "{}: {}, {:.3} apart; {}; {}; {:.1} s",
            self.output.display(),
            count_of(layout.viewpoints(), "viewpoint"),
            layout.spacing,
            count_of(grid.len() as u64, "cluster"),
            count_of(bytes.len() as u64, "byte"),
            seconds,
        ))
    }
}

/// Gives a culler the sampled visibility of a file.
pub fn give_grid(culler: &mut Culler, file: &Path) -> Result<(), Failure> {
    let bytes = std::fs::read(file).map_err(|e| Failure::with_file(file, "cannot be read", e))?;
    let grid = VisibilityGrid::from_bytes(&bytes);
    grid.and_then(|grid| culler.set_visibility_grid(Arc::new(grid)))
        .map_err(|e| Failure::with_file(file, "cannot be used", e))
}

fn parse_box(text: &str) -> Result<Aabb, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let bounds = match numbers.as_deref() {
        Ok(&[a, b, c, d, e, f]) => Aabb {
            min: [a, b, c].into(),
            max: [d, e, f].into(),
        },
        _ => return Err("give six numbers: the least x, y and z, and the largest".into()),
    };
    let is_box =
        bounds.min.cmple(bounds.max).all() && bounds.min.is_finite() && bounds.max.is_finite();
    if is_box {
        Ok(bounds)
    } else {
        Err("each least coordinate must be at most the largest, and all finite".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_six_numbers_in_order() {
        let bounds = parse_box("-1,0,2.5, 1,0,3").expect("a box");
        assert_eq!((bounds.min.x, bounds.max.z), (-1.0, 3.0));
        for bad in ["", "1,2,3", "1,0,0,0,1,1", "0,0,0,1,1,inf", "nan,0,0,1,1,1"] {
            assert!(parse_box(bad).is_err(), "{bad}");
        }
    }
}
