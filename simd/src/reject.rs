//! Which quadrilaterals of a cluster need no set-up: those that face away, that have no sample between their extremes or,
//! if they are tiny, inside, or that lie behind what is drawn already.
//!
//! Extents are found in f32, where coordinates on the grid are exact: a sample between the extremes is not lost. Areas are
//! found in f32 too, which nearly always tells their signs. Those of a tiny quadrilateral's corners, counted from its first
//! sample, are whole numbers below 2²², and so are its edge functions at its samples.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};

use crate::assemble::Drawing;
use crate::closer::LayeredTiles;
use crate::coverage::rectangle_mask;
use crate::order::greater;
use crate::project::Vertices;
use crate::quad::TINY;
use crate::set_up::{coordinates, extent};
use crate::spans::{BLOCK, SpanPolygon};
use crate::triangle::CullMode;
use crate::{SUBPIXELS, TILE_SIZE};

/// The quadrilaterals of a list that were not set up: bit `i` for number `i`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Left {
    /// Those that cannot be drawn as one.
    pub(crate) apart: u64,
    /// Those with a vertex that cannot be used as it is.
    pub(crate) outside: u64,
}

/// What is known of the quadrilaterals of a block before they are set up.
pub(crate) struct Asked {
    /// Those that may be drawn as one, and are not hidden.
    pub(crate) whole: u64,
    pub(crate) left: Left,
}

/// Which quadrilaterals of a block face the right way, have a sample between their extremes, and are not hidden by what
/// is drawn already.
#[inline(always)]
pub(crate) fn reject<S: Simd>(
    simd: S,
    quads: &[[u8; 4]],
    drawing: Drawing<'_>,
    vertices: &Vertices,
) -> Asked {
    let mut places = [[[0.0; 2]; BLOCK]; 4];
    for (i, &[a, b, c, d]) in quads.iter().take(BLOCK).enumerate() {
        places[0][i] = vertices.place[usize::from(a)];
        places[1][i] = vertices.place[usize::from(b)];
        places[2][i] = vertices.place[usize::from(c)];
        places[3][i] = vertices.place[usize::from(d)];
    }
    let mut left = Left::default();
    let mut candidates = (1_u64 << quads.len()) - 1;
    if !vertices.all_inside {
        for (i, &quad) in quads.iter().enumerate() {
            if !vertices.inside.has_all(quad) {
                candidates &= !(1 << i);
                left.outside |= u64::from(!vertices.too_near.has_all(quad)) << i;
            }
        }
    }
    let mut extents = Extents::default();
    let Lanes {
        drawn,
        convex,
        small,
        empty,
    } = look_at(simd, &places, candidates, drawing, &mut extents);
    let drawn = drawn & candidates;
    left.apart = drawn & !convex;
    let mut whole = drawn & convex & !empty;
    let mut to_ask = whole & small;
    while to_ask != 0 {
        let i = to_ask.trailing_zeros() as usize;
        to_ask &= to_ask - 1;
        let drawn = drawing.drawn;
        let [left, right] = extents
            .columns
            .each_ref()
            .map(|c| COLUMNS[c[i] as usize % 64]);
        let [upper, lower] = extents.rows.each_ref().map(|r| ROWS[r[i] as usize % 64]);
        let first = extents.first[i] as usize;
        // Most are not, and that is known before anything else.
        if left & upper & !drawn.coverage[first] != 0 {
            continue;
        }
        let [a, b, c, d] = quads[i];
        let depth = |v: u8| vertices.depth[usize::from(v)];
        let nearest = greater(greater(depth(a), depth(b)), greater(depth(c), depth(d))) as f32;
        let (to_right, down) = (extents.to_right[i] as usize, extents.down[i] as usize);
        let hidden = drawn.hides(first, left & upper, nearest)
            && (to_right + down == 0
                || drawn.hides(first + to_right, right & upper, nearest)
                    && drawn.hides(first + down, left & lower, nearest)
                    && drawn.hides(first + to_right + down, right & lower, nearest));
        whole &= !(u64::from(hidden) << i);
    }
    Asked { whole, left }
}

