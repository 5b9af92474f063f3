//! Projects axis-aligned boxes to rectangles of samples, eight at a time.
//!
//! Corners go through the same rows as vertices do; what may be off, and by how much everything is grown, stands in
//! the caller's documentation (`antumbra::occlusion`): here it is a number for each box. The vector form does what the
//! plain one does, for as many boxes as a vector of f64 holds.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};

use crate::order::{greater, largest, least, lesser};
use crate::vertex::ScreenTransform;
use crate::{Level, SUBPIXELS};

/// Boxes in a block.
pub const BOXES: usize = 8;

/// Boxes in coordinates relative to the eye, structure of arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxBlock {
    /// The least x, y and z of each.
    pub min: [[f64; BOXES]; 3],
    /// The largest x, y and z of each.
    pub max: [[f64; BOXES]; 3],
    /// How far what a box stands for may lie outside it, in scene units.
    pub error: [f64; BOXES],
}

impl BoxBlock {
    /// Boxes that are points in the eye.
    pub const EMPTY: BoxBlock = BoxBlock {
        min: [[0.0; BOXES]; 3],
        max: [[0.0; BOXES]; 3],
        error: [0.0; BOXES],
    };
}

/// What boxes are projected by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxView {
    /// From coordinates relative to the eye to the screen.
    pub screen: ScreenTransform,
    /// The lengths of the transform's rows without their constants: x, y, depth, w.
    pub norms: [f64; 4],
    /// What a screen coordinate may be off by, in sub-pixels.
    pub snap_error: f64,
    /// What a screen coordinate or a depth may be off by, relative to itself.
    pub relative_error: f64,
    /// How far the depth of a triangle at a sample may lie from its plane, as a share of the range of its corners' depths.
    pub slope_error: f64,
    /// Samples across the picture and down.
    pub size: [f64; 2],
}

/// Where boxes may be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectBlock {
    /// Bit `i` is set if box `i` holds a point, is finite, and lies before the near plane as a whole, as far as can be said;
    /// only then do the rest of the numbers mean anything.
    pub bounded: u8,
    /// First and last columns; the last before the first where there is none.
    pub x: [[f64; BOXES]; 2],
    /// First and last rows.
    pub y: [[f64; BOXES]; 2],
    /// Depths that nothing in the boxes is nearer than.
    pub nearest: [f64; BOXES],
}

impl RectBlock {
    /// No box is bounded.
    pub const EMPTY: RectBlock = RectBlock {
        bounded: 0,
        x: [[0.0; BOXES]; 2],
        y: [[0.0; BOXES]; 2],
        nearest: [0.0; BOXES],
    };
}

/// Projects a block of boxes.
pub fn project_boxes(level: Level, view: &BoxView, boxes: &BoxBlock, rects: &mut RectBlock) {
    rects.bounded = 0;
    match level.token() {
        None => (0..BOXES).for_each(|i| project_plain(view, boxes, i, rects)),
        Some(token) => dispatch!(token, simd => {
            for first in (0..BOXES).step_by(vector_length(simd)) {
                project_vector(simd, view, boxes, first, rects);
            }
        }),
    }
}

