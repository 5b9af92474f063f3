//! Where to stand to see a camera see: behind and above it, at enough distance to take in its frustum.
//!
//! The view is orthographic, so that what is to be seen fits exactly and near and far boxes have one scale. Two cuts
//! open the scene: what stands behind the camera is left out, and so is what is above it, from a little below the
//! ceiling on, if it has one.

use glam::DVec3;

use crate::final_pass::surfaces::{Surface, draw_nearest};
use crate::scene::{Aabb, Scene};
use crate::view::{Camera, PictureSize, Projection};

/// The camera's axis is seen this much from the side: sine and cosine of the angle between the headings.
const ASIDE: [f64; 2] = [0.42, 0.907];
/// How steeply the view falls: sine and cosine.
const FALL: [f64; 2] = [0.70, 0.714];
/// Part of the picture's width and height that is left free all around.
const MARGIN: f64 = 0.06;
/// The scene is shown up to the distance that this share of the objects in the frustum keeps.
const SHOWN_SHARE: f64 = 0.9;
/// The picture of what is above the eye.
const CEILING_SAMPLES: u32 = 17;
/// The eye's share, and the ceiling's, of the height at which the scene is cut open.
const CUT_SHARE: [f64; 2] = [0.25, 0.75];

/// A third person, who sees the camera and its frustum.
#[derive(Clone, Debug)]
pub struct Bystander {
    camera: Camera,
    height: f64,
    size: PictureSize,
    /// How far the frustum is shown, along the camera's view.
    pub reach: f64,
    cuts: Vec<Cut>,
}

/// Points with `normal · (point − origin) > 0` are left out. The normal points against the bystander's view.
#[derive(Clone, Copy, Debug)]
struct Cut {
    normal: DVec3,
    origin: DVec3,
}

impl Bystander {
    /// Finds a place to see `observed` and what it saw; none if numbers overflow.
    pub fn new(
        scene: &Scene,
        observed: &Camera,
        in_frustum: &[u32],
        size: PictureSize,
    ) -> Option<Bystander> {
        let reach = reach(scene, observed, in_frustum);
        let heading = heading(observed);
        let aside = DVec3::Y.cross(heading);
        let level = heading * ASIDE[1] + aside * ASIDE[0];
        let view = level * FALL[1] - DVec3::Y * FALL[0];

        let eye = observed.eye();
        let mut cuts = vec![Cut {
            normal: -heading,
            origin: eye - heading * (0.04 * reach),
        }];
        if let Some(ceiling) = ceiling(scene, observed, reach) {
            let height = CUT_SHARE[0] * eye.y + CUT_SHARE[1] * ceiling;
            cuts.push(Cut {
                normal: DVec3::Y,
                origin: DVec3::new(eye.x, height, eye.z),
            });
        }

        // What has to fit: the eye, and what it might have seen.
        let all = scene
            .bounds()
            .iter()
            .fold(Aabb::EMPTY, |all, &b| all.union(b));
        let mut points = vec![eye];
        // An orthographic camera is as wide as what it shows.
        points.extend(frustum_corners(observed, 0.0, size.aspect()));
        for &object in in_frustum {
            let bounds = scene.bounds()[object as usize];
            let center = bounds.center();
            if (center - eye).dot(observed.forward()) <= reach
                && bounds.size().max_element() <= reach
            {
                points.push(center);
            }
        }
        for corner in frustum_corners(observed, reach * 0.75, size.aspect()) {
            points.push(corner.clamp(all.min.min(eye), all.max.max(eye)));
        }

        let right = level.cross(DVec3::Y);
        let up = right.cross(view);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in points {
            let p = p - eye;
            let p = DVec3::new(p.dot(right), p.dot(up), p.dot(view));
            (low, high) = (low.min(p), high.max(p));
        }
        let extent = high - low;
        let height = extent.y.max(extent.x / size.aspect()) / (1.0 - 2.0 * MARGIN);
        let middle = (low + high) * 0.5;
        let stand = eye + right * middle.x + up * middle.y;
        // Nothing is clipped: the planes lie beyond the whole scene.
        let depth = (all.center() - stand).length() + all.size().length() + reach;
        let projection = Projection::Orthographic {
            height,
            near: -depth,
            far: Some(depth),
        };
        let camera = Camera::look_at(stand, stand + view, DVec3::Y, projection).ok()?;
        Some(Bystander {
            camera,
            height,
            size,
            reach,
            cuts,
        })
    }

    /// How the bystander sees.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Where a world point appears, in pixels.
    pub fn project(&self, point: DVec3) -> [f32; 2] {
        let p = point - self.camera.eye();
        let pixels_per_unit = self.size.height() as f64 / self.height;
        [
            (p.dot(self.camera.right()) * pixels_per_unit + self.size.width() as f64 * 0.5) as f32,
            (self.size.height() as f64 * 0.5 - p.dot(self.camera.up()) * pixels_per_unit) as f32,
        ]
    }

