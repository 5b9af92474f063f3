//! Sampled visibility on the command line: how it is asked for, and made.

use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::prepare::{GridLayout, Prepared, VisibilityGrid};
use antumbra::sampling::{SamplingSettings, sample_visibility};
use antumbra::scene::Aabb;
use antumbra::view::PictureSize;
use clap::Args;

use super::failure::Failure;
use super::progress;
use super::render::no_threads;

/// How sampled visibility is asked for.
#[derive(Clone, Copy, Debug, Args)]
pub struct GridOptions {
    /// Find out what is seen from viewpoints on a grid as well, for frames that remember nothing: from so many viewpoints at
    /// most, as dense as that allows
    #[arg(
        long,
        value_name = "VIEWPOINTS",
        num_args = 0..=1,
        default_missing_value = "2000",
        conflicts_with = "spacing",
        value_parser = clap::value_parser!(u64).range(1..)
    )]
    visibility_grid: Option<u64>,

    /// The same with viewpoints that are so far apart, in scene units: a room's width does well
    #[arg(long = "grid-spacing", value_name = "UNITS")]
    spacing: Option<f64>,

    /// Least and largest coordinates of the box to fill, in scene units [default: around all objects]
    #[arg(long = "grid-box", value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true, value_parser = parse_box)]
    bounds: Option<Aabb>,

    /// Pixels along the edge of each face of a viewpoint's cube
    #[arg(long = "grid-face", value_name = "PX", default_value_t = 256, value_parser = clap::value_parser!(u32).range(8..=4096))]
    face: u32,

    /// Clusters that are kept of what a viewpoint sees, at most
    #[arg(long = "grid-clusters", value_name = "COUNT", default_value_t = 2_048)]
    most_clusters: usize,
}

impl GridOptions {
    /// Samples the visibility of a scene, if that is asked for.
    pub fn make(self, prepared: &Prepared) -> Result<Option<Arc<VisibilityGrid>>, Failure> {
        let failed = |e: &dyn std::error::Error| Failure::Failed(e.to_string());
        if prepared.scene().objects().is_empty() {
            return Ok(None);
        }
        let all = prepared.scene().bvh().nodes[0].bounds();
        let bounds = self.bounds.unwrap_or(all);
        let layout = match (self.spacing, self.visibility_grid) {
            (Some(spacing), _) => GridLayout::with_spacing(&bounds, spacing),
            (None, Some(viewpoints)) => GridLayout::with_viewpoints(&bounds, viewpoints),
            (None, None) => return Ok(None),
        };
        // A grid's own frames have sizes of their own.
        let size = PictureSize::new(8, 8).map_err(|e| failed(&e))?;
        let culler = Culler::with_prepared(prepared, Settings::new(size)).map_err(no_threads)?;
        let settings = SamplingSettings {
            face: PictureSize::new(self.face, self.face).map_err(|e| failed(&e))?,
            most_clusters: self.most_clusters,
            ..SamplingSettings::new(layout.map_err(|e| failed(&e))?)
        };
        let bar = progress::bar("sampling", 0);
        let grid = sample_visibility(&culler, &settings, |done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        });
        bar.finish_and_clear();
        grid.map(|grid| Some(Arc::new(grid)))
            .map_err(|e| failed(&e))
    }
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
