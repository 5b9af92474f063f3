//! The pyramid of occlusion maps (HOM §4).

use antumbra_simd::pyramid::{sum_2x2, uncovered};
use antumbra_simd::{Level as LoopLevel, TILE_SIZE};

use super::SampleRect;
use super::veils::Veils;
use crate::raster::TileBuffer;
use crate::view::PictureSize;

#[derive(Clone, Debug)]
struct Level {
    width: usize,
    uncovered: Vec<u32>,
}

/// Occlusion maps from one cell a tile (level 0) up to a single cell, each level a quarter of the one below.
///
/// A cell keeps how many of its picture pixels are uncovered; its opacity in HOM's sense is 1 minus their share.
#[derive(Clone, Debug)]
pub struct OcclusionMap {
    size: PictureSize,
    picture: Vec<u64>,
    levels: Vec<Level>,
}

impl OcclusionMap {
    /// The pyramid of an empty buffer.
    pub fn new(tiles: &TileBuffer) -> OcclusionMap {
        let size = tiles.size();
        let (mut width, mut height) = (size.tiles_across(), size.tiles_down());
        let picture = (0..width * height)
            .map(|i| tiles.picture_mask(i % width, i / width))
            .collect();
        let mut levels = vec![Level {
            width,
            uncovered: vec![0; width * height],
        }];
        while width * height > 1 {
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
            levels.push(Level {
                width,
                uncovered: vec![0; width * height],
            });
        }
        let mut map = OcclusionMap {
            size,
            picture,
            levels,
        };
        map.build(tiles);
        map
    }

    /// Counts anew what a buffer leaves uncovered.
    ///
    /// # Panics
    /// If the buffer is not of the size that the map was made for.
    pub fn build(&mut self, tiles: &TileBuffer) {
        self.count(tiles.level(), tiles.coverage());
    }

    /// The same of coverage masks.
    pub(super) fn count(&mut self, level_of_loops: LoopLevel, coverage: &[u64]) {
        self.count_with(level_of_loops, coverage, &Veils::default());
    }

    /// The same, with samples counted by the light that comes through them.
    pub(super) fn count_with(
        &mut self,
        level_of_loops: LoopLevel,
        coverage: &[u64],
        veils: &Veils,
    ) {
        uncovered(
            level_of_loops,
            coverage,
            &self.picture,
            &mut self.levels[0].uncovered,
        );
        if !veils.is_empty() {
            let samples = coverage.iter().zip(&self.picture).enumerate();
            let counts = self.levels[0].uncovered.iter_mut();
            for (count, (tile, (covered, picture))) in counts.zip(samples) {
                *count = veils.light_through(tile, picture & !covered);
            }
        }
        for level in 1..self.levels.len() {
            let (fine, coarse) = self.levels.split_at_mut(level);
            let fine = &fine[level - 1];
            sum_2x2(
                level_of_loops,
                &fine.uncovered,
                fine.width,
                &mut coarse[0].uncovered,
            );
        }
    }

    /// How many levels there are; level 0 is the finest.
    pub fn level_count(&self) -> usize {
        self.levels.len()
    }

    /// The uncovered picture pixels of each cell of a level, row by row.
    pub fn uncovered_of_level(&self, level: usize) -> &[u32] {
        &self.levels[level].uncovered
    }

    /// Where a test of a rectangle begins: at the finest level whose cells are larger than its smaller side (HOM §5.2.1).
    pub(super) fn level_for(&self, rect: &SampleRect) -> usize {
        let side = |s: [i32; 2]| s[1] - s[0] + 1;
        let smaller = side(rect.x).min(side(rect.y));
        let last = self.level_count() - 1;
        (0..last)
            .find(|&level| TILE_SIZE << level > smaller)
            .unwrap_or(last)
    }

    /// The columns and rows of a level.
    pub(super) fn cells_of_level(&self, level: usize) -> [usize; 2] {
        let Level { width, uncovered } = &self.levels[level];
        [*width, uncovered.len() / width]
    }

    /// How many samples of the picture a cell has.
    #[inline]
    pub(super) fn samples_of_cell(&self, level: usize, x: usize, y: usize) -> u32 {
        let [columns, rows] = self.pixels_of_cell(level, x, y);
        let side = |s: [i32; 2]| (s[1] - s[0] + 1) as u32;
        side(columns) * side(rows)
    }

    /// The columns of a level.
    pub fn width_of_level(&self, level: usize) -> usize {
        self.levels[level].width
    }

    /// The uncovered picture pixels of a cell.
    #[inline]
    pub fn uncovered(&self, level: usize, x: usize, y: usize) -> u32 {
        let level = &self.levels[level];
        level.uncovered[y * level.width + x]
    }

    /// The columns and rows of picture pixels that a cell stands for, ends included.
    #[inline]
    pub fn pixels_of_cell(&self, level: usize, x: usize, y: usize) -> [[i32; 2]; 2] {
        let edge = (TILE_SIZE as usize) << level;
        let span = |cell: usize, pixels: usize| {
            [
                (cell * edge) as i32,
                ((cell + 1) * edge).min(pixels) as i32 - 1,
            ]
        };
        [span(x, self.size.width()), span(y, self.size.height())]
    }

    /// The samples of a tile that belong to the picture.
    #[inline]
    pub fn picture_mask(&self, tile_x: usize, tile_y: usize) -> u64 {
        self.picture[tile_y * self.levels[0].width + tile_x]
    }
}
