//! Distance-based selection (HOM §7.3.2): the objects whose boxes reach nearest to the eye.
//!
//! Most objects of a scene are found hidden in groups before their turn comes, so their order is only found as far as it is
//! needed.

use glam::DVec3;

use super::key;
use crate::scene::Scene;

/// Finds keys that sort objects by the distance of their boxes from the eye, nearest first, ties in scene order.
pub fn distance_keys(
    scene: &Scene,
    eye: DVec3,
    objects: impl Iterator<Item = u32>,
    keys: &mut Vec<u64>,
) {
    keys.clear();
    keys.extend(objects.map(|object| {
        let bounds = &scene.bounds()[object as usize];
        let distance = (eye.clamp(bounds.min, bounds.max) - eye).length_squared();
        key(distance as f32, object)
    }));
}

/// The object of a key.
pub fn object_of(key: u64) -> u32 {
    key as u32
}

/// Puts the nearest `count` objects first, in their order; the others follow in any.
pub fn sort_nearest(keys: &mut [u64], count: usize) {
    if count < keys.len() {
        keys.select_nth_unstable(count);
    }
    keys[..count].sort_unstable();
}