/// The plain form of what is asked about what is drawn: whether a polygon reaches over no more than two columns and two
/// rows of tiles, and they show nothing farther than its nearest corner at any sample between its extremes.
pub(crate) fn is_hidden(polygon: &SpanPolygon, drawn: LayeredTiles<'_>) -> bool {
    let [columns, rows] = [polygon.x, polygon.y].map(|v| v.map(|v| v / TILE_SIZE));
    let within = |samples: [i32; 2], tile: i32| {
        let from = tile * TILE_SIZE;
        [
            (samples[0] - from).max(0),
            (samples[1] - from).min(TILE_SIZE - 1),
        ]
    };
    columns[1] - columns[0] < 2
        && rows[1] - rows[0] < 2
        && (rows[0]..=rows[1]).all(|row| {
            (columns[0]..=columns[1]).all(|column| {
                let mask = rectangle_mask(within(polygon.x, column), within(polygon.y, row));
                let tile = row as usize * drawn.across + column as usize;
                drawn.hides(tile, mask, polygon.depth.nearest)
            })
        })
}

/// The samples of a tile in its columns from `first` to `last`, at `8·first + last`; none at 8.
const COLUMNS: [u64; 64] = {
    let mut masks = [0; 64];
    let mut i = 0;
    while i < 64 {
        let (first, last) = (i / 8, i % 8);
        if first <= last {
            masks[i] = (0xff >> (7 - last) & 0xff << first) * 0x0101_0101_0101_0101;
        }
        i += 1;
    }
    masks
};

/// Likewise in its rows.
const ROWS: [u64; 64] = {
    let mut masks = [0; 64];
    let mut i = 0;
    while i < 64 {
        let (first, last) = (i / 8, i % 8);
        if first <= last {
            masks[i] = u64::MAX >> (8 * (7 - last)) & u64::MAX << (8 * first);
        }
        i += 1;
    }
    masks
};

/// Where polygons lie that reach over no more than two columns and two rows of tiles.
#[derive(Default)]
struct Extents {
    /// The upper left tile.
    first: [i32; BLOCK],
    /// From there to the tile on the right.
    to_right: [i32; BLOCK],
    /// From there to the tile below.
    down: [i32; BLOCK],
    /// Which samples of the left and of the right tiles: indices into [`COLUMNS`].
    columns: [[i32; BLOCK]; 2],
    /// Which samples of the upper and of the lower tiles: indices into [`ROWS`].
    rows: [[i32; BLOCK]; 2],
}

/// What is known of the quadrilaterals of a block: a bit for each.
struct Lanes {
    /// There may be a sample in one of the triangles.
    drawn: u64,
    /// No corner is turned inwards.
    convex: u64,
    /// [`Extents`] has it.
    small: u64,
    /// It is tiny and covers no sample.
    empty: u64,
}

/// Looks at the quadrilaterals of a block, of which those that are `candidates` matter.
#[inline(always)]
fn look_at<S: Simd>(
    simd: S,
    places: &[[[f32; 2]; BLOCK]; 4],
    candidates: u64,
    drawing: Drawing<'_>,
    extents: &mut Extents,
) -> Lanes {
    let [x0, y0] = coordinates(simd, &places[0]);
    let [x1, y1] = coordinates(simd, &places[1]);
    let [x2, y2] = coordinates(simd, &places[2]);
    let [x3, y3] = coordinates(simd, &places[3]);
    let (width, [first_x, last_x]) = extent([x0, x1, x2, x3], drawing.width, drawing.inset);
    let (height, [first_y, last_y]) = extent([y0, y1, y2, y3], drawing.height, drawing.inset);
    let sampled = first_x.simd_le(last_x) & first_y.simd_le(last_y);

    let (per_sample, size) = (1.0 / TILE_SIZE as f32, TILE_SIZE as f32);
    let two = f32x8::splat(simd, 2.0);
    let first_column = (first_x * per_sample).floor();
    let first_row = (first_y * per_sample).floor();
    let to_right = (last_x * per_sample).floor() - first_column;
    let down = (last_y * per_sample).floor() - first_row;
    let small = to_right.simd_lt(two) & down.simd_lt(two) & sampled;
    let (left, top) = (first_column * size, first_row * size);
    let columns = within_tiles::<S>(simd, first_x - left, last_x - left);
    let rows = within_tiles::<S>(simd, first_y - top, last_y - top);
    // Numbers of tiles are exact in f32: there are less than 2²⁴.
    let across = drawing.drawn.across as f32;
    store_whole(simd, first_row * across + first_column, &mut extents.first);
    store_whole(simd, to_right, &mut extents.to_right);
    store_whole(simd, down * across, &mut extents.down);
    store_whole(simd, columns[0], &mut extents.columns[0]);
    store_whole(simd, columns[1], &mut extents.columns[1]);
    store_whole(simd, rows[0], &mut extents.rows[0]);
    store_whole(simd, rows[1], &mut extents.rows[1]);

    let limit = f32x8::splat(simd, TINY as f32);
    let tiny = width.simd_le(limit)
        & height.simd_le(limit)
        & (last_x - first_x).simd_lt(two)
        & (last_y - first_y).simd_lt(two)
        & sampled;
    let empty = if tiny.any_true() {
        let (x, y) = ([x0, x1, x2, x3], [y0, y1, y2, y3]);
        let first = [first_x, first_y];
        let covered = is_covered::<S>(simd, x, y, first, [last_x, last_y], drawing.inset);
        (tiny & !covered).to_bitmask()
    } else {
        0
    };

    let corners = [[x1 - x0, y1 - y0], [x2 - x0, y2 - y0], [x3 - x0, y3 - y0]];
    let [turned, convex] = facing(simd, corners, width * height, candidates, drawing.cull);
    Lanes {
        drawn: sampled.to_bitmask() & turned,
        convex,
        small: small.to_bitmask(),
        empty,
    }
}

