//! The CPU picture: z-buffered, flat-shaded, translucent surfaces blended over.
//!
//! **Invariant.** In exact mode the picture of the survivors equals the picture of the whole scene, byte for byte.
//! Surfaces that are not translucent are drawn first, in scene order, nearest wins, the first drawn of equals stays
//! (see `surfaces`); what is hidden owns no pixel, so its absence changes none. Translucent surfaces follow in scene
//! order, each sample blended over what is there if it is strictly nearer than the solid surface, and leaving no
//! depth; what is hidden has no such sample. Everything after that reads only the result.

use std::path::Path;

use image::{ExtendedColorType, ImageError, ImageFormat};
use rayon::prelude::*;

use super::creases::Creases;
use super::draw_objects;
use super::light::{Light, Linear, mix, opacity};
use super::surfaces::{Surface, draw_nearest};
use crate::scene::{Alpha, Scene};
use crate::view::{Camera, PictureSize};

/// A picture: 8 bits each of red, green and blue (sRGB), row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

impl Image {
    /// A picture of one colour.
    pub fn filled(width: usize, height: usize, color: [u8; 3]) -> Image {
        Image {
            width,
            pixels: vec![color; width * height],
        }
    }

    /// A picture of these pixels, so many in a row.
    #[cfg(feature = "gpu")]
    pub(super) fn of_pixels(width: usize, pixels: Vec<[u8; 3]>) -> Image {
        Image { width, pixels }
    }

    /// Pixels across.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> usize {
        self.pixels.len().checked_div(self.width).unwrap_or(0)
    }

    /// All pixels.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// All pixels, to be changed.
    pub fn pixels_mut(&mut self) -> &mut [[u8; 3]] {
        &mut self.pixels
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_png(&self, file: &Path) -> Result<(), ImageError> {
        let (width, height) = (self.width as u32, self.height() as u32);
        image::save_buffer_with_format(
            file,
            self.pixels.as_flattened(),
            width,
            height,
            ExtendedColorType::Rgb8,
            ImageFormat::Png,
        )
    }

    /// How many pixels differ from those of a picture of the same size.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn differing_pixels(&self, other: &Image) -> usize {
        self.pixels_differing_by_more(other, 0)
    }

    /// How many pixels differ by more than this from those of a picture of the same size, in red, green or blue.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn pixels_differing_by_more(&self, other: &Image, than: u8) -> usize {
        self.assert_same_size(other);
        let differs = |(a, b): &(&[u8; 3], &[u8; 3])| {
            let mut channels = a.iter().zip(*b);
            channels.any(|(&a, &b)| a.abs_diff(b) > than)
        };
        let pairs = self.pixels.iter().zip(&other.pixels);
        pairs.filter(differs).count()
    }

    /// Where two pictures of the same size differ: red there, the picture itself faintly elsewhere.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn difference(&self, other: &Image) -> Image {
        self.assert_same_size(other);
        let mark = |(&a, &b): (&[u8; 3], &[u8; 3])| {
            if a != b {
                [220, 0, 40]
            } else {
                a.map(|c| 190 + c / 4)
            }
        };
        Image {
            width: self.width,
            pixels: self.pixels.iter().zip(&other.pixels).map(mark).collect(),
        }
    }

    /// The picture at `1 / factor` of its size, each pixel the mean of a square; edges that are not whole squares are
    /// cut off.
    pub fn shrunk(&self, factor: usize) -> Image {
        let (width, height) = (self.width / factor, self.height() / factor);
        let samples = (factor * factor) as u32;
        let pixels = (0..width * height).map(|i| {
            let (x, y) = (i % width * factor, i / width * factor);
            let mut sum = [samples / 2; 3];
            for row in y..y + factor {
                for pixel in &self.pixels[row * self.width + x..][..factor] {
                    for (sum, &c) in sum.iter_mut().zip(pixel) {
                        *sum += u32::from(c);
                    }
                }
            }
            sum.map(|s| (s / samples) as u8)
        });
        Image {
            width,
            pixels: pixels.collect(),
        }
    }

    fn assert_same_size(&self, other: &Image) {
        assert_eq!(
            (self.width, self.pixels.len()),
            (other.width, other.pixels.len()),
            "pictures of different sizes"
        );
    }
}

