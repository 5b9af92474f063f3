//! The samples that a shape may cover, and the nearest depth it may have there.
//!
//! Both are upper bounds on what the shape's own triangles can do when they are drawn:
//!
//! * Vertices of the shape and the corners of its bounds go through different matrices, all in f64. Each result is
//!   off by less than 2⁻⁴⁵ of the coordinates that went in (a chain of at most 40 operations of relative error
//!   2⁻⁵³). The bounds are therefore taken anywhere within `2⁻⁴⁰ · (|shape| + |eye|)` of where they stand: 32 times
//!   that error.
//! * Vertices snap to the sub-pixel grid: half a sub-pixel (1/512 pixel), and 2⁻¹⁰ sub-pixels for the rounding of the
//!   snap itself and of the division.
//! * What a final pass that is not ours may do otherwise ([`Slack`]): its pixels are added to the snap; positions are off by its share of
//!   the distance to the farthest corner of the bounds, twice, since an occluder is drawn as much farther away; its depth, twice
//!   as well, is added to the nearest.
//! * A triangle's depth at a sample is clamped to its vertices' (see [`antumbra_simd::triangle::DepthPlane`]), so no
//!   sample is nearer than the nearest corner. The depth is rounded towards the eye when it becomes f32.

use std::borrow::Borrow;

use antumbra_simd::bounds::Extent;
use antumbra_simd::boxes::{BOXES, BoxBlock, BoxView, RectBlock, project_boxes};
use antumbra_simd::glance::{Rays, Slabs};
use antumbra_simd::projected::{CornerBox, OnScreen};
use antumbra_simd::vertex::ScreenTransform;
use antumbra_simd::{Level, SUBPIXELS};
use glam::DVec3;

use super::ProjectedBox;
use super::occluder_transform::asked_by;
use crate::scene::{Aabb, OrientedBox};
use crate::view::{Camera, MapScale, PictureSize, Projection, Slack};

/// How far a projected coordinate may lie from where it is drawn, in sub-pixels, besides errors that scale with the
/// scene and what a sample of a coarse map reaches.
const SNAP_ERROR: f64 = 0.5 + 1.0 / 1024.0;

/// The share of its coordinates by which a position may be off.
pub(super) const POSITION_ERROR: f64 = 1.0 / (1_u64 << 40) as f64;

/// Times this, what is larger than 2⁵²⁴ is infinite; no view's row has an element of 2²⁰⁰.
const OVERFLOW: f64 = f64::from_bits((1023 + 500) << 52);

/// A rectangle of samples (pixel centres) within the picture, ends included, and the nearest depth in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRect {
    /// First and last column.
    pub x: [i32; 2],
    /// First and last row.
    pub y: [i32; 2],
    /// No sample is nearer than this; the larger the nearer.
    pub nearest_depth: f32,
}

/// Where a shape may be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Footprint {
    /// Anywhere: it reaches the near plane, or its numbers are not finite.
    Unbounded,
    /// On no sample of the picture.
    Nowhere,
    /// Within a rectangle.
    Within(SampleRect),
}

/// A camera, a picture size and a map's scale, made ready to project shapes. Samples are the map's.
#[derive(Clone, Debug)]
pub struct Screen {
    pub(super) camera: Camera,
    pub(super) scale: MapScale,
    pub(super) slack: Slack,
    /// The map's.
    pub(super) size: PictureSize,
    /// The largest of the eye's coordinates.
    eye_reach: f64,
    /// What occluders are drawn by.
    pub(super) from_eye: ScreenTransform,
    /// What a depth may be off on behalf of the slack.
    pub(super) depth_slack: f64,
    rays: Rays,
    norms: Norms,
    view: BoxView,
}

/// How fast the four row products change with the position: the lengths of the rows.
#[derive(Clone, Debug)]
struct Norms {
    x: f64,
    y: f64,
    depth: f64,
    w: f64,
}

impl Screen {
    /// Makes a camera ready for a picture size.
    pub fn new(camera: Camera, picture: PictureSize) -> Screen {
        Screen::with_map_scale(camera, picture, MapScale::Full)
    }

    /// Makes a camera ready for a picture size and a map of this scale: samples are the map's, each of which stands for a block
    /// of pixels.
    pub fn with_map_scale(camera: Camera, picture: PictureSize, scale: MapScale) -> Screen {
        Screen::with_slack(camera, picture, scale, Slack::NONE)
    }