/// Whether convex quadrilaterals cover one of the samples in the first or the last column, and the first or the last row.
#[inline(always)]
fn is_covered<S: Simd>(
    simd: S,
    [x0, x1, x2, x3]: [f32x8<S>; 4],
    [y0, y1, y2, y3]: [f32x8<S>; 4],
    [first_x, first_y]: [f32x8<S>; 2],
    [last_x, last_y]: [f32x8<S>; 2],
    inset: i32,
) -> mask32x8<S> {
    let zero = f32x8::splat(simd, 0.0);
    let per_sample = SUBPIXELS as f32;
    let (x, y) = (first_x + 0.5, first_y + 0.5);
    let (x, y) = (x * per_sample, y * per_sample);
    // Clockwise.
    let turn = ((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)).simd_lt(zero);
    let a = [x0 - x, y0 - y];
    let b = [turn.select(x3, x1) - x, turn.select(y3, y1) - y];
    let c = [x2 - x, y2 - y];
    let d = [turn.select(x1, x3) - x, turn.select(y1, y3) - y];
    let step = [
        (last_x - first_x) * per_sample,
        (last_y - first_y) * per_sample,
    ];
    let ab = edge_at_samples::<S>(simd, a, b, step, inset);
    let bc = edge_at_samples::<S>(simd, b, c, step, inset);
    let cd = edge_at_samples::<S>(simd, c, d, step, inset);
    let da = edge_at_samples::<S>(simd, d, a, step, inset);
    // The least edge function at each sample, and the largest of these.
    let mut most = f32x8::splat(simd, -1.0);
    for at in 0..4 {
        most = most.max(ab[at].min(bc[at]).min(cd[at].min(da[at])));
    }
    most.simd_ge(zero)
}

/// The functions of the edges from `a` to `b`, with corners counted from a first sample: there, on the right, below, and on
/// the right below. See [`Edge::between`](crate::triangle::Edge::between).
#[inline(always)]
fn edge_at_samples<S: Simd>(
    simd: S,
    a: [f32x8<S>; 2],
    b: [f32x8<S>; 2],
    step: [f32x8<S>; 2],
    inset: i32,
) -> [f32x8<S>; 4] {
    let (ea, eb) = (a[1] - b[1], b[0] - a[0]);
    let at_first = a[0] * b[1] - b[0] * a[1];
    // Left edges and top ones: the first factor decides unless it is zero.
    let keeps_border = (ea * (2 * TINY) as f32 + eb).simd_ge(f32x8::splat(simd, 0.0));
    let at_first = keeps_border.select(at_first, at_first - 1.0);
    let per_sample = SUBPIXELS as f32;
    let moved = (ea.abs() + eb.abs()) * (inset as f32 / per_sample);
    let at_first = at_first - moved.ceil() * per_sample;
    let at_right = at_first + ea * step[0];
    let below = eb * step[1];
    [at_first, at_right, at_first + below, at_right + below]
}

