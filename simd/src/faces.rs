//! The nearest depth that a box can have at samples of a tile part, and whether it is farther than what is seen there.
//!
//! Depth is linear on screen, so a face of a box is a plane there. A box is nowhere nearer than the planes of the faces
//! that look at the eye, nor than its nearest corner: at each sample, its depth is at most the farthest of these. The
//! nearest that a plane gets over a rectangle of samples is its depth at one corner.
//!
//! Whoever makes a plane moves it towards the eye by all that may be off, the rounding of [`FacePlane::at`] included,
//! so that it holds for the depth that a triangle's formula gives *before* that is rounded to f32. Rounding keeps order:
//! the bound, rounded the same way, to the nearest f32, then holds for what is written.
//!
//! Both layers of a part are asked (see [`crate::tile`]): the samples in the near one against its depth, all others
//! against the part's. Where a near and a far surface meet in a part, what is behind the near one is found hidden.

use crate::coverage::PART_MASKS;
use crate::outline::Strip;
use crate::{PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

/// Depth over the screen that something nowhere exceeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePlane {
    /// What one sample to the right adds.
    pub slope_x: f64,
    /// What one sample down adds.
    pub slope_y: f64,
    /// The depth at sample (0, 0).
    pub depth: f64,
}

impl FacePlane {
    /// The depth at a sample.
    #[inline]
    pub fn at(&self, x: i32, y: i32) -> f64 {
        (self.depth + self.slope_x * f64::from(x)) + self.slope_y * f64::from(y)
    }

    /// The nearest depth over a rectangle of samples, ends included.
    #[inline]
    pub fn nearest_over(&self, x: [i32; 2], y: [i32; 2]) -> f64 {
        self.at(
            x[usize::from(self.slope_x > 0.0)],
            y[usize::from(self.slope_y > 0.0)],
        )
    }

    /// The farthest depth over a rectangle of samples, ends included.
    #[inline]
    pub fn farthest_over(&self, x: [i32; 2], y: [i32; 2]) -> f64 {
        self.at(
            x[usize::from(self.slope_x < 0.0)],
            y[usize::from(self.slope_y < 0.0)],
        )
    }
}

/// The eye sees at most three faces of a box.
pub const MOST_FACES: usize = 3;

/// The layers of the parts in a row of tiles; see [`crate::tile`].
#[derive(Clone, Copy, Debug)]
pub struct RowLayers<'a> {
    /// The depths of the far layers.
    pub far: &'a [[f32; PARTS_PER_TILE]],
    /// The samples of the near layers.
    pub near_samples: &'a [u64],
    /// The depths of the near layers.
    pub near: &'a [[f32; PARTS_PER_TILE]],
}

/// What bounds the depth of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faces {
    nearest: f32,
    planes: [FacePlane; MOST_FACES],
    count: usize,
}

impl Faces {
    /// Of something that is nowhere nearer than `nearest`.
    pub fn new(nearest: f32) -> Faces {
        let plane = FacePlane {
            slope_x: 0.0,
            slope_y: 0.0,
            depth: 0.0,
        };
        Faces {
            nearest,
            planes: [plane; MOST_FACES],
            count: 0,
        }
    }

    /// Adds a plane, finite at every sample of the picture. Beyond [`MOST_FACES`] it is left out: the bound stays
    /// nearer.
    pub fn push(&mut self, plane: FacePlane) {
        if let Some(free) = self.planes.get_mut(self.count) {
            *free = plane;
            self.count += 1;
        }
    }

    /// The depth of the nearest corner.
    pub fn nearest(&self) -> f32 {
        self.nearest
    }

    /// The planes.
    pub fn planes(&self) -> &[FacePlane] {
        &self.planes[..self.count]
    }

    /// No triangle of the box writes a nearer depth than this at a sample of a rectangle, ends included.
    #[inline]
    pub fn nearest_over(&self, x: [i32; 2], y: [i32; 2]) -> f32 {
        let mut bound = self.nearest;
        for plane in self.planes() {
            let depth = plane.nearest_over(x, y) as f32;
            bound = if depth < bound { depth } else { bound };
        }
        bound
    }

    /// Whether the box is strictly farther than what is seen at each of its samples in a row of tiles, `strip`, whose
    /// number is `tile_y` and whose layers are `layers`. Parts without coverage pass: they are the overlap test's business.
    #[inline]
    pub fn are_behind(&self, strip: &Strip, tile_y: i32, layers: RowLayers<'_>) -> bool {
        strip.tiles().all(|tile| {
            // The far layer's depth is the farthest of a part.
            let depths = layers.far[tile];
            if depths.iter().all(|&depth| self.nearest < depth) {
                return true;
            }
            let (samples, near, tile_x) =
                (strip.mask(tile), layers.near_samples[tile], tile as i32);
            PART_MASKS.into_iter().enumerate().all(|(part, mask)| {
                let in_near = samples & mask & near;
                let in_far = samples & mask & !near;
                self.are_behind_layer(in_far, tile_x, tile_y, depths[part])
                    && self.are_behind_layer(in_near, tile_x, tile_y, layers.near[tile][part])
            })
        })
    }

    /// Whether the box is strictly farther than `depth` at samples of a tile, all of them in one part: those are bounded
    /// by a rectangle.
    #[inline]
    fn are_behind_layer(&self, samples: u64, tile_x: i32, tile_y: i32, depth: f32) -> bool {
        samples == 0
            || self.nearest < depth
            || self.nearest_over_samples(samples, tile_x, tile_y) < depth
    }

