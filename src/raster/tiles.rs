//! The tile buffer: coverage and depth of the occluders drawn so far.

use std::ops::Range;

use super::BlockList;
use super::bands::Bands;
use crate::tasks::{Tasks, Work};
use crate::view::{MapScale, PictureSize};
use antumbra_simd::Level;
use antumbra_simd::PARTS_PER_TILE;
use antumbra_simd::blocks::{find_blocks, is_behind_blocks};
use antumbra_simd::closer::LayeredTiles;
use antumbra_simd::coverage::{PART_MASKS, rectangle_mask};
use antumbra_simd::fill::{TileRows, fill};
use antumbra_simd::query::{Rectangle, Tiles, is_behind_all};
use antumbra_simd::spans::SpanPolygon;
use antumbra_simd::tile::UNCOVERED;
use antumbra_simd::triangle::Triangle;

/// A rectangle is asked by blocks of tiles first if it reaches over so many samples, across and down.
const LARGE: i32 = 64;

/// Coverage masks and no-background depths of all tiles, row by row.
#[derive(Clone, Debug)]
pub struct TileBuffer {
    size: PictureSize,
    /// Sub-pixels by which what is drawn is pulled in.
    inset: i32,
    coverage: Vec<u64>,
    depths: Vec<[f32; PARTS_PER_TILE]>,
    near_samples: Vec<u64>,
    near: Vec<[f32; PARTS_PER_TILE]>,
    level: Level,
    bands: Bands,
    /// What the owners of blocks gain in each band.
    gains: Vec<u32>,
    /// What blocks of tiles hide as a whole; empty if that is not known of the tiles as they are.
    blocks: Vec<f32>,
    /// Rows of tiles that what is drawn is confined to, if it is.
    rows: Option<Range<usize>>,
}

/// Equal if everything that means something is: not the depths of layers without samples, nor the instruction set.
impl PartialEq for TileBuffer {
    fn eq(&self, other: &TileBuffer) -> bool {
        let near = |tiles: &TileBuffer, tile: usize| {
            let samples = tiles.near_samples[tile];
            PART_MASKS
                .iter()
                .zip(tiles.near[tile])
                .map(move |(&mask, depth)| (samples & mask != 0).then_some(depth))
                .collect::<Vec<_>>()
        };
        self.size == other.size
            && self.coverage == other.coverage
            && self.depths == other.depths
            && self.near_samples == other.near_samples
            && (0..self.near.len()).all(|tile| near(self, tile) == near(other, tile))
    }
}

impl TileBuffer {
    /// An empty buffer.
    pub fn new(size: PictureSize) -> TileBuffer {
        TileBuffer::with_map_scale(size, MapScale::Full)
    }

    /// An empty buffer for a map of this scale; `size` is the map's.
    pub(crate) fn with_map_scale(size: PictureSize, scale: MapScale) -> TileBuffer {
        let tiles = size.tiles_across() * size.tiles_down();
        TileBuffer {
            size,
            inset: scale.inset(),
            coverage: vec![0; tiles],
            depths: vec![[UNCOVERED; PARTS_PER_TILE]; tiles],
            near_samples: vec![0; tiles],
            near: vec![[UNCOVERED; PARTS_PER_TILE]; tiles],
            level: Level::best(),
            bands: Bands::default(),
            gains: Vec::new(),
            blocks: Vec::new(),
            rows: None,
        }
    }

    /// Forgets everything drawn.
    pub fn clear(&mut self) {
        self.clear_by(Tasks::ALONE);
    }

    /// Forgets everything drawn, in tasks.
    pub(crate) fn clear_by(&mut self, tasks: Tasks<'_>) {
        self.rows = None;
        let rows = self.size.tiles_down();
        self.bands.weigh(rows, tasks.threads(), std::iter::empty());
        self.gains.clear();
        self.each_band(tasks, Work::Clear, |band| {
            band.coverage.fill(0);
            band.far.fill([UNCOVERED; PARTS_PER_TILE]);
            band.near_samples.fill(0);
        });
    }

    /// Forgets what was drawn in some columns and rows of tiles, and confines to these rows what is drawn from now on, until all is
    /// cleared or [`TileBuffer::draw_everywhere`] is called.
    pub(crate) fn clear_within(&mut self, columns: Range<usize>, rows: Range<usize>) {
        self.blocks.clear();
        let across = self.size.tiles_across();
        for row in rows.clone() {
            let tiles = row * across + columns.start..row * across + columns.end;
            self.coverage[tiles.clone()].fill(0);
            self.depths[tiles.clone()].fill([UNCOVERED; PARTS_PER_TILE]);
            self.near_samples[tiles].fill(0);
        }
        self.rows = Some(rows);
    }

