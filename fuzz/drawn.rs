//! A picture of what was drawn, pixel by pixel, in the order of draws: what a final pass would show.
#![allow(dead_code, reason = "each target uses some")]

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::raster::{Assembler, CullMode, Geometry, Positions, TileBuffer, for_each_sample};
use antumbra::view::{Camera, PictureSize};

/// The corners of the cube from −1 to 1, and its faces.
pub const CUBE: [[f32; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, 1.0, 1.0],
];
pub const FACES: [u32; 36] = [
    0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3,
    7, 1, 7, 5,
];

/// The samples of something that is drawn, and their depths.
pub fn samples(
    camera: &Camera,
    size: PictureSize,
    positions: &[[f32; 3]],
    indices: &[u32],
    place: &DAffine3,
    cull: CullMode,
    mut visit: impl FnMut(usize, f32),
) {
    let cull = match cull {
        CullMode::Back if place.matrix3.determinant() < 0.0 => CullMode::Front,
        CullMode::Front if place.matrix3.determinant() < 0.0 => CullMode::Back,
        same => same,
    };
    let geometry = Geometry::new(Positions::packed(positions), indices).expect("sound");
    let screen = camera.screen_from_local(size, place);
    Assembler::default().assemble(geometry, &screen, size, cull, |t, _| {
        for_each_sample(&t, 0..size.height() as i32, |x, y, depth| {
            visit(y as usize * size.width() + x as usize, depth);
        });
    });
}

/// The nearest depth of each pixel.
pub struct Picture {
    pub size: PictureSize,
    pub nearest: Vec<Option<f32>>,
}

impl Picture {
    pub fn new(size: PictureSize) -> Picture {
        Picture {
            size,
            nearest: vec![None; size.width() * size.height()],
        }
    }

    pub fn draw(
        &mut self,
        camera: &Camera,
        positions: &[[f32; 3]],
        indices: &[u32],
        place: &DAffine3,
        cull: CullMode,
    ) {
        let nearest = &mut self.nearest;
        samples(
            camera,
            self.size,
            positions,
            indices,
            place,
            cull,
            |at, depth| {
                assert!(!depth.is_nan());
                if nearest[at].is_none_or(|old| depth > old) {
                    nearest[at] = Some(depth);
                }
            },
        );
    }

    /// Whether something would show at one of its samples, or is as near as what does.
    pub fn shows(
        &self,
        camera: &Camera,
        positions: &[[f32; 3]],
        indices: &[u32],
        place: &DAffine3,
    ) -> bool {
        let mut shows = false;
        samples(
            camera,
            self.size,
            positions,
            indices,
            place,
            CullMode::None,
            |at, depth| {
                shows |= self.nearest[at].is_none_or(|nearest| depth >= nearest);
            },
        );
        shows
    }

    /// Tiles cover what is drawn, and keep no depth that is nearer.
    pub fn check(&self, tiles: &TileBuffer) {
        let width = self.size.width();
        for (at, nearest) in self.nearest.iter().enumerate() {
            let (x, y) = (at % width, at / width);
            let tile = y / 8 * self.size.tiles_across() + x / 8;
            let (bit, part) = (y % 8 * 8 + x % 8, y % 8 / 4);
            let covered = tiles.coverage()[tile] >> bit & 1 == 1;
            assert_eq!(covered, nearest.is_some(), "({x}, {y})");
            let stored = if tiles.near_samples()[tile] >> bit & 1 == 1 {
                tiles.near_depths()[tile][part]
            } else {
                tiles.depths()[tile][part]
            };
            if let Some(nearest) = *nearest {
                assert!(stored <= nearest, "({x}, {y}): {stored:e} for {nearest:e}");
            }
        }
    }
}

/// The cube's placement in a box.
pub fn cube_in(min: DVec3, max: DVec3) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_diagonal((max - min) * 0.5),
        translation: (min + max) * 0.5,
    }
}

/// Whether the placement of a cube keeps within what is promised for occluders and boxes: numbers that do not cancel to a
/// thousandth of themselves. Anything is, as far as panics go.
pub fn is_promised(place: &DAffine3) -> bool {
    place.to_cols_array().iter().all(|v| v.abs() < 1e30)
}
