//! Selection by solid angle: the objects that are largest as seen from the eye.

use glam::DVec3;

use super::{key_of_largest, objects_and_bounds};
use crate::scene::{Aabb, Scene};

/// An estimate of the solid angle of a box: half its surface over the sum of two squares of distances, of its middle and of its
/// nearest point. (An eye within a box is near it, however far from its middle.)
pub(super) fn solid_angle(bounds: &Aabb, eye: DVec3) -> f64 {
    let size = bounds.size();
    let area = size.x * size.y + size.y * size.z + size.z * size.x;
    let to_middle = (bounds.center() - eye).length_squared();
    let to_nearest = (eye.clamp(bounds.min, bounds.max) - eye).length_squared();
    area / (to_middle + to_nearest)
}

/// Finds keys that sort objects by the solid angle of their boxes, the largest first, ties in scene order.
pub fn solid_angle_keys(
    scene: &Scene,
    eye: DVec3,
    objects: impl Iterator<Item = u32>,
    keys: &mut Vec<u64>,
) {
    keys.clear();
    keys.extend(
        objects_and_bounds(scene, objects)
            .map(|(object, bounds)| key_of_largest(solid_angle(bounds, eye) as f32, object)),
    );
}
