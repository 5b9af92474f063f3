//! The scene from behind and above the camera: what stands in the frustum, what was drawn as an occluder, what was
//! culled and what is left.

use rayon::prelude::*;

use super::bystander::{Bystander, frustum_corners};
use super::canvas::{Canvas, Ink};
use super::{CULLED, FRUSTUM, GROUND, VISIBLE};
use crate::final_pass::creases::Creases;
use crate::final_pass::image::SrgbTable;
use crate::final_pass::light::{Light, Linear, mix};
use crate::final_pass::{Image, PictureFrame};
use crate::scene::Aabb;
use crate::view::PictureSize;

/// The scene is drawn this much larger, and shrunk, for smooth edges.
const SUPERSAMPLES: u32 = 2;

/// Surface colours, linear: outside the frustum, inside, and drawn as occluders. Dark, for the boxes to show on.
const OUTSIDE: Linear = [0.055, 0.058, 0.065];
const INSIDE: Linear = [0.13, 0.14, 0.16];
const OCCLUDING: Linear = [0.005, 0.21, 0.13];

/// Boxes longer than this share of the shown depth are drawn faintly: they frame everything and point at nothing.
const LONG_BOX: f64 = 0.5;
/// Boxes without an edge of this length are drawn thinly and faintly.
const SMALL_BOX_PX: f32 = 16.0;
/// More survivors than this get thin lines: thick ones would cover the scene.
const MANY_BOXES: usize = 700;

/// The edges of a box between its corners, as [`Aabb::corners`] numbers them: bottom, top, uprights.
const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [1, 5],
    [5, 4],
    [4, 0],
    [2, 3],
    [3, 7],
    [7, 6],
    [6, 2],
    [0, 2],
    [1, 3],
    [5, 7],
    [4, 6],
];

/// Draws the picture, of a size.
pub fn draw(frame: &PictureFrame<'_>, size: PictureSize) -> Image {
    let bystander = Bystander::new(frame.scene, frame.camera, frame.in_frustum, size);
    let Some((bystander, scene)) = bystander.and_then(|b| {
        let scene = draw_scene(frame, &b)?;
        Some((b, scene))
    }) else {
        return Image::filled(size.width(), size.height(), GROUND.rgb);
    };
    let mut canvas = Canvas::over(&scene);
    draw_boxes(&mut canvas, frame, &bystander);
    draw_frustum(&mut canvas, frame, &bystander);
    canvas.into_image()
}

/// How much of its own colour an occluder has that took so many samples over: all of it from a sixteenth of a picture on.
fn shade_of(gain: u64) -> f64 {
    let doublings = f64::from(u64::BITS - gain.leading_zeros());
    (0.25 + 0.75 * doublings / 16.0).min(1.0)
}

/// The scene's surfaces, those of occluders in their own colour: the stronger, the more they contribute.
fn draw_scene(frame: &PictureFrame<'_>, bystander: &Bystander) -> Option<Image> {
    let scene = frame.scene;
    let (size, surfaces) = bystander.surfaces(scene, SUPERSAMPLES)?;
    let light = Light::new(scene, bystander.camera());
    let creases = Creases::new(size, bystander.camera().projection());
    let mut colors = vec![OUTSIDE; scene.objects().len()];
    for &object in frame.in_frustum {
        colors[object as usize] = INSIDE;
    }
    let mut gains = vec![None; scene.objects().len()];
    for drawn in &frame.set.occluders {
        *gains[drawn.id.object as usize].get_or_insert(0) += u64::from(drawn.gain);
    }
    for (color, gain) in colors.iter_mut().zip(gains) {
        if let Some(gain) = gain {
            *color = mix(INSIDE, OCCLUDING, shade_of(gain));
        }
    }
    let encode = SrgbTable::new();
    let width = size.width();
    let mut image = Image::filled(width, size.height(), GROUND.rgb);
    image
        .pixels_mut()
        .par_iter_mut()
        .zip(&surfaces)
        .enumerate()
        .for_each(|(i, (pixel, s))| {
            if s.is_background() {
                return;
            }
            let color = colors[s.object as usize];
            let lit = light.lit(s.object, s.triangle as usize, color);
            let factor = creases.factor(|x, y| surfaces[y * width + x].depth, i % width, i / width);
            *pixel = encode.of(mix(BLACK, lit, f64::from(factor)));
        });
    Some(image.shrunk(SUPERSAMPLES as usize))
}

const BLACK: Linear = [0.0; 3];

