//! From a cluster's positions and indices to triangles that are ready to be filled, several at once.
//!
//! The plain form is [`transform`], [`Triangle::new`] and [`SpanTriangle::from`], vertex after vertex and triangle after
//! triangle. The vector form does the same operations in the same order on as many as a vector of f64 holds. Products of
//! two coordinate differences stay below 2⁴⁸ and their sums below 2⁵³, so what the plain form does in integers is exact
//! in f64 as well.
//!
//! A triangle with a vertex outside the near or far plane or the guard band is not set up here but named, for the caller
//! to clip.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};

use crate::query::Tiles;
use crate::spans::{BLOCK, HORIZONTAL, SpanBlock, SpanTriangle};
use crate::triangle::{CullMode, SLIVER, Triangle};
use crate::vertex::{ScreenTransform, ScreenVertex, transform};
use crate::{GUARD_BAND, Level, SUBPIXELS, TILE_SIZE};

/// The most vertices a cluster may have.
pub const MOST_VERTICES: usize = 128;

/// A vector loop reads this many vertices at once.
pub const VERTEX_PADDING: usize = 16;

/// Triangles with vertices of their own, structure of arrays.
#[derive(Clone, Copy, Debug)]
pub struct Cluster<'a> {
    /// Positions, local coordinates; padded with copies to a multiple of [`VERTEX_PADDING`], at most [`MOST_VERTICES`].
    pub x: &'a [f32],
    /// Likewise.
    pub y: &'a [f32],
    /// Likewise.
    pub z: &'a [f32],
    /// Three vertices each; counter-clockwise is the front.
    pub triangles: &'a [[u8; 3]],
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
    /// What is drawn already: small triangles that lie behind it are left out, since filling them would change nothing.
    pub drawn: Tiles<'a>,
}

/// A cluster's vertices on the sub-pixel grid; kept from cluster to cluster.
#[derive(Clone, Debug)]
pub struct Vertices {
    /// Columns and rows in sub-pixels: whole numbers below 2²⁴, exact in f32.
    place: [[f32; 2]; MOST_VERTICES],
    depth: [f64; MOST_VERTICES],
    /// Bit `i` is set where vertex `i` can be used as it is.
    inside: u128,
}

impl Default for Vertices {
    fn default() -> Vertices {
        Vertices {
            place: [[0.0; 2]; MOST_VERTICES],
            depth: [0.0; MOST_VERTICES],
            inside: 0,
        }
    }
}

/// Appends to `blocks` the triangles of a cluster that can cover a sample, in their order, and to `to_clip` the places in
/// the cluster of those that have to be clipped.
///
/// # Panics
/// If the arrays differ in length, are not padded, or an index is out of range.
pub fn assemble(
    level: Level,
    cluster: Cluster<'_>,
    drawing: Drawing<'_>,
    vertices: &mut Vertices,
    blocks: &mut Vec<SpanBlock>,
    to_clip: &mut Vec<u8>,
) {
    assert!(
        cluster.x.len() == cluster.y.len()
            && cluster.x.len() == cluster.z.len()
            && cluster.x.len() <= MOST_VERTICES
            && cluster.x.len().is_multiple_of(VERTEX_PADDING)
    );
    match level.token() {
        None => assemble_plain(cluster, drawing, blocks, to_clip),
        Some(token) => dispatch!(token, simd => assemble_vector(
            simd, cluster, drawing, vertices, blocks, to_clip
        )),
    }
}

