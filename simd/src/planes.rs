//! The depth planes of quadrilaterals, as many at once as a vector of f64 holds.
//!
//! The plain forms are [`DepthPlane`](crate::triangle::DepthPlane), what [`Quad::new`](crate::quad::Quad::new) makes of it,
//! and [`PartDepth`](crate::part_depth::PartDepth).

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use crate::order::{largest, least};
use crate::part_depth::{LARGEST, ROUNDING, SUBNORMAL_ROUNDING};
use crate::quad::BEND;
use crate::spans::{BLOCK, SpanBlock};
use crate::triangle::SLIVER;
use crate::{SUBPIXELS, TILE_SIZE};

/// Of quadrilaterals `a b c d`: exact differences.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outlines {
    /// From `a` to the other corners, in sub-pixels.
    pub(crate) b: [[f64; BLOCK]; 2],
    pub(crate) c: [[f64; BLOCK]; 2],
    pub(crate) d: [[f64; BLOCK]; 2],
    /// From the least to the largest coordinates, in sub-pixels.
    pub(crate) extent: [[f64; BLOCK]; 2],
    /// From `a` to the columns where the part depth may be farthest: to the left one and to the right one.
    pub(crate) columns: [[f64; BLOCK]; 2],
    /// From `a` to the first row of samples.
    pub(crate) first_row: [f64; BLOCK],
    /// The depths of the corners.
    pub(crate) depth: [[f64; BLOCK]; 4],
}

/// Of quadrilaterals, a bit for each.
#[derive(Clone, Copy, Default)]
pub(crate) struct Planes {
    /// They can be drawn as one.
    pub(crate) whole: u64,
    /// They run counter-clockwise.
    pub(crate) turned: u64,
}

/// Finds the depths of quadrilaterals from place `first` of a block.
#[inline(always)]
pub(crate) fn find_planes<S: Simd>(
    simd: S,
    outlines: &Outlines,
    first: usize,
    inset: i32,
    block: &mut SpanBlock,
) -> Planes {
    let range = first..first + S::f64s::LEN;
    let load = |v: &[f64; BLOCK]| S::f64s::from_slice(simd, &v[range.clone()]);
    let zero = S::f64s::splat(simd, 0.0);
    let per_subpixel = 1.0 / f64::from(SUBPIXELS);
    let (bx, by) = (load(&outlines.b[0]), load(&outlines.b[1]));
    let (cx, cy) = (load(&outlines.c[0]), load(&outlines.c[1]));
    let (dx, dy) = (load(&outlines.d[0]), load(&outlines.d[1]));
    let (across, down) = (load(&outlines.extent[0]), load(&outlines.extent[1]));
    let d0 = load(&outlines.depth[0]);
    let d1 = load(&outlines.depth[1]);
    let d2 = load(&outlines.depth[2]);
    let d3 = load(&outlines.depth[3]);

    // `DepthPlane::through`, and `plane_of` a quadrilateral.
    let area = bx * cy - cx * by;
    let other_area = cx * dy - dx * cy;
    let is_triangle = cx.simd_eq(dx) & cy.simd_eq(dy) & d2.simd_eq(d3);
    let smaller_area = least::<S>(area.abs(), other_area.abs());
    let smaller_area = is_triangle.select(area.abs(), smaller_area);
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
    let tile = f64::from(TILE_SIZE);
    let column = slope_x
        .simd_lt(zero)
        .select(load(&outlines.columns[1]), load(&outlines.columns[0]));
    let (steep_x, steep_y) = (slope_x.abs(), slope_y.abs());
    let most = (largest::<S>(nearest.abs(), farthest.abs())
        + steep_x * (across * per_subpixel + 16.0))
        + steep_y * (down * per_subpixel + 16.0);
    let at = (depth + slope_y * load(&outlines.first_row)) + slope_x * column;
    let at = at - (steep_x + steep_y) * (f64::from(inset) * per_subpixel);
    let is_sloped = most.simd_le(S::f64s::splat(simd, LARGEST));
    let at = is_sloped.select(at - (most * ROUNDING + SUBNORMAL_ROUNDING), farthest);
    let per_row = is_sloped.select(slope_y, zero);
    let per_tile = is_sloped.select(slope_x * tile, zero);
    store_narrow::<S>(at, &mut block.at[range.clone()]);
    store_narrow::<S>(per_row, &mut block.per_row[range.clone()]);
    store_narrow::<S>(per_tile, &mut block.per_tile[range.clone()]);
    store_narrow::<S>(farthest, &mut block.farthest[range.clone()]);
    store_narrow::<S>(nearest, &mut block.nearest[range.clone()]);
    Planes {
        whole: (is_triangle | (is_flat & !is_sliver)).to_bitmask() << first,
        turned: area.simd_lt(zero).to_bitmask() << first,
    }
}

/// Rounds to f32; there is one zero only.
#[inline(always)]
fn store_narrow<S: Simd>(v: S::f64s, into: &mut [f32]) {
    let narrow: S::f32s = v.narrow(v) + 0.0;
    into.copy_from_slice(&narrow.as_slice()[..S::f64s::LEN]);
}