    /// Lets be drawn to all rows again.
    pub(crate) fn draw_everywhere(&mut self) {
        self.rows = None;
    }

    /// Chooses the instruction set; the best one at first.
    pub fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    /// The instruction set.
    pub fn level(&self) -> Level {
        self.level
    }

    /// Sets by how many sub-pixels polygons are pulled in.
    pub(crate) fn set_inset(&mut self, inset: i32) {
        self.inset = inset;
    }

    /// Covers samples of a tile that are not, as far away as what is covered beside them, in the same part or in the other one,
    /// and no nearer than depths that are given for the parts. Where there is neither, what is covered hides everything (HOM §6.4).
    pub(crate) fn cover(&mut self, tile: usize, samples: u64, farthest: [f32; PARTS_PER_TILE]) {
        let before = self.coverage[tile];
        self.coverage[tile] |= samples;
        let depths = &mut self.depths[tile];
        for part in 0..PARTS_PER_TILE {
            if before & PART_MASKS[part] == 0 {
                depths[part] = depths[1 - part];
            }
        }
        for part in 0..PARTS_PER_TILE {
            if samples & PART_MASKS[part] != 0 && farthest[part] < depths[part] {
                depths[part] = farthest[part];
            }
        }
    }

    /// By how many sub-pixels polygons are pulled in: see [`MapScale`].
    pub(crate) fn inset(&self) -> i32 {
        self.inset
    }

    /// The map's size; the picture's, if that is its scale.
    pub fn size(&self) -> PictureSize {
        self.size
    }

    /// One word a tile: bit `8·row + column` is set where the centre of that pixel is covered. Pixels of border tiles
    /// outside the picture are never covered.
    pub fn coverage(&self) -> &[u64] {
        &self.coverage
    }

    /// For the upper and the lower half of each tile: the farthest depth of the nearest occluder surfaces over the covered
    /// samples, or farther; [`UNCOVERED`] where none is covered. Depths are the larger the nearer.
    pub fn depths(&self) -> &[[f32; PARTS_PER_TILE]] {
        &self.depths
    }

    /// The samples of each tile's near layers: a nearer depth is known of them than their half's. See
    /// [`antumbra_simd::tile`].
    pub fn near_samples(&self) -> &[u64] {
        &self.near_samples
    }

    /// The depths of the near layers of each tile's halves; unspecified where a half has no sample in its near layer.
    pub fn near_depths(&self) -> &[[f32; PARTS_PER_TILE]] {
        &self.near
    }

    /// The samples of a tile that belong to the picture.
    pub fn picture_mask(&self, tile_x: usize, tile_y: usize) -> u64 {
        let last = |pixels: usize, tile: usize| (pixels - 8 * tile).min(8) as i32 - 1;
        rectangle_mask(
            [0, last(self.size.width(), tile_x)],
            [0, last(self.size.height(), tile_y)],
        )
    }

    /// Fills triangles in order. The extents of all must lie within the picture.
    pub fn fill(&mut self, triangles: &[Triangle]) {
        let mut list = BlockList::default();
        let polygon = |t: &Triangle| SpanPolygon::of_triangle(t, self.inset);
        list.blocks.pack(triangles.iter().map(polygon));
        list.find_rows();
        let in_a_pool = rayon::current_thread_index().is_some();
        let threads = if in_a_pool {
            rayon::current_num_threads()
        } else {
            1
        };
        self.fill_blocks(std::iter::once(&list), &mut [], Tasks::shared(threads));
    }

    /// Finds out what blocks of tiles hide as a whole: until something is drawn, questions about large rectangles are quicker.
    pub(crate) fn find_blocks(&mut self) {
        let mut blocks = std::mem::take(&mut self.blocks);
        find_blocks(self.level, self.tiles(), &mut blocks);
        self.blocks = blocks;
    }

    /// Whether a rectangle of samples is hidden.
    pub(crate) fn hides(&self, rectangle: Rectangle) -> bool {
        let Rectangle { x, y, .. } = rectangle;
        let is_large = (x[1] - x[0]).min(y[1] - y[0]) >= LARGE;
        is_large
            && !self.blocks.is_empty()
            && is_behind_blocks(&self.blocks, self.size.tiles_across(), rectangle)
            || is_behind_all(self.level, self.tiles(), rectangle)
    }