    /// Whether all of a box is cut away.
    pub fn is_cut(&self, bounds: &Aabb) -> bool {
        self.cuts.iter().any(|cut| {
            bounds
                .corners()
                .iter()
                .all(|&c| cut.normal.dot(c - cut.origin) > 0.0)
        })
    }

    /// The surfaces that the bystander sees of all objects, in a picture `scale` times the size.
    pub fn surfaces(&self, scene: &Scene, scale: u32) -> Option<(PictureSize, Vec<Surface>)> {
        let (width, height) = (self.size.width(), self.size.height());
        let size = PictureSize::new(width as u32 * scale, height as u32 * scale).ok()?;
        let unit = self.height / size.height() as f64;
        let (right, up, view) = (self.camera.right(), self.camera.up(), self.camera.forward());
        let cut_before = |i: usize| {
            let (x, y) = (i % size.width(), i / size.width());
            let across = (x as f64 + 0.5 - size.width() as f64 * 0.5) * unit;
            let down = (y as f64 + 0.5 - size.height() as f64 * 0.5) * unit;
            let start = self.camera.eye() + right * across - up * down;
            // Where the sight line leaves what is cut away, as a depth.
            let leaves = |c: &Cut| -(c.normal.dot(c.origin - start) / c.normal.dot(view)) as f32;
            self.cuts.iter().map(leaves).fold(f32::INFINITY, f32::min)
        };
        let mut pixels: Vec<(Surface, f32)> = (0..size.width() * size.height())
            .map(|i| (Surface::BACKGROUND, cut_before(i)))
            .collect();
        let objects: Vec<u32> = (0..scene.objects().len() as u32).collect();
        draw_nearest(
            scene,
            &self.camera,
            size,
            &objects,
            &mut pixels,
            |(surface, cut_before), depth| (depth <= *cut_before).then_some(surface),
        );
        Some((size, pixels.into_iter().map(|p| p.0).collect()))
    }
}

/// The corners of a camera's frustum at a distance: upper left, upper right, lower right, lower left.
pub fn frustum_corners(camera: &Camera, distance: f64, aspect: f64) -> [DVec3; 4] {
    let half_height = match *camera.projection() {
        Projection::Perspective { fov_y, .. } => libm::tan(fov_y * 0.5) * distance,
        Projection::Orthographic { height, .. } => height * 0.5,
    };
    let up = camera.up() * half_height;
    let right = camera.right() * (half_height * aspect);
    let middle = camera.eye() + camera.forward() * distance;
    [
        middle + up - right,
        middle + up + right,
        middle - up + right,
        middle - up - right,
    ]
}

/// How far to show the frustum: to most of the objects in it.
fn reach(scene: &Scene, camera: &Camera, in_frustum: &[u32]) -> f64 {
    let mut distances: Vec<f64> = in_frustum
        .iter()
        .map(|&o| (scene.bounds()[o as usize].center() - camera.eye()).dot(camera.forward()))
        .filter(|d| *d > 0.0)
        .collect();
    distances.sort_unstable_by(f64::total_cmp);
    let least = match *camera.projection() {
        Projection::Perspective { near, .. } => near * 8.0,
        Projection::Orthographic { height, .. } => height * 0.5,
    };
    let most = (distances.len() as f64 * SHOWN_SHARE) as usize;
    let reach = distances.get(most).or(distances.last());
    reach.copied().unwrap_or(0.0).max(least)
}

/// The camera's heading in the level plane.
fn heading(camera: &Camera) -> DVec3 {
    let level = |v: DVec3| DVec3::new(v.x, 0.0, v.z);
    // Looking straight up or down, what is up in the picture is ahead.
    let (forward, up) = (level(camera.forward()), level(camera.up()));
    let ahead = if forward.length() > 0.1 { forward } else { up };
    ahead / ahead.length().max(1e-9)
}

/// The height of what is over the eye, if most of the sky is covered.
fn ceiling(scene: &Scene, observed: &Camera, reach: f64) -> Option<f64> {
    let eye = observed.eye();
    let projection = Projection::Orthographic {
        height: reach * 0.25,
        near: 0.0,
        far: None,
    };
    let ahead = eye + heading(observed) * (reach * 0.05);
    let upwards = Camera::look_at(ahead, ahead + DVec3::Y, heading(observed), projection).ok()?;
    let size = PictureSize::new(CEILING_SAMPLES, CEILING_SAMPLES).ok()?;
    let mut pixels = vec![Surface::BACKGROUND; size.width() * size.height()];
    let objects: Vec<u32> = (0..scene.objects().len() as u32).collect();
    draw_nearest(scene, &upwards, size, &objects, &mut pixels, |s, _| Some(s));
    let mut heights: Vec<f64> = pixels
        .iter()
        .filter(|p| !p.is_background())
        .map(|p| eye.y - f64::from(p.depth))
        .collect();
    heights.sort_unstable_by(f64::total_cmp);
    (heights.len() * 2 > pixels.len()).then(|| heights[heights.len() / 2])
}
