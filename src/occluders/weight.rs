//! Selection by weight (LOD §5.2, equation 3): the objects that are large, near and turned towards the eye.
//!
//! The weight is `V·|N·E| / D³`, with the volume V of the object's box, the distance D of its nearest point, the direction N
//! across the largest face of the object's own box, and the direction E of the view.

use super::{key_of_largest, objects_and_bounds};
use crate::scene::Scene;
use crate::view::Camera;

/// Finds keys that sort objects by weight, the largest first, ties in scene order.
pub fn weight_keys(
    scene: &Scene,
    camera: &Camera,
    objects: impl Iterator<Item = u32>,
    keys: &mut Vec<u64>,
) {
    let eye = camera.eye();
    keys.clear();
    keys.extend(objects_and_bounds(scene, objects).map(|(object, bounds)| {
        let size = bounds.size();
        let axes = match scene.own_box(object as usize) {
            Some(own) => own.shape.half_axes,
            None => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|axis| size * glam::DVec3::from(axis)),
        };
        // The largest face lies across the shortest axis.
        let [a, b, c] = axes;
        let shorter = |a: glam::DVec3, b: glam::DVec3| {
            if b.length_squared() < a.length_squared() {
                b
            } else {
                a
            }
        };
        let across = shorter(shorter(a, b), c);
        // A sheet is flat across no direction that its box tells.
        let turned = if across.length_squared() > 0.0 {
            (across / across.length()).dot(camera.forward()).abs()
        } else {
            1.0
        };
        let distance = (eye.clamp(bounds.min, bounds.max) - eye).length();
        let weight = size.x * size.y * size.z * turned / (distance * distance * distance);
        // An eye within the box, or a box without volume.
        let weight = if weight.is_nan() { 0.0 } else { weight };
        key_of_largest(weight as f32, object)
    }));
}