    /// What closer questions read.
    pub(crate) fn layered(&self) -> LayeredTiles<'_> {
        LayeredTiles {
            coverage: &self.coverage,
            far: &self.depths,
            near_samples: &self.near_samples,
            near: &self.near,
            across: self.size.tiles_across(),
        }
    }

    /// What questions read.
    pub(crate) fn tiles(&self) -> Tiles<'_> {
        Tiles {
            coverage: &self.coverage,
            depths: &self.depths,
            across: self.size.tiles_across(),
        }
    }

    /// Fills triangles in order, list after list, and adds to `gains` what their owners gain: see [`TileRows`].
    pub(crate) fn fill_blocks<'a>(
        &mut self,
        lists: impl Iterator<Item = &'a BlockList> + Clone + Sync,
        gains: &mut [u32],
        tasks: Tasks<'_>,
    ) {
        let level = self.level;
        let rows = self.size.tiles_down();
        // A few rows are not worth sharing.
        let threads = if self.rows.is_some() {
            1
        } else {
            tasks.threads()
        };
        self.bands.weigh(rows, threads, lists.clone());
        self.gains.clear();
        self.gains.resize(self.bands.count() * gains.len(), 0);
        self.each_band(tasks, Work::Fill, |mut band| {
            let first = band.first_row;
            let last = first + (band.coverage.len() / band.across) as i32 - 1;
            let lists = lists.clone();
            let runs = lists.flat_map(|list| list.in_rows(first, last));
            fill(level, runs, &mut band);
        });
        if !gains.is_empty() {
            for of_band in self.gains.chunks(gains.len()) {
                for (sum, gain) in gains.iter_mut().zip(of_band) {
                    *sum += gain;
                }
            }
        }
    }

    /// Does something with all tiles, band after band.
    fn each_band(&mut self, tasks: Tasks<'_>, work: Work, of_band: impl Fn(TileRows<'_>) + Sync) {
        self.blocks.clear();
        let (bands, gains) = (&self.bands, self.gains.len());
        let all = TileRows {
            coverage: &mut self.coverage,
            far: &mut self.depths,
            near_samples: &mut self.near_samples,
            near: &mut self.near,
            first_row: 0,
            across: self.size.tiles_across(),
            height: self.size.height() as i32,
            gains: &mut self.gains,
        };
        if let Some(rows) = self.rows.clone() {
            let (_, below) = split_rows(all, rows.start, 0);
            let (part, _) = split_rows(below, rows.len(), gains);
            return tasks.alone(work, || of_band(part));
        }
        let owners = all.gains.len() / bands.count().max(1);
        tasks.divide(
            work,
            bands.count(),
            all,
            |some, count| {
                let rows = bands.rows_from(some.first_row as usize, count);
                split_rows(some, rows, count * owners)
            },
            of_band,
        );
    }

    /// 64-bit FNV-1a over the coverage words and then the depth values, as little-endian bytes, row by row.
    pub fn hash(&self) -> u64 {
        let coverage = self.coverage.iter().flat_map(|word| word.to_le_bytes());
        let depths = self
            .depths
            .iter()
            .flatten()
            .flat_map(|depth| depth.to_bits().to_le_bytes());
        coverage
            .chain(depths)
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
            })
    }
}

/// The first `rows` rows of tiles with as many gains, and the others.
fn split_rows(band: TileRows<'_>, rows: usize, gains: usize) -> (TileRows<'_>, TileRows<'_>) {
    let (across, first_row, height) = (band.across, band.first_row, band.height);
    let tiles = rows * across;
    let (coverage, coverage_below) = band.coverage.split_at_mut(tiles);
    let (far, far_below) = band.far.split_at_mut(tiles);
    let (near_samples, near_samples_below) = band.near_samples.split_at_mut(tiles);
    let (near, near_below) = band.near.split_at_mut(tiles);
    let (gains, gains_below) = band.gains.split_at_mut(gains);
    let above = TileRows {
        coverage,
        far,
        near_samples,
        near,
        first_row,
        across,
        height,
        gains,
    };
    let below = TileRows {
        coverage: coverage_below,
        far: far_below,
        near_samples: near_samples_below,
        near: near_below,
        first_row: first_row + rows as i32,
        across,
        height,
        gains: gains_below,
    };
    (above, below)
}
