//! Selection by promise: what a frame that remembers nothing draws first.
//!
//! What an object may hide is bounded by its solid angle. What it costs grows with its triangles, but less than with their
//! number: large meshes have large triangles, too.

use glam::DVec3;

use super::object_of;
use super::solid_angle::solid_angle;
use crate::scene::Scene;

/// Keeps the `count` keys ([`distance_keys`](super::distance_keys)) whose objects promise most for what they cost, in any order;
/// `triangles_of` says how many triangles an object has.
pub fn keep_promising(
    scene: &Scene,
    eye: DVec3,
    keys: &mut Vec<u64>,
    count: usize,
    triangles_of: impl Fn(u32) -> u32,
) {
    if keys.len() <= count {
        return;
    }
    let promise = |object: u32| {
        let angle = solid_angle(&scene.bounds()[object as usize], eye);
        (angle * angle / f64::from(triangles_of(object).max(1))) as f32
    };
    let mut by_promise: Vec<(u32, u64)> = keys
        .iter()
        // Bits of floats that are not negative sort as the floats do.
        .map(|&key| (promise(object_of(key)).to_bits(), key))
        .collect();
    by_promise.select_nth_unstable_by_key(count, |&(promise, key)| (!promise, object_of(key)));
    keys.clear();
    keys.extend(by_promise[..count].iter().map(|&(_, key)| key));
}
