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
use crate::project::positions;
use crate::triangle::CullMode;
use crate::vertex::{ScreenTransform, transform};
use crate::{Level, SUBPIXELS};

/// As many as a byte can tell apart: an index needs no check.
const INDICES: usize = 1 + u8::MAX as usize;

/// Where a cluster's vertices lie from a sample: memory to work in.
#[derive(Clone, Debug)]
pub struct PierceMemory {
    a: [f64; MOST_VERTICES],
    b: [f64; MOST_VERTICES],
    /// Bit 0 is set if `a` is negative, bit 1 if `b` is.
    sides: [u8; INDICES],
}

impl Default for PierceMemory {
    fn default() -> PierceMemory {
        PierceMemory {
            a: [0.0; MOST_VERTICES],
            b: [0.0; MOST_VERTICES],
            sides: [0; INDICES],
        }
    }
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
    memory: &mut PierceMemory,
) -> Option<f64> {
    let place = |v: i32| f64::from(v * SUBPIXELS + SUBPIXELS / 2);
    let [x, y] = [place(column), place(row)];
    // Two rows of the transform that give `a` and `b` at once.
    let less = |of: &[f64; 4], times: f64| -> [f64; 4] {
        std::array::from_fn(|i| of[i] - times * screen.w[i])
    };
    let rows = [less(&screen.x, x), less(&screen.y, y)];
    match level.token() {
        None => {
            for i in 0..cluster.vertices {
                let p = [cluster.x[i], cluster.y[i], cluster.z[i]].map(f64::from);
                let at = |r: &[f64; 4]| ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3];
                let [a, b] = [at(&rows[0]), at(&rows[1])];
                memory.a[i] = a;
                memory.b[i] = b;
                memory.sides[i] = u8::from(a < 0.0) | u8::from(b < 0.0) << 1;
            }
        }
        Some(token) => dispatch!(token, simd => find_places(simd, cluster, &rows, memory)),
    }
    meet(cluster, screen, cull, memory)
}

#[inline(always)]
fn find_places<S: Simd>(
    simd: S,
    cluster: Cluster<'_>,
    rows: &[[f64; 4]; 2],
    memory: &mut PierceMemory,
) {
    let lanes = S::f64s::LEN;
    let [a, b] = rows;
    for first in (0..cluster.vertices).step_by(2 * lanes) {
        for (half, [x, y, z]) in positions(simd, &cluster, first).into_iter().enumerate() {
            let at = first + half * lanes..first + (half + 1) * lanes;
            let a = x * a[0] + y * a[1] + z * a[2] + a[3];
            let b = x * b[0] + y * b[1] + z * b[2] + b[3];
            a.store_slice(&mut memory.a[at.clone()]);
            b.store_slice(&mut memory.b[at.clone()]);
            let zero = S::f64s::splat(simd, 0.0);
            let sides =
                spread(a.simd_lt(zero).to_bitmask()) | spread(b.simd_lt(zero).to_bitmask()) << 1;
            memory.sides[at].copy_from_slice(&sides.to_le_bytes()[..lanes]);
        }
    }
}

/// Eight bits in the lowest bits of eight bytes.
#[inline(always)]
fn spread(bits: u64) -> u64 {
    const LOWEST: u64 = 0x0101_0101_0101_0101;
    // Bit `i` of byte `i`, and then whether a byte is not 0.
    let apart = bits.wrapping_mul(LOWEST) & 0x8040_2010_0804_0201;
    (apart + 0x7f * LOWEST) >> 7 & LOWEST
}

#[inline]
fn meet(
    cluster: Cluster<'_>,
    screen: &ScreenTransform,
    cull: CullMode,
    memory: &PierceMemory,
) -> Option<f64> {
    let mut nearest = None;
    for quad in cluster.quads {
        let [a, b, c, d] = quad.map(|i| memory.sides[usize::from(i)]);
        // All corners on one side of the ray.
        if a & b & c & d != 0 || a | b | c | d != 3 {
            continue;
        }
        let corners = quad.map(usize::from);
        let [a, b] = [&memory.a, &memory.b].map(|of| corners.map(|i| of[i]));
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
