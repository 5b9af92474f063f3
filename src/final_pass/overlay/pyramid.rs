//! The pyramid of occlusion maps as a row of grey pictures, the finest first (HOM figure 4.1): white is opaque.

use super::canvas::{Canvas, Ink};
use super::{FAINT, INK, TEXT_HEIGHT, TEXT_SCALE, text_width};
use crate::final_pass::Image;
use crate::occlusion::OcclusionMap;

/// Canvas pixels to the edge of a cell, at the least.
const CELL: usize = 3;
/// The longer side of a level, at the least.
const SMALLEST: usize = 28;
const GAP: usize = 18;

/// The height of the row, labels included.
pub fn height(map: &OcclusionMap) -> usize {
    (0..map.level_count())
        .map(|level| height_of_level(map, level) * cell_edge(map, level))
        .max()
        .unwrap_or(0)
        + 2 * TEXT_HEIGHT
        + 4
}

/// The width of the row.
pub fn width(map: &OcclusionMap) -> usize {
    (0..map.level_count())
        .map(|level| column_width(map, level) + GAP)
        .sum::<usize>()
        .saturating_sub(GAP)
}

/// Draws all levels from the upper left corner `at` to the right.
pub fn draw(canvas: &mut Canvas, map: &OcclusionMap, at: [usize; 2]) {
    let [mut x, y] = at;
    for level in 0..map.level_count() {
        let picture = opacity_picture(map, level);
        canvas.text(&name_of(level), [x, y], TEXT_SCALE, INK);
        let top = y + TEXT_HEIGHT + 2;
        // A frame, since the pictures may be as dark as the ground.
        let size = [picture.width() as f32 + 2.0, picture.height() as f32 + 2.0];
        canvas.rectangle([x as f32 - 1.0, top as f32 - 1.0], size, FAINT);
        canvas.image(&picture, [x, top]);
        let below = top + picture.height() + 6;
        canvas.text(&size_of(map, level), [x, below], TEXT_SCALE, GREY);
        x += column_width(map, level) + GAP;
    }
}

const GREY: Ink = Ink::opaque([150, 158, 168]);

fn name_of(level: usize) -> String {
    if level == 0 {
        "level 0".into()
    } else {
        level.to_string()
    }
}

fn size_of(map: &OcclusionMap, level: usize) -> String {
    format!(
        "{}x{}",
        map.width_of_level(level),
        height_of_level(map, level)
    )
}

fn height_of_level(map: &OcclusionMap, level: usize) -> usize {
    map.uncovered_of_level(level).len() / map.width_of_level(level)
}

fn cell_edge(map: &OcclusionMap, level: usize) -> usize {
    let longer = map.width_of_level(level).max(height_of_level(map, level));
    CELL.max(SMALLEST.div_ceil(longer))
}

fn column_width(map: &OcclusionMap, level: usize) -> usize {
    (map.width_of_level(level) * cell_edge(map, level))
        .max(text_width(&name_of(level)))
        .max(text_width(&size_of(map, level)))
}

/// A level with its cells as squares, grey as they are opaque.
fn opacity_picture(map: &OcclusionMap, level: usize) -> Image {
    let (width, edge) = (map.width_of_level(level), cell_edge(map, level));
    let mut picture = Image::filled(width * edge, height_of_level(map, level) * edge, [0; 3]);
    let across = picture.width();
    for (i, pixel) in picture.pixels_mut().iter_mut().enumerate() {
        let (x, y) = (i % across / edge, i / across / edge);
        let [[x0, x1], [y0, y1]] = map.pixels_of_cell(level, x, y);
        let pixels =
            u64::from((x1 - x0 + 1).unsigned_abs()) * u64::from((y1 - y0 + 1).unsigned_abs());
        let covered = pixels.saturating_sub(u64::from(map.uncovered(level, x, y)));
        *pixel = [(covered * 255 / pixels.max(1)) as u8; 3];
    }
    picture
}