fn project_plain(view: &BoxView, boxes: &BoxBlock, i: usize, rects: &mut RectBlock) {
    let ends = |axis: usize| [boxes.min[axis][i], boxes.max[axis][i]];
    let [px, py, pz] = [ends(0), ends(1), ends(2)];
    let error = boxes.error[i];
    let terms = |r: &[f64; 4]| {
        [
            px.map(|v| v * r[0]),
            py.map(|v| v * r[1]),
            pz.map(|v| v * r[2]),
        ]
    };
    let t = &view.screen;
    let sum_of = |r: &[f64; 4], pick: fn(f64, f64) -> f64| {
        let [a, b, c] = terms(r).map(|[low, high]| pick(low, high));
        ((a + b) + c) + r[3]
    };
    let w = sum_of(&t.w, lesser) - error * view.norms[3];
    let depth = sum_of(&t.depth, greater) + error * view.norms[2];
    let is_box = [px, py, pz]
        .into_iter()
        .all(|[min, max]| (0.0..f64::INFINITY).contains(&(max - min)));
    if !(is_box && w > 0.0 && depth < w * t.near_depth) {
        return;
    }
    rects.bounded |= 1 << i;
    let [tx, ty, tw] = [terms(&t.x), terms(&t.y), terms(&t.w)];
    let at = |terms: &[[f64; 2]; 3], r: &[f64; 4], corner: usize| {
        (terms[0][corner & 1] + terms[1][corner >> 1 & 1]) + (terms[2][corner >> 2] + r[3])
    };
    let mut x = [f64::INFINITY, f64::NEG_INFINITY];
    let mut y = [f64::INFINITY, f64::NEG_INFINITY];
    for corner in 0..8 {
        let inverse = 1.0 / at(&tw, &t.w, corner);
        let (cx, cy) = (
            at(&tx, &t.x, corner) * inverse,
            at(&ty, &t.y, corner) * inverse,
        );
        x = [lesser(x[0], cx), greater(x[1], cx)];
        y = [lesser(y[0], cy), greater(y[1], cy)];
    }
    let inverse = 1.0 / w;
    let samples = |range: [f64; 2], axis: usize| {
        let largest = greater(range[0].abs(), range[1].abs());
        let moved = error * (view.norms[axis] + largest * view.norms[3]) * inverse;
        let off = (moved + view.snap_error) + largest * view.relative_error;
        let (per_subpixel, half) = (1.0 / f64::from(SUBPIXELS), f64::from(SUBPIXELS / 2));
        [
            greater((((range[0] - off) - half) * per_subpixel).ceil(), 0.0),
            lesser(
                (((range[1] + off) - half) * per_subpixel).floor(),
                view.size[axis] - 1.0,
            ),
        ]
    };
    let (x, y) = (samples(x, 0), samples(y, 1));
    for end in 0..2 {
        rects.x[end][i] = x[end];
        rects.y[end][i] = y[end];
    }
    let nearest = depth * inverse;
    rects.nearest[i] = nearest + nearest.abs() * view.relative_error;
}

#[inline(always)]
fn vector_length<S: Simd>(_: S) -> usize {
    S::f64s::LEN
}

/// The terms of one row, at both ends of each axis.
#[inline(always)]
fn terms<S: Simd>(r: &[f64; 4], ends: &[[S::f64s; 2]; 3]) -> [[S::f64s; 2]; 3] {
    let [x, y, z] = *ends;
    [
        [x[0] * r[0], x[1] * r[0]],
        [y[0] * r[1], y[1] * r[1]],
        [z[0] * r[2], z[1] * r[2]],
    ]
}

/// The sums of x's and y's terms.
#[inline(always)]
fn sides<S: Simd>([x, y, _]: &[[S::f64s; 2]; 3]) -> [S::f64s; 4] {
    [x[0] + y[0], x[1] + y[0], x[0] + y[1], x[1] + y[1]]
}

