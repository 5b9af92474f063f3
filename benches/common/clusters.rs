//! Clusters and tiles as the loops take them: what benches know of those interfaces stands here.

use antumbra::cull::Level;
use antumbra::prepare::ClusterGeometry;
use antumbra::raster::TileBuffer;
use antumbra::view::PictureSize;
use antumbra_simd::PARTS_PER_TILE;
use antumbra_simd::assemble::Cluster;
use antumbra_simd::closer::LayeredTiles;
use antumbra_simd::fill::{TileRows, fill};
use antumbra_simd::query::Tiles;
use antumbra_simd::spans::SpanBlock;
use antumbra_simd::tile::UNCOVERED;

/// A cluster to assemble.
pub fn cluster(geometry: ClusterGeometry<'_>) -> Cluster<'_> {
    Cluster {
        x: geometry.x,
        y: geometry.y,
        z: geometry.z,
        vertices: geometry.vertex_count,
        quads: geometry.quads,
    }
}

/// What rectangles are asked of.
pub fn tiles(buffer: &TileBuffer) -> Tiles<'_> {
    Tiles {
        coverage: buffer.coverage(),
        depths: buffer.depths(),
        across: buffer.size().tiles_across(),
    }
}

/// What boxes are asked of.
pub fn layered(buffer: &TileBuffer) -> LayeredTiles<'_> {
    LayeredTiles {
        coverage: buffer.coverage(),
        far: buffer.depths(),
        near_samples: buffer.near_samples(),
        near: buffer.near_depths(),
        across: buffer.size().tiles_across(),
    }
}

/// A picture's tiles, to fill.
#[derive(Clone)]
pub struct Canvas {
    coverage: Vec<u64>,
    far: Vec<[f32; PARTS_PER_TILE]>,
    near_samples: Vec<u64>,
    near: Vec<[f32; PARTS_PER_TILE]>,
    across: usize,
    height: i32,
}

impl Canvas {
    pub fn new(size: PictureSize) -> Canvas {
        let tiles = size.tiles_across() * size.tiles_down();
        Canvas {
            coverage: vec![0; tiles],
            far: vec![[UNCOVERED; PARTS_PER_TILE]; tiles],
            near_samples: vec![0; tiles],
            near: vec![[UNCOVERED; PARTS_PER_TILE]; tiles],
            across: size.tiles_across(),
            height: size.height() as i32,
        }
    }

    pub fn fill(&mut self, level: Level, blocks: &[SpanBlock]) {
        let mut rows = TileRows {
            coverage: &mut self.coverage,
            far: &mut self.far,
            near_samples: &mut self.near_samples,
            near: &mut self.near,
            first_row: 0,
            across: self.across,
            height: self.height,
            gains: &mut [],
        };
        fill(level, std::iter::once(blocks), &mut rows);
    }

    /// The samples that are covered.
    pub fn covered(&self) -> u64 {
        self.coverage
            .iter()
            .map(|c| u64::from(c.count_ones()))
            .sum()
    }
}
