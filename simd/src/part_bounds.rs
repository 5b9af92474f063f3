//! A box's nearest depth over whole tile parts, in f32: where it is farther than what is drawn all over a part, nobody needs
//! to know which of the part's samples are the box's.
//!
//! [`Faces`] says how near a box gets over a rectangle of samples, in f64. Here each plane is
//!
//! ```text
//!   (at + per_row·(row − first row)) + per_column·(column − first column)
//! ```
//!
//! for the first row and column of a part, `at` taken at the corner of the part where the plane is nearest. Let `M` be the
//! largest that `at` and both products get. No number in the formula is larger than `2·M`; its five operations, and what was
//! rounded before them, are off by ten times `2⁻²⁴·M` at the most. The formula of [`FacePlane::at`] counts from the
//! picture's corner, not from the box's, and its terms may be `2¹²` times as large: three roundings of `2⁻⁵³` of that are
//! nothing. `2⁻²⁰·M` is added for all, and what roundings of subnormal numbers may come to. So no depth of the plane, rounded to f32, is nearer than the bound at any sample of the
//! part: an answer by the bound is the answer by [`Faces::nearest_over`].

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use crate::faces::{Faces, MOST_FACES};
use crate::outline::Outline;
use crate::part_depth::SUBNORMAL_ROUNDING;
use crate::{PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

/// What is added, as a share of the largest number that occurs.
const ROUNDING: f64 = 1.0 / (1_u64 << 20) as f64;

/// Where numbers are larger than this, a plane bounds nothing.
const LARGEST: f64 = 1e30;

/// A box's nearest depths over parts; see the module.
pub(crate) struct PartBounds<S: Simd> {
    nearest: S::f32s,
    at: [S::f32s; MOST_FACES],
    per_row: [S::f32s; MOST_FACES],
    per_column: [S::f32s; MOST_FACES],
    /// The first column and row of the box's tiles.
    first: [i32; 2],
    /// The first column and row of each of a vector's parts, from those of its first tile.
    part_column: S::f32s,
    part_row: S::f32s,
}

/// The same along a row of tiles.
pub(crate) struct RowBounds<'a, S: Simd> {
    of: &'a PartBounds<S>,
    at: [S::f32s; MOST_FACES],
}

impl<S: Simd> PartBounds<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, outline: &Outline, faces: &Faces) -> Self {
        let first = [outline.x[0], outline.y[0]].map(|v| v / TILE_SIZE * TILE_SIZE);
        // A picture's last vector may begin left of the first tile.
        let wider = TILE_SIZE * S::f64s::LEN as i32;
        let across = f64::from(outline.x[1] - first[0] + wider);
        let down = f64::from(outline.y[1] - first[1] + TILE_SIZE);
        // Of a plane that there is none of, infinitely near.
        let mut at = [S::f32s::splat(simd, f32::INFINITY); MOST_FACES];
        let mut per_row = [S::f32s::splat(simd, 0.0); MOST_FACES];
        let mut per_column = per_row;
        for (i, plane) in faces.planes().iter().enumerate() {
            let [right, lower] = [TILE_SIZE - 1, PART_HEIGHT - 1];
            let x = [first[0], first[0] + right];
            let y = [first[1], first[1] + lower];
            let nearest = plane.nearest_over(x, y);
            let largest =
                nearest.abs() + (plane.slope_x.abs() * across + plane.slope_y.abs() * down);
            if largest < LARGEST {
                at[i] = S::f32s::splat(
                    simd,
                    (nearest + (largest * ROUNDING + SUBNORMAL_ROUNDING)) as f32,
                );
                per_row[i] = S::f32s::splat(simd, plane.slope_y as f32);
                per_column[i] = S::f32s::splat(simd, plane.slope_x as f32);
            }
        }
        PartBounds {
            nearest: S::f32s::splat(simd, faces.nearest()),
            at,
            per_row,
            per_column,
            first,
            part_column: S::f32s::from_fn(simd, |i| {
                (i / PARTS_PER_TILE * TILE_SIZE as usize) as f32
            }),
            part_row: S::f32s::from_fn(simd, |i| {
                (i % PARTS_PER_TILE * PART_HEIGHT as usize) as f32
            }),
        }
    }

    /// Along the row of tiles whose first row of samples is `top`.
    #[inline(always)]
    pub(crate) fn of_row(&self, top: i32) -> RowBounds<'_, S> {
        let row = self.part_row + (top - self.first[1]) as f32;
        let mut at = self.at;
        for (at, per_row) in at.iter_mut().zip(self.per_row) {
            *at += per_row * row;
        }
        RowBounds { of: self, at }
    }
}

