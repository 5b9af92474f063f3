//! Sets quadrilaterals up: edges solved for x, and the depth plane, as many at once as a vector of f64 holds.
//!
//! The plain form is [`Quad::new`](crate::quad::Quad::new).

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use crate::assemble::Drawing;
use crate::order::{largest, least};
use crate::part_depth::{LARGEST, ROUNDING};
use crate::project::Vertices;
use crate::quad::BEND;
use crate::small::SMALL;
use crate::spans::{BLOCK, EDGES, EXCHANGES, HORIZONTAL, SpanBlock};
use crate::triangle::SLIVER;
use crate::{SUBPIXELS, TILE_SIZE};

/// Appends a block of the quadrilaterals of a list that are named; names those that cannot be drawn as one.
#[inline(always)]
pub(crate) fn set_up_block<S: Simd>(
    simd: S,
    quads: &[[u8; 4]],
    named: &[u8],
    drawing: Drawing<'_>,
    vertices: &Vertices,
    blocks: &mut Vec<SpanBlock>,
) -> u64 {
    let mut places = [[[0.0; 2]; BLOCK]; 4];
    let mut depths = [[0.0; BLOCK]; 4];
    for (i, &quad) in named.iter().enumerate() {
        for (corner, &vertex) in quads[usize::from(quad)].iter().enumerate() {
            let vertex = usize::from(vertex);
            places[corner][i] = vertices.place[vertex];
            depths[corner][i] = vertices.depth[vertex];
        }
    }
    blocks.push(SpanBlock::EMPTY);
    let Some(block) = blocks.last_mut() else {
        return 0;
    };
    let mut whole = 0;
    for lane in (0..named.len()).step_by(S::f32s::LEN) {
        let [x0, y0] = coordinates::<S>(simd, &places[0], lane);
        let [x1, y1] = coordinates::<S>(simd, &places[1], lane);
        let [x2, y2] = coordinates::<S>(simd, &places[2], lane);
        let [x3, y3] = coordinates::<S>(simd, &places[3], lane);
        let x = [x0.widen(), x1.widen(), x2.widen(), x3.widen()];
        let y = [y0.widen(), y1.widen(), y2.widen(), y3.widen()];
        let low = Corners::<S> {
            x: [x[0].0, x[1].0, x[2].0, x[3].0],
            y: [y[0].0, y[1].0, y[2].0, y[3].0],
        };
        whole |= set_up(simd, low, &depths, lane, drawing, block) << lane;
        let second = lane + S::f64s::LEN;
        if second < named.len() {
            let high = Corners::<S> {
                x: [x[0].1, x[1].1, x[2].1, x[3].1],
                y: [y[0].1, y[1].1, y[2].1, y[3].1],
            };
            whole |= set_up(simd, high, &depths, second, drawing, block) << second;
        }
    }
    let present = (1_u16 << named.len()) - 1;
    block.present = (whole as u16 & present) as u8;
    let mut missing = !whole & u64::from(present);
    let mut apart = 0;
    while missing != 0 {
        apart |= 1 << named[missing.trailing_zeros() as usize];
        missing &= missing - 1;
    }
    apart
}

