//! Cameras: plain structs, which are checked wherever they are used.

use std::mem::MaybeUninit;

use antumbra::glam::DVec3;
use antumbra::view::{Camera, Projection, ViewError};

use crate::arguments::{affine, chosen, required, vector};
use crate::status::{AntumbraStatus, Error, guard};

/// How space is projected.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraProjectionKind {
    /// Everything meets in the eye. Depth is near / distance: 1 at the near plane, 0 infinitely far.
    ANTUMBRA_PERSPECTIVE = 0,
    /// Everything moves along the view. Depth is -distance.
    ANTUMBRA_ORTHOGRAPHIC = 1,
}

use AntumbraProjectionKind::*;

#[derive(Clone, Copy)]
enum Kind {
    Perspective,
    Orthographic,
}

const KINDS: [(u32, Kind); 2] = [
    (ANTUMBRA_PERSPECTIVE as u32, Kind::Perspective),
    (ANTUMBRA_ORTHOGRAPHIC as u32, Kind::Orthographic),
];

/// A projection, symmetric about the view: a picture that is moved by parts of a pixel has to be culled without. The picture's size gives
/// the proportions. Distances are in scene units along the view.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraProjection {
    /// An AntumbraProjectionKind.
    pub kind: u32,
    /// Perspective: the angle between the upper and lower edges of the picture, in radians, between 0 and pi. Orthographic: the height of
    /// what the picture shows, in scene units.
    pub fov_y_or_height: f64,
    /// Distance of the near plane: above 0 where the projection is perspective.
    pub near_plane: f64,
    /// Distance of the far plane, beyond the near one; INFINITY if there is none.
    pub far_plane: f64,
}

/// A camera. antumbra_camera_look_at and antumbra_camera_from_view make one. Its axes are unit vectors at right angles, by 1e-6 at the most;
/// what uses a camera checks it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraCamera {
    /// Where it stands, world coordinates.
    pub eye: [f64; 3],
    /// To the right of the picture: forward x up.
    pub right: [f64; 3],
    /// To the top of the picture: right x forward.
    pub up: [f64; 3],
    /// Along the view.
    pub forward: [f64; 3],
    /// How it projects.
    pub projection: AntumbraProjection,
}

impl From<ViewError> for Error {
    fn from(error: ViewError) -> Error {
        Error::invalid(error)
    }
}

impl AntumbraProjection {
    fn checked(&self) -> Result<Projection, Error> {
        let near = self.near_plane;
        // Of a NaN, the camera says what is wrong.
        let far = (self.far_plane != f64::INFINITY).then_some(self.far_plane);
        Ok(match chosen(self.kind, &KINDS, "the projection's kind")? {
            Kind::Perspective => Projection::Perspective {
                fov_y: self.fov_y_or_height,
                near,
                far,
            },
            Kind::Orthographic => Projection::Orthographic {
                height: self.fov_y_or_height,
                near,
                far,
            },
        })
    }

    fn of(projection: &Projection) -> AntumbraProjection {
        let (kind, fov_y_or_height) = match *projection {
            Projection::Perspective { fov_y, .. } => (ANTUMBRA_PERSPECTIVE, fov_y),
            Projection::Orthographic { height, .. } => (ANTUMBRA_ORTHOGRAPHIC, height),
        };
        AntumbraProjection {
            kind: kind as u32,
            fov_y_or_height,
            near_plane: projection.near(),
            far_plane: projection.far().unwrap_or(f64::INFINITY),
        }
    }
}

impl AntumbraCamera {
    /// The camera, bit for bit.
    pub fn checked(&self) -> Result<Camera, Error> {
        let axes = [self.right, self.up, self.forward].map(DVec3::from_array);
        let projection = self.projection.checked()?;
        Ok(Camera::from_axes(self.eye.into(), axes, projection)?)
    }

    pub fn of(camera: &Camera) -> AntumbraCamera {
        AntumbraCamera {
            eye: camera.eye().to_array(),
            right: camera.right().to_array(),
            up: camera.up().to_array(),
            forward: camera.forward().to_array(),
            projection: AntumbraProjection::of(camera.projection()),
        }
    }
}

/// Makes a camera at a point that looks at another one. Coordinates are right-handed.
///
/// @param eye, target, up Three numbers each, world coordinates. up, of any length, points upwards in the picture.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if a number is not finite, eye and target are the same, up points along the view, or
/// the projection is out of range.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_camera_look_at(
    eye: *const f64,
    target: *const f64,
    up: *const f64,
    projection: Option<&AntumbraProjection>,
    camera: Option<&mut MaybeUninit<AntumbraCamera>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(camera, "camera")?;
        let (eye, target) = (vector(eye, "eye")?, vector(target, "target")?);
        let projection = required(projection, "projection")?.checked()?;
        let camera = Camera::look_at(eye, target, vector(up, "up")?, projection)?;
        place.write(AntumbraCamera::of(&camera));
        Ok(())
    })
}

/// Makes a camera of the matrix that leads from world coordinates to those of the view: x to the right, y upwards, z backwards.
///
/// @param view_from_world 16 numbers, column by column; a rotation and a translation. What it lacks of right angles and unit
///     lengths, as a matrix that was computed in single precision does, is mended.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if a number is not finite, the last row is not 0 0 0 1, the upper left part is by more
/// than 1e-3 no rotation, or the projection is out of range.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_camera_from_view(
    view_from_world: *const f64,
    projection: Option<&AntumbraProjection>,
    camera: Option<&mut MaybeUninit<AntumbraCamera>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(camera, "camera")?;
        let view = affine(view_from_world, "view_from_world")?;
        let projection = required(projection, "projection")?.checked()?;
        let axes = view.matrix3.transpose();
        let eye = -(axes * view.translation);
        let camera = Camera::look_along(eye, -axes.z_axis, axes.y_axis, projection)?;
        let off = [
            camera.right() - axes.x_axis,
            camera.up() - axes.y_axis,
            camera.forward() + axes.z_axis,
        ];
        if off.iter().any(|off| off.length() > 1e-3) {
            return Err(Error::invalid(
                "view_from_world is no rotation and translation: it scales, shears or mirrors",
            ));
        }
        place.write(AntumbraCamera::of(&camera));
        Ok(())
    })
}
