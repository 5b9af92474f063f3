//! The pyramid of occlusion maps (HOM §4) and its thresholds (HOM §5.3).

use antumbra_simd::TILE_SIZE;
use antumbra_simd::pyramid::{sum_2x2, uncovered};

use crate::raster::TileBuffer;
use crate::view::PictureSize;

/// How much may be lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Accuracy {
    /// Nothing that owns a pixel is ever culled.
    #[default]
    Exact,
    /// Up to `hole` uncovered pixels are ignored in any window of a tile's size, 8×8 pixels (HOM §5.3.3). A window
    /// meets at most four tiles, so a quarter is ignored in each. The bound is on a count, not on a shape.
    Approximate {
        /// Pixels.
        hole: u32,
    },
}

impl Accuracy {
    /// How many uncovered pixels a cell may hold and still count as opaque. The same at every level: all of a coarse
    /// cell's may lie in one of its tiles (a distribution factor of 1 in HOM §5.3.3.1).
    pub fn ignored_per_cell(self) -> u32 {
        match self {
            Accuracy::Exact => 0,
            Accuracy::Approximate { hole } => hole / 4,
        }
    }
}

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
        let level_of_loops = tiles.level();
        uncovered(
            level_of_loops,
            tiles.coverage(),
            &self.picture,
            &mut self.levels[0].uncovered,
        );
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
