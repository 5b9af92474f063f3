//! A hierarchical Z-buffer: the nearest depth at each sample, and a pyramid of what is farthest in ever larger cells.
//!
//! A question reads the level whose cells are just as large as the rectangle's larger side, or larger (LOD §5.3, equation 4): it
//! touches two of them across at the most, and two down.
//!
//! ```text
//!   level   cells, in samples    keeps
//!     0       1×1                the nearest surface's depth
//!     1       2×2                the farthest of four cells below
//!     2       4×4                likewise
//!     3       8×8                the N farthest of 64 samples, the farthest first; questions read the N-th
//!     4      16×16               the N farthest of four cells below …
//! ```
//!
//! GW §5.3 lets the N-th farthest value stand for a cell, which ignores N − 1 of its samples. Here that begins with cells of a
//! tile's size, as the holes do that approximate overlap tests ignore: of what covers a few samples, nothing is ignored. With
//! N = 1 a cell is nowhere nearer than its samples, and the answers are exact.
//!
//! A sample that nothing covers counts as the nearest possible (HOM §6.4), and so does a cell with fewer than N covered ones.

use std::num::NonZeroU32;

use antumbra_simd::TILE_SIZE;
use antumbra_simd::tile::UNCOVERED;

use super::DrawnSurface;
use crate::occlusion::{Footprint, SampleRect};
use crate::raster::{LoweredPlane, for_each_tile};
use crate::view::PictureSize;

/// The most N: the samples of a tile.
pub const MOST_NTH: u32 = (TILE_SIZE * TILE_SIZE) as u32;

const TILE: usize = TILE_SIZE as usize;

/// Cells of this level have a tile's size.
const LEVEL_OF_TILES: usize = TILE.trailing_zeros() as usize;

/// A tile that is not wholly covered: no surface is farther than that.
const OPEN: f32 = f32::NEG_INFINITY;

/// The nearest depth of what was drawn at each sample, and the farthest of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct HierarchicalZ {
    size: PictureSize,
    /// Level 0, with whole tiles.
    samples: Level,
    /// The farthest depth of each tile, so that what is farther is passed over; [`OPEN`] if one of its samples is not covered.
    farthest: Vec<f32>,
    /// Level 1 and those above, as of the last [`HierarchicalZ::finish`].
    levels: Vec<Level>,
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    width: usize,
    height: usize,
    /// How many of the farthest are kept of each cell.
    kept: usize,
    depths: Vec<f32>,
}

impl Level {
    fn new(width: usize, height: usize, kept: usize, depth: f32) -> Level {
        Level {
            width,
            height,
            kept,
            depths: vec![depth; width * height * kept],
        }
    }

    fn cell(&self, x: usize, y: usize) -> &[f32] {
        &self.depths[(y * self.width + x) * self.kept..][..self.kept]
    }
}

impl HierarchicalZ {
    /// An empty buffer over a picture, which keeps the N-th farthest depth of cells; [`MOST_NTH`] is the most.
    pub fn new(size: PictureSize, nth: NonZeroU32) -> HierarchicalZ {
        let nth = nth.get().min(MOST_NTH) as usize;
        let (across, down) = (size.tiles_across() * TILE, size.tiles_down() * TILE);
        let (mut width, mut height) = (across, down);
        let mut levels = Vec::new();
        while width * height > 1 {
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
            let kept = if levels.len() + 1 < LEVEL_OF_TILES {
                1
            } else {
                nth
            };
            levels.push(Level::new(width, height, kept, UNCOVERED));
        }
        HierarchicalZ {
            size,
            samples: Level::new(across, down, 1, UNCOVERED),
            farthest: vec![OPEN; size.tiles_across() * size.tiles_down()],
            levels,
        }
    }

    /// Forgets all that was drawn.
    pub fn clear(&mut self) {
        self.samples.depths.fill(UNCOVERED);
        self.farthest.fill(OPEN);
    }

    /// Whether all that is within a footprint is farther than what is drawn there, so that drawing it would change nothing.
    pub fn is_farther_than_drawn(&self, footprint: Footprint) -> bool {
        let rect = match footprint {
            Footprint::Unbounded => return false,
            Footprint::Nowhere => return true,
            Footprint::Within(rect) => rect,
        };
        let across = self.size.tiles_across();
        let [x, y] = [rect.x, rect.y].map(|ends| ends.map(|end| end as usize / TILE));
        (y[0]..=y[1]).all(|row| {
            let tiles = &self.farthest[row * across..][x[0]..=x[1]];
            tiles.iter().all(|&farthest| rect.nearest_depth <= farthest)
        })
    }

