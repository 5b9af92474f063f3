//! Is this box hidden by what has been drawn?
//!
//! A question runs through the files in this order: a shape's `footprint` on screen, the rectangle of samples it may
//! cover and its nearest depth; the `overlap` test of that rectangle; the `depth` test against the no-background Z-buffer,
//! or one of three other representations.
//! Occluded means that both pass (HOM §3.1); both are asked at once ([`antumbra_simd::query`]). A box that those do not
//! hide, and that does not show itself at one of a few samples, is asked again, more closely ([`antumbra_simd::closer`]): with its
//! silhouette in place of the rectangle and its sloped faces in place of the nearest depth (`projected_box`). What may be lost
//! (`accuracy`) is known beforehand: the `holes` that the pyramid of occlusion maps (`map`) lets pass are covered. [`OcclusionBuffer`] (`buffer`) puts them together for an engine that
//! has its own scene.

mod accuracy;
mod buffer;
mod depth;
mod footprint;
mod holes;
mod map;
mod occluder_transform;
mod overlap;
mod projected_box;
mod veils;

pub use crate::scene::OrientedBox;
pub use accuracy::{Accuracy, Approximation, Thresholds};
pub use buffer::{Occluder, OcclusionBuffer, Sphere, Visibility};
pub use depth::{
    DepthMap, DepthRepresentation, DrawnSurface, ESTIMATION_CELLS, EstimationBuffer, FarPlane,
    HierarchicalZ, MOST_NTH, UnknownDepthRepresentation, is_behind,
};
pub use footprint::{Footprint, SampleRect, Screen};
pub use holes::Holes;
pub use map::OcclusionMap;
pub use overlap::{is_covered, is_covered_so_far};
pub use projected_box::ProjectedBox;