/// The columns and the rows of places, as many as a vector of f32 holds, from `lane`.
#[inline(always)]
pub(crate) fn coordinates<S: Simd>(
    simd: S,
    places: &[[f32; 2]; BLOCK],
    lane: usize,
) -> [S::f32s; 2] {
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

/// The crossings of edges, and whether their inside lies on the right.
#[derive(Clone, Copy)]
struct Crossing<S: Simd> {
    slope: S::f64s,
    at_zero: S::f64s,
    is_lower: S::mask64s,
}

impl<S: Simd> Crossing<S> {
    /// The edges from `a` to `b`: see [`crate::triangle`] and [`crate::spans`].
    #[inline(always)]
    fn between(simd: S, a: [S::f64s; 2], b: [S::f64s; 2]) -> Crossing<S> {
        let zero = S::f64s::splat(simd, 0.0);
        let ea = a[1] - b[1];
        let eb = b[0] - a[0];
        let is_horizontal = ea.simd_eq(zero);
        let keeps_border = ea.simd_gt(zero) | (is_horizontal & eb.simd_ge(zero));
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

    /// Puts the second before the first where only its inside lies on the right.
    #[inline(always)]
    fn sort(first: Self, second: Self) -> [Self; 2] {
        let swap = second.is_lower & !first.is_lower;
        [
            Crossing {
                slope: swap.select(second.slope, first.slope),
                at_zero: swap.select(second.at_zero, first.at_zero),
                is_lower: first.is_lower | second.is_lower,
            },
            Crossing {
                slope: swap.select(first.slope, second.slope),
                at_zero: swap.select(first.at_zero, second.at_zero),
                is_lower: first.is_lower & second.is_lower,
            },
        ]
    }
}

/// The corners of as many quadrilaterals as a vector of f64 holds, in sub-pixels.
struct Corners<S: Simd> {
    x: [S::f64s; 4],
    y: [S::f64s; 4],
}

/// Rounds to f32; there is one zero only.
#[inline(always)]
fn store_narrow<S: Simd>(v: S::f64s, into: &mut [f32]) {
    let narrow: S::f32s = v.narrow(v) + 0.0;
    into.copy_from_slice(&narrow.as_slice()[..S::f64s::LEN]);
}

/// Sets up the quadrilaterals from place `first` of a block: [`Quad::new`]. Says which can be drawn as one.
#[inline(always)]
fn set_up<S: Simd>(
    simd: S,
    corners: Corners<S>,
    depths: &[[f64; BLOCK]; 4],
    first: usize,
    drawing: Drawing<'_>,
    block: &mut SpanBlock,
) -> u64 {
    let range = first..first + S::f64s::LEN;
    let zero = S::f64s::splat(simd, 0.0);
    let ([x0, x1, x2, x3], [y0, y1, y2, y3]) = (corners.x, corners.y);
    let least_x = least::<S>(least::<S>(x0, x1), least::<S>(x2, x3));
    let largest_x = largest::<S>(largest::<S>(x0, x1), largest::<S>(x2, x3));
    let least_y = least::<S>(least::<S>(y0, y1), least::<S>(y2, y3));
    let largest_y = largest::<S>(largest::<S>(y0, y1), largest::<S>(y2, y3));
    let per_subpixel = 1.0 / f64::from(SUBPIXELS);
    let first_x = largest::<S>((least_x * per_subpixel - 0.5).ceil(), zero);
    let first_y = largest::<S>((least_y * per_subpixel - 0.5).ceil(), zero);
    let right = S::f64s::splat(simd, f64::from(drawing.width - 1));
    let bottom = S::f64s::splat(simd, f64::from(drawing.height - 1));
    let last_x = least::<S>((largest_x * per_subpixel - 0.5).floor(), right);
    let last_y = least::<S>((largest_y * per_subpixel - 0.5).floor(), bottom);
    first_x.store_slice(&mut block.x[0][range.clone()]);
    last_x.store_slice(&mut block.x[1][range.clone()]);
    first_y.store_slice(&mut block.y[0][range.clone()]);
    last_y.store_slice(&mut block.y[1][range.clone()]);

    // The plane: `DepthPlane::through`, and `plane_of` a quadrilateral.
    let d0 = S::f64s::from_slice(simd, &depths[0][range.clone()]);
    let d1 = S::f64s::from_slice(simd, &depths[1][range.clone()]);
    let d2 = S::f64s::from_slice(simd, &depths[2][range.clone()]);
    let d3 = S::f64s::from_slice(simd, &depths[3][range.clone()]);
    let (bx, by) = (x1 - x0, y1 - y0);
    let (cx, cy) = (x2 - x0, y2 - y0);
    let (dx, dy) = (x3 - x0, y3 - y0);
    let area = bx * cy - cx * by;
    let other_area = cx * dy - dx * cy;
    let is_triangle = x2.simd_eq(x3) & y2.simd_eq(y3) & d2.simd_eq(d3);
    let smaller_area = least::<S>(area.abs(), other_area.abs());
    let smaller_area = is_triangle.select(area.abs(), smaller_area);
    let (across, down) = (largest_x - least_x, largest_y - least_y);
    let is_sliver = (across * down).simd_gt(smaller_area * SLIVER);
    let farthest = least::<S>(least::<S>(least::<S>(d0, d1), d2), d3);
    let nearest = largest::<S>(largest::<S>(largest::<S>(d0, d1), d2), d3);
    let per_sample = S::f64s::splat(simd, f64::from(SUBPIXELS)) / area;
    let slope_x = ((d1 - d0) * cy - (d2 - d0) * by) * per_sample;
    let slope_y = ((d2 - d0) * bx - (d1 - d0) * cx) * per_sample;
    let there = (d0 + slope_y * (dy * per_subpixel)) + slope_x * (dx * per_subpixel);
    let behind = there - d3;
    let is_flat = behind.abs().simd_le((nearest - farthest) * BEND);
    let depth = is_triangle.select(
        is_sliver.select(farthest, d0),
        d0 - largest::<S>(behind, zero),
    );
    let slope_x = is_sliver.select(zero, slope_x);
    let slope_y = is_sliver.select(zero, slope_y);

    // `PartDepth::new`.
    let (per_tile, tile) = (1.0 / f64::from(TILE_SIZE), f64::from(TILE_SIZE));
    let first_tile = (first_x * per_tile).floor();
    let is_column = first_tile.simd_eq((last_x * per_tile).floor());
    let left = is_column.select(first_x, first_tile * tile);
    let right = is_column.select(last_x, first_tile * tile + (tile - 1.0));
    let column = slope_x.simd_lt(zero).select(right, left);
    let half = f64::from(SUBPIXELS / 2);
    let (origin_x, origin_y) = ((x0 - half) * per_subpixel, (y0 - half) * per_subpixel);
    let most = (largest::<S>(nearest.abs(), farthest.abs())
        + slope_x.abs() * (across * per_subpixel + 16.0))
        + slope_y.abs() * (down * per_subpixel + 16.0);
    let at = (depth + slope_y * (first_y - origin_y)) + slope_x * (column - origin_x);
    let is_sloped = most.simd_le(S::f64s::splat(simd, LARGEST));
    let at = is_sloped.select(at - most * ROUNDING, farthest);
    store_narrow::<S>(at, &mut block.at[range.clone()]);
    store_narrow::<S>(
        is_sloped.select(slope_y, zero),
        &mut block.per_row[range.clone()],
    );
    store_narrow::<S>(
        is_sloped.select(slope_x * tile, zero),
        &mut block.per_tile[range.clone()],
    );
    store_narrow::<S>(farthest, &mut block.farthest[range.clone()]);
    store_narrow::<S>(nearest, &mut block.nearest[range.clone()]);

    // The edges, clockwise.
    let turn = area.simd_lt(zero);
    let (b, d) = (
        [turn.select(x3, x1), turn.select(y3, y1)],
        [turn.select(x1, x3), turn.select(y1, y3)],
    );
    let (a, c) = ([x0, y0], [x2, y2]);
    let mut edges: [Crossing<S>; EDGES] = [
        Crossing::between(simd, a, b),
        Crossing::between(simd, b, c),
        Crossing::between(simd, c, d),
        Crossing::between(simd, d, a),
    ];
    for [i, j] in EXCHANGES {
        [edges[i], edges[j]] = Crossing::sort(edges[i], edges[j]);
    }
    for (edge, crossing) in edges.iter().enumerate() {
        crossing
            .slope
            .store_slice(&mut block.slope[edge][range.clone()]);
        crossing
            .at_zero
            .store_slice(&mut block.at_zero[edge][range.clone()]);
    }
    for (lower, edge) in block.lower.iter_mut().zip(&edges[1..3]) {
        *lower |= (edge.is_lower.to_bitmask() << first) as u8;
    }
    let limit = S::f64s::splat(simd, f64::from(SMALL));
    let small = across.simd_le(limit) & down.simd_le(limit);
    block.small |= (small.to_bitmask() << first) as u8;
    (is_triangle | (is_flat & !is_sliver)).to_bitmask()
}
