//! From a cluster's positions and indices to polygons that are ready to be filled, several at once.
//!
//! The plain form is [`transform`] and [`Quad::new`], vertex after vertex and quadrilateral after quadrilateral. The vector
//! form does the same operations in the same order on as many as a vector of f64 holds. Products of
//! two coordinate differences stay below 2⁴⁸ and their sums below 2⁵³, so what the plain form does in integers is exact
//! in f64 as well.
//!
//! Quadrilaterals that cannot be drawn as one are set up as triangles, after all others of the cluster. A triangle with a
//! vertex outside the near or far plane or the guard band is not set up here but named, for the caller to clip.

use fearless_simd::{Simd, dispatch};

use crate::Level;
use crate::closer::LayeredTiles;
use crate::project::{Vertices, project};
use crate::quad::Quad;
use crate::reject::{Left, is_hidden, reject};
use crate::set_up::{SetUpMemory, set_up_block};
use crate::spans::{BLOCK, SpanBlocks};
use crate::triangle::CullMode;
use crate::vertex::{ClipVertex, ScreenTransform, transform};

/// The most quadrilaterals a cluster may have.
pub const MOST_QUADS: usize = 64;

/// The most vertices a cluster may have.
pub const MOST_VERTICES: usize = 128;

/// A vector loop reads this many vertices at once.
pub const VERTEX_PADDING: usize = 16;

/// Quadrilaterals with vertices of their own, structure of arrays.
#[derive(Clone, Copy, Debug)]
pub struct Cluster<'a> {
    /// Positions, local coordinates; padded with copies to a multiple of [`VERTEX_PADDING`], at most [`MOST_VERTICES`].
    pub x: &'a [f32],
    /// Likewise.
    pub y: &'a [f32],
    /// Likewise.
    pub z: &'a [f32],
    /// How many of them are no padding.
    pub vertices: usize,
    /// Four vertices `a b c d` each, at most [`MOST_QUADS`]: two triangles `a b c` and `a c d`, or one if the last two are
    /// the same. Counter-clockwise is the front.
    pub quads: &'a [[u8; 4]],
}

/// How to draw.
#[derive(Clone, Copy, Debug)]
pub struct Drawing<'a> {
    /// From local coordinates to the screen.
    pub screen: &'a ScreenTransform,
    /// Which sides are left out.
    pub cull: CullMode,
    /// Samples across the picture.
    pub width: i32,
    /// Samples down the picture.
    pub height: i32,
    /// Sub-pixels by which polygons are pulled in: see [`Edge::moved_in`](crate::triangle::Edge::moved_in).
    pub inset: i32,
    /// What is drawn already: small polygons that lie behind it are left out.
    pub drawn: LayeredTiles<'a>,
}

/// Memory to work in, kept from cluster to cluster.
#[derive(Clone, Debug)]
pub struct AssembleMemory {
    vertices: Vertices,
    set_up: SetUpMemory,
    /// The triangles of quadrilaterals that cannot be drawn as one.
    apart: Vec<[u8; 4]>,
}

impl Default for AssembleMemory {
    fn default() -> AssembleMemory {
        AssembleMemory {
            vertices: Vertices::default(),
            set_up: SetUpMemory::default(),
            apart: Vec::with_capacity(2 * MOST_QUADS),
        }
    }
}

/// Appends to `blocks` the polygons of a cluster that can cover a sample, and to `to_clip` the triangles that have to be
/// clipped.
///
/// # Panics
/// If the arrays differ in length, are too long or not padded or have fewer vertices than they should, or an index is out of
/// range.
pub fn assemble(
    level: Level,
    cluster: Cluster<'_>,
    drawing: Drawing<'_>,
    memory: &mut AssembleMemory,
    blocks: &mut SpanBlocks,
    to_clip: &mut Vec<[u8; 3]>,
) {
    assert!(
        cluster.x.len() == cluster.y.len()
            && cluster.x.len() == cluster.z.len()
            && cluster.x.len() <= MOST_VERTICES
            && cluster.vertices <= cluster.x.len()
            && cluster.x.len().is_multiple_of(VERTEX_PADDING)
            && cluster.quads.len() <= MOST_QUADS
    );
    match level.token() {
        None => assemble_plain(cluster, drawing, memory, blocks, to_clip),
        Some(token) => dispatch!(token, simd => assemble_vector(
            simd, cluster, drawing, memory, blocks, to_clip
        )),
    }
}

/// The triangles of the quadrilaterals that `which` names.
#[inline(always)]
fn take_apart(quads: &[[u8; 4]], mut which: u64, apart: &mut Vec<[u8; 4]>) {
    apart.clear();
    while which != 0 {
        let [a, b, c, d] = quads[which.trailing_zeros() as usize];
        which &= which - 1;
        apart.push([a, b, c, c]);
        if c != d {
            apart.push([a, c, d, d]);
        }
    }
}

