//! The no-background Z-buffer (HOM §6.4), as drawing leaves it in the tiles.

use antumbra_simd::coverage::PART_MASKS;

use super::super::overlap::{mask_in_tile, tiles_of};
use super::SampleRect;
use crate::raster::TileBuffer;

/// Whether the rectangle's nearest depth is strictly farther than the depth of every tile part that holds one of its
/// samples. Parts without coverage pass: they are the overlap test's business.
pub fn is_behind(tiles: &TileBuffer, rect: &SampleRect) -> bool {
    let across = tiles.size().tiles_across();
    tiles_of(rect).all(|(x, y)| {
        let mask = mask_in_tile(rect, x, y);
        let depths = &tiles.depths()[y * across + x];
        depths
            .iter()
            .zip(PART_MASKS)
            .all(|(&depth, part)| mask & part == 0 || rect.nearest_depth < depth)
    })
}
