//! The question of a box: is it hidden at each sample inside its outline? See [`antumbra_simd::closer`].

use antumbra_simd::closer;
use antumbra_simd::faces::Faces;
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
    let layered = tiles.layered();
    let ignored = accuracy.ignored_per_cell();
    if ignored == 0 {
        return closer::is_outline_hidden(tiles.level(), layered, outline, faces);
    }
    closer::is_outline_hidden_plain(layered, outline, faces, ignored, is_covered)
}
