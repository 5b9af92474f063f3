//! Positions and indices to triangles that are ready to be filled.

use antumbra_simd::triangle::{CullMode, Triangle};
use antumbra_simd::vertex::{ClipVertex, ScreenTransform, ScreenVertex, transform};
use thiserror::Error;

use super::clip::clip_triangle;
use crate::view::PictureSize;

/// Geometry that cannot be drawn.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum GeometryError {
    /// The stride is less than a position.
    #[error("a stride of {stride} floats is less than the 3 of a position")]
    Stride {
        /// The stride given.
        stride: usize,
    },
    /// The indices are not whole triangles.
    #[error("{count} indices are not a multiple of 3")]
    PartialTriangle {
        /// How many indices there are.
        count: usize,
    },
    /// An index has no position.
    #[error("index {index} is out of range: there are {positions} positions")]
    IndexOutOfRange {
        /// The index.
        index: u32,
        /// How many positions there are.
        positions: usize,
    },
}

/// Vertex positions in a slice of floats, perhaps between other attributes.
#[derive(Clone, Copy, Debug)]
pub struct Positions<'a> {
    floats: &'a [f32],
    stride: usize,
}

impl<'a> Positions<'a> {
    /// Positions one after the other.
    pub fn packed(positions: &'a [[f32; 3]]) -> Positions<'a> {
        Positions {
            floats: positions.as_flattened(),
            stride: 3,
        }
    }

    /// Positions every `stride` floats, the first at the start of the slice.
    ///
    /// # Errors
    /// If the stride is less than 3.
    pub fn strided(floats: &'a [f32], stride: usize) -> Result<Positions<'a>, GeometryError> {
        if stride < 3 {
            Err(GeometryError::Stride { stride })
        } else {
            Ok(Positions { floats, stride })
        }
    }

    /// How many positions there are.
    pub fn len(&self) -> usize {
        // The last may lack what follows its coordinates.
        (self.floats.len() + self.stride - 3) / self.stride
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = [f32; 3]> + 'a {
        self.floats
            .chunks(self.stride)
            .filter_map(|c| c.first_chunk().copied())
    }
}

/// Triangles to draw: checked positions and indices.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    positions: Positions<'a>,
    triangles: &'a [[u32; 3]],
}

impl<'a> Geometry<'a> {
    /// The positions.
    pub(crate) fn positions(&self) -> Positions<'a> {
        self.positions
    }

    /// Three indices into `positions` a triangle; counter-clockwise is the front.
    ///
    /// # Errors
    /// If there are indices left over or an index is out of range.
    pub fn new(
        positions: Positions<'a>,
        indices: &'a [u32],
    ) -> Result<Geometry<'a>, GeometryError> {
        let (triangles, rest) = indices.as_chunks();
        if !rest.is_empty() {
            return Err(GeometryError::PartialTriangle {
                count: indices.len(),
            });
        }
        match indices.iter().max() {
            Some(&index) if index as usize >= positions.len() => {
                Err(GeometryError::IndexOutOfRange {
                    index,
                    positions: positions.len(),
                })
            }
            _ => Ok(Geometry {
                positions,
                triangles,
            }),
        }
    }
}

/// Turns geometry into triangles; keeps its buffers from draw to draw.
#[derive(Clone, Debug, Default)]
pub struct Assembler {
    clip: Vec<ClipVertex>,
    screen: Vec<Option<ScreenVertex>>,
}

impl Assembler {
    /// Transforms positions, and hands every triangle that can cover a sample of the picture to `emit`, in the order
    /// of the indices, with its place in that order. A triangle with a vertex that is not finite gives none.
    pub fn assemble(
        &mut self,
        geometry: Geometry<'_>,
        screen: &ScreenTransform,
        size: PictureSize,
        cull: CullMode,
        emit: impl FnMut(Triangle, usize),
    ) {
        self.transform(geometry.positions, screen);
        self.set_up(geometry.triangles, screen, size, cull, emit);
    }

    /// The first half: transforms and snaps positions.
    pub(super) fn transform(&mut self, positions: Positions<'_>, screen: &ScreenTransform) {
        self.clip.clear();
        self.clip
            .extend(positions.iter().map(|p| transform(screen, p)));
        self.screen.clear();
        self.screen.extend(
            self.clip
                .iter()
                .map(|v| v.is_inside(screen).then(|| v.snap())),
        );
    }

    /// The second half: clips where need be, and sets up triangles of the positions transformed last, by the same
    /// `screen`.
    pub(super) fn set_up(
        &self,
        triangles: &[[u32; 3]],
        screen: &ScreenTransform,
        size: PictureSize,
        cull: CullMode,
        mut emit: impl FnMut(Triangle, usize),
    ) {
        let (width, height) = (size.width() as i32, size.height() as i32);
        for (index, triangle) in triangles.iter().enumerate() {
            let mut set_up = |vertices| {
                if let Some(triangle) =
                    Triangle::new(vertices, cull).and_then(|t| t.within(width, height))
                {
                    emit(triangle, index);
                }
            };
            let [a, b, c] = triangle.map(|i| i as usize);
            match (self.screen[a], self.screen[b], self.screen[c]) {
                (Some(a), Some(b), Some(c)) => set_up([a, b, c]),
                _ => clip_triangle([self.clip[a], self.clip[b], self.clip[c]], screen, set_up),
            }
        }
    }
}
