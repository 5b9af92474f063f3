//! Occlusion culling on the CPU: which objects of a scene can this camera see?
#![forbid(unsafe_code)]

pub use glam;

pub mod cull;
pub mod final_pass;
pub mod measure;
pub mod occluders;
pub mod occlusion;
pub mod pipeline;
pub mod prepare;
pub mod raster;
pub mod sampling;
pub mod scene;
pub mod tasks;
pub mod threads;
pub mod view;

/// Runs the guide's examples.
#[cfg(doctest)]
#[doc = include_str!("../docs/guide.md")]
struct GuideExamples;

/// Compiles the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
