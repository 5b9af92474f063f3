//! Which surface each pixel shows: the nearest at its centre, the first drawn of equally near ones.
//!
//! Objects are given in scene order, so "first drawn" names the same surface whether or not hidden objects are left
//! out: leaving one out removes only samples that something strictly nearer owns.

use super::draw_objects;
use crate::scene::{Alpha, Material, Scene};
use crate::view::{Camera, PictureSize, Projection};

/// The nearest surface at a pixel's centre.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Depth, the larger the nearer; minus infinity where there is only background.
    pub depth: f32,
    /// The object.
    pub object: u32,
    /// The triangle of the object's mesh.
    pub triangle: u32,
}

impl Surface {
    /// No surface.
    pub const BACKGROUND: Surface = Surface {
        depth: f32::NEG_INFINITY,
        object: u32::MAX,
        triangle: 0,
    };

    /// Whether there is no surface.
    pub fn is_background(&self) -> bool {
        self.object == u32::MAX
    }

    /// The surface's material.
    pub fn material<'a>(&self, scene: &'a Scene) -> &'a Material {
        let mesh = &scene.meshes()[scene.objects()[self.object as usize].mesh];
        let triangle = self.triangle as usize;
        let run = mesh
            .surfaces
            .partition_point(|s| s.triangles.end <= triangle);
        &mesh.surfaces[run].material
    }
}

/// Draws the surfaces that are not translucent of `objects`, in order. `place` gives a pixel's surface, or none if
/// what has this depth is not to be drawn there.
pub fn draw_nearest<P: Send>(
    scene: &Scene,
    camera: &Camera,
    size: PictureSize,
    objects: &[u32],
    pixels: &mut [P],
    place: impl Fn(&mut P, f32) -> Option<&mut Surface> + Sync,
) {
    let solid = |m: &Material| m.alpha != Alpha::Blend;
    draw_objects(scene, camera, size, objects, solid, pixels, |pixel, f| {
        if let Some(surface) = place(pixel, f.depth)
            && f.depth > surface.depth
        {
            *surface = Surface {
                depth: f.depth,
                object: f.object,
                triangle: f.triangle as u32,
            };
        }
    });
}

/// The distance along the view direction of what has this depth, scene units.
pub fn distance_at(projection: &Projection, depth: f32) -> f64 {
    match *projection {
        Projection::Perspective { near, .. } => near / f64::from(depth),
        Projection::Orthographic { .. } => -f64::from(depth),
    }
}