#[inline(always)]
fn project_vector<S: Simd>(
    simd: S,
    view: &BoxView,
    boxes: &BoxBlock,
    first: usize,
    rects: &mut RectBlock,
) {
    let range = first..first + S::f64s::LEN;
    let ends = [
        ends_of::<S>(simd, boxes, 0, first),
        ends_of::<S>(simd, boxes, 1, first),
        ends_of::<S>(simd, boxes, 2, first),
    ];
    let error = S::f64s::from_slice(simd, &boxes.error[range.clone()]);
    let t = &view.screen;
    let tw = terms::<S>(&t.w, &ends);
    let td = terms::<S>(&t.depth, &ends);
    let w = ((least::<S>(tw[0][0], tw[0][1]) + least::<S>(tw[1][0], tw[1][1]))
        + least::<S>(tw[2][0], tw[2][1]))
        + t.w[3];
    let w = w - error * view.norms[3];
    let depth = ((largest::<S>(td[0][0], td[0][1]) + largest::<S>(td[1][0], td[1][1]))
        + largest::<S>(td[2][0], td[2][1]))
        + t.depth[3];
    let depth = depth + error * view.norms[2];
    let zero = S::f64s::splat(simd, 0.0);
    // The size is no number from 0 on where an end is not finite, or the least beyond the largest.
    let mut bounded = w.simd_gt(zero) & depth.simd_lt(w * t.near_depth);
    for [min, max] in ends {
        let size = max - min;
        bounded &= size.simd_ge(zero) & size.simd_lt(S::f64s::splat(simd, f64::INFINITY));
    }
    let bits = bounded.to_bitmask();
    if bits == 0 {
        return;
    }
    rects.bounded |= (bits << first) as u8;
    let tx = terms::<S>(&t.x, &ends);
    let ty = terms::<S>(&t.y, &ends);
    let (sides_x, sides_y, sides_w) = (sides::<S>(&tx), sides::<S>(&ty), sides::<S>(&tw));
    let mut x = [
        S::f64s::splat(simd, f64::INFINITY),
        S::f64s::splat(simd, f64::NEG_INFINITY),
    ];
    let mut y = x;
    for back in 0..2 {
        for side in 0..4 {
            let inverse = S::f64s::splat(simd, 1.0) / (sides_w[side] + (tw[2][back] + t.w[3]));
            let cx = (sides_x[side] + (tx[2][back] + t.x[3])) * inverse;
            let cy = (sides_y[side] + (ty[2][back] + t.y[3])) * inverse;
            x = [least::<S>(x[0], cx), largest::<S>(x[1], cx)];
            y = [least::<S>(y[0], cy), largest::<S>(y[1], cy)];
        }
    }
    let inverse = S::f64s::splat(simd, 1.0) / w;
    let x = samples::<S>(simd, view, 0, x, error, inverse);
    let y = samples::<S>(simd, view, 1, y, error, inverse);
    x[0].store_slice(&mut rects.x[0][range.clone()]);
    x[1].store_slice(&mut rects.x[1][range.clone()]);
    y[0].store_slice(&mut rects.y[0][range.clone()]);
    y[1].store_slice(&mut rects.y[1][range.clone()]);
    let nearest = depth * inverse;
    (nearest + nearest.abs() * view.relative_error).store_slice(&mut rects.nearest[range]);
}

#[inline(always)]
fn ends_of<S: Simd>(simd: S, boxes: &BoxBlock, axis: usize, first: usize) -> [S::f64s; 2] {
    let range = first..first + S::f64s::LEN;
    [
        S::f64s::from_slice(simd, &boxes.min[axis][range.clone()]),
        S::f64s::from_slice(simd, &boxes.max[axis][range]),
    ]
}

#[inline(always)]
fn samples<S: Simd>(
    simd: S,
    view: &BoxView,
    axis: usize,
    range: [S::f64s; 2],
    error: S::f64s,
    inverse: S::f64s,
) -> [S::f64s; 2] {
    let most = largest::<S>(range[0].abs(), range[1].abs());
    let moved = error * (most * view.norms[3] + view.norms[axis]) * inverse;
    let off = (moved + view.snap_error) + most * view.relative_error;
    let (per_subpixel, half) = (1.0 / f64::from(SUBPIXELS), f64::from(SUBPIXELS / 2));
    [
        largest::<S>(
            (((range[0] - off) - half) * per_subpixel).ceil(),
            S::f64s::splat(simd, 0.0),
        ),
        least::<S>(
            (((range[1] + off) - half) * per_subpixel).floor(),
            S::f64s::splat(simd, view.size[axis] - 1.0),
        ),
    ]
}
