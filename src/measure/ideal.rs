//! The yardsticks: bounding boxes tested against the exact depth of every pixel.

use glam::DVec3;

use crate::scene::Aabb;
use crate::view::{Camera, PictureSize, Projection};

/// Depths count as strictly nearer from this share on.
const TO_SPARE: f64 = 1e-6;

/// Pixels along the edge of the blocks whose farthest depth is kept, to decide them at once.
const BLOCK: usize = 8;

/// The depth of every pixel of a picture, row by row; minus infinity where there is nothing.
#[derive(Clone, Debug)]
pub struct ExactDepths {
    size: PictureSize,
    pixels: Vec<f32>,
    farthest_of_block: Vec<f32>,
}

impl ExactDepths {
    /// Takes the depths of a picture.
    ///
    /// # Panics
    /// If there are not as many as pixels.
    pub fn new(size: PictureSize, pixels: Vec<f32>) -> ExactDepths {
        assert_eq!(pixels.len(), size.width() * size.height());
        let across = size.width().div_ceil(BLOCK);
        let mut farthest_of_block = vec![f32::INFINITY; across * size.height().div_ceil(BLOCK)];
        for (y, row) in pixels.chunks_exact(size.width()).enumerate() {
            for (x, &depth) in row.iter().enumerate() {
                let farthest = &mut farthest_of_block[y / BLOCK * across + x / BLOCK];
                *farthest = if depth < *farthest { depth } else { *farthest };
            }
        }
        ExactDepths {
            size,
            pixels,
            farthest_of_block,
        }
    }

    /// The picture's size.
    pub fn size(&self) -> PictureSize {
        self.size
    }

    /// The depth of a pixel.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        self.pixels[y * self.size.width() + x]
    }

    /// Whether at each pixel of columns `x` and rows `y`, ends included, the exact depth is strictly nearer than
    /// `depth_at` says, which is nowhere nearer than `nearest`.
    fn hide(
        &self,
        x: [usize; 2],
        y: [usize; 2],
        nearest: f64,
        depth_at: impl Fn(usize, usize) -> Option<f64>,
    ) -> bool {
        let before = |exact: f32, depth: f64| f64::from(exact) > depth + depth.abs() * TO_SPARE;
        let across = self.size.width().div_ceil(BLOCK);
        (y[0] / BLOCK..=y[1] / BLOCK).all(|block_y| {
            (x[0] / BLOCK..=x[1] / BLOCK).all(|block_x| {
                if before(self.farthest_of_block[block_y * across + block_x], nearest) {
                    return true;
                }
                let span = |s: [usize; 2], block: usize| {
                    s[0].max(block * BLOCK)..=s[1].min(block * BLOCK + BLOCK - 1)
                };
                span(y, block_y).all(|py| {
                    span(x, block_x).all(|px| {
                        depth_at(px, py).is_none_or(|depth| before(self.at(px, py), depth))
                    })
                })
            })
        })
    }
}

/// What a box's corners span: columns and rows in pixels, and the nearest depth. None if one is at or behind the near
/// plane.
fn span_of_corners(
    camera: &Camera,
    size: PictureSize,
    bounds: &Aabb,
) -> Option<([f64; 2], [f64; 2], f64)> {
    let (mut x, mut y) = (
        [f64::INFINITY, f64::NEG_INFINITY],
        [f64::INFINITY, f64::NEG_INFINITY],
    );
    let mut nearest = f64::INFINITY;
    for corner in bounds.corners() {
        let relative = corner - camera.eye();
        let distance = relative.dot(camera.forward());
        if distance <= camera.projection().near() {
            return None;
        }
        let (across, up) = half_extents(camera, size);
        let scale = match camera.projection() {
            Projection::Perspective { .. } => distance,
            Projection::Orthographic { .. } => 1.0,
        };
        let px =
            (relative.dot(camera.right()) / (across * scale) + 1.0) * 0.5 * size.width() as f64
                - camera.jitter().x;
        let py = (1.0 - relative.dot(camera.up()) / (up * scale)) * 0.5 * size.height() as f64
            - camera.jitter().y;
        x = [x[0].min(px), x[1].max(px)];
        y = [y[0].min(py), y[1].max(py)];
        nearest = nearest.min(distance);
    }
    Some((x, y, camera.projection().depth_at(nearest)))
}

