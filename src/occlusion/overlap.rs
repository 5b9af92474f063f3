//! The overlap test: does a rectangle of samples lie within what the occluders cover?
//!
//! The algorithm is HOM's (§5.2, figure 5.3), with ≥ for the figure's strict > so that a threshold of 1 still culls.
//! Below level 0, where the paper stops, the rectangle's mask is compared with the tile's coverage bits. A frame covers the holes
//! that may be ignored beforehand ([`holes`](super::holes)) and does without this test: it is what that is measured by.

use antumbra_simd::TILE_SIZE;
use antumbra_simd::coverage::rectangle_mask;

use super::{OcclusionMap, SampleRect, Thresholds};
use crate::raster::TileBuffer;

/// Whether the rectangle lies within covered samples, up to the holes that may be ignored. `map` must be built from `tiles`.
pub fn is_covered(
    map: &OcclusionMap,
    tiles: &TileBuffer,
    rect: &SampleRect,
    thresholds: &Thresholds,
) -> bool {
    let test = Test {
        map,
        tiles,
        rect,
        thresholds,
    };
    test.all_cells(rect.x, rect.y, map.level_for(rect))
}

/// Whether every sample of the rectangle is covered, asked of the tiles alone: for a buffer that is still being drawn
/// to and has no map.
pub fn is_covered_so_far(tiles: &TileBuffer, rect: &SampleRect) -> bool {
    let across = tiles.size().tiles_across();
    tiles_of(rect).all(|(x, y)| mask_in_tile(rect, x, y) & !tiles.coverage()[y * across + x] == 0)
}

/// The tiles that a rectangle touches, row by row.
pub(super) fn tiles_of(rect: &SampleRect) -> impl Iterator<Item = (usize, usize)> {
    let span = |s: [i32; 2]| (s[0] / TILE_SIZE) as usize..=(s[1] / TILE_SIZE) as usize;
    let columns = span(rect.x);
    span(rect.y).flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

/// The samples of a tile that lie in the rectangle, which touches the tile.
#[inline]
pub(super) fn mask_in_tile(rect: &SampleRect, tile_x: usize, tile_y: usize) -> u64 {
    let within = |s: [i32; 2], tile: usize| {
        let start = tile as i32 * TILE_SIZE;
        [(s[0] - start).max(0), (s[1] - start).min(TILE_SIZE - 1)]
    };
    rectangle_mask(within(rect.x, tile_x), within(rect.y, tile_y))
}

struct Test<'a> {
    map: &'a OcclusionMap,
    tiles: &'a TileBuffer,
    rect: &'a SampleRect,
    thresholds: &'a Thresholds,
}

impl Test<'_> {
    /// Checks the cells of a level that hold samples of the rectangle within columns `x` and rows `y`.
    fn all_cells(&self, x: [i32; 2], y: [i32; 2], level: usize) -> bool {
        let edge = (TILE_SIZE as usize) << level;
        let span = |s: [i32; 2], r: [i32; 2]| {
            s[0].max(r[0]) as usize / edge..=s[1].min(r[1]) as usize / edge
        };
        span(y, self.rect.y).all(|cy| span(x, self.rect.x).all(|cx| self.cell(level, cx, cy)))
    }

    fn cell(&self, level: usize, x: usize, y: usize) -> bool {
        let uncovered = self.map.uncovered(level, x, y);
        if uncovered == 0 {
            return true;
        }
        // Conservative rejection (HOM §5.3.1), and what has no coverage at all.
        let covered = self.map.samples_of_cell(level, x, y) - uncovered;
        if covered == 0 || level > 0 && covered <= self.thresholds.lost(level) {
            return false;
        }
        if uncovered <= self.thresholds.ignored(level) {
            return true;
        }
        if level == 0 {
            let coverage = self.tiles.coverage()[y * self.map.width_of_level(0) + x];
            return mask_in_tile(self.rect, x, y) & !coverage == 0;
        }
        let [columns, rows] = self.map.pixels_of_cell(level, x, y);
        // Predictive rejection (HOM §5.3.4): in a cell wholly in the rectangle, more is uncovered than finer cells let pass.
        let in_rect = |cell: [i32; 2], rect: [i32; 2]| rect[0] <= cell[0] && cell[1] <= rect[1];
        let must_fail = u64::from(uncovered) > self.thresholds.passed_below(level);
        if must_fail && in_rect(columns, self.rect.x) && in_rect(rows, self.rect.y) {
            return false;
        }
        self.all_cells(columns, rows, level - 1)
    }
}