/// The indices into [`COLUMNS`] or [`ROWS`] of samples that are counted from the corner of the first of two tiles.
#[inline(always)]
fn within_tiles<S: Simd>(simd: S, first: f32x8<S>, last: f32x8<S>) -> [f32x8<S>; 2] {
    let size = f32x8::splat(simd, TILE_SIZE as f32);
    [
        first * size + last.min(size - 1.0),
        last.simd_ge(size).select(last - size, size),
    ]
}

#[inline(always)]
fn store_whole<S: Simd>(simd: S, v: f32x8<S>, into: &mut [i32; BLOCK]) {
    simd.cvt_i32_f32x8(v).store_array(into);
}

/// Areas are exact in f32 where the box around the corners has less than this, for no product is larger, nor twice any
/// triangle. (The sum of two may then be rounded if it is larger, but by 1, where 2 or more are left of it when the third is
/// taken off.)
const EXACT: f32 = (1 << 24) as f32;

/// How far areas may be off in f32, as a part of the area of the box around the corners. No product is larger than that, nor
/// is twice the area of any triangle. In units of 2⁻²⁴ of it, a difference of two products is off by 4, and a sum of three such
/// by 12 and 5 more.
const AREA_ERROR: f32 = 1.0 / (1 << 19) as f32;

/// Of quadrilaterals, by what leads from the first corner to the others: which have a triangle that is drawn, and which
/// of these may be drawn as one.
#[inline(always)]
fn facing<S: Simd>(
    simd: S,
    [b, c, d]: [[f32x8<S>; 2]; 3],
    box_area: f32x8<S>,
    candidates: u64,
    cull: CullMode,
) -> [u64; 2] {
    let first = b[0] * c[1] - c[0] * b[1];
    let second = c[0] * d[1] - d[0] * c[1];
    let third = b[0] * d[1] - d[0] * b[1];
    let fourth = first + second - third;
    // A triangle's other areas come out as 0, or as the first.
    let is_triangle = c[0].simd_eq(d[0]) & c[1].simd_eq(d[1]);
    let least = first.abs().min(third.abs());
    let least = is_triangle.select(least, least.min(second.abs()).min(fourth.abs()));
    let is_certain = box_area.simd_lt(EXACT) | least.simd_gt(box_area * AREA_ERROR);
    if !is_certain.to_bitmask() & candidates != 0 {
        let arrays = |v: [f32x8<S>; 2]| [v[0].to_array(), v[1].to_array()];
        return facing_exactly([arrays(b), arrays(c), arrays(d)], cull);
    }
    let zero = f32x8::splat(simd, 0.0);
    let turned = |[first, second, third, fourth]: [f32x8<S>; 4]| {
        let drawn = first.simd_gt(zero) | second.simd_gt(zero);
        let convex = first.simd_gt(zero) & second.min(third).min(fourth).simd_ge(zero);
        [drawn.to_bitmask(), convex.to_bitmask()]
    };
    let areas = [first, second, third, fourth];
    let other_way = [-first, -second, -third, -fourth];
    match cull {
        CullMode::None => {
            let (backs, fronts) = (turned(areas), turned(other_way));
            [backs[0] | fronts[0], backs[1] | fronts[1]]
        }
        CullMode::Back => turned(other_way),
        CullMode::Front => turned(areas),
    }
}

/// [`facing`] where f32 does not tell.
fn facing_exactly(corners: [[[f32; BLOCK]; 2]; 3], cull: CullMode) -> [u64; 2] {
    let (mut drawn, mut convex) = (0, 0);
    for i in 0..BLOCK {
        let [b, c, d] = corners.map(|corner| corner.map(|axis| axis[i] as i64));
        let area = |p: [i64; 2], q: [i64; 2]| p[0] * q[1] - q[0] * p[1];
        let (first, second, third) = (area(b, c), area(c, d), area(b, d));
        let others = [second, third, first + second - third];
        let is_convex = first > 0 && others.iter().all(|&area| area >= 0)
            || first < 0 && others.iter().all(|&area| area <= 0);
        let is_drawn = !cull.leaves_out(first);
        drawn |= u64::from(is_drawn || !cull.leaves_out(second)) << i;
        convex |= u64::from(is_drawn && is_convex) << i;
    }
    [drawn, convex]
}
