//! The depth estimation buffer (HOM §6.3): many small planes, each for the occluders that reach into its cell.
//!
//! An occluder is taken for a rectangle on screen at its farthest depth. It puts the depth of each cell that it touches at least
//! that far away. More cells than 64×64 bring nothing, says the paper, since rectangles and farthest points are coarser anyway.

use antumbra_simd::tile::UNCOVERED;

use super::DrawnSurface;
use crate::occlusion::{Footprint, SampleRect};
use crate::view::PictureSize;

/// Cells across the picture, and down (HOM §6.3.3).
pub const ESTIMATION_CELLS: usize = 64;

/// The farthest depth of what was drawn, cell by cell.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimationBuffer {
    size: PictureSize,
    /// Row by row; the nearest possible where nothing is drawn.
    cells: Vec<f32>,
}

impl EstimationBuffer {
    /// An empty buffer over a picture.
    pub fn new(size: PictureSize) -> EstimationBuffer {
        EstimationBuffer {
            size,
            cells: vec![UNCOVERED; ESTIMATION_CELLS * ESTIMATION_CELLS],
        }
    }

    /// Forgets all that was drawn.
    pub fn clear(&mut self) {
        self.cells.fill(UNCOVERED);
    }

    /// Puts the cells that an occluder's rectangle touches no nearer than its farthest depth.
    pub fn note(&mut self, drawn: &DrawnSurface<'_>) {
        let [x, y] = match drawn.footprint {
            Footprint::Nowhere => return,
            Footprint::Unbounded => [[0, ESTIMATION_CELLS - 1]; 2],
            Footprint::Within(rect) => self.cells_of(&rect),
        };
        for row in y[0]..=y[1] {
            let cells = &mut self.cells[row * ESTIMATION_CELLS..][x[0]..=x[1]];
            for cell in cells {
                *cell = cell.min(drawn.farthest_depth);
            }
        }
    }

    /// Whether a rectangle is strictly farther than each cell that it touches.
    pub fn is_behind(&self, rect: &SampleRect) -> bool {
        let [x, y] = self.cells_of(rect);
        (y[0]..=y[1]).all(|row| {
            let cells = &self.cells[row * ESTIMATION_CELLS..][x[0]..=x[1]];
            cells.iter().all(|&cell| rect.nearest_depth < cell)
        })
    }

    /// The first and last columns and rows of cells that a rectangle touches. A sample is in one cell.
    fn cells_of(&self, rect: &SampleRect) -> [[usize; 2]; 2] {
        let cell = |sample: i32, samples: usize| sample as usize * ESTIMATION_CELLS / samples;
        [
            rect.x.map(|x| cell(x, self.size.width())),
            rect.y.map(|y| cell(y, self.size.height())),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::SurfaceTriangles;

    fn rect(x: [i32; 2], y: [i32; 2], nearest_depth: f32) -> SampleRect {
        SampleRect {
            x,
            y,
            nearest_depth,
        }
    }

    fn note(buffer: &mut EstimationBuffer, footprint: Footprint, farthest_depth: f32) {
        buffer.note(&DrawnSurface {
            footprint,
            farthest_depth,
            triangles: &SurfaceTriangles::default(),
        });
    }

    #[test]
    fn an_occluder_matters_in_the_cells_that_it_touches() {
        // A cell is 10 samples across and 5 down.
        let mut buffer = EstimationBuffer::new(PictureSize::new(640, 320).expect("a size"));
        let occluder = rect([15, 24], [5, 5], 0.9);
        note(&mut buffer, Footprint::Within(occluder), 0.5);
        let is_behind = |x, y, depth| buffer.is_behind(&rect(x, y, depth));
        assert!(is_behind([10, 29], [5, 9], 0.4));
        assert!(!is_behind([10, 10], [9, 9], 0.5), "as far is not behind");
        assert!(!is_behind([29, 40], [0, 5], 0.6));
        // Beside it anything passes: the overlap test decides.
        assert!(is_behind([0, 9], [5, 9], 0.6) && is_behind([30, 639], [0, 319], 0.6));
        assert!(is_behind([10, 29], [0, 4], 0.6) && is_behind([10, 29], [10, 14], 0.6));
    }

    #[test]
    fn the_farthest_stays_and_what_reaches_the_near_plane_is_everywhere() {
        let mut buffer = EstimationBuffer::new(PictureSize::new(7, 3).expect("a size"));
        let all = |depth| rect([0, 6], [0, 2], depth);
        for (depth, expected) in [(0.5, 0.5), (0.7, 0.5), (0.25, 0.25)] {
            note(&mut buffer, Footprint::Unbounded, depth);
            assert!(!buffer.is_behind(&all(expected)));
            assert!(buffer.is_behind(&all(expected.next_down())));
        }
        note(&mut buffer, Footprint::Nowhere, 0.0);
        assert!(buffer.is_behind(&all(0.2)));
        buffer.clear();
        assert!(buffer.is_behind(&all(1.0)));
    }
}
