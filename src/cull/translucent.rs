//! Translucent occluders of a frame: the panes of glass in the frustum, where several of them may hide what is behind (HOM §4.4).

use super::Frame;
use crate::occlusion::{Occluder, OcclusionBuffer};
use crate::raster::{CullMode, Geometry, Positions};
use crate::scene::Alpha;
use crate::view::{Containment, Planes};

/// Draws the translucent surfaces of the objects that are not hidden yet.
pub fn draw_translucent(frame: &Frame<'_>, buffer: &mut OcclusionBuffer) {
    let frustum = frame.frustum(buffer.screen().camera());
    for &number in frame.occluders.translucent() {
        let bounds = &frame.scene.bounds()[number as usize];
        let is_outside = frustum.contains(bounds, Planes::ALL) == Containment::Outside;
        if is_outside || buffer.hides(buffer.screen().footprint_of_aabb(bounds)) {
            continue;
        }
        let object = &frame.scene.objects()[number as usize];
        let mesh = &frame.scene.meshes()[object.mesh];
        let surfaces = mesh.surfaces.iter();
        for surface in surfaces.filter(|surface| surface.material.alpha == Alpha::Blend) {
            let indices = mesh.triangles[surface.triangles.clone()].as_flattened();
            let Ok(geometry) = Geometry::new(Positions::packed(&mesh.positions), indices) else {
                // A scene's indices are in range.
                continue;
            };
            let [.., opacity] = surface.material.color;
            let occluder = Occluder {
                geometry,
                world_from_local: object.world_from_local,
                cull_mode: if surface.material.double_sided {
                    CullMode::None
                } else {
                    CullMode::Back
                },
            };
            buffer.draw_translucent(&occluder, opacity);
        }
    }
}