impl<S: Simd> RowBounds<'_, S> {
    /// The depths that the box is not nearer than, over the parts of a vector's tiles from `start` on.
    #[inline(always)]
    pub(crate) fn nearest(&self, start: usize) -> S::f32s {
        let bounds = self.of;
        let column = bounds.part_column + (start as i32 * TILE_SIZE - bounds.first[0]) as f32;
        let mut nearest = bounds.nearest;
        for (at, per_column) in self.at.into_iter().zip(bounds.per_column) {
            nearest = nearest.min(at + per_column * column);
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::Level;
    use crate::faces::FacePlane;

    /// The bounds over the parts of a picture's tiles, row by row, the upper part of each tile first.
    #[inline(always)]
    fn bounds<S: Simd>(
        simd: S,
        outline: &Outline,
        faces: &Faces,
        [across, down]: [usize; 2],
    ) -> Vec<f32> {
        let bounds = PartBounds::new(simd, outline, faces);
        let mut all = Vec::new();
        for tile_y in 0..down {
            let row = bounds.of_row(tile_y as i32 * TILE_SIZE);
            for start in (0..across).step_by(S::f64s::LEN) {
                let mut some = vec![0.0; S::f32s::LEN];
                row.nearest(start).store_slice(&mut some);
                all.extend(some);
            }
        }
        all
    }

    #[test]
    fn no_face_is_nearer_than_the_bound_anywhere_in_a_part() {
        let (across, down) = (16, 6);
        let mut state = 5_u64;
        let mut number = |count: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) % count
        };
        let mut close = 0;
        for round in 0..2_500 {
            // Now and then all of it subnormal.
            let scale = if round % 5 == 4 { 1e-43 } else { 1.0 };
            let outline = Outline::of_rectangle([number(8) as i32, 127], [number(8) as i32, 47]);
            let mut faces = Faces::new((0.75 * scale) as f32);
            for _ in 0..number(4) {
                let mut slope = || {
                    let steep = [1e-9, 1e-4, 0.1, 1e12, 1e40][number(5) as usize];
                    (number(2001) as f64 - 1000.0) * steep * scale
                };
                let (slope_x, slope_y) = (slope(), slope());
                let (x, y) = (number(128) as f64, number(48) as f64);
                faces.push(FacePlane {
                    slope_x,
                    slope_y,
                    depth: 0.5 * scale - slope_x * x - slope_y * y,
                });
            }
            for token in Level::available().iter().filter_map(|level| level.token()) {
                let found =
                    dispatch!(token, simd => bounds(simd, &outline, &faces, [across, down]));
                for (i, bound) in found.into_iter().enumerate() {
                    let (tile, part) = (i / 2, i % 2);
                    let x = (tile % across) as i32 * TILE_SIZE;
                    let y = (tile / across) as i32 * TILE_SIZE + part as i32 * PART_HEIGHT;
                    let nearest = faces.nearest_over([x, x + 7], [y, y + 3]);
                    assert!(nearest <= bound, "{token:?}: {faces:?} {x} {y}");
                    close += u32::from(scale == 1.0 && nearest > bound - 1e-4 && bound < 0.75);
                }
            }
        }
        let levels = Level::available()
            .iter()
            .filter(|level| level.token().is_some());
        assert!(close > 25_000 * levels.count() as u32, "{close}");
    }
}
