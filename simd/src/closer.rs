//! The closer question of a box: is it hidden at each sample inside its outline?
//!
//! It asks the same two tests as the question of a rectangle (HOM §3.1), over fewer samples and with a farther depth at
//! most of them: do the occluders cover the outline ([`Strip::is_covered`](crate::outline::Strip::is_covered)), and is
//! each face of the box behind them ([`Faces::are_behind`])? Row of tiles by row of tiles, so that the outline's samples
//! are found once for both. The plain form is the definition; the vector form answers both for the parts of several
//! tiles at once:
//!
//! * **Masks** come from the ends of eight rows, as in [`crate::fill`].
//! * **Depth.** First the nearest corner and the faces are compared all over each part (`part_bounds`): most parts
//!   are decided by that, without masks. Then each face where the samples of a part get nearest to it. The
//!   rectangle around a part's samples is found in the bits of their mask: fold four rows into one for the columns, and
//!   read the highest bit off a float's exponent.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f64x8, i16x8};

use crate::boxes::BoxView;
use crate::coverage::PART_MASKS;
use crate::faces::{Faces, RowLayers};
use crate::outline::{Outline, OutlineEdge};
use crate::part_bounds::{PartBounds, RowBounds};
use crate::projected::{CornerBox, OnScreen};
use crate::query::Rectangle;
use crate::strip_masks::StripMasks;
use crate::{Level, PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

/// What closer questions read of a picture's tiles; see [`crate::tile`].
#[derive(Clone, Copy, Debug)]
pub struct LayeredTiles<'a> {
    /// The covered samples of each tile.
    pub coverage: &'a [u64],
    /// The depths of each tile's parts: of their far layers.
    pub far: &'a [[f32; PARTS_PER_TILE]],
    /// The samples of each tile's near layers.
    pub near_samples: &'a [u64],
    /// The depths of each tile's near layers. Unspecified where a part has no sample in its near layer.
    pub near: &'a [[f32; PARTS_PER_TILE]],
    /// Tiles in a row.
    pub across: usize,
}

impl LayeredTiles<'_> {
    /// Whether these samples of a tile are covered by something not farther than `depth`.
    #[inline(always)]
    pub(crate) fn hides(&self, tile: usize, samples: u64, depth: f32) -> bool {
        let before = |[upper, lower]: [f32; PARTS_PER_TILE]| {
            let mask = |part: f32| u64::from(part >= depth).wrapping_neg();
            mask(upper) & PART_MASKS[0] | mask(lower) & PART_MASKS[1]
        };
        let near_samples = self.near_samples[tile];
        let far_samples = self.coverage[tile] & !near_samples;
        let hiding = far_samples & before(self.far[tile]) | near_samples & before(self.near[tile]);
        samples & !hiding == 0
    }

    /// Whether a sample is covered by something strictly nearer than `depth`.
    #[inline]
    pub fn is_nearer(&self, column: i32, row: i32, depth: f32) -> bool {
        let (column, row, size) = (column as u32, row as u32, TILE_SIZE as u32);
        let tile = (row / size) as usize * self.across + (column / size) as usize;
        let sample = 1_u64 << (row % size * size + column % size);
        let part = (row % size / PART_HEIGHT as u32) as usize;
        let layer = if self.near_samples[tile] & sample != 0 {
            self.near[tile][part]
        } else {
            self.far[tile][part]
        };
        self.coverage[tile] & sample != 0 && depth < layer
    }
}

/// Whether all samples of an outline, within the picture, are covered, and what is behind `faces` there is strictly
/// farther than what covers them.
pub fn is_outline_hidden(
    level: Level,
    tiles: LayeredTiles<'_>,
    outline: &Outline,
    faces: &Faces,
) -> bool {
    match level.token() {
        None => is_outline_hidden_plain(tiles, outline, faces),
        Some(token) => {
            dispatch!(token, simd => is_outline_hidden_vector(simd, tiles, outline, faces))
        }
    }
}

