//! Which objects appear all at once: hints for fading them in (HOM §5.3.2).
//!
//! An object that was culled and is not any more appears all at once, although a part of it may have been seen through an ignored
//! hole, or beside the occluders, for some frames. What merely enters the picture does not.

use super::VisibleSet;
use crate::scene::Scene;
use crate::view::{Camera, Containment, Frustum, PictureSize, Planes};

/// Finds what newly appears, frame by frame.
#[derive(Clone, Debug, Default)]
pub struct Appearances {
    /// The last frame's frustum, and what was visible in it.
    last: Option<(Frustum, Vec<u32>)>,
    appeared: Vec<u32>,
}

impl Appearances {
    /// The objects that are visible now and were in the frustum of the frame before, but not visible in it; in scene order. Of the
    /// first frame none are.
    pub fn of_frame(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        size: PictureSize,
        found: &VisibleSet,
    ) -> &[u32] {
        self.appeared.clear();
        let frustum = Frustum::new(camera, size);
        match &mut self.last {
            None => self.last = Some((frustum, found.visible.clone())),
            Some((last, visible)) => {
                let is_new = |object: &&u32| {
                    let bounds = &scene.bounds()[**object as usize];
                    visible.binary_search(object).is_err()
                        && last.contains(bounds, Planes::ALL) != Containment::Outside
                };
                self.appeared.extend(found.visible.iter().filter(is_new));
                *last = frustum;
                visible.clone_from(&found.visible);
            }
        }
        &self.appeared
    }
}