fn assemble_plain(
    cluster: Cluster<'_>,
    drawing: Drawing<'_>,
    memory: &mut AssembleMemory,
    blocks: &mut SpanBlocks,
    to_clip: &mut Vec<[u8; 3]>,
) {
    let vertex = |i: usize| {
        let position = [cluster.x[i], cluster.y[i], cluster.z[i]];
        transform(drawing.screen, position)
    };
    let vertices: Vec<ClipVertex> = (0..cluster.vertices).map(vertex).collect();
    let quad = |corners: &[u8; 4]| {
        let corners = corners.map(|i| vertices[usize::from(i)]);
        if corners.iter().all(|v| v.is_too_near(drawing.screen)) {
            return Some(Quad::Nothing);
        }
        let [a, b, c, d] = corners.map(|v| v.is_inside(drawing.screen).then(|| v.snap()));
        let corners = [a?, b?, c?, d?];
        Some(Quad::new(
            corners,
            drawing.cull,
            drawing.width,
            drawing.height,
            drawing.inset,
        ))
    };
    let mut whole = Vec::new();
    let mut apart = 0;
    for (index, corners) in cluster.quads.iter().enumerate() {
        match quad(corners) {
            Some(Quad::Nothing) => {}
            Some(Quad::Whole(polygon)) if is_hidden(&polygon, drawing.drawn) => {}
            Some(Quad::Whole(polygon)) => whole.push(polygon),
            Some(Quad::Apart) | None => apart |= 1 << index,
        }
    }
    blocks.pack(whole.drain(..));
    take_apart(cluster.quads, apart, &mut memory.apart);
    for &corners in &memory.apart {
        match quad(&corners) {
            Some(Quad::Whole(polygon)) if is_hidden(&polygon, drawing.drawn) => {}
            Some(Quad::Whole(polygon)) => whole.push(polygon),
            // A triangle comes apart no further.
            Some(Quad::Nothing | Quad::Apart) => {}
            None => to_clip.push([corners[0], corners[1], corners[2]]),
        }
    }
    blocks.pack(whole.into_iter());
}

#[inline(always)]
fn assemble_vector<S: Simd>(
    simd: S,
    cluster: Cluster<'_>,
    drawing: Drawing<'_>,
    memory: &mut AssembleMemory,
    blocks: &mut SpanBlocks,
    to_clip: &mut Vec<[u8; 3]>,
) {
    let AssembleMemory {
        vertices,
        set_up,
        apart,
    } = memory;
    project(simd, cluster, drawing.screen, vertices);
    // First the quadrilaterals, then the triangles of those that came apart; in one loop, for there is a lot of code in it.
    let mut of_apart: Option<[usize; 2]> = None;
    loop {
        let quads = match of_apart {
            None => cluster.quads,
            Some([first, end]) => &apart[first..end],
        };
        let left = set_up_all(simd, quads, drawing, vertices, set_up, blocks);
        if of_apart.is_none() {
            take_apart(cluster.quads, left.apart | left.outside, apart);
        } else {
            let mut outside = left.outside;
            while outside != 0 {
                let [a, b, c, _] = quads[outside.trailing_zeros() as usize];
                outside &= outside - 1;
                to_clip.push([a, b, c]);
            }
        }
        let first = of_apart.map_or(0, |[_, end]| end);
        if first == apart.len() {
            return;
        }
        of_apart = Some([first, apart.len().min(first + MOST_QUADS)]);
    }
}

#[inline(always)]
fn set_up_all<S: Simd>(
    simd: S,
    quads: &[[u8; 4]],
    drawing: Drawing<'_>,
    vertices: &Vertices,
    memory: &mut SetUpMemory,
    blocks: &mut SpanBlocks,
) -> Left {
    let mut left = Left::default();
    let mut to_set_up = [0_u8; BLOCK];
    let mut waiting = 0;
    for (index, block) in quads.chunks(BLOCK).enumerate() {
        let first = index * BLOCK;
        let asked = reject(simd, block, drawing, vertices);
        left.apart |= asked.left.apart << first;
        left.outside |= asked.left.outside << first;
        let mut whole = asked.whole;
        while whole != 0 {
            let i = whole.trailing_zeros() as usize;
            whole &= whole - 1;
            to_set_up[waiting] = (first + i) as u8;
            waiting += 1;
            if waiting == BLOCK {
                left.apart |=
                    set_up_block(simd, quads, &to_set_up, drawing, vertices, memory, blocks);
                waiting = 0;
            }
        }
    }
    if waiting > 0 {
        let rest = &to_set_up[..waiting];
        left.apart |= set_up_block(simd, quads, rest, drawing, vertices, memory, blocks);
    }
    left
}
