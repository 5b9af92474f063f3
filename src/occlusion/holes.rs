//! Holes that approximate accuracy ignores are covered, once for all questions.
//!
//! HOM §5.3.2 takes a cell for opaque if its opacity reaches the threshold of its level, whenever a test meets it. Here such
//! cells become opaque in the tiles themselves: their uncovered samples are covered from then on, as far away as what is covered
//! around them. Every question is then the exact one, with its speed; and what is ignored is a set of pixels, not a matter of who
//! asks: **a pixel that is wrong was ignored**, so their number bounds the error before a picture is drawn.
//! ([`is_covered`](super::is_covered) is HOM's test itself, and says the same of a rectangle.)
//!
//! What was ignored counts as uncovered whenever cells are looked at again, so that holes do not grow by being closed one after the
//! other.

use antumbra_simd::TILE_SIZE;
use antumbra_simd::triangle::Triangle;

use super::veils::Veils;
use super::{Accuracy, OcclusionMap, SampleRect, Thresholds};
use crate::raster::TileBuffer;
use crate::view::MapScale;

/// The holes of a frame.
#[derive(Clone, Debug)]
pub struct Holes {
    map: OcclusionMap,
    thresholds: Thresholds,
    /// The cells that are smaller than a tile: their edges in samples, and up to how many uncovered samples they are opaque.
    small_cells: Vec<(i32, u32)>,
    /// The samples of each tile that were covered because they may be ignored.
    ignored: Vec<u64>,
    /// The samples of each tile that are covered by something.
    solid: Vec<u64>,
    samples: u64,
    veils: Veils,
}

impl Holes {
    /// For buffers like this one.
    pub fn new(tiles: &TileBuffer, accuracy: &Accuracy, scale: MapScale) -> Holes {
        let map = OcclusionMap::new(tiles);
        let per_sample = scale.pixels() * scale.pixels();
        let level_of_tile = scale.pixels().trailing_zeros() as u8;
        let small_cells = accuracy
            .approximation()
            .map_or(Vec::new(), |approximation| {
                // The coarser first: what they ignore needs no finer look.
                let levels = (approximation.base_level..level_of_tile).rev();
                let cell = |level: u8| {
                    let edge = TILE_SIZE >> (level_of_tile - level);
                    let ignored = approximation.ignored(level) / f64::from(per_sample);
                    (edge, ignored as u32)
                };
                levels
                    .map(cell)
                    .filter(|&(_, ignored)| ignored > 0)
                    .collect()
            });
        Holes {
            thresholds: Thresholds::new(accuracy, scale, map.level_count()),
            map,
            small_cells,
            ignored: vec![0; tiles.coverage().len()],
            solid: vec![0; tiles.coverage().len()],
            samples: 0,
            veils: Veils::default(),
        }
    }

    /// Forgets what was ignored, and what is translucent.
    pub fn clear(&mut self) {
        self.veils.clear();
        self.ignored.fill(0);
        self.samples = 0;
    }

    /// How many samples are ignored.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// How many samples may be ignored in a tile, whatever is around it.
    pub(super) fn ignored_in_tile(&self) -> u32 {
        self.thresholds.ignored(0)
    }

    /// The samples of each tile that are ignored.
    pub fn ignored(&self) -> &[u64] {
        &self.ignored
    }

    /// Whether a rectangle meets a cell with so little coverage that it is taken for uncovered (HOM §5.3.1), as of the last look.
    pub fn is_hardly_covered(&self, rect: &SampleRect) -> bool {
        let level = self.map.level_for(rect);
        let lost = self.thresholds.lost(level);
        let edge = TILE_SIZE << level;
        let cells = |s: [i32; 2]| (s[0] / edge) as usize..=(s[1] / edge) as usize;
        lost > 0
            && cells(rect.y).any(|y| {
                cells(rect.x).any(|x| {
                    let all = self.map.samples_of_cell(level, x, y);
                    all - self.map.uncovered(level, x, y) <= lost
                })
            })
    }

    /// Draws translucent triangles, with an opacity in 255ths.
    pub(super) fn draw_translucent(
        &mut self,
        triangles: &[Triangle],
        opacity: u8,
        tiles: &TileBuffer,
    ) {
        self.veils.draw(triangles, opacity, tiles);
    }

    /// Covers what may be ignored.
    pub fn close(&mut self, tiles: &mut TileBuffer) {
        let samples = self
            .solid
            .iter_mut()
            .zip(tiles.coverage())
            .zip(&self.ignored);
        for ((solid, &covered), &ignored) in samples {
            *solid = covered & !ignored;
        }
        let Holes {
            map, solid, veils, ..
        } = self;
        map.count_with(tiles.level(), solid, veils);
        self.close_cell(tiles, self.map.level_count() - 1, 0, 0);
    }

    /// Covers what may be ignored in a cell.
    fn close_cell(&mut self, tiles: &mut TileBuffer, level: usize, x: usize, y: usize) {
        let uncovered = self.map.uncovered(level, x, y);
        // Behind glass that lets nothing through there is something to cover as well.
        let is_done = uncovered == 0 && self.veils.is_empty();
        if is_done || uncovered == self.map.samples_of_cell(level, x, y) {
            return;
        }
        if uncovered <= self.thresholds.ignored(level) {
            let [columns, rows] = [x, y].map(|v| v << level..(v + 1) << level);
            let [across, down] = self.map.cells_of_level(0);
            for y in rows.start..rows.end.min(down) {
                for x in columns.start..columns.end.min(across) {
                    self.ignore(tiles, x, y, u64::MAX);
                }
            }
        } else if level == 0 {
            let picture = self.map.picture_mask(x, y);
            let tile = y * self.map.width_of_level(0) + x;
            let holes = small_holes(&self.small_cells, picture & !self.solid[tile]);
            self.ignore(tiles, x, y, holes);
        } else {
            let [across, down] = self.map.cells_of_level(level - 1);
            for y in 2 * y..(2 * y + 2).min(down) {
                for x in 2 * x..(2 * x + 2).min(across) {
                    self.close_cell(tiles, level - 1, x, y);
                }
            }
        }
    }

    /// Covers those of a tile's samples that are not.
    fn ignore(&mut self, tiles: &mut TileBuffer, x: usize, y: usize, samples: u64) {
        let tile = y * self.map.width_of_level(0) + x;
        let holes = samples & self.map.picture_mask(x, y) & !tiles.coverage()[tile];
        if holes != 0 {
            tiles.cover(tile, holes, self.veils.farthest(tile));
            self.ignored[tile] |= holes;
            self.samples += u64::from(holes.count_ones());
        }
    }
}

/// The uncovered samples of a tile's cells that may be ignored.
fn small_holes(cells: &[(i32, u32)], uncovered: u64) -> u64 {
    let mut holes = 0;
    for &(edge, ignored) in cells {
        let row = (1_u64 << edge) - 1;
        let cell = (0..edge).fold(0, |cell, y| cell | row << (y * TILE_SIZE));
        for y in (0..TILE_SIZE).step_by(edge as usize) {
            for x in (0..TILE_SIZE).step_by(edge as usize) {
                let of_cell = uncovered & cell << (y * TILE_SIZE + x);
                if of_cell.count_ones() <= ignored && of_cell != cell << (y * TILE_SIZE + x) {
                    holes |= of_cell;
                }
            }
        }
    }
    holes
}
