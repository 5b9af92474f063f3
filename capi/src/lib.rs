//! The C interface: what `include/antumbra.h` declares, which cbindgen makes of these files.
//!
//! ```text
//!   C program  →  exported functions  →  checked arguments  →  the Rust library
//!                 (`status::guard`)      (`arguments`, `borrow`, `handle`)
//! ```
//!
//! A pointer that may be null is an `Option` of a reference or of a box, which has the same form in C; what C has not written yet is
//! a `MaybeUninit`. So results and handles that are created, read and destroyed take no unsafe code. What is left are handles that calls change,
//! since a `&mut` would promise what C cannot, and lists and strings, whose length C alone knows: `borrow` has all of that. Handles
//! lock themselves (`handle`): a caller who breaks the rules of threads gets an error, not a data race, and what a panic has left half done
//! is not used again.
//!
//! Values that C chooses from a list come as plain numbers and are looked up, since a Rust enum with another value would be undefined
//! behaviour.

mod arguments;
mod borrow;
mod builder;
mod camera;
mod camera_path;
mod culler;
mod culler_clusters;
mod culler_memory;
mod handle;
mod level;
mod material;
mod occluder;
mod occlusion_buffer;
mod questions;
mod scene;
mod settings;
mod statistics;
mod status;
mod version;

pub use version::{ANTUMBRA_VERSION_MAJOR, ANTUMBRA_VERSION_MINOR, ANTUMBRA_VERSION_PATCH};