fn assemble_plain(
    cluster: Cluster<'_>,
    drawing: Drawing<'_>,
    blocks: &mut Vec<SpanBlock>,
    to_clip: &mut Vec<u8>,
) {
    let vertex = |i: usize| {
        let position = [cluster.x[i], cluster.y[i], cluster.z[i]];
        let v = transform(drawing.screen, position);
        v.is_inside(drawing.screen).then(|| v.snap())
    };
    let vertices: Vec<Option<ScreenVertex>> = (0..cluster.x.len()).map(vertex).collect();
    let mut set_up = Vec::new();
    for (index, triangle) in cluster.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|i| vertices[usize::from(i)]);
        if let (Some(a), Some(b), Some(c)) = (a, b, c) {
            let triangle = Triangle::new([a, b, c], drawing.cull)
                .and_then(|t| t.within(drawing.width, drawing.height));
            set_up.extend(triangle.as_ref().map(SpanTriangle::from));
        } else {
            to_clip.push(index as u8);
        }
    }
    SpanBlock::pack(set_up.into_iter(), blocks);
}

#[inline(always)]
fn assemble_vector<S: Simd>(
    simd: S,
    cluster: Cluster<'_>,
    drawing: Drawing<'_>,
    vertices: &mut Vertices,
    blocks: &mut Vec<SpanBlock>,
    to_clip: &mut Vec<u8>,
) {
    project(simd, cluster, drawing.screen, vertices);
    let mut to_set_up = [0_u8; BLOCK];
    let mut waiting = 0;
    for (index, triangles) in cluster.triangles.chunks(BLOCK).enumerate() {
        let mut drawn =
            visible_of_block(simd, triangles, index * BLOCK, drawing, vertices, to_clip);
        while drawn != 0 {
            let i = drawn.trailing_zeros() as usize;
            drawn &= drawn - 1;
            to_set_up[waiting] = (index * BLOCK + i) as u8;
            waiting += 1;
            if waiting == BLOCK {
                set_up_block(
                    simd,
                    cluster.triangles,
                    &to_set_up,
                    drawing,
                    vertices,
                    blocks,
                );
                waiting = 0;
            }
        }
    }
    if waiting > 0 {
        set_up_block(
            simd,
            cluster.triangles,
            &to_set_up[..waiting],
            drawing,
            vertices,
            blocks,
        );
    }
}