    /// Draws triangles into the Z-buffer.
    pub fn note(&mut self, drawn: &DrawnSurface<'_>) {
        let rows = 0..self.size.tiles_down() as i32;
        let (tiles_across, across) = (self.size.tiles_across(), self.samples.width);
        for triangle in drawn.triangles.iter() {
            let plane = LoweredPlane::new(triangle.depth);
            let nearest = plane.nearest();
            for_each_tile(triangle, rows.clone(), |tile_x, tile_y, mask| {
                let farthest = &mut self.farthest[tile_y as usize * tiles_across + tile_x as usize];
                if nearest <= *farthest {
                    return;
                }
                let (x, y) = (tile_x * TILE_SIZE, tile_y * TILE_SIZE);
                let tile = &mut self.samples.depths[y as usize * across + x as usize..];
                let (mut least, mut is_open) = (UNCOVERED, false);
                for (row, samples) in (0..TILE_SIZE).zip(tile.chunks_mut(across)) {
                    let samples = &mut samples[..TILE];
                    let covered = mask >> (TILE_SIZE * row) & 0xff;
                    if covered != 0 {
                        let depths = plane.depths_of_row(x, y + row);
                        for (column, (sample, depth)) in samples.iter_mut().zip(depths).enumerate()
                        {
                            let is_nearer = depth > *sample || *sample == UNCOVERED;
                            let is_covered = covered >> column & 1 == 1;
                            *sample = if is_covered & is_nearer {
                                depth
                            } else {
                                *sample
                            };
                        }
                    }
                    for &sample in &*samples {
                        is_open |= sample == UNCOVERED;
                        least = lesser(least, sample);
                    }
                }
                *farthest = if is_open { OPEN } else { least };
            });
        }
    }

    /// Builds the pyramid.
    pub fn finish(&mut self) {
        for level in 1..=self.levels.len() {
            let (finer, coarser) = self.levels.split_at_mut(level - 1);
            let coarser = &mut coarser[0];
            if level == LEVEL_OF_TILES && coarser.kept > 1 {
                farthest_of_tiles(&self.samples, coarser);
            } else if let Some(finer) = finer.last() {
                if coarser.kept == 1 {
                    farthest_of_four(finer, coarser);
                } else {
                    several_of_four(finer, coarser);
                }
            } else {
                farthest_of_four(&self.samples, coarser);
            }
        }
    }

    /// Whether a rectangle is strictly farther than the cells that it touches, of the level that has cells of its size.
    pub fn is_behind(&self, rect: &SampleRect) -> bool {
        let level = self.level_of(rect);
        let [x, y] = [rect.x, rect.y].map(|ends| ends.map(|end| end as usize >> level));
        (y[0]..=y[1])
            .all(|y| (x[0]..=x[1]).all(|x| rect.nearest_depth < self.depth_of_cell(level, x, y)))
    }

    /// The level that a rectangle is asked at (LOD §5.3, equation 4, whose level counts from the picture's size down): the finest
    /// with cells no smaller than its larger side.
    pub fn level_of(&self, rect: &SampleRect) -> usize {
        let side = |ends: [i32; 2]| (ends[1] - ends[0] + 1) as u32;
        let larger = side(rect.x).max(side(rect.y));
        let level = larger.next_power_of_two().trailing_zeros() as usize;
        level.min(self.levels.len())
    }

    /// The N-th farthest depth in a cell of a level.
    pub fn depth_of_cell(&self, level: usize, x: usize, y: usize) -> f32 {
        match level.checked_sub(1) {
            None => self.samples.cell(x, y)[0],
            Some(above) => {
                let level = &self.levels[above];
                level.cell(x, y)[level.kept - 1]
            }
        }
    }
}

fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// The farthest of two by two cells that keep one depth each.
fn farthest_of_four(finer: &Level, coarser: &mut Level) {
    let rows = coarser.depths.chunks_exact_mut(coarser.width);
    for (row, cells) in rows.enumerate() {
        let of_row = |row: usize| &finer.depths[row * finer.width..][..finer.width];
        let above = of_row(2 * row);
        // What is missing beyond the border changes nothing if it is there twice.
        let below = of_row((2 * row + 1).min(finer.height - 1));
        let (above, last_above) = above.as_chunks::<2>();
        let (below, last_below) = below.as_chunks::<2>();
        for (cell, (above, below)) in cells.iter_mut().zip(above.iter().zip(below)) {
            *cell = lesser(lesser(above[0], above[1]), lesser(below[0], below[1]));
        }
        if let ([above], [below], Some(cell)) = (last_above, last_below, cells.last_mut()) {
            *cell = lesser(*above, *below);
        }
    }
}

/// The farthest depths of the samples of each tile.
fn farthest_of_tiles(samples: &Level, tiles: &mut Level) {
    let kept = tiles.kept;
    for (tile, farthest) in tiles.depths.chunks_exact_mut(kept).enumerate() {
        let (x, y) = (tile % tiles.width * TILE, tile / tiles.width * TILE);
        let mut depths = [UNCOVERED; TILE * TILE];
        for (row, depths) in depths.chunks_exact_mut(TILE).enumerate() {
            let samples = &samples.depths[(y + row) * samples.width + x..][..TILE];
            depths.copy_from_slice(samples);
        }
        depths.sort_unstable_by(f32::total_cmp);
        farthest.copy_from_slice(&depths[..kept]);
    }
}

