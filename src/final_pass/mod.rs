//! Pictures of the survivors.

mod pixels;

pub use pixels::{Fragment, draw_objects};
