//! Selection by a plane across the view (HOM §7.3.1): the objects that reach before it.
//!
//! Where the plane lies is not said beforehand: it moves away from the eye until the budget is spent.

use super::{key, objects_and_bounds};
use crate::scene::Scene;
use crate::view::Camera;

/// Finds keys that sort objects by how far along the view their boxes begin, ties in scene order.
pub fn z_plane_keys(
    scene: &Scene,
    camera: &Camera,
    objects: impl Iterator<Item = u32>,
    keys: &mut Vec<u64>,
) {
    let (eye, forward) = (camera.eye(), camera.forward());
    keys.clear();
    keys.extend(objects_and_bounds(scene, objects).map(|(object, bounds)| {
        let to_middle = (bounds.center() - eye).dot(forward);
        let half = (bounds.size() * 0.5).dot(forward.abs());
        // What begins behind the eye begins at once.
        let distance = if to_middle > half {
            to_middle - half
        } else {
            0.0
        };
        key(distance as f32, object)
    }));
}
