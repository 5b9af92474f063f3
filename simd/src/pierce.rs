//! What the ray through a sample meets of a cluster: to know whether drawing it would cover the sample, without drawing it.
//!
//! A vertex at X, Y, W (see [`ScreenTransform`]) lies from the sample (x, y) by `a = X − x·W` and `b = Y − y·W`, times W. The ray
//! meets a triangle where the three products `aᵢ·bⱼ − aⱼ·bᵢ` of its edges have the same sign; they are also the weights by
//! which D and W of the corners add up to D and W of the point. That holds for corners behind the eye as well, so that nothing
//! need be clipped.
//!
//! The answer is not exact, as what is drawn is: it takes corners where they are and not on the grid. Nothing may rest on it
//! but what to draw. It is the same on every level all the same.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};

use crate::assemble::{Cluster, MOST_VERTICES};
use crate::order::{greater, lesser};
use crate::project::positions;
use crate::triangle::CullMode;
use crate::vertex::{ScreenTransform, transform};
use crate::{Level, SUBPIXELS};

/// Where the vertices lie from the sample.
struct FromSample {
    a: [f64; MOST_VERTICES],
    b: [f64; MOST_VERTICES],
}

/// The depth of the nearest point where the ray through a sample meets a cluster between the near and the far plane; none if it
/// does not.
///
/// # Panics
/// If an index is out of range, or there are more vertices than a cluster may have.
pub fn pierce(
    level: Level,
    cluster: Cluster<'_>,
    screen: &ScreenTransform,
    cull: CullMode,
    [column, row]: [i32; 2],
) -> Option<f64> {
    let place = |v: i32| f64::from(v * SUBPIXELS + SUBPIXELS / 2);
    let [x, y] = [place(column), place(row)];
    // Two rows of the transform that give `a` and `b` at once.
    let less = |of: &[f64; 4], times: f64| -> [f64; 4] {
        std::array::from_fn(|i| of[i] - times * screen.w[i])
    };
    let rows = [less(&screen.x, x), less(&screen.y, y)];
    let mut from = FromSample {
        a: [0.0; MOST_VERTICES],
        b: [0.0; MOST_VERTICES],
    };
    match level.token() {
        None => {
            for i in 0..cluster.vertices {
                let p = [cluster.x[i], cluster.y[i], cluster.z[i]].map(f64::from);
                let at = |r: &[f64; 4]| ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3];
                from.a[i] = at(&rows[0]);
                from.b[i] = at(&rows[1]);
            }
        }
        Some(token) => dispatch!(token, simd => find_places(simd, cluster, &rows, &mut from)),
    }
    meet(cluster, screen, cull, &from)
}

#[inline(always)]
fn find_places<S: Simd>(
    simd: S,
    cluster: Cluster<'_>,
    rows: &[[f64; 4]; 2],
    from: &mut FromSample,
) {
    let lanes = S::f64s::LEN;
    let [a, b] = rows;
    for first in (0..cluster.vertices).step_by(2 * lanes) {
        for (half, [x, y, z]) in positions(simd, &cluster, first).into_iter().enumerate() {
            let at = first + half * lanes..first + (half + 1) * lanes;
            let a = x * a[0] + y * a[1] + z * a[2] + a[3];
            let b = x * b[0] + y * b[1] + z * b[2] + b[3];
            a.store_slice(&mut from.a[at.clone()]);
            b.store_slice(&mut from.b[at]);
        }
    }
}

#[inline]
fn meet(
    cluster: Cluster<'_>,
    screen: &ScreenTransform,
    cull: CullMode,
    from: &FromSample,
) -> Option<f64> {
    let mut nearest = None;
    for quad in cluster.quads {
        let corners = quad.map(usize::from);
        let [a, b] = [&from.a, &from.b].map(|of| corners.map(|i| of[i]));
        let is_beside = |v: [f64; 4]| {
            lesser(lesser(v[0], v[1]), lesser(v[2], v[3])) > 0.0
                || greater(greater(v[0], v[1]), greater(v[2], v[3])) < 0.0
        };
        if is_beside(a) || is_beside(b) {
            continue;
        }
        for [i, j, k] in [[0, 1, 2], [0, 2, 3]] {
            let edge = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
            let weights = [edge(j, k), edge(k, i), edge(i, j)];
            let is_front = weights.iter().all(|&w| w < 0.0);
            let is_back = weights.iter().all(|&w| w > 0.0);
            let is_drawn = match cull {
                CullMode::None => is_front || is_back,
                CullMode::Back => is_front,
                CullMode::Front => is_back,
            };
            if !is_drawn {
                continue;
            }
            let (mut depth, mut w) = (0.0, 0.0);
            for (corner, weight) in [i, j, k].into_iter().zip(weights) {
                let v = corners[corner];
                let vertex = transform(screen, [cluster.x[v], cluster.y[v], cluster.z[v]]);
                depth += vertex.depth * weight;
                w += vertex.w * weight;
            }
            // Of the point's W only the sign of that of the weights is missing.
            let depth = depth / w;
            let is_ahead = (w < 0.0) == is_front;
            if is_ahead
                && depth <= screen.near_depth
                && depth >= screen.far_depth
                && nearest.is_none_or(|nearest| depth > nearest)
            {
                nearest = Some(depth);
            }
        }
    }
    nearest
}
