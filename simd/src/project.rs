//! Projects a cluster's vertices and snaps them to the sub-pixel grid, as many at once as a vector of f64 holds.
//!
//! The plain form is [`transform`](crate::vertex::transform) and what [`ClipVertex`](crate::vertex::ClipVertex) makes of it.
//! Nearly always all vertices of a cluster are inside; only if not, it is found which.

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use crate::GUARD_BAND;
use crate::assemble::{Cluster, MOST_VERTICES};
use crate::vertex::ScreenTransform;

/// A bit for each vertex of a cluster.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VertexSet([u64; MOST_VERTICES / 64]);

impl VertexSet {
    const NONE: VertexSet = VertexSet([0; MOST_VERTICES / 64]);

    /// Whether it has all corners of a quadrilateral.
    #[inline(always)]
    pub(crate) fn has_all(&self, quad: [u8; 4]) -> bool {
        let has = |v: u8| self.0[usize::from(v) % MOST_VERTICES / 64] >> (v % 64) & 1 == 1;
        has(quad[0]) && has(quad[1]) && has(quad[2]) && has(quad[3])
    }

    /// Adds a vector of vertices that begins with number `at`: no vector reaches over two words.
    #[inline(always)]
    fn add(&mut self, vertices: u64, at: usize) {
        self.0[at / 64] |= vertices << (at % 64);
    }
}

/// As many as a byte can tell apart: an index needs no check.
const INDICES: usize = 1 + u8::MAX as usize;

/// A cluster's vertices on the sub-pixel grid.
#[derive(Clone, Debug)]
pub(crate) struct Vertices {
    /// Columns and rows in sub-pixels: whole numbers below 2²⁴, exact in f32.
    pub(crate) place: [[f32; 2]; INDICES],
    pub(crate) depth: [f64; INDICES],
    /// Whether all vertices can be used as they are. Only if not, the sets are known.
    pub(crate) all_inside: bool,
    /// Which vertices can be used as they are.
    pub(crate) inside: VertexSet,
    /// Which vertices lie in front of the near plane.
    pub(crate) too_near: VertexSet,
}

impl Default for Vertices {
    fn default() -> Vertices {
        Vertices {
            place: [[0.0; 2]; INDICES],
            depth: [0.0; INDICES],
            all_inside: true,
            inside: VertexSet::NONE,
            too_near: VertexSet::NONE,
        }
    }
}

/// A [`ScreenTransform`] for many positions at once.
#[derive(Clone, Copy)]
struct Rows<S: Simd> {
    x: [S::f64s; 4],
    y: [S::f64s; 4],
    depth: [S::f64s; 4],
    w: [S::f64s; 4],
    near_depth: f64,
    far_depth: f64,
    /// Whether D is the same everywhere, as it is in perspective without a far plane.
    is_depth_constant: bool,
    /// Whether there is a far plane to ask about.
    has_far: bool,
}

impl<S: Simd> Rows<S> {
    #[inline(always)]
    fn new(simd: S, t: &ScreenTransform) -> Rows<S> {
        let splat = |factor: f64| S::f64s::splat(simd, factor);
        let row = |r: &[f64; 4]| [splat(r[0]), splat(r[1]), splat(r[2]), splat(r[3])];
        let is_depth_constant = t.depth[..3] == [0.0; 3] && t.depth[3] > 0.0;
        Rows {
            x: row(&t.x),
            y: row(&t.y),
            depth: row(&t.depth),
            w: row(&t.w),
            near_depth: t.near_depth,
            far_depth: t.far_depth,
            is_depth_constant,
            // What is before the eye and has a depth above 0 is before a far plane of depth 0.
            has_far: t.far_depth != f64::NEG_INFINITY && !(is_depth_constant && t.far_depth == 0.0),
        }
    }

    #[inline(always)]
    fn product(r: &[S::f64s; 4], [x, y, z]: [S::f64s; 3]) -> S::f64s {
        x * r[0] + y * r[1] + z * r[2] + r[3]
    }