fn is_outline_hidden_plain(tiles: LayeredTiles<'_>, outline: &Outline, faces: &Faces) -> bool {
    (outline.y[0] / TILE_SIZE..=outline.y[1] / TILE_SIZE).all(|tile_y| {
        let start = tile_y as usize * tiles.across;
        let row = start..start + tiles.across;
        let strip = outline.strip(tile_y);
        let layers = RowLayers {
            far: &tiles.far[row.clone()],
            near_samples: &tiles.near_samples[row.clone()],
            near: &tiles.near[row.clone()],
        };
        strip.is_covered(&tiles.coverage[row]) && faces.are_behind(&strip, tile_y, layers)
    })
}

/// Whether all of something inside a box is hidden at each sample inside the box's outline. It is known to be drawn
/// within `rectangle`, and nowhere nearer than that says.
pub fn is_box_hidden(
    level: Level,
    view: &BoxView,
    tiles: LayeredTiles<'_>,
    b: &CornerBox,
    rectangle: Rectangle,
) -> bool {
    match level.token() {
        None => is_box_hidden_plain(view, tiles, b, rectangle),
        Some(token) => {
            dispatch!(token, simd => is_box_hidden_vector(simd, view, tiles, b, rectangle))
        }
    }
}

fn is_box_hidden_plain(
    view: &BoxView,
    tiles: LayeredTiles<'_>,
    b: &CornerBox,
    rectangle: Rectangle,
) -> bool {
    let Some((on_screen, extent)) = OnScreen::new(view, b) else {
        return false;
    };
    let Some(rectangle) = on_screen.within(&extent, rectangle) else {
        return true;
    };
    let (outline, faces) = (on_screen.outline(rectangle), on_screen.faces(rectangle));
    is_outline_hidden_plain(tiles, &outline, &faces)
}

#[inline(always)]
fn is_box_hidden_vector<S: Simd>(
    simd: S,
    view: &BoxView,
    tiles: LayeredTiles<'_>,
    b: &CornerBox,
    rectangle: Rectangle,
) -> bool {
    let Some((on_screen, extent)) = OnScreen::new(view, b) else {
        return false;
    };
    let Some(rectangle) = on_screen.within(&extent, rectangle) else {
        return true;
    };
    let (outline, faces) = (on_screen.outline(rectangle), on_screen.faces(rectangle));
    is_outline_hidden_vector(simd, tiles, &outline, &faces)
}

/// An open sample is looked for in so many tiles at most.
const MOST_TILES: usize = 1024;

/// A sample inside a box's outline for whose sake the box is not hidden, and a depth than which the box is nowhere nearer there:
/// what covers that sample, and is nearer, may hide the box. None if the box is hidden, or too large to be looked through. (In
/// plain form: whether a box is hidden is asked before, and much quicker.)
pub fn open_sample(
    view: &BoxView,
    tiles: LayeredTiles<'_>,
    b: &CornerBox,
    rectangle: Rectangle,
) -> Option<([i32; 2], f32)> {
    let (on_screen, extent) = OnScreen::new(view, b)?;
    let rectangle = on_screen.within(&extent, rectangle)?;
    let (outline, faces) = (on_screen.outline(rectangle), on_screen.faces(rectangle));
    let nearest = faces.nearest();
    let mut left = MOST_TILES;
    for tile_y in outline.y[0] / TILE_SIZE..=outline.y[1] / TILE_SIZE {
        let row = tile_y as usize * tiles.across;
        let [first, last] = outline.x.map(|x| (x / TILE_SIZE) as usize);
        let may_be_open = |tile_x: &usize| {
            let tile = row + tile_x;
            let [upper, lower] = tiles.far[tile];
            tiles.coverage[tile] != u64::MAX || upper <= nearest || lower <= nearest
        };
        if !(first..=last).any(|tile_x| may_be_open(&tile_x)) {
            continue;
        }
        let strip = outline.strip(tile_y);
        for tile_x in strip.tiles().filter(may_be_open) {
            let mask = strip.mask(tile_x);
            let tile = row + tile_x;
            let uncovered = mask & !tiles.coverage[tile];
            let sample = |bit: u32| {
                let [x, y] = [bit as i32 % TILE_SIZE, bit as i32 / TILE_SIZE];
                [tile_x as i32 * TILE_SIZE + x, tile_y * TILE_SIZE + y]
            };
            if uncovered != 0 {
                let [x, y] = sample(uncovered.trailing_zeros());
                return Some(([x, y], faces.nearest_over([x, x], [y, y])));
            }
            let near = tiles.near_samples[tile];
            for (part, part_mask) in PART_MASKS.into_iter().enumerate() {
                let layers = [
                    (mask & part_mask & !near, tiles.far[tile][part]),
                    (mask & part_mask & near, tiles.near[tile][part]),
                ];
                for (samples, depth) in layers.into_iter().filter(|&(samples, _)| samples != 0) {
                    let nearest = faces.nearest_over_samples(samples, tile_x as i32, tile_y);
                    if nearest >= depth {
                        return Some((sample(samples.trailing_zeros()), nearest));
                    }
                }
            }
            left -= 1;
            if left == 0 {
                return None;
            }
        }
    }
    None
}

