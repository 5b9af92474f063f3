//! A camera for scenes that come without one: outside, seen from a corner and a little above.

use antumbra::glam::DVec3;
use antumbra::scene::Aabb;
use antumbra::view::{Camera, Projection, ViewError};

/// Angle between the upper and lower edges of the picture, and its half's tangent.
const FOV_Y_DEGREES: f64 = 40.0;
const HALF_TANGENT: f64 = 0.363_970_234;
/// From the scene to the camera.
const TOWARDS_CAMERA: DVec3 = DVec3::new(0.62, 0.42, 0.66);
/// Room around the scene.
const MARGIN: f64 = 1.06;
/// The near plane stands at this share of the way to the scene.
const NEAR_SHARE: f64 = 0.5;

/// The camera that shows all of `bounds`, in a picture of this width over height.
///
/// # Errors
/// If the boxes are beyond what a camera can take in.
pub fn camera_outside(bounds: &[Aabb], aspect: f64) -> Result<Camera, ViewError> {
    let all = bounds.iter().fold(Aabb::EMPTY, |all, &b| all.union(b));
    let middle = all.center();
    let back = TOWARDS_CAMERA / TOWARDS_CAMERA.length();
    let right = DVec3::Y.cross(back);
    let right = right / right.length();
    let up = back.cross(right);
    // Each corner wants a distance at which it fits; a corner nearer to the camera wants more.
    let (mut distance, mut nearest) = (0.0_f64, 0.0_f64);
    for corner in all.corners() {
        let c = corner - middle;
        let sideways = c.dot(right).abs() / aspect;
        let needed = sideways.max(c.dot(up).abs()) * MARGIN / HALF_TANGENT;
        distance = distance.max(needed + c.dot(back));
        nearest = nearest.max(c.dot(back));
    }
    // A single point can be looked at from anywhere.
    let distance = if distance > 0.0 { distance } else { 1.0 };
    let projection = Projection::Perspective {
        fov_y: FOV_Y_DEGREES.to_radians(),
        near: (distance - nearest).max(distance * 1e-3) * NEAR_SHARE,
        far: None,
    };
    Camera::look_at(middle + back * distance, middle, DVec3::Y, projection)
}

#[cfg(test)]
mod tests {
    use antumbra::view::{Containment, Frustum, PictureSize, Planes};

    use super::*;

    #[test]
    fn the_whole_scene_is_inside_the_frustum() {
        let boxes = [
            Aabb {
                min: DVec3::splat(-1.0),
                max: DVec3::splat(1.0),
            },
            Aabb {
                min: DVec3::new(5e4, 0.0, 0.0),
                max: DVec3::new(5e4 + 900.0, 2.0, 1.0),
            },
            Aabb {
                min: DVec3::ZERO,
                max: DVec3::new(1.0, 700.0, 1.0),
            },
            Aabb {
                min: DVec3::ZERO,
                max: DVec3::ZERO,
            },
        ];
        for bounds in boxes {
            for (width, height) in [(1280, 768), (200, 900)] {
                let size = PictureSize::new(width, height).expect("a size");
                let camera = camera_outside(&[bounds], size.aspect()).expect("a camera");
                let Containment::Meets(crossed) =
                    Frustum::new(&camera, size).contains(&bounds, Planes::ALL)
                else {
                    panic!("{bounds:?} is outside");
                };
                assert!(crossed.is_empty(), "{bounds:?} sticks out");
            }
        }
    }
}
