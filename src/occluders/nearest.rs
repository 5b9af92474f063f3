//! Distance-based selection (HOM §7.3.2): the objects whose boxes have the nearest centres.

use glam::DVec3;

use crate::scene::Scene;

/// Sorts objects by the distance of their boxes' centres from the eye, nearest first, ties in scene order.
pub fn nearest_first(scene: &Scene, eye: DVec3, objects: &mut Vec<u32>) {
    let mut keyed: Vec<(f64, u32)> = objects
        .iter()
        .map(|&object| {
            (
                (scene.bounds()[object as usize].center() - eye).length_squared(),
                object,
            )
        })
        .collect();
    keyed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    objects.clear();
    objects.extend(keyed.into_iter().map(|(_, object)| object));
}