    /// [`transform`](crate::vertex::transform): X, Y, D and W. (The products of a position with zeros add nothing to D, or
    /// make the other sums something that is nowhere inside.)
    #[inline(always)]
    fn transform(&self, position: [S::f64s; 3]) -> [S::f64s; 4] {
        let depth = if self.is_depth_constant {
            self.depth[3]
        } else {
            Self::product(&self.depth, position)
        };
        [
            Self::product(&self.x, position),
            Self::product(&self.y, position),
            depth,
            Self::product(&self.w, position),
        ]
    }

    /// [`is_inside`](crate::vertex::ClipVertex::is_inside).
    #[inline(always)]
    fn are_inside(&self, [x, y, depth, w]: [S::f64s; 4]) -> S::mask64s {
        let simd = w.token();
        let band = w * f64::from(GUARD_BAND);
        let inside = w.simd_gt(S::f64s::splat(simd, 0.0))
            & band.simd_lt(S::f64s::splat(simd, f64::INFINITY))
            & depth.simd_le(w * self.near_depth)
            & x.abs().simd_le(band)
            & y.abs().simd_le(band);
        if self.has_far {
            inside & depth.simd_ge(w * self.far_depth)
        } else {
            inside
        }
    }
}

/// Positions from number `at`, as many as a vector of f32 holds: the first half and the second.
#[inline(always)]
pub(crate) fn positions<S: Simd>(simd: S, cluster: &Cluster<'_>, at: usize) -> [[S::f64s; 3]; 2] {
    let lanes = at..at + S::f32s::LEN;
    let x = S::f32s::from_slice(simd, &cluster.x[lanes.clone()]).widen();
    let y = S::f32s::from_slice(simd, &cluster.y[lanes.clone()]).widen();
    let z = S::f32s::from_slice(simd, &cluster.z[lanes]).widen();
    [[x.0, y.0, z.0], [x.1, y.1, z.1]]
}

/// Transforms and snaps all vertices of a cluster.
#[inline(always)]
pub(crate) fn project<S: Simd>(
    simd: S,
    cluster: Cluster<'_>,
    t: &ScreenTransform,
    vertices: &mut Vertices,
) {
    let rows = Rows::new(simd, t);
    let lanes = S::f64s::LEN;
    let one = S::f64s::splat(simd, 1.0);
    let mut inside = one.simd_gt(S::f64s::splat(simd, 0.0));
    for at in (0..cluster.vertices).step_by(2 * lanes) {
        let halves = positions(simd, &cluster, at);
        let places = &mut vertices.place.as_flattened_mut()[2 * at..2 * at + 4 * lanes];
        let depths = &mut vertices.depth[at..at + 2 * lanes];
        let mut columns = [one; 2];
        let mut lines = [one; 2];
        for half in 0..2 {
            let [x, y, depth, w] = rows.transform(halves[half]);
            inside &= rows.are_inside([x, y, depth, w]);
            let inverse = one / w;
            (depth * inverse).store_slice(&mut depths[half * lanes..(half + 1) * lanes]);
            columns[half] = (x * inverse + 0.5).floor();
            lines[half] = (y * inverse + 0.5).floor();
        }
        let columns = columns[0].narrow(columns[1]);
        let (low, high) = columns.interleave(lines[0].narrow(lines[1]));
        low.store_slice(&mut places[..2 * lanes]);
        high.store_slice(&mut places[2 * lanes..]);
    }
    vertices.all_inside = inside.all_true();
    if !vertices.all_inside {
        find_outside(simd, &cluster, t, vertices);
    }
}

/// Finds which vertices are not inside, where some are.
#[inline(always)]
fn find_outside<S: Simd>(
    simd: S,
    cluster: &Cluster<'_>,
    t: &ScreenTransform,
    vertices: &mut Vertices,
) {
    let rows = Rows {
        is_depth_constant: false,
        ..Rows::new(simd, t)
    };
    vertices.inside = VertexSet::NONE;
    vertices.too_near = VertexSet::NONE;
    for at in (0..cluster.vertices).step_by(S::f32s::LEN) {
        for (half, position) in positions(simd, cluster, at).into_iter().enumerate() {
            let at = at + half * S::f64s::LEN;
            let [x, y, depth, w] = rows.transform(position);
            let inside = rows.are_inside([x, y, depth, w]);
            let too_near = depth.simd_gt(w * t.near_depth);
            vertices.inside.add(inside.to_bitmask(), at);
            vertices.too_near.add(too_near.to_bitmask(), at);
        }
    }
}
