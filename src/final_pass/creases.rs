//! Darkens creases and brightens ridges, so that flat-shaded surfaces of one colour can be told apart.
//!
//! The depth buffer is compared with itself a little to each side (Luft, Colditz and Deussen, "Image enhancement by
//! unsharp masking the depth buffer", 2006). Depth is linear on screen, so the two opposite neighbours of a sample on
//! a plane average to the sample itself; if they are nearer, it lies in a crease, if farther, on a ridge.
//!
//! The effect reads nothing but final depths, and these are the same with and without culling.

use crate::view::{PictureSize, Projection};

/// Neighbours at these distances, in pixels of a picture of [`REFERENCE_HEIGHT`].
const RADII: [f64; 3] = [2.0, 6.0, 18.0];
const REFERENCE_HEIGHT: f64 = 768.0;
/// One step to each direction; the opposite is taken with it.
const DIRECTIONS: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [0.7, 0.7], [0.7, -0.7]];
/// How much darker a right angle seen from within is, and how much brighter one seen from without.
pub const DARKEST: f32 = 0.9;
pub const BRIGHTEST: f32 = 0.2;

/// Finds creases in the depths of a picture, row by row; minus infinity where there is nothing.
#[derive(Clone, Debug)]
pub struct Creases {
    size: PictureSize,
    /// Steps to one of two opposite neighbours, and one over their length.
    steps: Vec<([i32; 2], f32)>,
    scale: Scale,
}

/// What a difference of depth means, in pixels.
#[derive(Clone, Copy, Debug)]
pub enum Scale {
    /// Depth is one over distance: pixels = focal length × relative difference.
    Relative(f32),
    /// Depth is distance: pixels = pixels a unit × difference.
    Absolute(f32),
}

impl Creases {
    /// For pictures of a size, through a projection.
    pub fn new(size: PictureSize, projection: &Projection) -> Creases {
        let height = size.height() as f64;
        let scale = match *projection {
            Projection::Perspective { fov_y, .. } => {
                Scale::Relative((height * 0.5 / libm::tan(fov_y * 0.5)) as f32)
            }
            Projection::Orthographic { height: shown, .. } => {
                Scale::Absolute((height / shown) as f32)
            }
        };
        let mut steps = Vec::new();
        for radius in RADII {
            let radius = radius * height / REFERENCE_HEIGHT;
            let radius = if radius < 1.0 { 1.0 } else { radius };
            for [x, y] in DIRECTIONS {
                let step = [(x * radius).round() as i32, (y * radius).round() as i32];
                let length = f64::from(step[0] * step[0] + step[1] * step[1]).sqrt();
                steps.push((step, (1.0 / length) as f32));
            }
        }
        Creases { size, steps, scale }
    }

    /// Steps in pixels to one of two opposite neighbours, and one over their length.
    #[cfg(feature = "gpu")]
    pub fn steps(&self) -> &[([i32; 2], f32)] {
        &self.steps
    }

    /// What a difference of depth means.
    #[cfg(feature = "gpu")]
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// What to multiply the light of a pixel with.
    pub fn factor(&self, depth_at: impl Fn(usize, usize) -> f32, x: usize, y: usize) -> f32 {
        let here = depth_at(x, y);
        let (mut dark, mut bright) = (0.0_f32, 0.0_f32);
        for &([dx, dy], per_length) in &self.steps {
            let (Some((x0, y0)), Some((x1, y1))) =
                (self.moved(x, y, dx, dy), self.moved(x, y, -dx, -dy))
            else {
                continue;
            };
            let (a, b) = (depth_at(x0, y0), depth_at(x1, y1));
            if a == f32::NEG_INFINITY || b == f32::NEG_INFINITY {
                continue;
            }
            let nearer = (a - here) + (b - here);
            let pixels = match self.scale {
                Scale::Relative(focal_length) => nearer / here * focal_length,
                Scale::Absolute(pixels_per_unit) => nearer * pixels_per_unit,
            };
            let slope = pixels * 0.5 * per_length;
            // A step far deeper than wide is another object's outline, and fades.
            if slope > 1.0 {
                dark += 1.0 / (slope * slope);
            } else if slope > 0.0 {
                dark += slope;
            } else if slope > -1.0 {
                bright -= slope;
            } else if slope < -1.0 {
                bright += 1.0 / (slope * slope);
            }
        }
        let count = self.steps.len() as f32;
        (1.0 - DARKEST * (dark / count)) * (1.0 + BRIGHTEST * (bright / count))
    }

    fn moved(&self, x: usize, y: usize, dx: i32, dy: i32) -> Option<(usize, usize)> {
        let x = x.checked_add_signed(dx as isize)?;
        let y = y.checked_add_signed(dy as isize)?;
        (x < self.size.width() && y < self.size.height()).then_some((x, y))
    }
}
