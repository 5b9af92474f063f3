//! Things somewhere in view of a camera, at a distance.
#![allow(dead_code)] // Each program uses its own share.

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::view::{Camera, PictureSize, Projection};

use crate::oracle::Chance;
use crate::world::Thing;
use crate::worlds::{self, DOUBLE_SIDED, SHAPES, SINGLE_SIDED, Shape};

/// One of several.
pub fn one_of<T: Copy>(chance: &mut Chance, choices: &[T]) -> T {
    choices[chance.whole(0, choices.len() as i32 - 1) as usize]
}

/// A number between two above 0, all powers of ten as likely.
pub fn power(chance: &mut Chance, low: f64, high: f64) -> f64 {
    (low.ln() + (high.ln() - low.ln()) * chance.real(0.0, 1.0)).exp()
}

pub fn size(width: u32, height: u32) -> PictureSize {
    PictureSize::new(width, height).expect("a size")
}

/// A small picture, border tiles included.
pub fn small(chance: &mut Chance) -> PictureSize {
    size(chance.whole(9, 44) as u32, chance.whole(9, 36) as u32)
}

/// A camera that looks anywhere from `eye`.
pub fn camera_at(chance: &mut Chance, eye: DVec3, projection: Projection) -> Camera {
    loop {
        let aim = eye + worlds::direction(chance) * (1.0 + eye.abs().max_element());
        if let Ok(camera) = Camera::look_at(eye, aim, worlds::direction(chance), projection) {
            return camera;
        }
    }
}

/// A point that the camera sees `distance` away, most of the time, and half of what the picture's height is there.
pub fn in_view(
    chance: &mut Chance,
    camera: &Camera,
    size: PictureSize,
    distance: f64,
) -> (DVec3, f64) {
    let half = match *camera.projection() {
        Projection::Perspective { fov_y, .. } => (fov_y * 0.5).tan() * distance,
        Projection::Orthographic { height, .. } => height * 0.5,
    };
    let (x, y) = (chance.real(-1.1, 1.1), chance.real(-1.1, 1.1));
    let aside = camera.right() * (x * half * size.aspect()) + camera.up() * (y * half);
    (camera.eye() + camera.forward() * distance + aside, half)
}

/// A matrix with a rotation and three sizes, perhaps mirrored.
pub fn turned(chance: &mut Chance, radius: f64) -> DMat3 {
    let mut sizes = DVec3::splat(radius);
    if chance.one_in(2) {
        let mut size = || radius * chance.real(0.1, 1.0);
        sizes = DVec3::new(size(), size(), size());
    }
    if chance.one_in(3) {
        sizes.x = -sizes.x;
    }
    worlds::rotation(chance) * DMat3::from_diagonal(sizes)
}

/// A thing of a shape; its place stands in the matrix.
pub fn shaped(chance: &mut Chance, shape: Shape, matrix3: DMat3, translation: DVec3) -> Thing {
    let (points, triangles) = worlds::shape(chance, shape);
    let material = if chance.one_in(3) {
        SINGLE_SIDED
    } else {
        DOUBLE_SIDED
    };
    let positions = points
        .iter()
        .map(|p| p.to_array().map(|v| v as f32))
        .collect();
    let mesh = worlds::mesh(positions, triangles, material);
    let place = DAffine3 {
        matrix3,
        translation,
    };
    Thing::new(&mesh, place, !chance.one_in(4))
}

/// A thing of any shape.
pub fn any_thing(chance: &mut Chance, center: DVec3, radius: f64) -> Thing {
    let shape = one_of(chance, &SHAPES);
    let matrix3 = turned(chance, radius);
    shaped(chance, shape, matrix3, center)
}

/// A thing made of positions in world coordinates.
pub fn of_world(points: &[DVec3], triangles: Vec<[u32; 3]>, drawn: bool) -> Thing {
    let positions = points
        .iter()
        .map(|p| p.to_array().map(|v| v as f32))
        .collect();
    let mesh = worlds::mesh(positions, triangles, DOUBLE_SIDED);
    Thing::new(&mesh, DAffine3::IDENTITY, drawn)
}

/// A wall across the view, `distance` away, that covers about `part` of the picture's height.
pub fn wall(
    chance: &mut Chance,
    camera: &Camera,
    size: PictureSize,
    distance: f64,
    part: f64,
) -> Thing {
    let (center, half) = in_view(chance, camera, size, distance);
    // Not so much that it would reach the eye, however wide the view.
    let tilt = camera.forward() * (chance.real(-0.2, 0.2) * (distance / half).abs().min(1.0));
    let axes = DMat3::from_cols(
        (camera.right() + tilt) * (half * part * size.aspect()),
        camera.up() * (half * part),
        -camera.forward() * (half * part),
    );
    let cells = one_of(chance, &[1, 3]);
    let mut thing = shaped(chance, Shape::Wall(cells), axes, center);
    (thing.double_sided, thing.drawn) = (true, true);
    thing
}

/// Things at distances that `distance` gives, and walls among them, so that some hide others. Each is about `part` of the
/// picture's height.
pub fn scattered(
    chance: &mut Chance,
    camera: &Camera,
    size: PictureSize,
    mut distance: impl FnMut(&mut Chance) -> f64,
) -> Vec<Thing> {
    let mut things = Vec::new();
    for _ in 0..chance.whole(0, 2) {
        let (away, part) = (distance(chance), chance.real(0.5, 2.0));
        things.push(wall(chance, camera, size, away, part));
    }
    for _ in 0..chance.whole(2, 9) {
        let away = distance(chance);
        let (center, half) = in_view(chance, camera, size, away);
        let radius = half.min(away.abs()) * chance.real(0.02, 0.5);
        things.push(any_thing(chance, center, radius));
    }
    things
}
