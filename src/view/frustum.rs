//! The space that a camera sees, and which boxes meet it.

use glam::DVec3;

use super::{Camera, PictureSize, Projection};
use crate::scene::Aabb;

/// What rounding may amount to, as a part of the coordinates: ten operations of 2⁻⁵³ each, and a wide margin.
const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// Which of the frustum's six planes a box still has to be tested against; a node's children need not repeat what the
/// node has passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Planes(u8);

impl Planes {
    /// All six.
    pub const ALL: Planes = Planes(0b11_1111);

    /// Whether no plane is left: what is inside here is inside the frustum.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// Where a box lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Containment {
    /// Wholly outside one of the planes.
    Outside,
    /// Not wholly outside any; the planes that it may still cross.
    Meets(Planes),
}

/// Six planes: left, right, bottom, top, near, far. A missing far plane is never crossed.
///
/// The normals point inwards and take coordinates relative to the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    eye: DVec3,
    planes: [(DVec3, f64); 6],
    /// The area of the picture: of what it shows, or in perspective of what it shows at a distance of 1.
    area: f64,
    is_perspective: bool,
}

impl Frustum {
    /// The frustum of a camera for a picture's proportions.
    pub fn new(camera: &Camera, size: PictureSize) -> Frustum {
        let (right, up, forward) = (camera.right(), camera.up(), camera.forward());
        let projection = camera.projection();
        let sides = match *projection {
            Projection::Perspective { fov_y, .. } => {
                let tangent = libm::tan(fov_y * 0.5);
                let across = forward * (tangent * size.aspect());
                let down = forward * tangent;
                [
                    (across + right, 0.0),
                    (across - right, 0.0),
                    (down + up, 0.0),
                    (down - up, 0.0),
                ]
            }
            Projection::Orthographic { height, .. } => {
                let (across, down) = (height * 0.5 * size.aspect(), height * 0.5);
                [(right, across), (-right, across), (up, down), (-up, down)]
            }
        };
        let far = projection
            .far()
            .map_or((DVec3::ZERO, 0.0), |far| (-forward, far));
        // A box may touch a plane just where an object lies, and the eye's coordinates be the largest of all: the planes
        // stand back by far more than the subtraction of the eye and the plane's own distance are rounded.
        let reach = camera.eye().abs().max_element();
        let planes = [
            sides[0],
            sides[1],
            sides[2],
            sides[3],
            (forward, -projection.near()),
            far,
        ]
        .map(|(normal, offset): (DVec3, f64)| {
            (
                normal,
                offset + (normal.length() * reach + offset.abs()) * ROUNDING,
            )
        });
        let (height, is_perspective) = match *projection {
            Projection::Perspective { fov_y, .. } => (2.0 * libm::tan(fov_y * 0.5), true),
            Projection::Orthographic { height, .. } => (height, false),
        };
        Frustum {
            eye: camera.eye(),
            planes,
            area: height * height * size.aspect(),
            is_perspective,
        }
    }

    /// About how large a surface at a place is that faces the eye and fills the picture, in square scene units.
    pub(crate) fn picture_area_at(&self, place: DVec3) -> f64 {
        if self.is_perspective {
            self.area * (place - self.eye).length_squared()
        } else {
            self.area
        }
    }

    /// Where a world box lies, tested against `planes` only. A box that is larger than what it holds by one part in 2⁴⁰
    /// of its coordinates, as a scene's boxes are, is never outside where what it holds would be drawn.
    pub fn contains(&self, bounds: &Aabb, planes: Planes) -> Containment {
        let (min, max) = (bounds.min - self.eye, bounds.max - self.eye);
        let greater = |a: f64, b: f64| if a > b { a } else { b };
        let lesser = |a: f64, b: f64| if a < b { a } else { b };
        let (mut untested, mut left) = (planes.0, 0);
        while untested != 0 {
            let i = untested.trailing_zeros();
            untested &= untested - 1;
            let (normal, offset) = self.planes[i as usize];
            let (a, b) = (normal * min, normal * max);
            let farthest_in = greater(a.x, b.x) + greater(a.y, b.y) + greater(a.z, b.z);
            if farthest_in + offset < 0.0 {
                return Containment::Outside;
            }
            let farthest_out = lesser(a.x, b.x) + lesser(a.y, b.y) + lesser(a.z, b.z);
            left |= u8::from(farthest_out + offset < 0.0) << i;
        }
        Containment::Meets(Planes(left))
    }
}