/// Boxes of culled objects in thin lines, those of survivors in thick ones, over them.
fn draw_boxes(canvas: &mut Canvas, frame: &PictureFrame<'_>, bystander: &Bystander) {
    let (visible, culled): (Vec<u32>, Vec<u32>) = frame
        .in_frustum
        .iter()
        .partition(|o| frame.set.visible.binary_search(o).is_ok());
    let bounds_of = |&object: &u32| &frame.scene.bounds()[object as usize];
    let is_long = |b: &Aabb| b.size().max_element() > LONG_BOX * bystander.reach;
    let mut wires = |objects: &[u32], width: f32, ink: Ink| {
        let long_boxes = objects.iter().map(bounds_of).filter(|b| is_long(b)).count();
        let faint = (usize::from(ink.opacity) / (4 + long_boxes / 12)).max(12) as u8;
        for bounds in objects.iter().map(bounds_of) {
            if bystander.is_cut(bounds) {
                continue;
            }
            let edges = outline(bystander, bounds);
            let (width, opacity) = match (is_long(bounds), is_small(&edges)) {
                (true, _) => (1.0, faint),
                (false, true) => (1.0, ink.opacity / 2),
                (false, false) => (width, ink.opacity),
            };
            canvas.lines(&edges, width, ink.with_opacity(opacity));
        }
    };
    // Very many boxes together are a haze, through which single ones still show.
    let opacity =
        |count: usize| (255 - 20 * count.max(32).ilog2() as usize + 100).clamp(90, 255) as u8;
    wires(&culled, 1.0, CULLED.with_opacity(opacity(culled.len())));
    let width = if visible.len() > MANY_BOXES { 1.0 } else { 2.0 };
    wires(
        &visible,
        width,
        VISIBLE.with_opacity(opacity(visible.len())),
    );
}

/// Whether thick lines would fill a box rather than frame it.
fn is_small(edges: &[[[f32; 2]; 2]]) -> bool {
    edges
        .iter()
        .all(|[a, b]| (a[0] - b[0]).abs() < SMALL_BOX_PX && (a[1] - b[1]).abs() < SMALL_BOX_PX)
}

/// The edges of a box that the bystander can see; those behind would only be clutter.
fn outline(bystander: &Bystander, bounds: &Aabb) -> Vec<[[f32; 2]; 2]> {
    let corners = bounds.corners();
    let view = bystander.camera().forward();
    // The corner that is farthest away is the end of the three hidden edges.
    let hidden = (0..8)
        .max_by(|&a, &b| corners[a].dot(view).total_cmp(&corners[b].dot(view)))
        .unwrap_or(0);
    let points = corners.map(|c| bystander.project(c));
    EDGES
        .iter()
        .filter(|edge| !edge.contains(&hidden))
        .map(|&[a, b]| [points[a], points[b]])
        .collect()
}

/// The frustum: its edges, and the level that it cuts through the scene at the height of the eye.
fn draw_frustum(canvas: &mut Canvas, frame: &PictureFrame<'_>, bystander: &Bystander) {
    let aspect = frame.size.aspect();
    let far = frustum_corners(frame.camera, bystander.reach, aspect);
    // For an orthographic camera, whose frustum is a box, these are apart.
    let near = frustum_corners(frame.camera, 0.0, aspect);
    let camera = frustum_corners(frame.camera, bystander.reach * 0.05, aspect);
    let on_screen = |points: [glam::DVec3; 4]| points.map(|p| bystander.project(p));
    let (far_2, near_2, camera_2) = (on_screen(far), on_screen(near), on_screen(camera));

    let middle = |a: glam::DVec3, b: glam::DVec3| bystander.project((a + b) * 0.5);
    let wedge = [
        middle(near[0], near[3]),
        middle(far[0], far[3]),
        middle(far[1], far[2]),
        middle(near[1], near[2]),
    ];
    canvas.polygon(&wedge, FRUSTUM.with_opacity(26));
    let sides: [[[f32; 2]; 2]; 4] = std::array::from_fn(|i| [near_2[i], far_2[i]]);
    let eye_level: [[[f32; 2]; 2]; 2] = [[wedge[0], wedge[1]], [wedge[3], wedge[2]]];
    canvas.lines(&sides, 1.0, FRUSTUM.with_opacity(110));
    canvas.lines(&eye_level, 2.5, FRUSTUM);
    let around = |p: [[f32; 2]; 4]| [p[0], p[1], p[2], p[3], p[0]];
    canvas.lines(&[around(far_2)], 1.0, FRUSTUM.with_opacity(110));
    // The camera itself: the first bit of its frustum.
    canvas.polygon(&camera_2, FRUSTUM.with_opacity(90));
    canvas.lines(&[around(camera_2)], 2.0, FRUSTUM);
    for (near, camera) in near_2.iter().zip(camera_2) {
        canvas.lines(&[[*near, camera]], 2.0, FRUSTUM);
    }
}
