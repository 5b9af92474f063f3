//! The space that a camera sees, and which boxes meet it.

use glam::DVec3;

use super::{Camera, PictureSize, Projection, Slack};
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
    /// What a position may be off, as a share of the distance to the box's farthest corner.
    slack: f64,
}

impl Frustum {
    /// The frustum of a camera for a picture's proportions.
    pub fn new(camera: &Camera, size: PictureSize) -> Frustum {
        Frustum::with_slack(camera, size, Slack::NONE)
    }

    /// The frustum of all that a final pass with this slack may draw in the picture.
    pub fn with_slack(camera: &Camera, size: PictureSize, slack: Slack) -> Frustum {
        let (right, up, forward) = (camera.right(), camera.up(), camera.forward());
        let projection = camera.projection();
        // The sides of the picture, counted from its middle: left, right, bottom and top as shares of half of it.
        let slack_and_jitter = |pixels: usize, jitter: f64| {
            let [off, moved] = [slack.pixels(), jitter].map(|v| 2.0 * v / pixels as f64);
            [(1.0 + off) - moved, (1.0 + off) + moved]
        };
        let [left, right_side] = slack_and_jitter(size.width(), camera.jitter().x);
        let [top, bottom] = slack_and_jitter(size.height(), camera.jitter().y);
        let sides = match *projection {
            Projection::Perspective { fov_y, .. } => {
                let tangent = libm::tan(fov_y * 0.5);
                let across = forward * (tangent * size.aspect());
                let down = forward * tangent;
                [
                    (across * left + right, 0.0),
                    (across * right_side - right, 0.0),
                    (down * bottom + up, 0.0),
                    (down * top - up, 0.0),
                ]
            }
            Projection::Orthographic { height, .. } => {
                let (across, down) = (height * 0.5 * size.aspect(), height * 0.5);
                [
                    (right, across * left),
                    (-right, across * right_side),
                    (up, down * bottom),
                    (-up, down * top),
                ]
            }
        };
        let [near, far] = ends(projection, slack);
        let far = far.map_or((DVec3::ZERO, 0.0), |far| (-forward, far));
        // A box may touch a plane just where an object lies, and the eye's coordinates be the largest of all: the planes
        // stand back by far more than the subtraction of the eye and the plane's own distance are rounded.
        let reach = camera.eye().abs().max_element();
        let planes = [
            sides[0],
            sides[1],
            sides[2],
            sides[3],
            near.map_or((DVec3::ZERO, 0.0), |near| (forward, -near)),
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
            slack: slack.position(),
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
            let (normal, mut offset) = self.planes[i as usize];
            if self.slack > 0.0 {
                offset += self.slack * distance_of_farthest(bounds, self.eye) * normal.length();
            }
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

/// The least and the largest distance of what may be drawn, positions aside; none: anything nearer, or farther.
fn ends(projection: &Projection, slack: Slack) -> [Option<f64>; 2] {
    let off = slack.depth_through(projection);
    let (near, far) = (projection.near(), projection.far());
    if off == 0.0 {
        return [Some(near), far];
    }
    match projection {
        Projection::Perspective { .. } => {
            let beyond = |far: f64| {
                let depth = near / far - off;
                (depth > 0.0).then(|| near / depth)
            };
            [Some(near / (1.0 + off)), far.and_then(beyond)]
        }
        Projection::Orthographic { .. } if off.is_finite() => {
            [Some(near - off), far.map(|far| far + off)]
        }
        Projection::Orthographic { .. } => [None, None],
    }
}

/// How far the farthest corner of a box is from the eye.
pub(crate) fn distance_of_farthest(bounds: &Aabb, eye: DVec3) -> f64 {
    let (min, max) = (bounds.min - eye, bounds.max - eye);
    min.abs().max(max.abs()).length()
}