/// Draws `objects`, which are in scene order, as the camera sees them.
///
/// With all objects of a scene, or with only those that exact culling leaves
/// ([`VisibleSet::visible`](crate::cull::VisibleSet::visible)), the picture is the same.
pub fn render_image(scene: &Scene, camera: &Camera, size: PictureSize, objects: &[u32]) -> Image {
    let (width, height) = (size.width(), size.height());
    let mut surfaces = vec![Surface::BACKGROUND; width * height];
    draw_nearest(scene, camera, size, objects, &mut surfaces, |s, _| Some(s));

    let light = Light::new(scene, camera);
    let creases = Creases::new(size, camera.projection());
    let mut pixels: Vec<Pixel> = surfaces
        .par_iter()
        .enumerate()
        .map(|(i, s)| {
            let (x, y) = (i % width, i / width);
            let color = if s.is_background() {
                light.background(y, height)
            } else {
                let material = s.material(scene);
                let lit = light.color_of(s.object, s.triangle as usize, material, s.depth);
                let factor = creases.factor(|x, y| surfaces[y * width + x].depth, x, y);
                lit.map(|c| c * factor)
            };
            Pixel {
                color,
                depth: s.depth,
            }
        })
        .collect();
    drop(surfaces);

    draw_objects(
        scene,
        camera,
        size,
        objects,
        |m| m.alpha == Alpha::Blend,
        &mut pixels,
        |pixel, f| {
            if f.depth > pixel.depth {
                let over = light.color_of(f.object, f.triangle, f.material, f.depth);
                pixel.color = mix(pixel.color, over, f64::from(opacity(f.material)));
            }
        },
    );

    let encode = SrgbTable::new();
    Image {
        width,
        pixels: pixels.par_iter().map(|p| encode.of(p.color)).collect(),
    }
}

/// What a pixel shows so far.
#[derive(Clone, Copy)]
struct Pixel {
    color: Linear,
    /// Of the solid surface.
    depth: f32,
}

/// From linear light to 8-bit sRGB, by a table that is finer than 8 bits everywhere.
#[derive(Clone, Debug)]
pub(super) struct SrgbTable(Vec<u8>);

impl SrgbTable {
    const LAST: usize = 8191;

    pub fn new() -> SrgbTable {
        let encode = |i: usize| {
            let linear = i as f64 / Self::LAST as f64;
            let encoded = if linear <= 0.003_130_8 {
                linear * 12.92
            } else {
                1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
            };
            (encoded * 255.0 + 0.5) as u8
        };
        SrgbTable((0..=Self::LAST).map(encode).collect())
    }

    /// What is encoded of 0, and so on in equal steps to 1.
    #[cfg(feature = "gpu")]
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    pub fn of(&self, color: Linear) -> [u8; 3] {
        // A cast saturates: below 0 gives 0.
        color.map(|c| self.0[((c * Self::LAST as f32 + 0.5) as usize).min(Self::LAST)])
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DVec2, DVec3};

    use super::*;
    use crate::cull::{Culler, Settings};
    use crate::scene::{Material, Mesh, Object, Surface};
    use crate::view::Projection;

    /// A square of side 2 in the plane z = 0, that faces +z.
    fn square(alpha: Alpha, color: [f32; 4]) -> Mesh {
        Mesh {
            name: String::new(),
            positions: vec![
                [-1.0, -1.0, 0.0],
                [1.0, -1.0, 0.0],
                [1.0, 1.0, 0.0],
                [-1.0, 1.0, 0.0],
            ]
            .into(),
            triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
            surfaces: vec![Surface {
                triangles: 0..2,
                material: Material {
                    alpha,
                    color,
                    ..Material::default()
                },
            }],
        }
    }

    fn placed(mesh: usize, at: DVec3) -> Object {
        Object {
            name: format!("{mesh} at {at}"),
            mesh,
            world_from_local: DAffine3::from_translation(at),
            never_cull: false,
            never_occlude: false,
            occluder_proxy: None,
        }
    }

    const RED: [f32; 4] = [0.8, 0.1, 0.1, 1.0];
    const BLUE: [f32; 4] = [0.1, 0.1, 0.8, 1.0];
    const GLASS: [f32; 4] = [0.2, 0.9, 0.3, 0.4];

