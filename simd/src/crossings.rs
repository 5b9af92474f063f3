//! Where the edges of quadrilaterals cross rows of samples, as many quadrilaterals at once as there are lanes.
//!
//! The plain form is [`Spans::between`](crate::spans::Spans::between). Those of small quadrilaterals are found in i32 and
//! f32: counted from a sample of the first tile, coordinates stay below 2¹⁴ and their products below 2²⁹.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, i32x8, mask32x8};

use crate::SUBPIXELS;
use crate::spans::{BLOCK, EDGES, EXCHANGES, HORIZONTAL, SpanBlock};

/// The crossings of edges, and whether their inside lies on the right.
#[derive(Clone, Copy)]
struct Crossing<V, M> {
    slope: V,
    at_zero: V,
    is_lower: M,
}

/// Sorts edges by their side: those with their inside on the right come first.
#[inline(always)]
fn sort<S: Simd, V: SimdBase<S>>(edges: &mut [Crossing<V, V::Mask>; EDGES]) {
    for [i, j] in EXCHANGES {
        let (one, other) = (edges[i], edges[j]);
        let swap = other.is_lower & !one.is_lower;
        edges[i] = Crossing {
            slope: swap.select(other.slope, one.slope),
            at_zero: swap.select(other.at_zero, one.at_zero),
            is_lower: one.is_lower | other.is_lower,
        };
        edges[j] = Crossing {
            slope: swap.select(one.slope, other.slope),
            at_zero: swap.select(one.at_zero, other.at_zero),
            is_lower: one.is_lower & other.is_lower,
        };
    }
}

/// The edges of small quadrilaterals `a b c d`, whose corners are counted in sub-pixels from the corner of their first tile;
/// `turn` names those that run the other way.
#[inline(always)]
pub(crate) fn find_small_crossings<S: Simd>(
    simd: S,
    x: [f32x8<S>; 4],
    y: [f32x8<S>; 4],
    turn: mask32x8<S>,
    inset: i32,
    block: &mut SpanBlock,
) {
    let half = (SUBPIXELS / 2) as f32;
    let from_sample = |v: f32x8<S>| simd.cvt_i32_f32x8(v - half);
    let (a, c) = (
        [from_sample(x[0]), from_sample(y[0])],
        [from_sample(x[2]), from_sample(y[2])],
    );
    let (b, d) = (
        [
            from_sample(turn.select(x[3], x[1])),
            from_sample(turn.select(y[3], y[1])),
        ],
        [
            from_sample(turn.select(x[1], x[3])),
            from_sample(turn.select(y[1], y[3])),
        ],
    );
    let mut edges = [
        small_crossing(simd, a, b, inset),
        small_crossing(simd, b, c, inset),
        small_crossing(simd, c, d, inset),
        small_crossing(simd, d, a, inset),
    ];
    sort(&mut edges);
    for (edge, crossing) in edges.iter().enumerate() {
        crossing.slope.store_array(&mut block.small_slope[edge]);
        crossing.at_zero.store_array(&mut block.small_at_zero[edge]);
    }
    for (lower, edge) in block.lower.iter_mut().zip(&edges[1..3]) {
        *lower = edge.is_lower.to_bitmask() as u8;
    }
}

/// The edges from `a` to `b`, counted in sub-pixels from a sample.
#[inline(always)]
fn small_crossing<S: Simd>(
    simd: S,
    a: [i32x8<S>; 2],
    b: [i32x8<S>; 2],
    inset: i32,
) -> Crossing<f32x8<S>, mask32x8<S>> {
    let ea = a[1] - b[1];
    let eb = b[0] - a[0];
    // Left edges and top ones keep their border: the first factor decides unless it is zero. Others have −1 as their bias.
    let bias = ((ea << 14_u32) + eb) >> 31_u32;
    let c = (bias - (ea * a[0] + eb * a[1])) >> SUBPIXELS.trailing_zeros();
    let steepness = ea.max(-ea) + eb.max(-eb);
    let c = c - ((steepness * inset + (SUBPIXELS - 1)) >> SUBPIXELS.trailing_zeros());
    let ea: f32x8<S> = ea.to_float();
    let eb: f32x8<S> = eb.to_float();
    let c: f32x8<S> = c.to_float();
    let zero = f32x8::splat(simd, 0.0);
    let inverse = ea.simd_eq(zero).select(
        f32x8::splat(simd, -HORIZONTAL as f32),
        f32x8::splat(simd, -1.0) / ea,
    );
    Crossing {
        slope: eb * inverse,
        at_zero: (c + 0.5) * inverse,
        is_lower: ea.simd_ge(zero),
    }
}