/// Which triangles of a block face the right way, have a sample between their extremes, and are not hidden by what is
/// drawn already. `first` is the place of the block in the cluster.
#[inline(always)]
fn visible_of_block<S: Simd>(
    simd: S,
    triangles: &[[u8; 3]],
    first: usize,
    drawing: Drawing<'_>,
    vertices: &Vertices,
    to_clip: &mut Vec<u8>,
) -> u64 {
    let mut places = [[[0.0; 2]; BLOCK]; 3];
    for (i, triangle) in triangles.iter().enumerate() {
        for (places, &vertex) in places.iter_mut().zip(triangle) {
            places[i] = vertices.place[usize::from(vertex) % MOST_VERTICES];
        }
    }
    let mut candidates = (1_u64 << triangles.len()) - 1;
    if vertices.inside != u128::MAX {
        for (i, triangle) in triangles.iter().enumerate() {
            if !triangle.iter().all(|v| vertices.inside >> v & 1 == 1) {
                candidates &= !(1 << i);
                to_clip.push((first + i) as u8);
            }
        }
    }
    let mut columns = [[0.0; BLOCK]; 2];
    let mut rows = [[0.0; BLOCK]; 2];
    let mut drawn = 0;
    for lane in (0..BLOCK).step_by(S::f32s::LEN) {
        drawn |= extents(simd, &places, lane, drawing, &mut columns, &mut rows) << lane;
    }
    drawn &= candidates;
    let mut left = drawn;
    while left != 0 {
        let i = left.trailing_zeros() as usize;
        left &= left - 1;
        let tiles = |s: [[f32; BLOCK]; 2]| s.map(|s| s[i] as i32 / TILE_SIZE);
        let ([x0, x1], [y0, y1]) = (tiles(columns), tiles(rows));
        if x1 - x0 < 2 && y1 - y0 < 2 {
            let [a, b, c] = triangles[i].map(|v| vertices.depth[usize::from(v) % MOST_VERTICES]);
            let nearest = greater(greater(a, b), c) as f32;
            let hidden = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)]
                .iter()
                .all(|&(x, y)| drawing.drawn.is_full_before(x, y, nearest));
            drawn &= !(u64::from(hidden) << i);
        }
    }
    drawn
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Finds first and last columns and rows of the triangles from `lane` of a block, as many as a vector of f32 holds, and
/// which of them may cover a sample.
#[inline(always)]
fn extents<S: Simd>(
    simd: S,
    places: &[[[f32; 2]; BLOCK]; 3],
    lane: usize,
    drawing: Drawing<'_>,
    columns: &mut [[f32; BLOCK]; 2],
    rows: &mut [[f32; BLOCK]; 2],
) -> u64 {
    let [x0, y0] = coordinates::<S>(simd, &places[0], lane);
    let [x1, y1] = coordinates::<S>(simd, &places[1], lane);
    let [x2, y2] = coordinates::<S>(simd, &places[2], lane);
    let range = lane..(lane + S::f32s::LEN).min(BLOCK);
    let per_subpixel = 1.0 / SUBPIXELS as f32;
    let zero = S::f32s::splat(simd, 0.0);
    let first_x = (x0.min(x1).min(x2) * per_subpixel - 0.5).ceil().max(zero);
    let first_y = (y0.min(y1).min(y2) * per_subpixel - 0.5).ceil().max(zero);
    let right = S::f32s::splat(simd, (drawing.width - 1) as f32);
    let bottom = S::f32s::splat(simd, (drawing.height - 1) as f32);
    let last_x = (x0.max(x1).max(x2) * per_subpixel - 0.5).floor().min(right);
    let last_y = (y0.max(y1).max(y2) * per_subpixel - 0.5)
        .floor()
        .min(bottom);
    let sampled = first_x.simd_le(last_x) & first_y.simd_le(last_y);
    let len = range.len();
    columns[0][range.clone()].copy_from_slice(&first_x.as_slice()[..len]);
    columns[1][range.clone()].copy_from_slice(&last_x.as_slice()[..len]);
    rows[0][range.clone()].copy_from_slice(&first_y.as_slice()[..len]);
    rows[1][range].copy_from_slice(&last_y.as_slice()[..len]);
    let (ax, bx) = ((x1 - x0).widen(), (x2 - x0).widen());
    let (ay, by) = ((y1 - y0).widen(), (y2 - y0).widen());
    let faces = faces::<S>(simd, ax.0 * by.0 - bx.0 * ay.0, drawing.cull)
        | faces::<S>(simd, ax.1 * by.1 - bx.1 * ay.1, drawing.cull) << S::f64s::LEN;
    sampled.to_bitmask() & faces
}

/// Which of twice the areas belong to triangles that are drawn.
#[inline(always)]
fn faces<S: Simd>(simd: S, area: S::f64s, cull: CullMode) -> u64 {
    let zero = S::f64s::splat(simd, 0.0);
    match cull {
        CullMode::None => (area.simd_lt(zero) | area.simd_gt(zero)).to_bitmask(),
        CullMode::Back => area.simd_lt(zero).to_bitmask(),
        CullMode::Front => area.simd_gt(zero).to_bitmask(),
    }
}

#[inline(always)]
fn coordinates<S: Simd>(simd: S, places: &[[f32; 2]; BLOCK], lane: usize) -> [S::f32s; 2] {
    let flat = places.as_flattened();
    let lanes = S::f32s::LEN;
    if lanes > BLOCK {
        // One block fills half of a vector.
        let both = S::f32s::from_slice(simd, flat);
        let (x, y) = both.deinterleave(both);
        return [x, y];
    }
    let low = S::f32s::from_slice(simd, &flat[2 * lane..2 * lane + lanes]);
    let high = S::f32s::from_slice(simd, &flat[2 * lane + lanes..2 * lane + 2 * lanes]);
    let (x, y) = low.deinterleave(high);
    [x, y]
}

