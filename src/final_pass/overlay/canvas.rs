//! What overlays are drawn on: rectangles, lines, text and pictures over each other (tiny-skia).

use tiny_skia::{
    Color, FillRule, IntSize, Paint, PathBuilder, Pixmap, PixmapMut, Rect, Stroke, Transform,
};

use super::font;
use crate::final_pass::Image;

/// A colour with an opacity, sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ink {
    pub rgb: [u8; 3],
    pub opacity: u8,
}

impl Ink {
    pub const fn opaque(rgb: [u8; 3]) -> Ink {
        Ink { rgb, opacity: 255 }
    }

    pub const fn with_opacity(self, opacity: u8) -> Ink {
        Ink { opacity, ..self }
    }

    fn paint(self) -> Paint<'static> {
        let [r, g, b] = self.rgb;
        let mut paint = Paint::default();
        paint.set_color(Color::from_rgba8(r, g, b, self.opacity));
        paint.anti_alias = true;
        paint
    }
}

/// A picture that is being drawn. Coordinates are pixels from the upper left corner.
pub struct Canvas {
    pixmap: Pixmap,
}

impl Canvas {
    /// A canvas of one colour; its sides must not be 0 or beyond what a `u32` of bytes holds.
    pub fn new(width: usize, height: usize, background: Ink) -> Canvas {
        let mut canvas = Canvas::over(&Image::filled(width, height, background.rgb));
        canvas.rectangle([0.0, 0.0], [width as f32, height as f32], background);
        canvas
    }

    /// A canvas that begins as a picture.
    pub fn over(image: &Image) -> Canvas {
        let bytes = image.pixels().iter().flat_map(|&[r, g, b]| [r, g, b, 255]);
        let size = IntSize::from_wh(image.width() as u32, image.height() as u32);
        let pixmap = size.and_then(|size| Pixmap::from_vec(bytes.collect(), size));
        Canvas {
            pixmap: pixmap.expect("a picture has a size, and four bytes a pixel"),
        }
    }

    /// What has been drawn. The canvas is opaque, so its colours are as they are.
    pub fn into_image(self) -> Image {
        let (width, height) = (self.pixmap.width() as usize, self.pixmap.height() as usize);
        let mut image = Image::filled(width, height, [0; 3]);
        for (to, from) in image.pixels_mut().iter_mut().zip(self.pixmap.pixels()) {
            *to = [from.red(), from.green(), from.blue()];
        }
        image
    }

    fn target(&mut self) -> PixmapMut<'_> {
        self.pixmap.as_mut()
    }

    /// Fills a rectangle given by its upper left corner and its size.
    pub fn rectangle(&mut self, at: [f32; 2], size: [f32; 2], ink: Ink) {
        if let Some(rect) = Rect::from_xywh(at[0], at[1], size[0], size[1]) {
            self.target()
                .fill_rect(rect, &ink.paint(), Transform::identity(), None);
        }
    }

    /// Fills a polygon.
    pub fn polygon(&mut self, points: &[[f32; 2]], ink: Ink) {
        let mut path = PathBuilder::new();
        trace(&mut path, points);
        path.close();
        if let Some(path) = path.finish() {
            let identity = Transform::identity();
            self.target()
                .fill_path(&path, &ink.paint(), FillRule::Winding, identity, None);
        }
    }

    /// Draws open lines through points, all in one go: where they cross, the ink is not doubled.
    pub fn lines(&mut self, lines: &[impl AsRef<[[f32; 2]]>], width: f32, ink: Ink) {
        let mut path = PathBuilder::new();
        for points in lines {
            trace(&mut path, points.as_ref());
        }
        if let Some(path) = path.finish() {
            let stroke = Stroke {
                width,
                ..Stroke::default()
            };
            let identity = Transform::identity();
            self.target()
                .stroke_path(&path, &ink.paint(), &stroke, identity, None);
        }
    }

    /// Writes a line of text, `scale` pixels to a pixel of the typeface; `at` is its upper left corner.
    pub fn text(&mut self, text: &str, at: [usize; 2], scale: usize, ink: Ink) {
        let paint = ink.paint();
        let mut target = self.target();
        font::for_each_ink(text, |x, y| {
            let (x, y) = (
                at[0] as i32 + x * scale as i32,
                at[1] as i32 + y * scale as i32,
            );
            let side = scale as f32;
            if let Some(rect) = Rect::from_xywh(x as f32, y as f32, side, side) {
                target.fill_rect(rect, &paint, Transform::identity(), None);
            }
        });
    }

    /// Puts a picture down, its upper left corner at `at`, cut off at the canvas's edges.
    pub fn image(&mut self, image: &Image, at: [usize; 2]) {
        let across = self.pixmap.width() as usize;
        let shown = image.width().min(across.saturating_sub(at[0]));
        let rows = self.pixmap.pixels_mut().chunks_exact_mut(across);
        let source = image.pixels().chunks_exact(image.width());
        for (to, from) in rows.skip(at[1]).zip(source) {
            for (to, &[r, g, b]) in to[at[0]..].iter_mut().zip(&from[..shown]) {
                *to = tiny_skia::ColorU8::from_rgba(r, g, b, 255).premultiply();
            }
        }
    }
}

fn trace(path: &mut PathBuilder, points: &[[f32; 2]]) {
    let Some((first, rest)) = points.split_first() else {
        return;
    };
    path.move_to(first[0], first[1]);
    for point in rest {
        path.line_to(point[0], point[1]);
    }
}