/// The edges of quadrilaterals `a b c d` that are not small, from place `first` of a block, with corners in sub-pixels;
/// `turned` has a bit for each in the block that runs the other way.
#[inline(always)]
pub(crate) fn find_crossings<S: Simd>(
    simd: S,
    x: &[[f64; BLOCK]; 4],
    y: &[[f64; BLOCK]; 4],
    first: usize,
    turned: u64,
    inset: i32,
    block: &mut SpanBlock,
) {
    let range = first..first + S::f64s::LEN;
    let corner = |i: usize| {
        [
            S::f64s::from_slice(simd, &x[i][range.clone()]),
            S::f64s::from_slice(simd, &y[i][range.clone()]),
        ]
    };
    let turn = S::mask64s::from_bitmask(simd, turned >> first);
    let (a, c) = (corner(0), corner(2));
    let (one, other) = (corner(1), corner(3));
    let (b, d) = (
        [turn.select(other[0], one[0]), turn.select(other[1], one[1])],
        [turn.select(one[0], other[0]), turn.select(one[1], other[1])],
    );
    let mut edges = [
        crossing::<S>(simd, a, b, inset),
        crossing::<S>(simd, b, c, inset),
        crossing::<S>(simd, c, d, inset),
        crossing::<S>(simd, d, a, inset),
    ];
    sort(&mut edges);
    for (edge, crossing) in edges.iter().enumerate() {
        crossing
            .slope
            .store_slice(&mut block.slope[edge][range.clone()]);
        crossing
            .at_zero
            .store_slice(&mut block.at_zero[edge][range.clone()]);
    }
    let lanes = (1_u64 << S::f64s::LEN) - 1;
    let of_others = block.small | !((lanes << first) as u8);
    for (lower, edge) in block.lower.iter_mut().zip(&edges[1..3]) {
        let bits = (edge.is_lower.to_bitmask() << first) as u8;
        *lower = *lower & of_others | bits & !of_others;
    }
}

/// The edges from `a` to `b`: see [`crate::triangle`] and [`crate::spans`].
#[inline(always)]
fn crossing<S: Simd>(
    simd: S,
    a: [S::f64s; 2],
    b: [S::f64s; 2],
    inset: i32,
) -> Crossing<S::f64s, S::mask64s> {
    let zero = S::f64s::splat(simd, 0.0);
    let ea = a[1] - b[1];
    let eb = b[0] - a[0];
    let is_horizontal = ea.simd_eq(zero);
    let keeps_border = ea.simd_gt(zero) | (is_horizontal & eb.simd_ge(zero));
    let bias = keeps_border.select(zero, S::f64s::splat(simd, -1.0));
    let half = f64::from(SUBPIXELS / 2);
    let c = (ea + eb) * half - (ea * a[0] + eb * a[1]) + bias;
    let per_subpixel = 1.0 / f64::from(SUBPIXELS);
    let c = (c * per_subpixel).floor();
    let c = c - ((ea.abs() + eb.abs()) * f64::from(inset) * per_subpixel).ceil();
    let inverse = is_horizontal.select(
        S::f64s::splat(simd, -HORIZONTAL),
        S::f64s::splat(simd, -1.0) / ea,
    );
    Crossing {
        slope: eb * inverse,
        at_zero: (c + 0.5) * inverse,
        is_lower: ea.simd_ge(zero),
    }
}
