//! The tile buffer: coverage and depth of the occluders drawn so far.

use std::ops::Range;

use antumbra_simd::PARTS_PER_TILE;
use antumbra_simd::coverage::rectangle_mask;
use antumbra_simd::tile::{NearLayers, UNCOVERED, merge};
use antumbra_simd::triangle::Triangle;
use rayon::prelude::*;

use super::for_each_tile;
use crate::view::PictureSize;

/// Rows of tiles that one thread fills at a time. Chosen small enough to share a picture out, large enough that a
/// triangle seldom meets two.
const ROWS_PER_BAND: usize = 4;

/// Fewer triangles than this are filled by the calling thread alone: waking others costs more.
const FEWEST_TO_SHARE: usize = 256;

/// Coverage masks and no-background depths of all tiles, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct TileBuffer {
    size: PictureSize,
    coverage: Vec<u64>,
    depths: Vec<[f32; PARTS_PER_TILE]>,
    near: Vec<NearLayers>,
}

impl TileBuffer {
    /// An empty buffer.
    pub fn new(size: PictureSize) -> TileBuffer {
        let tiles = size.tiles_across() * size.tiles_down();
        TileBuffer {
            size,
            coverage: vec![0; tiles],
            depths: vec![[UNCOVERED; PARTS_PER_TILE]; tiles],
            near: vec![NearLayers::EMPTY; tiles],
        }
    }

    /// Forgets everything drawn.
    pub fn clear(&mut self) {
        self.coverage.fill(0);
        self.depths.fill([UNCOVERED; PARTS_PER_TILE]);
        self.near.fill(NearLayers::EMPTY);
    }

    /// The picture's size.
    pub fn size(&self) -> PictureSize {
        self.size
    }

    /// One word a tile: bit `8·row + column` is set where the centre of that pixel is covered. Pixels of border tiles
    /// outside the picture are never covered.
    pub fn coverage(&self) -> &[u64] {
        &self.coverage
    }

    /// For the upper and the lower half of each tile: the farthest depth of the nearest occluder surfaces over the covered samples, or farther; [`UNCOVERED`] where none is covered. Depths
    /// are the larger the nearer.
    pub fn depths(&self) -> &[[f32; PARTS_PER_TILE]] {
        &self.depths
    }

    /// The near layers of each tile's halves: samples of which a nearer depth is known than their half's. See
    /// [`antumbra_simd::tile`].
    pub fn near_layers(&self) -> &[NearLayers] {
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
        let across = self.size.tiles_across();
        let serial = triangles.len() < FEWEST_TO_SHARE || rayon::current_num_threads() == 1;
        let rows = if serial {
            self.size.tiles_down()
        } else {
            ROWS_PER_BAND
        };
        let fill_band = |(index, mut band): (usize, Band<'_>)| {
            let first = index * rows;
            let last = first + band.coverage.len() / across;
            band.fill(triangles, first as i32..last as i32, across);
        };
        let tiles = rows * across;
        if serial {
            let (coverage, depths, near) = (&mut self.coverage, &mut self.depths, &mut self.near);
            fill_band((
                0,
                Band {
                    coverage,
                    depths,
                    near,
                },
            ));
        } else {
            let bands = self
                .coverage
                .par_chunks_mut(tiles)
                .zip(self.depths.par_chunks_mut(tiles));
            bands
                .zip(self.near.par_chunks_mut(tiles))
                .map(|((coverage, depths), near)| Band {
                    coverage,
                    depths,
                    near,
                })
                .enumerate()
                .for_each(fill_band);
        }
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

/// Some rows of tiles.
struct Band<'a> {
    coverage: &'a mut [u64],
    depths: &'a mut [[f32; PARTS_PER_TILE]],
    near: &'a mut [NearLayers],
}

impl Band<'_> {
    fn fill(&mut self, triangles: &[Triangle], rows: Range<i32>, across: usize) {
        for triangle in triangles {
            for_each_tile(triangle, rows.clone(), |tile_x, tile_y, mask| {
                let tile = (tile_y - rows.start) as usize * across + tile_x as usize;
                let (coverage, depths) = (&mut self.coverage[tile], &mut self.depths[tile]);
                merge(
                    coverage,
                    depths,
                    &mut self.near[tile],
                    mask,
                    triangle,
                    tile_x,
                    tile_y,
                );
            });
        }
    }
}