/// Strips are asked in rounds, each this far from the last.
const STRIDE: i32 = 4;

#[inline(always)]
fn is_outline_hidden_vector<S: Simd>(
    simd: S,
    tiles: LayeredTiles<'_>,
    outline: &Outline,
    faces: &Faces,
) -> bool {
    if tiles.across < S::f64s::LEN {
        // A picture narrower than a vector.
        return is_outline_hidden_plain(tiles, outline, faces);
    }
    let question = Question::new(simd, tiles, outline, faces);
    // A box that can be seen often shows itself at its foot, and what it shows is often several strips high.
    let [top, bottom] = outline.y.map(|y| y / TILE_SIZE);
    let (mut tile_y, mut next) = (bottom, top);
    while question.is_strip_hidden(tile_y) {
        tile_y += STRIDE;
        if tile_y >= bottom {
            if next == bottom.min(top + STRIDE) {
                return true;
            }
            (tile_y, next) = (next, next + 1);
        }
    }
    false
}

/// The parts of as many tiles as a vector holds.
struct Parts<S: Simd> {
    /// The first of the tiles.
    start: usize,
    coverage: S::u32s,
    /// The depths of the far layers: the farthest of the parts.
    far: S::f32s,
    /// Whether all samples of a part that are covered are strictly nearer than the box.
    before: S::mask32s,
}

impl<S: Simd> Parts<S> {
    /// Whether the parts are covered, and strictly nearer than the box, all over.
    #[inline(always)]
    fn are_all_before(&self) -> bool {
        let all = S::u32s::splat(self.coverage.token(), u32::MAX);
        (self.coverage.simd_eq(all) & self.before).all_true()
    }
}

/// What stays the same from strip to strip. A vector holds the parts of `S::f64s::LEN` tiles.
struct Question<'a, S: Simd> {
    simd: S,
    outline: &'a Outline,
    faces: &'a Faces,
    coverage: &'a [u32],
    far: &'a [f32],
    near_samples: &'a [u32],
    near: &'a [f32],
    across: usize,
    nearest: S::f32s,
    bounds: PartBounds<S>,
    masks: StripMasks<S>,
    /// The first column of a part, and its first row, relative to the first tile of a vector.
    part_column: S::f32s,
    part_row: S::f32s,
    row_numbers: f64x8<S>,
}

impl<'a, S: Simd> Question<'a, S> {
    #[inline(always)]
    fn new(simd: S, tiles: LayeredTiles<'a>, outline: &'a Outline, faces: &'a Faces) -> Self {
        Question {
            simd,
            outline,
            faces,
            coverage: bytemuck::cast_slice(tiles.coverage),
            far: tiles.far.as_flattened(),
            near_samples: bytemuck::cast_slice(tiles.near_samples),
            near: tiles.near.as_flattened(),
            across: tiles.across,
            nearest: S::f32s::splat(simd, faces.nearest()),
            bounds: PartBounds::new(simd, outline, faces),
            masks: StripMasks::new(simd),
            part_column: S::f32s::from_fn(simd, |i| {
                (i / PARTS_PER_TILE * TILE_SIZE as usize) as f32
            }),
            part_row: S::f32s::from_fn(simd, |i| {
                (i % PARTS_PER_TILE * PART_HEIGHT as usize) as f32
            }),
            row_numbers: f64x8::from_fn(simd, |i| i as f64),
        }
    }

