//! What the culling did, drawn beside the picture: a third person's view of the frustum, the occluders, what was
//! culled and what is left; the pyramid of occlusion maps (HOM figure 4.1); counts, and a legend.
//!
//! The colours are those of Okabe and Ito's palette ("Color universal design", 2008), which differ for every kind of
//! colour vision; what they stand for differs in line width and brightness too.

mod bystander;
mod canvas;
mod font;
mod pyramid;
mod third_person;

use super::Image;
use crate::cull::VisibleSet;
use crate::occlusion::OcclusionMap;
use crate::scene::Scene;
use crate::view::{Camera, PictureSize};
use canvas::{Canvas, Ink};

const GROUND: Ink = Ink::opaque([18, 21, 26]);
const INK: Ink = Ink::opaque([232, 236, 240]);
const FAINT: Ink = Ink::opaque([70, 76, 84]);
const FRUSTUM: Ink = Ink::opaque([255, 255, 255]);
/// Bluish green.
const OCCLUDER: Ink = Ink::opaque([0, 158, 115]);
/// Sky blue.
const CULLED: Ink = Ink::opaque([86, 180, 233]);
/// Orange.
const VISIBLE: Ink = Ink::opaque([240, 165, 10]);

const TEXT_SCALE: usize = 2;
const TEXT_HEIGHT: usize = font::HEIGHT as usize * TEXT_SCALE + 4;
const MARGIN: usize = 20;
const PYRAMID_CAPTION: &str =
    "occlusion maps: white = opaque, black = open; each level averages 2x2 cells";
/// The third person's picture is at least this high and wide, however small the main one.
const SMALLEST_VIEW: usize = 480;

/// A frame that has been culled.
#[derive(Clone, Copy, Debug)]
pub struct PictureFrame<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its camera.
    pub camera: &'a Camera,
    /// The picture's size.
    pub size: PictureSize,
    /// The objects in the frustum, in scene order.
    pub in_frustum: &'a [u32],
    /// What culling found.
    pub set: &'a VisibleSet,
    /// The pyramid that it asked.
    pub map: &'a OcclusionMap,
}

/// Puts a frame's picture, the third person's view, the pyramid and the legend on one sheet. `title` is written at
/// the top; characters that are not printable ASCII show as question marks.
pub fn overlay_image(frame: &PictureFrame<'_>, picture: &Image, title: &str) -> Image {
    let view_height = picture.height().max(SMALLEST_VIEW);
    let view_width = (view_height * 11 / 10).max(legend::WIDTH);
    let left_width = picture
        .width()
        .max(pyramid::width(frame.map))
        .max(text_width(title))
        .max(text_width(PYRAMID_CAPTION));
    let top = MARGIN + TEXT_HEIGHT + 6;
    let below = top + view_height + MARGIN;
    let bottom_height = (TEXT_HEIGHT + 6 + pyramid::height(frame.map)).max(legend::HEIGHT);
    let right = MARGIN + left_width + MARGIN;

    // Drawn before the sheet is made: it takes the most memory while it is drawn.
    let third_person = PictureSize::new(view_width as u32, view_height as u32)
        .map(|size| third_person::draw(frame, size));
    let mut canvas = Canvas::new(
        right + view_width + MARGIN,
        below + bottom_height + MARGIN,
        GROUND,
    );
    canvas.text(title, [MARGIN, MARGIN], TEXT_SCALE, INK);
    canvas.image(picture, [MARGIN, top]);

    canvas.text(
        "the same frame seen from behind and above the camera",
        [right, MARGIN],
        TEXT_SCALE,
        INK,
    );
    if let Ok(view) = third_person {
        canvas.image(&view, [right, top]);
    }

    canvas.text(PYRAMID_CAPTION, [MARGIN, below], TEXT_SCALE, INK);
    pyramid::draw(&mut canvas, frame.map, [MARGIN, below + TEXT_HEIGHT + 6]);
    legend::draw(&mut canvas, frame, [right, below]);
    canvas.into_image()
}

fn text_width(text: &str) -> usize {
    font::width_of(text).unsigned_abs() as usize * TEXT_SCALE
}

mod legend {
    //! What the colours mean, and the counts.

    use super::canvas::Canvas;
    use super::{CULLED, FRUSTUM, INK, OCCLUDER, PictureFrame, TEXT_SCALE, VISIBLE};

    pub const WIDTH: usize = 640;
    const ROW: usize = 36;
    pub const HEIGHT: usize = 5 * ROW;
    const SWATCH: [usize; 2] = [44, 20];

    pub fn draw(canvas: &mut Canvas, frame: &PictureFrame<'_>, at: [usize; 2]) {
        let set = frame.set;
        let in_frustum = frame.in_frustum.len();
        let visible = set.visible.len();
        let culled = in_frustum.saturating_sub(visible);
        let share = |part: usize| part as f64 * 100.0 / in_frustum.max(1) as f64;
        let rows = [
            format!("camera and frustum; objects in it: {in_frustum}"),
            format!(
                "occluders by cover: {} clusters, {} triangles",
                set.occluders.len(),
                set.statistics.occluder_triangles
            ),
            format!("culled: {culled} ({:.1} %)", share(culled)),
            format!("visible: {visible} ({:.1} %)", share(visible)),
        ];
        for (i, text) in rows.iter().enumerate() {
            let y = at[1] + i * ROW;
            swatch(canvas, i, [at[0] as f32, y as f32]);
            canvas.text(text, [at[0] + SWATCH[0] + 16, y + 2], TEXT_SCALE, INK);
        }
    }

    fn swatch(canvas: &mut Canvas, row: usize, [x, y]: [f32; 2]) {
        let size = SWATCH.map(|s| s as f32);
        let frame = |inset: f32| {
            let (x0, y0) = (x + inset, y + inset);
            let (x1, y1) = (x + size[0] - inset, y + size[1] - inset);
            [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]
        };
        match row {
            0 => {
                let eye = [x, y + size[1] * 0.5];
                let wedge = [[x + size[0], y], eye, [x + size[0], y + size[1]]];
                canvas.polygon(&wedge, FRUSTUM.with_opacity(40));
                canvas.lines(&[wedge], 2.5, FRUSTUM);
            }
            1 => canvas.rectangle([x, y], size, OCCLUDER),
            2 => canvas.lines(&[frame(0.5)], 1.0, CULLED),
            _ => canvas.lines(&[frame(1.0)], 2.0, VISIBLE),
        }
    }
}
