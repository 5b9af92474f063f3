//! Distance-based selection (HOM §7.3.2): the objects whose boxes have the nearest centres.

use glam::DVec3;

use crate::scene::Scene;

/// Sorts objects by the distance of their boxes' centres from the eye, nearest first, ties in scene order. `keys` is
/// memory to work in.
pub fn nearest_first(scene: &Scene, eye: DVec3, objects: &mut [u32], keys: &mut Vec<u64>) {
    keys.clear();
    keys.extend(objects.iter().map(|&object| {
        let distance = (scene.bounds()[object as usize].center() - eye).length_squared();
        // Bits of floats that are not negative sort as the floats do.
        u64::from((distance as f32).to_bits()) << 32 | u64::from(object)
    }));
    keys.sort_unstable();
    for (object, &key) in objects.iter_mut().zip(&*keys) {
        *object = key as u32;
    }
}
