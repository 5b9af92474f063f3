//! A camera, and the transforms from world or local coordinates to the screen.

use antumbra_simd::vertex::ScreenTransform;
use antumbra_simd::{SUBPIXELS, TILE_SIZE};
use glam::{DAffine3, DVec2, DVec3};
use thiserror::Error;

/// A camera or picture that cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ViewError {
    /// A coordinate is NaN or infinite, or so large that its square is.
    #[error("{what} is not a finite point")]
    NotFinite {
        /// Which.
        what: &'static str,
    },
    /// The target is the eye, or up points along the view.
    #[error("the camera has no orientation: {why}")]
    NoOrientation {
        /// What coincides.
        why: &'static str,
    },
    /// A projection parameter is out of range.
    #[error("{what} is {value}, but must be {must_be}")]
    OutOfRange {
        /// Which parameter.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must_be: &'static str,
    },
    /// A picture without pixels, or larger than the fixed-point coordinates reach.
    #[error(
        "a picture of {width}x{height} pixels: each side must be 1 to {}",
        PictureSize::LARGEST
    )]
    PictureSize {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
}

/// The size of the final picture in pixels; any, not only multiples of eight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureSize {
    width: u32,
    height: u32,
}

impl PictureSize {
    /// The longest side: half the guard band.
    pub const LARGEST: u32 = 1 << 14;

    /// A size of `width` × `height` pixels.
    ///
    /// # Errors
    /// If a side is 0 or above [`PictureSize::LARGEST`].
    pub fn new(width: u32, height: u32) -> Result<PictureSize, ViewError> {
        let sides = 1..=PictureSize::LARGEST;
        if sides.contains(&width) && sides.contains(&height) {
            Ok(PictureSize { width, height })
        } else {
            Err(ViewError::PictureSize { width, height })
        }
    }

    /// Pixels across.
    pub fn width(self) -> usize {
        self.width as usize
    }

    /// Pixels down.
    pub fn height(self) -> usize {
        self.height as usize
    }

    /// The size of a picture whose pixels are so many times as wide and high, the last perhaps partly outside.
    pub(super) fn divided_by(self, pixels: u32) -> PictureSize {
        PictureSize {
            width: self.width.div_ceil(pixels),
            height: self.height.div_ceil(pixels),
        }
    }

    /// Columns of tiles, the last perhaps partly outside the picture.
    pub fn tiles_across(self) -> usize {
        self.width().div_ceil(TILE_SIZE as usize)
    }

    /// Rows of tiles, the last perhaps partly outside the picture.
    pub fn tiles_down(self) -> usize {
        self.height().div_ceil(TILE_SIZE as usize)
    }

    /// Width over height.
    pub fn aspect(self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }
}

/// How space is projected. Distances are in scene units along the view direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Everything meets in the eye. Depth is `near / distance`: 1 at the near plane, 0 infinitely far.
    Perspective {
        /// Angle between the upper and lower edges of the picture, in radians, between 0 and π.
        fov_y: f64,
        /// Distance of the near plane, above 0.
        near: f64,
        /// Distance of the far plane; none: infinite.
        far: Option<f64>,
    },
    /// Everything moves along the view direction. Depth is `−distance`.
    Orthographic {
        /// Height of what the picture shows, in scene units.
        height: f64,
        /// Distance of the near plane; may be negative.
        near: f64,
        /// Distance of the far plane; none: infinite.
        far: Option<f64>,
    },
}

impl Projection {
    /// Distance of the near plane.
    pub fn near(&self) -> f64 {
        match *self {
            Projection::Perspective { near, .. } | Projection::Orthographic { near, .. } => near,
        }
    }

    /// Distance of the far plane, if there is one.
    pub fn far(&self) -> Option<f64> {
        match *self {
            Projection::Perspective { far, .. } | Projection::Orthographic { far, .. } => far,
        }
    }

    /// The depth of what lies `distance` away along the view direction.
    pub fn depth_at(&self, distance: f64) -> f64 {
        match *self {
            Projection::Perspective { near, .. } => near / distance,
            Projection::Orthographic { .. } => -distance,
        }
    }

