//! Occluders to coverage masks and depth, tile by tile.
//!
//! A draw runs through the files in this order: [`Assembler`] (`assemble`) transforms and snaps vertices, clips what
//! crosses the near plane, the far plane or the guard band (`clip`), and sets triangles up; `traverse` walks the
//! tiles that a triangle touches; [`TileBuffer`] (`tiles`) merges them. The final pass assembles and traverses with the
//! same code, and so covers the same samples at the same depths.

mod assemble;
mod bands;
mod blocks;
mod clip;
mod cluster;
mod object;
mod surface;
mod tiles;
mod traverse;

pub use antumbra_simd::triangle::CullMode;
pub use assemble::{Assembler, Geometry, GeometryError, Positions};
pub use blocks::BlockList;
pub use cluster::ClusterAssembler;
pub use object::{ObjectAssembler, ObjectTriangle};
pub use surface::{LoweredPlane, SurfaceTriangles};
pub use tiles::TileBuffer;
pub use traverse::{for_each_sample, for_each_tile};