    /// The same for a final pass that may lie this far from ours.
    pub fn with_slack(
        camera: Camera,
        picture: PictureSize,
        scale: MapScale,
        slack: Slack,
    ) -> Screen {
        let from_eye = scale.map_from(&camera.screen_from_eye(picture));
        let size = scale.map_size(picture);
        let depth_slack = slack.depth_through(camera.projection());
        let asked_from_eye = asked_by(&from_eye, depth_slack);
        let norm = |r: [f64; 4]| vector(r).length();
        let norms = Norms {
            x: norm(from_eye.x),
            y: norm(from_eye.y),
            depth: norm(asked_from_eye.depth),
            w: norm(from_eye.w),
        };
        Screen {
            camera,
            scale,
            slack,
            size,
            eye_reach: largest(camera.eye().abs()),
            rays: Rays::new(&asked_from_eye),
            view: BoxView {
                screen: asked_from_eye,
                norms: [norms.x, norms.y, norms.depth, norms.w],
                snap_error: SNAP_ERROR + f64::from(scale.reach()) + slack.subpixels(scale),
                relative_error: POSITION_ERROR,
                slope_error: slack.slope_error(),
                size: [size.width() as f64, size.height() as f64],
            },
            from_eye,
            depth_slack,
            norms,
        }
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The map's scale.
    pub fn scale(&self) -> MapScale {
        self.scale
    }

    /// What the final pass may do otherwise than ours.
    pub fn slack(&self) -> Slack {
        self.slack
    }

    /// The map's size.
    pub fn size(&self) -> PictureSize {
        self.size
    }

    /// Where an axis-aligned world box may be drawn.
    pub fn footprint_of_aabb(&self, bounds: &Aabb) -> Footprint {
        self.project_aabb(bounds).footprint()
    }

    /// An axis-aligned world box on screen, for questions that ask more than its footprint.
    pub fn project_aabb(&self, bounds: &Aabb) -> ProjectedBox {
        self.project_box(&self.corners_of_aabb(bounds), self.slabs_of_aabb(bounds))
    }

    /// Where axis-aligned world boxes may be drawn, several at once; appended to `footprints` in their order.
    pub fn footprints_of_aabbs(
        &self,
        level: Level,
        boxes: impl Iterator<Item: Borrow<Aabb>>,
        footprints: &mut Vec<Footprint>,
    ) {
        let eye = self.camera.eye();
        let boxes = boxes.map(|bounds| {
            let bounds: &Aabb = bounds.borrow();
            let relative = Aabb {
                min: bounds.min - eye,
                max: bounds.max - eye,
            };
            // What is empty or not finite is so relative to the eye as well.
            (relative, self.bounds_error(bounds))
        });
        self.footprints_of_boxes(level, &self.from_eye, boxes, footprints);
    }

    /// Where boxes may be drawn that are axis-aligned in the local coordinates of something within `bounds`, several at
    /// once; `from_local` is its transform to the screen.
    pub(crate) fn footprints_of_local_boxes(
        &self,
        level: Level,
        from_local: &ScreenTransform,
        bounds: &Aabb,
        boxes: impl Iterator<Item = Aabb>,
        footprints: &mut Vec<Footprint>,
    ) {
        let error = self.bounds_error(bounds);
        let boxes = boxes.map(|b| (b, error));
        self.footprints_of_boxes(level, from_local, boxes, footprints);
    }

    /// Boxes in the coordinates that `screen` takes, each with how far it may be off in scene units.
    fn footprints_of_boxes(
        &self,
        level: Level,
        screen: &ScreenTransform,
        boxes: impl Iterator<Item = (Aabb, f64)>,
        footprints: &mut Vec<Footprint>,
    ) {
        let view = BoxView {
            screen: asked_by(screen, self.depth_slack),
            ..self.view
        };
        let mut boxes = boxes.peekable();
        let mut block = BoxBlock::EMPTY;
        let mut rects = RectBlock::EMPTY;
        while boxes.peek().is_some() {
            let mut count = 0;
            for (i, (b, error)) in boxes.by_ref().take(BOXES).enumerate() {
                for axis in 0..3 {
                    block.min[axis][i] = b.min[axis];
                    block.max[axis][i] = b.max[axis];
                }
                block.error[i] = error;
                count = i + 1;
            }
            project_boxes(level, &view, &block, &mut rects);
            footprints.extend((0..count).map(|i| {
                let nearest_depth = round_up(rects.nearest[i]);
                if rects.bounded >> i & 1 == 0 || !nearest_depth.is_finite() {
                    return Footprint::Unbounded;
                }
                let RectBlock { x, y, .. } = &rects;
                let (x, y) = ([x[0][i], x[1][i]], [y[0][i], y[1][i]]);
                if x[0] > x[1] || y[0] > y[1] {
                    return Footprint::Nowhere;
                }
                Footprint::Within(SampleRect {
                    x: x.map(whole),
                    y: y.map(whole),
                    nearest_depth,
                })
            }));
        }
    }

    /// A depth that nothing is drawn farther than which is within a box, axis-aligned in the local coordinates of something
    /// within `bounds`; `from_local` is its transform to the screen. Minus infinity where that is not known.
    ///
    /// A quotient of sums is no less than the least quotient of its summands, so depth is least at a corner, or where the near
    /// plane cuts: nothing is drawn before that.
    pub(crate) fn farthest_depth_of_local_box(
        &self,
        from_local: &ScreenTransform,
        bounds: &Aabb,
        local: &Aabb,
    ) -> f32 {
        let error = self.bounds_error(bounds);
        let [depth_error, w_error] = [self.norms.depth, self.norms.w].map(|norm| norm * error);
        let t = from_local;
        let at_least = |depth: f64, w: f64| {
            let depth = depth - depth_error;
            let w = if depth < 0.0 {
                w - w_error
            } else {
                w + w_error
            };
            if w > 0.0 {
                depth / w
            } else {
                f64::NEG_INFINITY
            }
        };
        let near_w = match self.camera.projection() {
            Projection::Perspective { near, .. } => *near,
            Projection::Orthographic { .. } => 1.0,
        };
        let mut farthest = at_least(t.near_depth * near_w, near_w);
        for i in 0..8 {
            let side = |axis: usize| {
                if i >> axis & 1 == 0 {
                    local.min
                } else {
                    local.max
                }
            };
            let corner = DVec3::new(side(0).x, side(1).y, side(2).z);
            let at = |r: [f64; 4]| vector(r).dot(corner) + r[3];
            let (depth, w) = (at(t.depth), at(t.w));
            let is_too_near = depth - depth_error > t.near_depth * (w + w_error);
            let at_least = at_least(depth, w);
            // Of what is not a number nothing is known.
            if at_least.is_nan() || w <= w_error && !is_too_near {
                return f32::NEG_INFINITY;
            }
            if w > w_error && at_least < farthest {
                farthest = at_least;
            }
        }
        -round_up(farthest.abs() * POSITION_ERROR - farthest)
    }

    /// Where a box with any orientation may be drawn: its centre, and three vectors from there to the middles of
    /// faces.
    pub fn footprint_of_oriented_box(&self, center: DVec3, half_axes: [DVec3; 3]) -> Footprint {
        let oriented = OrientedBox { center, half_axes };
        self.project_oriented_box(&oriented, 0.0).footprint()
    }

    /// A box with any orientation on screen, for questions that ask more than its footprint. Its points may be off by
    /// `error` along each world axis, besides what the projection does.
    pub fn project_oriented_box(&self, bounds: &OrientedBox, error: f64) -> ProjectedBox {
        let corners = self.corners_of_oriented_box(bounds, error);
        self.project_box(&corners, self.slabs_of_oriented_box(bounds))
    }

    /// Where a ball may be drawn.
    ///
    /// `X = λ·W` is a plane through the eye (or, orthographic, along the view); it touches the ball where the centre
    /// is `radius` away from it: a quadratic in λ, whose roots are the extremes on screen.
    pub fn footprint_of_sphere(&self, center: DVec3, radius: f64) -> Footprint {
        if radius.is_nan() || radius < 0.0 {
            return Footprint::Unbounded;
        }
        let relative = center - self.camera.eye();
        let slack = 2.0 * self.slack.position() * (relative.length() + radius);
        let radius = radius + self.position_error(largest(center.abs()) + radius) + slack;
        let t = &self.view.screen;
        let at = |r: [f64; 4]| vector(r).dot(relative) + r[3];
        let (w, ww) = (at(t.w), vector(t.w).length_squared());
        let nearest_w = w - radius * self.norms.w;
        let depth = at(t.depth) + radius * self.norms.depth;
        // A ball that all but reaches the eye's plane: `a` below would be all rounding.
        let clear_of_the_eye = nearest_w > w * 2e-6;
        if !(clear_of_the_eye && depth < t.near_depth * nearest_w) {
            return Footprint::Unbounded;
        }
        let extremes = |row: [f64; 4]| {
            let (x, n) = (at(row), vector(row));
            let r2 = radius * radius;
            let a = w * w - r2 * ww;
            let b = x * w - r2 * n.dot(vector(t.w));
            let discriminant = b * b - a * (x * x - r2 * n.length_squared());
            // The difference cancels for a small ball far away; the error of its terms is added, so that the root
            // stays an upper bound.
            let error = (b * b + a * (x * x + r2 * n.length_squared())) * POSITION_ERROR;
            let root = (discriminant.max(0.0) + error).sqrt();
            [(b - root) / a, (b + root) / a]
        };
        self.footprint_of_extent(
            Extent {
                x: extremes(t.x),
                y: extremes(t.y),
                depth,
                w: nearest_w,
            },
            0.0,
        )
    }

    /// Where something may be drawn of which only a rectangle on screen is known: columns `x` and rows `y` in pixels,
    /// fractions allowed, and the distance of its nearest point along the view direction. What its position may be off has to be in
    /// them already, if there is a slack.
    pub fn footprint_of_rectangle(
        &self,
        x: [f64; 2],
        y: [f64; 2],
        nearest_distance: f64,
    ) -> Footprint {
        let per_pixel = f64::from(SUBPIXELS) / f64::from(self.scale.pixels());
        let subpixels = |v: [f64; 2]| v.map(|v| v * per_pixel);
        let projection = self.camera.projection();
        let in_front = nearest_distance > projection.near();
        let ordered = x[0] <= x[1] && y[0] <= y[1];
        if !(in_front && ordered) {
            return Footprint::Unbounded;
        }
        let depth = projection.depth_at(nearest_distance) + 2.0 * self.depth_slack;
        self.footprint_of_extent(
            Extent {
                x: subpixels(x),
                y: subpixels(y),
                depth,
                w: 1.0,
            },
            0.0,
        )
    }

    /// The rays of the samples, relative to the eye.
    pub(crate) fn rays(&self) -> &Rays {
        &self.rays
    }

    /// What boxes relative to the eye are projected by.
    pub(super) fn view(&self) -> &BoxView {
        &self.view
    }

    /// The faces of a world box, relative to the eye.
    pub(super) fn slabs_of_aabb(&self, bounds: &Aabb) -> Slabs {
        let eye = self.camera.eye();
        Slabs {
            normals: None,
            low: (bounds.min - eye).to_array(),
            high: (bounds.max - eye).to_array(),
        }
    }

    /// The corners of a world box, relative to the eye.
    pub(super) fn corners_of_aabb(&self, bounds: &Aabb) -> CornerBox {
        let eye = self.camera.eye();
        let (min, max) = (bounds.min - eye, bounds.max - eye);
        let side = |i: usize, axis: usize| if i >> axis & 1 == 0 { min } else { max };
        CornerBox {
            corners: std::array::from_fn(|a| std::array::from_fn(|i| side(i, a)[a])),
            // Of an empty box nothing is known.
            error: if bounds.is_valid() {
                self.bounds_error(bounds)
            } else {
                f64::NAN
            },
            mirrored: false,
        }
    }

    /// The faces of a box with any orientation, relative to the eye.
    pub(super) fn slabs_of_oriented_box(&self, bounds: &OrientedBox) -> Slabs {
        let [u, v, w] = bounds.half_axes;
        let center = bounds.center - self.camera.eye();
        let normals = [v.cross(w), w.cross(u), u.cross(v)];
        let half = u.dot(normals[0]).abs();
        let middle = normals.map(|n| n.dot(center));
        Slabs {
            normals: Some(normals.map(|n| n.to_array())),
            low: middle.map(|m| m - half),
            high: middle.map(|m| m + half),
        }
    }

    /// The corners of a box with any orientation, relative to the eye; its points may be off by `error` along each world
    /// axis.
    pub(super) fn corners_of_oriented_box(&self, bounds: &OrientedBox, error: f64) -> CornerBox {
        let [u, v, w] = bounds.half_axes;
        let center = bounds.center - self.camera.eye();
        let sign = |i: usize, bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corner = |i| center + u * sign(i, 0) + v * sign(i, 1) + w * sign(i, 2);
        let corners: [DVec3; 8] = std::array::from_fn(corner);
        let half = u.abs() + v.abs() + w.abs();
        let reach = largest(bounds.center.abs() + half);
        let around = (center.abs() + half).length();
        CornerBox {
            corners: std::array::from_fn(|axis| corners.map(|c| c[axis])),
            // Three axes may all be off at once: the length of the diagonal is less than twice as much.
            error: 2.0 * (error + self.position_error(reach) + self.slack.position() * around),
            mirrored: u.dot(v.cross(w)) < 0.0,
        }
    }

    /// How far a position may be off that is no farther from the origin than `reach`: infinitely, where sums of its products
    /// with a view's rows might overflow.
    fn position_error(&self, reach: f64) -> f64 {
        ((reach + self.eye_reach) * OVERFLOW) * (POSITION_ERROR / OVERFLOW)
    }

    /// How far a vertex of something within these bounds may lie outside of them. (Three axes may all be off at once: the length of the
    /// diagonal is less than twice as much. Where an occluder's transform is asked with, it has stood back by the slack.)
    fn bounds_error(&self, bounds: &Aabb) -> f64 {
        2.0 * (self.position_error(reach(bounds)) + self.position_slack(bounds))
    }

    fn project_box(&self, corners: &CornerBox, slabs: Slabs) -> ProjectedBox {
        let (footprint, on_screen) = match OnScreen::new(&self.view, corners) {
            Some((on_screen, extent)) => (
                self.footprint_of_extent(extent, corners.error),
                Some(on_screen),
            ),
            None => (Footprint::Unbounded, None),
        };
        ProjectedBox::new(footprint, on_screen, slabs)
    }

    /// How far a vertex may be drawn from where its position, off by `position_error`, projects to, in sub-pixels: along
    /// one axis of the screen, whose row has length `norm`, where no coordinate is larger than `largest` and no W less
    /// than `w`.
    fn screen_error(&self, largest: f64, norm: f64, position_error: f64, w: f64) -> f64 {
        // A move by e changes X by |e|·norm and W by |e|·|w|, hence X / W by no more than this.
        let moved = position_error * (norm + largest * self.norms.w) / w;
        self.view.snap_error + moved + largest * POSITION_ERROR
    }

    /// Grows an extent by all that may be off, `position_error` in scene units, and finds its samples.
    fn footprint_of_extent(&self, extent: Extent, position_error: f64) -> Footprint {
        let w = extent.w - position_error * self.norms.w;
        let depth = extent.depth + position_error * self.norms.depth;
        if !(w > 0.0 && depth < self.from_eye.near_depth * w) {
            return Footprint::Unbounded;
        }
        let samples = |range: [f64; 2], norm: f64, pixels: usize| {
            let largest = range[0].abs().max(range[1].abs());
            let error = self.screen_error(largest, norm, position_error, w);
            let (per_pixel, half) = (f64::from(SUBPIXELS), f64::from(SUBPIXELS / 2));
            let first = ((range[0] - error - half) / per_pixel).ceil();
            let last = ((range[1] + error - half) / per_pixel).floor();
            [first.max(0.0) as i32, last.min(pixels as f64 - 1.0) as i32]
        };
        let x = samples(extent.x, self.norms.x, self.size.width());
        let y = samples(extent.y, self.norms.y, self.size.height());
        if x[0] > x[1] || y[0] > y[1] {
            return Footprint::Nowhere;
        }
        let nearest = depth / w;
        let nearest_depth = round_up(nearest + nearest.abs() * POSITION_ERROR);
        if nearest_depth.is_nan() {
            return Footprint::Unbounded;
        }
        Footprint::Within(SampleRect {
            x,
            y,
            nearest_depth,
        })
    }
}

/// The largest coordinate. What is not a number is left out: the questions find it themselves.
fn largest(v: DVec3) -> f64 {
    let greater = |a: f64, b: f64| if b > a { b } else { a };
    greater(greater(v.x, v.y), v.z)
}

/// The largest magnitude of a coordinate of a box.
fn reach(bounds: &Aabb) -> f64 {
    let (min, max) = (largest(bounds.min.abs()), largest(bounds.max.abs()));
    if max > min { max } else { min }
}

/// A whole number from 0 to 2³¹, which a cast would first have to find within bounds: in the lowest bits of its sum with
/// 2⁵².
fn whole(value: f64) -> i32 {
    (value + (1_u64 << 52) as f64).to_bits() as i32
}

fn vector(row: [f64; 4]) -> DVec3 {
    DVec3::new(row[0], row[1], row[2])
}

/// The least f32 that is not below `value`.
fn round_up(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) < value {
        nearest.next_up()
    } else {
        nearest
    }
}