/// Appends a block of the triangles of a cluster that are named.
#[inline(always)]
fn set_up_block<S: Simd>(
    simd: S,
    triangles: &[[u8; 3]],
    named: &[u8],
    drawing: Drawing<'_>,
    vertices: &Vertices,
    blocks: &mut Vec<SpanBlock>,
) {
    let mut corners = [[[0.0; BLOCK]; 3]; 3];
    for (i, &triangle) in named.iter().enumerate() {
        for (corner, &vertex) in triangles[usize::from(triangle)].iter().enumerate() {
            let vertex = usize::from(vertex) % MOST_VERTICES;
            let [x, y] = vertices.place[vertex];
            corners[0][corner][i] = f64::from(x);
            corners[1][corner][i] = f64::from(y);
            corners[2][corner][i] = vertices.depth[vertex];
        }
    }
    blocks.push(SpanBlock::EMPTY);
    if let Some(block) = blocks.last_mut() {
        block.present = ((1_u16 << named.len()) - 1) as u8;
        for first in (0..named.len()).step_by(S::f64s::LEN) {
            set_up(simd, &corners, first, drawing, block);
        }
    }
}

#[inline(always)]
fn row<S: Simd>(r: &[f64; 4], x: S::f64s, y: S::f64s, z: S::f64s) -> S::f64s {
    x * r[0] + y * r[1] + z * r[2] + r[3]
}

/// Transforms and snaps all vertices of a cluster.
#[inline(always)]
fn project<S: Simd>(simd: S, cluster: Cluster<'_>, t: &ScreenTransform, vertices: &mut Vertices) {
    let lanes = S::f64s::LEN;
    vertices.inside = 0;
    for at in (0..cluster.x.len()).step_by(2 * lanes) {
        let x = S::f32s::from_slice(simd, &cluster.x[at..at + 2 * lanes]).widen();
        let y = S::f32s::from_slice(simd, &cluster.y[at..at + 2 * lanes]).widen();
        let z = S::f32s::from_slice(simd, &cluster.z[at..at + 2 * lanes]).widen();
        let [x_low, y_low] = project_lanes(simd, [x.0, y.0, z.0], t, vertices, at);
        let [x_high, y_high] = project_lanes(simd, [x.1, y.1, z.1], t, vertices, at + lanes);
        let (low, high) = x_low.narrow(x_high).interleave(y_low.narrow(y_high));
        let places = vertices.place[at..at + 2 * lanes].as_flattened_mut();
        low.store_slice(&mut places[..2 * lanes]);
        high.store_slice(&mut places[2 * lanes..]);
    }
    // Vertices that there are none of are no reason to look for outsiders.
    let count = cluster.x.len();
    if count < MOST_VERTICES {
        vertices.inside |= u128::MAX << count;
    }
}

#[inline(always)]
fn project_lanes<S: Simd>(
    simd: S,
    [px, py, pz]: [S::f64s; 3],
    t: &ScreenTransform,
    vertices: &mut Vertices,
    at: usize,
) -> [S::f64s; 2] {
    let x = row::<S>(&t.x, px, py, pz);
    let y = row::<S>(&t.y, px, py, pz);
    let depth = row::<S>(&t.depth, px, py, pz);
    let w = row::<S>(&t.w, px, py, pz);
    let zero = S::f64s::splat(simd, 0.0);
    let band = w * f64::from(GUARD_BAND);
    let mut inside = w.simd_gt(zero)
        & band.simd_lt(S::f64s::splat(simd, f64::INFINITY))
        & depth.simd_le(w * t.near_depth)
        & x.abs().simd_le(band)
        & y.abs().simd_le(band);
    if t.far_depth != f64::NEG_INFINITY {
        inside &= depth.simd_ge(w * t.far_depth);
    }
    vertices.inside |= u128::from(inside.to_bitmask()) << at;
    let inverse = S::f64s::splat(simd, 1.0) / w;
    let range = at..at + S::f64s::LEN;
    (depth * inverse).store_slice(&mut vertices.depth[range]);
    [(x * inverse + 0.5).floor(), (y * inverse + 0.5).floor()]
}

