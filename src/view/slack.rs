//! What a final pass that is not ours may do otherwise: how far culling keeps away from it.
//!
//! Our final pass has the vertices, samples and depths of the occluders to the bit. A graphics processor transforms vertices in f32,
//! rounds them to a grid of its own, has samples of its own if it takes several a pixel, and depths of its own format. Exact culling
//! is right for its picture as well if everything that it may do otherwise is taken off what hides, and added to what is asked:
//!
//! * Each occluder's outline is pulled in by [`Slack::pixels`], *before* coverage is merged, and its depth is taken anywhere that far
//!   around a sample. What is asked is moved out by as much. Pulling in the merged mask would not do: a slit between two walls that
//!   our rounding closes leaves no hole in the mask, and shows what is behind on a device that rounds otherwise.
//! * Vertices may be off by [`Slack::position`] of the distance to their object's farthest corner. Boxes grow by that; occluders stand
//!   back by it, and are cut off where they are so near that it may be more than three eighths of the pixels.
//! * Depths may be off by [`Slack::depth`]. What is asked comes nearer by it, on its own behalf and on that of what is in front.
//!
//! That a sample within an outline pulled in by δ is covered on a device that draws each vertex within δ of ours: as the vertices move
//! from our places to the device's, no point of the outline gets farther than δ from where it was, so none crosses the sample. How
//! often the outline winds around the sample does not change, and so some triangle of it covers the sample. That holds for two
//! triangles drawn as one quadrilateral, too, if the device leaves no gap between triangles that share an edge.

use super::{MapScale, Projection, ViewError};
use antumbra_simd::SUBPIXELS;
use antumbra_simd::triangle::DepthPlane;

/// How far the final pass may lie from ours; see the module. None for the CPU picture.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Slack {
    pixels: f64,
    position: f64,
    depth: f64,
}

impl Slack {
    /// The final pass is ours.
    pub const NONE: Slack = Slack {
        pixels: 0.0,
        position: 0.0,
        depth: 0.0,
    };

    /// A graphics processor with one sample a pixel, at its centre, that gets positions relative to the middle of their mesh, matrices made
    /// in f64 with the eye subtracted first, and a depth buffer of 24 bits or f32.
    ///
    /// An eighth of a pixel: half of it for the device's grid, which has 16 steps a pixel or more; the rest for what transforms are off.
    /// 2⁻²¹ of the distance, which is 8 roundings of f32. A product with a matrix has 6 of the distance from the middle of the mesh
    /// (matrix, position, product, three sums) and 2 of that from the eye to the middle: no more than 6.4 of that from the eye to the
    /// farthest corner. 2⁻²² of depth: four steps of 24 bits.
    pub const GPU: Slack = Slack {
        pixels: 1.0 / 8.0,
        position: 1.0 / (1 << 21) as f64,
        depth: 1.0 / (1 << 22) as f64,
    };

    /// The same with several samples a pixel, wherever in the pixel: half a pixel for where they are.
    pub const GPU_MULTISAMPLED: Slack = Slack {
        pixels: 1.0,
        ..Slack::GPU
    };

    /// The most pixels: what the arithmetic of small polygons has room for.
    pub const MOST_PIXELS: f64 = 4.0;

    /// A slack of so many pixels, up to [`Slack::MOST_PIXELS`]; of a share of the distance from the eye to the farthest corner of the box
    /// of a vertex's object, up to 1/2; and of a share of the depth buffer's range, up to 1.
    ///
    /// In perspective the range is 1. In orthographic views it is the distance from the near plane to the far plane; without a far
    /// plane nothing is known of depth, and a slack of it hides nothing.
    ///
    /// # Errors
    /// If a number is out of range.
    pub fn new(pixels: f64, position: f64, depth: f64) -> Result<Slack, ViewError> {
        let check = |what, value: f64, most: f64, must_be| {
            if (0.0..=most).contains(&value) {
                Ok(value)
            } else {
                Err(ViewError::OutOfRange {
                    what,
                    value,
                    must_be,
                })
            }
        };
        Ok(Slack {
            pixels: check("slack in pixels", pixels, Slack::MOST_PIXELS, "0 to 4")?,
            position: check("slack of positions", position, 0.5, "0 to 1/2")?,
            depth: check("slack of depth", depth, 1.0, "0 to 1")?,
        })
    }

    /// How far on screen a vertex may be drawn from where it projects to, added to how far a sample may be from its pixel's centre.
    pub fn pixels(&self) -> f64 {
        self.pixels
    }

    /// How far a vertex may be from where it should be, as a share of the distance from the eye to the farthest corner of its object's box.
    pub fn position(&self) -> f64 {
        self.position
    }

    /// How far a depth may be off, as a share of the depth buffer's range.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Whether the final pass is ours.
    pub fn is_none(&self) -> bool {
        *self == Slack::NONE
    }

    /// How far a depth may be off through a projection, in the projection's own depth. Infinitely, where its range is not known.
    pub(crate) fn depth_through(&self, projection: &Projection) -> f64 {
        match *projection {
            _ if self.depth == 0.0 => 0.0,
            Projection::Perspective { .. } => self.depth,
            Projection::Orthographic { near, far, .. } => {
                far.map_or(f64::INFINITY, |far| self.depth * (far - near))
            }
        }
    }

    /// How far a depth between vertices may be off, as a share of their range: a device is trusted with ten bits.
    pub(crate) fn slope_error(&self) -> f64 {
        if self.is_none() {
            DepthPlane::SLOPE_ERROR
        } else {
            1.0 / 1024.0
        }
    }

    /// The pixels in sub-pixels of a map.
    pub(crate) fn subpixels(&self, scale: MapScale) -> f64 {
        self.pixels * f64::from(SUBPIXELS) / f64::from(scale.pixels())
    }

    /// Sub-pixels of the map by which occluders are pulled in besides what its scale asks for.
    pub(crate) fn inset(&self, scale: MapScale) -> i32 {
        // A vertex of ours is half a step of the grid from where it projects to.
        let snap = i32::from(self.pixels > 0.0);
        self.subpixels(scale).ceil() as i32 + snap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_slack_pulls_nothing_in_and_a_pixel_pulls_in_more_than_a_pixel() {
        for scale in MapScale::ALL {
            assert_eq!(Slack::NONE.inset(scale), 0);
            let pixel = SUBPIXELS / scale.pixels() as i32;
            assert_eq!(Slack::GPU_MULTISAMPLED.inset(scale), pixel + 1);
        }
    }

    #[test]
    fn a_slack_out_of_range_is_refused() {
        assert_eq!(Slack::new(0.0, 0.0, 0.0), Ok(Slack::NONE));
        for [pixels, position, depth] in [
            [4.1, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [f64::NAN, 0.0, 0.0],
            [1.0, 0.6, 0.0],
            [1.0, 0.0, 1.5],
        ] {
            assert!(Slack::new(pixels, position, depth).is_err());
        }
    }
}
