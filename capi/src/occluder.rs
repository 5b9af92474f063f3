//! What is drawn into an occlusion buffer.

use antumbra::occlusion::Occluder;
use antumbra::raster::{CullMode, Geometry, GeometryError, Positions};

use crate::arguments::{chosen, placement};
use crate::borrow::list;
use crate::status::AntumbraStatus::ANTUMBRA_ERROR_OUT_OF_RANGE;
use crate::status::Error;

/// Which sides of a triangle are drawn. A front is where its corners run counter-clockwise in local coordinates: a matrix that mirrors
/// does not turn a mesh inside out.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraCullMode {
    /// Backs are left out.
    ANTUMBRA_CULL_BACK = 0,
    /// Fronts are left out.
    ANTUMBRA_CULL_FRONT = 1,
    /// Both sides are drawn.
    ANTUMBRA_CULL_NONE = 2,
}

use AntumbraCullMode::*;

const CULL_MODES: [(u32, CullMode); 3] = [
    (ANTUMBRA_CULL_BACK as u32, CullMode::Back),
    (ANTUMBRA_CULL_FRONT as u32, CullMode::Front),
    (ANTUMBRA_CULL_NONE as u32, CullMode::None),
];

/// Something to draw into an occlusion buffer. Nothing of it is needed after the call.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraOccluder {
    /// x, y and z of each vertex, local units. Triangles with a vertex that is not finite hide nothing.
    pub positions: *const f32,
    /// How many vertices there are.
    pub vertex_count: usize,
    /// Bytes from one vertex to the next: a multiple of 4, at least 12.
    pub stride: usize,
    /// Three vertices a triangle, counter-clockwise at the front.
    pub indices: *const u32,
    /// How many indices there are: a multiple of 3.
    pub index_count: usize,
    /// 16 numbers, column by column, whose last row is 0 0 0 1; it may mirror and scale unevenly; NULL for the identity. Answers are
    /// exact as long as local coordinates, times the matrix's scale, and its translation are not a thousand times larger than the world
    /// coordinates that they cancel to.
    pub world_from_local: *const f64,
    /// An AntumbraCullMode.
    pub cull_mode: u32,
}

impl From<GeometryError> for Error {
    fn from(error: GeometryError) -> Error {
        match error {
            GeometryError::IndexOutOfRange { .. } => Error::new(ANTUMBRA_ERROR_OUT_OF_RANGE, error),
            _ => Error::invalid(error),
        }
    }
}

/// The floats that hold positions, from the first to the end of the last.
pub fn positions<'a>(
    first: *const f32,
    vertices: usize,
    stride: usize,
) -> Result<&'a [f32], Error> {
    if stride < 12 || !stride.is_multiple_of(4) {
        let message =
            format_args!("stride is {stride} bytes, but must be a multiple of 4, at least 12");
        return Err(Error::invalid(message));
    }
    let floats = match vertices {
        0 => Some(0),
        _ => (vertices - 1)
            .checked_mul(stride / 4)
            .and_then(|floats| floats.checked_add(3)),
    };
    let floats = floats.ok_or_else(|| {
        let message = format_args!("positions: {vertices} vertices are more than memory holds");
        Error::invalid(message)
    })?;
    list(first, floats, "positions")
}

impl AntumbraOccluder {
    pub fn checked(&self) -> Result<Occluder<'_>, Error> {
        let floats = positions(self.positions, self.vertex_count, self.stride)?;
        let positions = Positions::strided(floats, self.stride / 4)?;
        let indices = list(self.indices, self.index_count, "indices")?;
        Ok(Occluder {
            geometry: Geometry::new(positions, indices)?,
            world_from_local: placement(self.world_from_local, "world_from_local")?,
            cull_mode: chosen(self.cull_mode, &CULL_MODES, "cull_mode")?,
        })
    }
}