    fn check(&self) -> Result<(), ViewError> {
        // Written so that a NaN fails.
        let require = |ok: bool, what, value, must_be| {
            if ok {
                Ok(())
            } else {
                Err(ViewError::OutOfRange {
                    what,
                    value,
                    must_be,
                })
            }
        };
        let near = self.near();
        match *self {
            Projection::Perspective { fov_y, .. } => {
                let widest = std::f64::consts::PI;
                require(
                    fov_y > 1e-6 && fov_y < widest - 1e-6,
                    "fov_y",
                    fov_y,
                    "between 0 and pi (180 degrees)",
                )?;
                require(
                    (1e-30..=1e30).contains(&near),
                    "near",
                    near,
                    "above 0 and finite",
                )?;
            }
            Projection::Orthographic { height, .. } => {
                require(
                    (1e-30..=1e30).contains(&height),
                    "height",
                    height,
                    "above 0 and finite",
                )?;
                require(near.abs() <= 1e30, "near", near, "finite")?;
            }
        }
        match self.far() {
            Some(far) => require(
                far > near && far <= 1e30,
                "far",
                far,
                "above near and finite (or left out)",
            ),
            None => Ok(()),
        }
    }
}

/// Makes sure that all coordinates are finite, and so small that their squares are.
fn in_range<const N: usize>(points: [(&'static str, DVec3); N]) -> Result<(), ViewError> {
    // False for a NaN.
    let is_in_range = |v: DVec3| v.abs().cmple(DVec3::splat(1e30)).all();
    match points.into_iter().find(|&(_, v)| !is_in_range(v)) {
        Some((what, _)) => Err(ViewError::NotFinite { what }),
        None => Ok(()),
    }
}

/// A vector's direction. It is scaled to its largest coordinate first, so that no square over- or underflows.
fn unit(v: DVec3, why: &'static str) -> Result<DVec3, ViewError> {
    let largest = v.abs().max_element();
    if largest > 0.0 {
        let v = v / largest;
        Ok(v / v.length())
    } else {
        Err(ViewError::NoOrientation { why })
    }
}

/// A camera: an eye, three orthogonal unit vectors, and a projection. Right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    projection: Projection,
    jitter: DVec2,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` pointing upwards in the picture.
    ///
    /// # Errors
    /// If a number is not finite, the points leave no direction, or the projection is out of range.
    pub fn look_at(
        eye: DVec3,
        target: DVec3,
        up: DVec3,
        projection: Projection,
    ) -> Result<Camera, ViewError> {
        in_range([("the eye", eye), ("the target", target), ("up", up)])?;
        projection.check()?;
        let forward = unit(target - eye, "the target is the eye")?;
        Camera::turned(eye, forward, up, projection)
    }

    /// A camera at `eye` that looks along `forward`, of any length but 0, with `up` pointing upwards in the picture.
    ///
    /// # Errors
    /// As [`Camera::look_at`].
    pub fn look_along(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        projection: Projection,
    ) -> Result<Camera, ViewError> {
        in_range([("the eye", eye), ("forward", forward), ("up", up)])?;
        projection.check()?;
        let forward = unit(forward, "forward is zero")?;
        Camera::turned(eye, forward, up, projection)
    }

    /// Finds the other axes of a camera that looks along a unit vector.
    fn turned(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        projection: Projection,
    ) -> Result<Camera, ViewError> {
        let sideways = forward.cross(unit(up, "up is zero")?);
        if sideways.length() < 1e-9 {
            return Err(ViewError::NoOrientation {
                why: "up points along the view",
            });
        }
        let right = unit(sideways, "up points along the view")?;
        Ok(Camera {
            eye,
            right,
            up: right.cross(forward),
            forward,
            projection,
            jitter: DVec2::ZERO,
        })
    }

    /// A camera at `eye` with these axes, which it keeps bit for bit: `right` and `up` point so in the picture, `forward` along the view.
    /// [`Camera::look_at`] makes them of less.
    ///
    /// # Errors
    /// If a number is not finite, the axes are by more than 10⁻⁶ no unit vectors at right angles with `up = right × forward`, or the
    /// projection is out of range.
    pub fn from_axes(
        eye: DVec3,
        [right, up, forward]: [DVec3; 3],
        projection: Projection,
    ) -> Result<Camera, ViewError> {
        in_range([
            ("the eye", eye),
            ("right", right),
            ("up", up),
            ("forward", forward),
        ])?;
        projection.check()?;
        let off = [
            right.length_squared() - 1.0,
            forward.length_squared() - 1.0,
            right.dot(forward),
            (right.cross(forward) - up).length(),
        ];
        if off.iter().any(|off| off.abs() > 1e-6) {
            return Err(ViewError::NoOrientation {
                why: "right, up and forward must be unit vectors at right angles, up = right x forward",
            });
        }
        Ok(Camera {
            eye,
            right,
            up,
            forward,
            projection,
            jitter: DVec2::ZERO,
        })
    }

    /// The same camera, whose samples lie so far from the pixels' centres: to the right and down, in pixels. For pictures that are
    /// added up over time, each with other samples.
    ///
    /// # Errors
    /// If it is more than a pixel.
    pub fn jittered(self, jitter: DVec2) -> Result<Camera, ViewError> {
        // False for a NaN.
        if jitter.abs().cmple(DVec2::ONE).all() {
            Ok(Camera { jitter, ..self })
        } else {
            Err(ViewError::OutOfRange {
                what: "jitter",
                value: jitter.abs().max_element(),
                must_be: "no more than a pixel",
            })
        }
    }

    /// Where the camera stands, world coordinates.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Unit vector to the right of the picture.
    pub fn right(&self) -> DVec3 {
        self.right
    }

    /// Unit vector to the top of the picture.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// Unit vector along the view.
    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// How far its samples lie from the pixels' centres: to the right and down, in pixels.
    pub fn jitter(&self) -> DVec2 {
        self.jitter
    }

    /// How the camera projects.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// The transform from coordinates *relative to the eye* (world axes) to a screen of the given size.
    pub fn screen_from_eye(&self, size: PictureSize) -> ScreenTransform {
        let half = |pixels: u32| f64::from(pixels) * f64::from(SUBPIXELS) * 0.5;
        let (half_width, half_height) = (half(size.width), half(size.height));
        let row = |v: DVec3, constant: f64| [v.x, v.y, v.z, constant];
        // Samples to the right are a picture to the left.
        let jitter = self.jitter * f64::from(SUBPIXELS);
        match self.projection {
            Projection::Perspective { fov_y, near, far } => {
                let half_tangent = libm::tan(fov_y * 0.5);
                ScreenTransform {
                    x: row(
                        (self.forward + self.right / (half_tangent * size.aspect())) * half_width
                            - self.forward * jitter.x,
                        0.0,
                    ),
                    y: row(
                        (self.forward - self.up / half_tangent) * half_height
                            - self.forward * jitter.y,
                        0.0,
                    ),
                    depth: row(DVec3::ZERO, near),
                    w: row(self.forward, 0.0),
                    near_depth: 1.0,
                    far_depth: far.map_or(f64::NEG_INFINITY, |far| near / far),
                }
            }
            Projection::Orthographic { height, near, far } => {
                let subpixels_per_unit = half_height * 2.0 / height;
                ScreenTransform {
                    x: row(self.right * subpixels_per_unit, half_width - jitter.x),
                    y: row(-self.up * subpixels_per_unit, half_height - jitter.y),
                    depth: row(-self.forward, 0.0),
                    w: row(DVec3::ZERO, 1.0),
                    near_depth: -near,
                    far_depth: far.map_or(f64::NEG_INFINITY, |far| -far),
                }
            }
        }
    }

    /// The transform from a mesh's local coordinates to a screen of the given size.
    pub fn screen_from_local(
        &self,
        size: PictureSize,
        world_from_local: &DAffine3,
    ) -> ScreenTransform {
        self.placed(&self.screen_from_eye(size), world_from_local)
    }

    /// The same by the transform from coordinates relative to the eye.
    pub(crate) fn placed(
        &self,
        screen: &ScreenTransform,
        world_from_local: &DAffine3,
    ) -> ScreenTransform {
        let columns = world_from_local.matrix3;
        let translation = world_from_local.translation - self.eye;
        let through = |r: [f64; 4]| {
            let normal = DVec3::new(r[0], r[1], r[2]);
            [
                normal.dot(columns.x_axis),
                normal.dot(columns.y_axis),
                normal.dot(columns.z_axis),
                normal.dot(translation) + r[3],
            ]
        };
        ScreenTransform {
            x: through(screen.x),
            y: through(screen.y),
            depth: through(screen.depth),
            w: through(screen.w),
            ..*screen
        }
    }
}