    #[inline(always)]
    fn is_strip_hidden(&self, tile_y: i32) -> bool {
        let simd = self.simd;
        let tiles = S::f64s::LEN;
        let top = tile_y * TILE_SIZE;
        let row = tile_y as usize * self.across;
        let bounds = self.bounds.of_row(top);
        let [mut tile, mut last] = self.outline.x.map(|x| (x / TILE_SIZE) as usize);
        // Most of a strip is hidden whatever the outline: that is quicker to ask than where its samples are.
        while self.parts(row, tile, &bounds).are_all_before() {
            tile += tiles;
            if tile > last {
                return true;
            }
        }
        let [first, end] = self.spans(top);
        let least = least_of(simd, first);
        let largest = -least_of(simd, -end);
        if least >= largest {
            return true;
        }
        tile = tile.max(least as usize / TILE_SIZE as usize);
        last = (largest as usize - 1) / TILE_SIZE as usize;
        let [first, end] = [self.to_short(first), self.to_short(end)];
        while tile <= last {
            let parts = self.parts(row, tile, &bounds);
            if !parts.are_all_before() {
                let mask = self.masks.of_rows(first, end, parts.start, tile);
                if !self.are_parts_hidden(mask, row, &parts, top) {
                    return false;
                }
            }
            tile += tiles;
        }
        true
    }

    /// The parts of a vector's tiles, in the row of tiles that begins at `row`.
    #[inline(always)]
    fn parts(&self, row: usize, tile: usize, bounds: &RowBounds<'_, S>) -> Parts<S> {
        let start = tile.min(self.across - S::f64s::LEN);
        let at = (row + start) * PARTS_PER_TILE;
        let range = at..at + S::u32s::LEN;
        let far = S::f32s::from_slice(self.simd, &self.far[range.clone()]);
        Parts {
            start,
            coverage: S::u32s::from_slice(self.simd, &self.coverage[range]),
            far,
            before: far.simd_gt(bounds.nearest(start)),
        }
    }

    /// The first column inside the outline in each of eight rows, and the first one outside after it; 2¹⁵ − 1 and 0
    /// where there is none.
    #[inline(always)]
    fn spans(&self, top: i32) -> [f64x8<S>; 2] {
        let simd = self.simd;
        let rows = self.row_numbers + f64::from(top);
        let Outline { x, y, .. } = *self.outline;
        let mut first = f64x8::splat(simd, f64::from(x[0]));
        let mut last = f64x8::splat(simd, f64::from(x[1]));
        for &OutlineEdge { slope, offset } in self.outline.left.edges() {
            first = first.max(rows * slope + offset);
        }
        for &OutlineEdge { slope, offset } in self.outline.right.edges() {
            last = last.min(rows * slope + offset);
        }
        let (first, last) = (first.ceil(), last.floor());
        let present = first.simd_le(last)
            & rows.simd_ge(f64x8::splat(simd, f64::from(y[0])))
            & rows.simd_le(f64x8::splat(simd, f64::from(y[1])));
        [
            present.select(first, f64x8::splat(simd, 32767.0)),
            present.select(last + 1.0, f64x8::splat(simd, 0.0)),
        ]
    }

    #[inline(always)]
    fn to_short(&self, v: f64x8<S>) -> i16x8<S> {
        let simd = self.simd;
        let (low, high) = simd.split_f64x8(v);
        let (low, high) = simd.split_i32x8(simd.cvt_i32_f32x8(low.narrow(high)));
        low.narrow(high)
    }

