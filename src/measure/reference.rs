//! The truth: which objects own a pixel.
//!
//! An object is *exactly visible* if it owns a pixel of an object-id picture of the whole scene, drawn in scene order,
//! the nearer surface keeping the pixel and the first drawn at equal depth (HOM §8.3 encodes ids as colours). Masked
//! surfaces draw as opaque ones. A translucent object is exactly visible if a sample of it lies before the opaque
//! picture.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use super::ExactDepths;
use crate::final_pass::draw_objects;
use crate::scene::{Alpha, Scene};
use crate::view::{Camera, PictureSize};

/// The id of a pixel that no object owns.
const NOBODY: u32 = u32::MAX;

#[derive(Clone, Copy, PartialEq)]
struct IdPixel {
    depth: f32,
    object: u32,
}

/// Exact visibility of a scene from a camera.
#[derive(Debug)]
pub struct Reference {
    ids: Vec<u32>,
    depths: ExactDepths,
    visible: Vec<bool>,
    sampled: Vec<bool>,
}

/// The object-id picture of `objects`, which calls `sampled` with every object that covers a sample.
fn id_picture(
    scene: &Scene,
    camera: &Camera,
    size: PictureSize,
    objects: &[u32],
    sampled: impl Fn(u32) + Sync,
) -> Vec<IdPixel> {
    let empty = IdPixel {
        depth: f32::NEG_INFINITY,
        object: NOBODY,
    };
    let mut pixels = vec![empty; size.width() * size.height()];
    draw_objects(
        scene,
        camera,
        size,
        objects,
        |m| m.alpha != Alpha::Blend,
        &mut pixels,
        |pixel, f| {
            sampled(f.object);
            if f.depth > pixel.depth {
                *pixel = IdPixel {
                    depth: f.depth,
                    object: f.object,
                };
            }
        },
    );
    pixels
}

impl Reference {
    /// Draws the whole scene, objects outside the frustum too.
    pub fn new(scene: &Scene, camera: &Camera, size: PictureSize) -> Reference {
        let all: Vec<u32> = (0..scene.objects().len() as u32).collect();
        let flags = || -> Vec<AtomicBool> { all.iter().map(|_| AtomicBool::new(false)).collect() };
        let (sampled, visible) = (flags(), flags());
        let set = |flags: &[AtomicBool], object: u32| {
            // A load first: thousands of samples of one object would pass its line between the cores.
            let flag = &flags[object as usize];
            if !flag.load(Relaxed) {
                flag.store(true, Relaxed);
            }
        };
        let mut pixels = id_picture(scene, camera, size, &all, |object| set(&sampled, object));
        for pixel in pixels.iter().filter(|p| p.object != NOBODY) {
            set(&visible, pixel.object);
        }
        draw_objects(
            scene,
            camera,
            size,
            &all,
            |m| m.alpha == Alpha::Blend,
            &mut pixels,
            |pixel, f| {
                set(&sampled, f.object);
                if f.depth > pixel.depth {
                    set(&visible, f.object);
                }
            },
        );
        let plain =
            |flags: Vec<AtomicBool>| flags.into_iter().map(AtomicBool::into_inner).collect();
        Reference {
            ids: pixels.iter().map(|p| p.object).collect(),
            depths: ExactDepths::new(size, pixels.iter().map(|p| p.depth).collect()),
            visible: plain(visible),
            sampled: plain(sampled),
        }
    }

    /// Whether an object is exactly visible.
    pub fn is_visible(&self, object: u32) -> bool {
        self.visible[object as usize]
    }

    /// The exactly visible objects, in scene order.
    pub fn visible_objects(&self) -> impl Iterator<Item = u32> {
        self.visible
            .iter()
            .enumerate()
            .filter_map(|(object, &visible)| visible.then_some(object as u32))
    }

    /// Whether an object covers a pixel centre at all, even alone.
    pub fn is_sampled(&self, object: u32) -> bool {
        self.sampled[object as usize]
    }

    /// The exact depths of the opaque picture.
    pub fn depths(&self) -> &ExactDepths {
        &self.depths
    }

    /// How many pixels of the id picture change if only `objects` are drawn (DYN §4.3).
    pub fn wrong_pixels(&self, scene: &Scene, camera: &Camera, objects: &[u32]) -> u64 {
        let pixels = id_picture(scene, camera, self.depths.size(), objects, |_| {});
        pixels
            .iter()
            .zip(&self.ids)
            .filter(|(p, id)| p.object != **id)
            .count() as u64
    }
}