#[inline(always)]
fn least<S: Simd>(a: S::f64s, b: S::f64s) -> S::f64s {
    b.simd_lt(a).select(b, a)
}

#[inline(always)]
fn largest<S: Simd>(a: S::f64s, b: S::f64s) -> S::f64s {
    b.simd_gt(a).select(b, a)
}

/// Crossings of an edge, and whether its inside lies on the right.
struct Crossing<S: Simd> {
    slope: S::f64s,
    at_zero: S::f64s,
    is_lower: S::mask64s,
}

/// The edge from `a` to `b`: see [`crate::triangle`] and [`crate::spans`].
#[inline(always)]
fn crossing<S: Simd>(simd: S, a: [S::f64s; 2], b: [S::f64s; 2]) -> Crossing<S> {
    let zero = S::f64s::splat(simd, 0.0);
    let ea = a[1] - b[1];
    let eb = b[0] - a[0];
    let is_horizontal = ea.simd_eq(zero);
    let keeps_border = ea.simd_gt(zero) | (is_horizontal & eb.simd_gt(zero));
    let bias = keeps_border.select(zero, S::f64s::splat(simd, -1.0));
    let half = f64::from(SUBPIXELS / 2);
    let c = (ea + eb) * half - (ea * a[0] + eb * a[1]) + bias;
    let c = (c * (1.0 / f64::from(SUBPIXELS))).floor();
    let inverse = is_horizontal.select(
        S::f64s::splat(simd, HORIZONTAL),
        S::f64s::splat(simd, 1.0) / ea,
    );
    Crossing {
        slope: -eb * inverse,
        at_zero: -(c + 0.5) * inverse,
        is_lower: ea.simd_ge(zero),
    }
}

/// Stores the first and the last edge with its inside on the right, and likewise on the left: [`Spans::between`].
///
/// [`Spans::between`]: crate::spans::Spans::between
#[inline(always)]
fn store_by_side<S: Simd>(
    [l0, l1, l2]: [S::mask64s; 3],
    [a, b, c]: [S::f64s; 3],
    edges: &mut [[f64; BLOCK]; 4],
    first: usize,
) {
    let range = first..first + S::f64s::LEN;
    let [e0, e1, e2, e3] = edges;
    l0.select(a, l1.select(b, c))
        .store_slice(&mut e0[range.clone()]);
    l2.select(c, l1.select(b, a))
        .store_slice(&mut e1[range.clone()]);
    l0.select(l1.select(c, b), a)
        .store_slice(&mut e2[range.clone()]);
    l2.select(l1.select(a, b), c).store_slice(&mut e3[range]);
}