/// The farthest depths of two by two cells that keep several each.
fn several_of_four(finer: &Level, coarser: &mut Level) {
    let kept = coarser.kept;
    for (cell, farthest) in coarser.depths.chunks_exact_mut(kept).enumerate() {
        let (x, y) = (2 * (cell % coarser.width), 2 * (cell / coarser.width));
        let below = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|[x, y]| {
            let is_there = x < finer.width && y < finer.height;
            if is_there { finer.cell(x, y) } else { &[] }
        });
        let mut next = [0; 4];
        for depth in farthest {
            let (mut least, mut from) = (UNCOVERED, None);
            for (i, cell) in below.iter().enumerate() {
                if let Some(&candidate) = cell.get(next[i])
                    && (from.is_none() || candidate < least)
                {
                    (least, from) = (candidate, Some(i));
                }
            }
            *depth = least;
            if let Some(from) = from {
                next[from] += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(size: [u32; 2], nth: u32, depth_at: impl Fn(usize, usize) -> f32) -> HierarchicalZ {
        let size = PictureSize::new(size[0], size[1]).expect("a size");
        let mut z = HierarchicalZ::new(size, NonZeroU32::new(nth).expect("not 0"));
        for y in 0..size.height() {
            for x in 0..size.width() {
                z.samples.depths[y * z.samples.width + x] = depth_at(x, y);
            }
        }
        z.finish();
        z
    }

    /// Depths without a pattern; one in eight samples is not covered.
    fn noise(x: usize, y: usize) -> f32 {
        let mixed = (x as u64 * 0x9e37_79b9 + y as u64 * 0x85eb_ca6b + 1)
            .wrapping_mul(0x2545_f491_4f6c_dd1d)
            >> 40;
        if mixed.is_multiple_of(8) {
            UNCOVERED
        } else {
            mixed as f32 / (1 << 24) as f32
        }
    }

    #[test]
    fn a_cell_keeps_the_nth_farthest_of_its_samples() {
        for size in [[1, 1], [8, 8], [37, 21], [130, 65]] {
            for nth in [1, 2, 5, 64] {
                let z = filled(size, nth, noise);
                let [width, height] = size.map(|s| s as usize);
                for level in 0..=z.levels.len() {
                    let edge = 1_usize << level;
                    for y in 0..height.div_ceil(edge) {
                        for x in 0..width.div_ceil(edge) {
                            let span = |c: usize, most: usize| c * edge..((c + 1) * edge).min(most);
                            let mut depths: Vec<f32> = span(y, height)
                                .flat_map(|y| span(x, width).map(move |x| noise(x, y)))
                                .collect();
                            depths.sort_unstable_by(f32::total_cmp);
                            let of_them = if level < LEVEL_OF_TILES {
                                0
                            } else {
                                nth as usize - 1
                            };
                            let expected = depths.get(of_them).copied().unwrap_or(UNCOVERED);
                            let found = z.depth_of_cell(level, x, y);
                            assert_eq!(found, expected, "{size:?}, {nth}, {level}: {x}, {y}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_question_reads_four_cells_at_the_most() {
        let z = filled([200, 100], 1, noise);
        for side in 1..200 {
            let rect = SampleRect {
                x: [0, side - 1],
                y: [0, 0],
                nearest_depth: 0.0,
            };
            let edge = 1 << z.level_of(&rect);
            assert!(edge >= side && (side == 1 || edge < 2 * side));
        }
    }

    #[test]
    fn behind_is_strictly_farther_and_ignores_one_less_than_n() {
        // One sample is far away.
        let far = |x, y| if [x, y] == [12, 9] { 0.25 } else { 0.5 };
        let is_behind = |nth, first: i32, side: i32, depth| {
            filled([64, 64], nth, far).is_behind(&SampleRect {
                x: [first, first + side - 1],
                y: [first, first + side - 1],
                nearest_depth: depth,
            })
        };
        for side in [5, 8, 11, 16] {
            let behind = |nth, depth| is_behind(nth, 8, side, depth);
            assert!(!behind(1, 0.25) && behind(1, 0.25_f32.next_down()));
            assert!(!behind(2, 0.5) && behind(2, 0.5_f32.next_down()));
        }
        // Beside it nothing is so far, and cells smaller than a tile ignore nothing.
        assert!(is_behind(1, 8, 4, 0.4));
        assert!(!is_behind(2, 9, 4, 0.25) && is_behind(2, 9, 4, 0.2));
    }
}
