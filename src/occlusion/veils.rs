//! Translucent occluders (HOM §4.4): surfaces that let some light through, of which several hide nearly as much as an opaque one.
//!
//! Each sample keeps how much light all of them together let through: what one with opacity `α` leaves of it is a share of `1 − α`, so
//! their opacities combine to `1 − ∏(1 − αᵢ)`. It is kept in 255ths and rounded up. The pyramid counts a sample by that share
//! instead of as a whole, and so cells behind glass may reach their thresholds. What is covered then is as far away
//! as the farthest of these surfaces in its half of a tile.

use antumbra_simd::coverage::PART_MASKS;
use antumbra_simd::spans::SpanPolygon;
use antumbra_simd::triangle::Triangle;
use antumbra_simd::{PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

use crate::raster::TileBuffer;

/// Samples of a tile.
const SAMPLES: usize = 64;

/// The light that comes through where nothing translucent is.
const ALL: u8 = u8::MAX;

/// What translucent surfaces let through, tile by tile.
#[derive(Clone, Debug, Default)]
pub struct Veils {
    /// The light that comes through each sample, in 255ths; empty until something is drawn.
    light: Vec<[u8; SAMPLES]>,
    /// The farthest depth of these surfaces in each part.
    farthest: Vec<[f32; PARTS_PER_TILE]>,
}

impl Veils {
    /// Forgets all surfaces.
    pub fn clear(&mut self) {
        self.light.clear();
        self.farthest.clear();
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.light.is_empty()
    }

    /// Draws triangles with an opacity in 255ths. Their extents must lie within the map of `tiles`.
    pub fn draw(&mut self, triangles: &[Triangle], opacity: u8, tiles: &TileBuffer) {
        let count = tiles.coverage().len();
        self.light.resize(count, [ALL; SAMPLES]);
        self.farthest.resize(count, [f32::INFINITY; PARTS_PER_TILE]);
        let across = tiles.size().tiles_across();
        let left = u32::from(u8::MAX - opacity);
        for triangle in triangles {
            let polygon = SpanPolygon::of_triangle(triangle, tiles.inset());
            let [columns, rows] =
                [polygon.x, polygon.y].map(|v| v[0] / TILE_SIZE..=v[1] / TILE_SIZE);
            for tile_y in rows {
                for tile_x in columns.clone() {
                    let mask = polygon.coverage_of_tile(tile_x, tile_y);
                    let tile = tile_y as usize * across + tile_x as usize;
                    for bit in (0..SAMPLES).filter(|bit| mask >> bit & 1 == 1) {
                        let light = &mut self.light[tile][bit];
                        *light = (u32::from(*light) * left).div_ceil(u32::from(ALL)) as u8;
                    }
                    for part in (0..PARTS_PER_TILE).filter(|&part| mask & PART_MASKS[part] != 0) {
                        let y = tile_y * TILE_SIZE + part as i32 * PART_HEIGHT;
                        let rows = [y.max(polygon.y[0]), (y + PART_HEIGHT - 1).min(polygon.y[1])];
                        let depth = polygon.depth.over(tile_x, rows);
                        let farthest = &mut self.farthest[tile][part];
                        *farthest = if depth < *farthest { depth } else { *farthest };
                    }
                }
            }
        }
    }

    /// How much light comes through some samples of a tile, as a number of samples, rounded up.
    pub fn light_through(&self, tile: usize, samples: u64) -> u32 {
        let Some(light) = self.light.get(tile) else {
            return samples.count_ones();
        };
        let through = (0..SAMPLES).filter(|bit| samples >> bit & 1 == 1);
        let sum: u32 = through.map(|bit| u32::from(light[bit])).sum();
        sum.div_ceil(u32::from(ALL))
    }

    /// The farthest depths of the surfaces in a tile's parts; infinitely near where there are none.
    pub fn farthest(&self, tile: usize) -> [f32; PARTS_PER_TILE] {
        let none = [f32::INFINITY; PARTS_PER_TILE];
        self.farthest.get(tile).copied().unwrap_or(none)
    }
}
