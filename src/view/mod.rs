//! The view: where the camera stands, how it projects, what its frustum holds, and paths of cameras.
//!
//! Everything that a camera makes is relative to the eye: the eye is subtracted in f64 before a coordinate meets the
//! projection, so a scene far from the origin is seen as sharply as one at it.

mod camera;
mod frustum;
mod map_scale;
mod path;
mod slack;

pub use camera::{Camera, PictureSize, Projection, ViewError};
pub(crate) use frustum::distance_of_farthest;
pub use frustum::{Containment, Frustum, Planes};
pub use map_scale::MapScale;
pub use path::{CameraPath, PathError};
pub use slack::Slack;
