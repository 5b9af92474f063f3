//! Pictures of the survivors: `image` draws what the camera sees, `overlay` what the culling did.
//!
//! A picture is made in this order: `surfaces` finds the nearest surface at each pixel (with `pixels`, which the exact
//! reference uses too), `light` colours it, `creases` brings out its shape, `image` blends translucent surfaces over
//! and encodes the result. With the feature `gpu`, `gpu` draws the same picture on a graphics processor.

mod creases;
#[cfg(feature = "gpu")]
pub mod gpu;
mod image;
mod light;
mod overlay;
mod pixels;
mod surfaces;

pub use image::{Image, render_image};
pub use overlay::{PictureFrame, overlay_image};
pub use pixels::{Fragment, draw_objects, draw_placed};
