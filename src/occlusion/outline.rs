//! The question of a box: is it hidden at each sample inside its outline?
//!
//! It asks the same two tests as the question of a rectangle (HOM §3.1), over fewer samples and with a farther depth at
//! most of them: do the occluders cover the outline ([`Strip::is_covered`](antumbra_simd::outline::Strip::is_covered)),
//! and is each face of the box behind them ([`Faces::are_behind`])? Row of tiles by row of tiles, so that the outline's
//! samples are found once for both.

use antumbra_simd::TILE_SIZE;
use antumbra_simd::faces::{Faces, RowLayers};
use antumbra_simd::outline::Outline;

use super::Accuracy;
use crate::raster::TileBuffer;

/// Whether all samples of an outline are covered, up to the holes that `accuracy` ignores in each tile, and what is
/// behind `faces` there is strictly farther than what covers them. With `is_covered` the first is known.
pub fn is_outline_hidden(
    tiles: &TileBuffer,
    outline: &Outline,
    faces: &Faces,
    accuracy: Accuracy,
    is_covered: bool,
) -> bool {
    let across = tiles.size().tiles_across();
    let ignored = accuracy.ignored_per_cell();
    (outline.y[0] / TILE_SIZE..=outline.y[1] / TILE_SIZE).all(|tile_y| {
        let start = tile_y as usize * across;
        let row = start..start + across;
        let strip = outline.strip(tile_y);
        let layers = RowLayers {
            far: &tiles.depths()[row.clone()],
            near_samples: &tiles.near_samples()[row.clone()],
            near: &tiles.near_depths()[row.clone()],
        };
        (is_covered || strip.is_covered(&tiles.coverage()[row], ignored))
            && faces.are_behind(&strip, tile_y, layers)
    })
}