/// Sets up the triangles from place `first` of a block, as many as a vector holds.
#[inline(always)]
fn set_up<S: Simd>(
    simd: S,
    corners: &[[[f64; BLOCK]; 3]; 3],
    first: usize,
    drawing: Drawing<'_>,
    block: &mut SpanBlock,
) {
    let range = first..first + S::f64s::LEN;
    let zero = S::f64s::splat(simd, 0.0);
    let x0 = S::f64s::from_slice(simd, &corners[0][0][range.clone()]);
    let x1 = S::f64s::from_slice(simd, &corners[0][1][range.clone()]);
    let x2 = S::f64s::from_slice(simd, &corners[0][2][range.clone()]);
    let y0 = S::f64s::from_slice(simd, &corners[1][0][range.clone()]);
    let y1 = S::f64s::from_slice(simd, &corners[1][1][range.clone()]);
    let y2 = S::f64s::from_slice(simd, &corners[1][2][range.clone()]);
    let area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
    let least_x = least::<S>(least::<S>(x0, x1), x2);
    let largest_x = largest::<S>(largest::<S>(x0, x1), x2);
    let least_y = least::<S>(least::<S>(y0, y1), y2);
    let largest_y = largest::<S>(largest::<S>(y0, y1), y2);
    let per_subpixel = 1.0 / f64::from(SUBPIXELS);
    let first_x = largest::<S>((least_x * per_subpixel - 0.5).ceil(), zero);
    let first_y = largest::<S>((least_y * per_subpixel - 0.5).ceil(), zero);
    let last_x = least::<S>(
        (largest_x * per_subpixel - 0.5).floor(),
        S::f64s::splat(simd, f64::from(drawing.width - 1)),
    );
    let last_y = least::<S>(
        (largest_y * per_subpixel - 0.5).floor(),
        S::f64s::splat(simd, f64::from(drawing.height - 1)),
    );
    let d0 = S::f64s::from_slice(simd, &corners[2][0][range.clone()]);
    let d1 = S::f64s::from_slice(simd, &corners[2][1][range.clone()]);
    let d2 = S::f64s::from_slice(simd, &corners[2][2][range.clone()]);
    let flip = area.simd_lt(zero);
    let (x1, x2) = (flip.select(x2, x1), flip.select(x1, x2));
    let (y1, y2) = (flip.select(y2, y1), flip.select(y1, y2));
    let (d1, d2) = (flip.select(d2, d1), flip.select(d1, d2));
    let area = area.abs();

    let e0 = crossing(simd, [x0, y0], [x1, y1]);
    let e1 = crossing(simd, [x1, y1], [x2, y2]);
    let e2 = crossing(simd, [x2, y2], [x0, y0]);
    let sides = [e0.is_lower, e1.is_lower, e2.is_lower];
    store_by_side::<S>(
        sides,
        [e0.slope, e1.slope, e2.slope],
        &mut block.slope,
        first,
    );
    store_by_side::<S>(
        sides,
        [e0.at_zero, e1.at_zero, e2.at_zero],
        &mut block.at_zero,
        first,
    );
    first_x.store_slice(&mut block.x[0][range.clone()]);
    last_x.store_slice(&mut block.x[1][range.clone()]);
    first_y.store_slice(&mut block.y[0][range.clone()]);
    last_y.store_slice(&mut block.y[1][range.clone()]);

    // The depth plane: `DepthPlane::through`.
    let farthest = least::<S>(least::<S>(d0, d1), d2);
    let nearest = largest::<S>(largest::<S>(d0, d1), d2);
    let is_sliver = ((largest_x - least_x) * (largest_y - least_y)).simd_gt(area * SLIVER);
    let per_sample = S::f64s::splat(simd, f64::from(SUBPIXELS)) / area;
    let (d1, d2) = (d1 - d0, d2 - d0);
    let slope_x = (d1 * (y2 - y0) - d2 * (y1 - y0)) * per_sample;
    let slope_y = (d2 * (x1 - x0) - d1 * (x2 - x0)) * per_sample;
    ((x0 - f64::from(SUBPIXELS / 2)) * per_subpixel)
        .store_slice(&mut block.origin_x[range.clone()]);
    ((y0 - f64::from(SUBPIXELS / 2)) * per_subpixel)
        .store_slice(&mut block.origin_y[range.clone()]);
    is_sliver
        .select(farthest, d0)
        .store_slice(&mut block.depth[range.clone()]);
    is_sliver
        .select(zero, slope_x)
        .store_slice(&mut block.slope_x[range.clone()]);
    is_sliver
        .select(zero, slope_y)
        .store_slice(&mut block.slope_y[range.clone()]);
    farthest.store_slice(&mut block.farthest[range.clone()]);
    nearest.store_slice(&mut block.nearest[range]);
}