    /// [`Faces::nearest_over`] the rectangle around samples of a tile, not none and all of them in one part.
    #[inline]
    pub(crate) fn nearest_over_samples(&self, samples: u64, tile_x: i32, tile_y: i32) -> f32 {
        let first_row = samples.trailing_zeros() as i32 / TILE_SIZE;
        let last_row = (63 - samples.leading_zeros() as i32) / TILE_SIZE;
        let mut columns = samples | samples >> 32;
        columns |= columns >> 16;
        columns |= columns >> 8;
        columns &= 0xff;
        let first_column = columns.trailing_zeros() as i32;
        let last_column = 63 - columns.leading_zeros() as i32;
        let (x0, y0) = (tile_x * TILE_SIZE, tile_y * TILE_SIZE);
        debug_assert!(last_row - first_row < PART_HEIGHT);
        self.nearest_over(
            [x0 + first_column, x0 + last_column],
            [y0 + first_row, y0 + last_row],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::{Outline, OutlineEdge};
    use crate::tile::UNCOVERED;

    fn numbers() -> impl FnMut(u64) -> u64 {
        let mut state = 11_u64;
        move |count| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % count
        }
    }

    fn any_faces(number: &mut impl FnMut(u64) -> u64) -> Faces {
        let mut faces = Faces::new(0.25 + number(4) as f32 * 0.25);
        for _ in 0..number(4) {
            let mut slope = || (number(129) as f64 - 64.0) / 1024.0;
            let (slope_x, slope_y) = (slope(), slope());
            let (x, y) = (number(32) as f64, number(8) as f64);
            faces.push(FacePlane {
                slope_x,
                slope_y,
                depth: number(5) as f64 * 0.25 - slope_x * x - slope_y * y,
            });
        }
        faces
    }

    #[test]
    fn over_a_rectangle_the_bound_is_the_nearest_plane_corner_and_holds_at_each_sample() {
        let mut number = numbers();
        for _ in 0..2_000 {
            let faces = any_faces(&mut number);
            let (x0, y0) = (number(30) as i32, number(30) as i32);
            let (x, y) = ([x0, x0 + number(8) as i32], [y0, y0 + number(4) as i32]);
            let bound = faces.nearest_over(x, y);
            let mut of_planes = faces.nearest();
            for plane in faces.planes() {
                let corners = x.map(|x| y.map(|y| plane.at(x, y)));
                let nearest = corners
                    .as_flattened()
                    .iter()
                    .copied()
                    .fold(f64::MIN, f64::max);
                of_planes = of_planes.min(nearest as f32);
            }
            assert_eq!(bound, of_planes);
            for (px, py) in (y[0]..=y[1]).flat_map(|py| (x[0]..=x[1]).map(move |px| (px, py))) {
                assert!(faces.nearest_over([px, px], [py, py]) <= bound);
            }
        }
    }

    /// By definition: the samples of each part and layer, one by one, their rectangle, and the bound over it.
    fn expected(faces: &Faces, outline: &Outline, layers: RowLayers<'_>) -> bool {
        let mut hidden = true;
        for (tile, part, in_near) in
            (0..4).flat_map(|t| (0..2).flat_map(move |p| [(t, p, false), (t, p, true)]))
        {
            let (mut x, mut y) = ([i32::MAX, i32::MIN], [i32::MAX, i32::MIN]);
            for bit in 32 * part..32 * part + 32 {
                let (px, py) = (8 * tile + bit % 8, bit / 8);
                let [first, last] = outline.columns(py);
                let is_inside =
                    (outline.y[0]..=outline.y[1]).contains(&py) && (first..=last).contains(&px);
                if is_inside && (layers.near_samples[tile as usize] >> bit & 1 == 1) == in_near {
                    x = [x[0].min(px), x[1].max(px)];
                    y = [y[0].min(py), y[1].max(py)];
                }
            }
            let depth = if in_near {
                layers.near[tile as usize][part as usize]
            } else {
                layers.far[tile as usize][part as usize]
            };
            hidden &= x[0] > x[1] || faces.nearest_over(x, y) < depth;
        }
        hidden
    }

    #[test]
    fn a_box_is_behind_a_row_of_tiles_if_it_is_behind_each_layer_that_it_meets() {
        let mut number = numbers();
        let mut count = [0; 2];
        for _ in 0..20_000 {
            let faces = any_faces(&mut number);
            let mut span = |limit: u64| {
                let (a, b) = (number(limit) as i32, number(limit) as i32);
                [a.min(b), a.max(b)]
            };
            let mut outline = Outline::of_rectangle(span(32), span(8));
            let slope = number(17) as f64 - 8.0;
            outline.left.push(OutlineEdge {
                slope,
                offset: number(16) as f64 - 4.0 * slope,
            });
            let mut far = [[0.0; 2]; 4];
            let mut near = [[UNCOVERED; 2]; 4];
            let mut near_samples = [0_u64; 4];
            for ((far, near), samples) in far.iter_mut().zip(&mut near).zip(&mut near_samples) {
                for part in 0..2 {
                    // Half the parts hide everything, a few nothing has been drawn to.
                    far[part] =
                        [0.125, 0.375, 0.5, 0.625, 2.0, 2.0, 2.0, UNCOVERED][number(8) as usize];
                    if far[part] < 1.0 && number(2) == 0 {
                        near[part] = far[part] + 0.25 + number(3) as f32 * 0.25;
                        let rows = [0xff_u64 << 8, 0x0f0f_0f0f, 0xaaaa_aaaa][number(3) as usize];
                        *samples |= rows << (32 * part);
                    }
                }
            }
            let layers = RowLayers {
                far: &far,
                near_samples: &near_samples,
                near: &near,
            };
            let answer = faces.are_behind(&outline.strip(0), 0, layers);
            assert_eq!(answer, expected(&faces, &outline, layers), "{outline:?}");
            count[usize::from(answer)] += 1;
        }
        assert!(count[0] > 3_000 && count[1] > 3_000, "{count:?}");
    }
}