    /// Meshes 0 red, 1 blue, 2 glass.
    fn scene(objects: Vec<Object>) -> Scene {
        let meshes = vec![
            square(Alpha::Opaque, RED),
            square(Alpha::Opaque, BLUE),
            square(Alpha::Blend, GLASS),
        ];
        Scene::new(meshes, objects).expect("a scene")
    }

    fn camera() -> Camera {
        let projection = Projection::Perspective {
            fov_y: 0.8,
            near: 0.1,
            far: None,
        };
        Camera::look_at(DVec3::Z * 6.0, DVec3::ZERO, DVec3::Y, projection).expect("a camera")
    }

    fn size() -> PictureSize {
        PictureSize::new(101, 67).expect("a size")
    }

    fn render(scene: &Scene, objects: &[u32]) -> Image {
        render_image(scene, &camera(), size(), objects)
    }

    #[test]
    fn the_first_drawn_of_equally_near_surfaces_stays() {
        let red_first = scene(vec![placed(0, DVec3::ZERO), placed(1, DVec3::ZERO)]);
        assert_eq!(render(&red_first, &[0, 1]), render(&red_first, &[0]));
        assert_ne!(render(&red_first, &[0, 1]), render(&red_first, &[1]));
    }

    #[test]
    fn a_hidden_translucent_object_changes_nothing_and_a_visible_one_does() {
        let objects = vec![
            placed(2, DVec3::Z * -3.0),
            placed(0, DVec3::ZERO),
            placed(2, DVec3::new(0.5, 0.0, 1.0)),
            placed(2, DVec3::ZERO),
        ];
        let scene = scene(objects);
        let all = render(&scene, &[0, 1, 2, 3]);
        assert_eq!(all, render(&scene, &[1, 2]));
        assert_ne!(all, render(&scene, &[1]));
    }

    #[test]
    fn the_picture_of_the_survivors_is_the_picture_of_the_scene() {
        let mut objects = vec![placed(0, DVec3::ZERO)];
        for i in 0..40 {
            let (x, y) = (f64::from(i % 7) * 0.4 - 1.2, f64::from(i / 7) * 0.35 - 0.9);
            let z = f64::from(i % 5) * -0.8 + 0.4;
            objects.push(placed(i as usize % 3, DVec3::new(x, y, z)));
        }
        let all: Vec<u32> = (0..objects.len() as u32).collect();
        let scene = Arc::new(scene(objects));
        let mut culler = Culler::new(scene.clone(), Settings::new(size())).expect("threads");
        let visible = culler.cull(&camera()).visible;
        assert!(visible.len() < all.len());
        assert_eq!(render(&scene, &visible), render(&scene, &all));
    }

    #[test]
    fn samples_a_pixel_away_are_the_picture_moved_by_a_pixel() {
        let scene = scene(vec![
            placed(0, DVec3::ZERO),
            placed(1, DVec3::new(0.7, 0.3, 0.9)),
            placed(2, DVec3::new(-0.9, -0.6, 1.2)),
        ]);
        let there = camera().jittered(DVec2::new(1.0, -1.0)).expect("a pixel");
        let (here, there) = (
            render(&scene, &[0, 1, 2]),
            render_image(&scene, &there, size(), &[0, 1, 2]),
        );
        let at = |image: &Image, x: usize, y: usize| image.pixels()[y * image.width() + x];
        // Within the red square: the background stays.
        for y in 24..43 {
            for x in 41..59 {
                assert_eq!(at(&there, x, y), at(&here, x + 1, y - 1), "{x}, {y}");
            }
        }
    }

    #[test]
    fn differences_are_counted_and_marked() {
        let white = Image::filled(3, 2, [255; 3]);
        let mut other = white.clone();
        other.pixels_mut()[4] = [254, 255, 255];
        assert_eq!(white.differing_pixels(&other), 1);
        let marked = white.difference(&other);
        assert_eq!(marked.differing_pixels(&white.difference(&white)), 1);
    }

    #[test]
    fn linear_light_is_encoded_to_the_whole_range() {
        let table = SrgbTable::new();
        assert_eq!(table.of([0.0, 1.0, 2.0]), [0, 255, 255]);
        // Half of the light is 188 of 255 in sRGB.
        assert_eq!(table.of([0.5, -1.0, 0.214]), [188, 0, 127]);
    }
}