    /// Whether the samples `mask` of parts in the row of tiles that begins at `row` are all hidden.
    #[inline(always)]
    fn are_parts_hidden(&self, mask: S::u32s, row: usize, parts: &Parts<S>, top: i32) -> bool {
        let simd = self.simd;
        let none = S::u32s::splat(simd, 0);
        if !(mask & !parts.coverage).simd_eq(none).all_true() {
            return false;
        }
        let open = parts.before.select(none, mask);
        if open.simd_eq(none).all_true() {
            return true;
        }
        let at = (row + parts.start) * PARTS_PER_TILE;
        let range = at..at + S::u32s::LEN;
        let near_samples = S::u32s::from_slice(simd, &self.near_samples[range.clone()]);
        let near = S::f32s::from_slice(simd, &self.near[range]);
        let in_far = open & !near_samples;
        let in_near = near.simd_gt(self.nearest).select(none, open & near_samples);
        let corner = [(parts.start as i32 * TILE_SIZE) as f32, top as f32];
        self.are_faces_behind(in_far, parts.far, corner)
            && self.are_faces_behind(in_near, near, corner)
    }

    /// Whether some face is strictly farther than `depth` at the samples `mask` of a layer of each part.
    #[inline(always)]
    fn are_faces_behind(&self, mask: S::u32s, depth: S::f32s, corner: [f32; 2]) -> bool {
        let simd = self.simd;
        let none = S::u32s::splat(simd, 0);
        let mut behind = mask.simd_eq(none);
        if behind.all_true() {
            return true;
        }
        let columns = mask | mask >> 16;
        let columns = (columns | columns >> 8) & 0xff;
        let first_column = exponent::<S>(columns & (none - columns)) + self.part_column + corner[0];
        let last_column = exponent::<S>(columns) + self.part_column + corner[0];
        let first_row = first_row::<S>(mask) + self.part_row + corner[1];
        let last_row = last_row::<S>(mask) + self.part_row + corner[1];
        for plane in self.faces.planes() {
            let x = if plane.slope_x > 0.0 {
                last_column
            } else {
                first_column
            };
            let y = if plane.slope_y > 0.0 {
                last_row
            } else {
                first_row
            };
            let (x0, x1) = x.widen();
            let (y0, y1) = y.widen();
            // In the order of operations of `FacePlane::at`.
            let at0 = (x0 * plane.slope_x + plane.depth) + y0 * plane.slope_y;
            let at1 = (x1 * plane.slope_x + plane.depth) + y1 * plane.slope_y;
            let nearest: S::f32s = at0.narrow(at1);
            behind |= nearest.simd_lt(depth);
            if behind.all_true() {
                return true;
            }
        }
        false
    }
}

/// The number of the highest bit of numbers from 1 to 2²⁴.
#[inline(always)]
fn exponent<S: Simd>(v: S::u32s) -> S::f32s {
    let v: S::i32s = v.bitcast();
    let v: S::f32s = v.to_float();
    let bits: S::i32s = v.bitcast();
    ((bits >> 23) - 127).to_float()
}

/// The first of four rows of eight bits each that has one set; some row does.
#[inline(always)]
fn first_row<S: Simd>(mask: S::u32s) -> S::f32s {
    (is_zero::<S>(mask & 0xff) + is_zero::<S>(mask & 0xffff)) + is_zero::<S>(mask & 0x00ff_ffff)
}

/// The last of four rows of eight bits each that has one set; some row does.
#[inline(always)]
fn last_row<S: Simd>(mask: S::u32s) -> S::f32s {
    let empty = (is_zero::<S>(mask >> 8) + is_zero::<S>(mask >> 16)) + is_zero::<S>(mask >> 24);
    S::f32s::splat(mask.token(), 3.0) - empty
}

/// 1 where a number is 0, and 0 elsewhere.
#[inline(always)]
fn is_zero<S: Simd>(v: S::u32s) -> S::f32s {
    let simd = v.token();
    v.simd_eq(S::u32s::splat(simd, 0))
        .select(S::f32s::splat(simd, 1.0), S::f32s::splat(simd, 0.0))
}

#[inline(always)]
fn least_of<S: Simd>(simd: S, v: f64x8<S>) -> f64 {
    let (low, high) = simd.split_f64x8(v);
    let (low, high) = simd.split_f64x4(low.min(high));
    let v = low.min(high);
    if v[1] < v[0] { v[1] } else { v[0] }
}
