//! Occlusion culling on the CPU: which objects of a scene can this camera see?
#![forbid(unsafe_code)]

pub mod scene;