/// Half the picture's width and height, at distance 1 or, orthographic, at any.
fn half_extents(camera: &Camera, size: PictureSize) -> (f64, f64) {
    let up = match *camera.projection() {
        Projection::Perspective { fov_y, .. } => libm::tan(fov_y * 0.5),
        Projection::Orthographic { height, .. } => height * 0.5,
    };
    (up * size.aspect(), up)
}

/// Pixels from `first` to `last`, cut to those there are; none if there are none.
fn clamped(first: f64, last: f64, pixels: usize) -> Option<[usize; 2]> {
    let (first, last) = (first.max(0.0), last.min(pixels as f64 - 1.0));
    (first <= last).then_some([first as usize, last as usize])
}

/// The ideal box test: whether the exact depth is strictly nearer than the box's nearest corner at every pixel from
/// ⌊x_min − ½⌋ to ⌈x_max − ½⌉ of its projected corners, and likewise in y. About a pixel wider than need be; it stays
/// so, to compare with figures measured elsewhere.
pub fn ideal_box_test(depths: &ExactDepths, camera: &Camera, bounds: &Aabb) -> bool {
    let Some((x, y, nearest)) = span_of_corners(camera, depths.size(), bounds) else {
        return false;
    };
    let size = depths.size();
    let columns = clamped((x[0] - 0.5).floor(), (x[1] - 0.5).ceil(), size.width());
    let rows = clamped((y[0] - 0.5).floor(), (y[1] - 0.5).ceil(), size.height());
    let (Some(columns), Some(rows)) = (columns, rows) else {
        return true;
    };
    depths.hide(columns, rows, nearest, |_, _| Some(nearest))
}

/// The ideal face test: whether the exact depth is strictly nearer than the box itself at every pixel centre inside
/// its projection.
pub fn ideal_face_test(depths: &ExactDepths, camera: &Camera, bounds: &Aabb) -> bool {
    let size = depths.size();
    let Some((x, y, nearest)) = span_of_corners(camera, size, bounds) else {
        return false;
    };
    let columns = clamped((x[0] - 0.5).ceil(), (x[1] - 0.5).floor(), size.width());
    let rows = clamped((y[0] - 0.5).ceil(), (y[1] - 0.5).floor(), size.height());
    let (Some(columns), Some(rows)) = (columns, rows) else {
        return true;
    };
    let (across, up) = half_extents(camera, size);
    let relative = Aabb {
        min: bounds.min - camera.eye(),
        max: bounds.max - camera.eye(),
    };
    depths.hide(columns, rows, nearest, |px, py| {
        let right = ((px as f64 + 0.5) / size.width() as f64 * 2.0 - 1.0) * across;
        let upward = (1.0 - (py as f64 + 0.5) / size.height() as f64 * 2.0) * up;
        let sideways = camera.right() * right + camera.up() * upward;
        let (origin, direction) = match camera.projection() {
            Projection::Perspective { .. } => (DVec3::ZERO, camera.forward() + sideways),
            Projection::Orthographic { .. } => (sideways, camera.forward()),
        };
        entry_distance(origin, direction, &relative)
            .map(|distance| camera.projection().depth_at(distance))
    })
}

/// Where a ray enters a box (slab by slab), in multiples of `direction`; none if it misses.
fn entry_distance(origin: DVec3, direction: DVec3, bounds: &Aabb) -> Option<f64> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (o, d, min, max) = (
            origin[axis],
            direction[axis],
            bounds.min[axis],
            bounds.max[axis],
        );
        if d == 0.0 {
            if o < min || o > max {
                return None;
            }
            continue;
        }
        let (a, b) = ((min - o) / d, (max - o) / d);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter <= leave).then_some(enter)
}
