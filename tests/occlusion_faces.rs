//! A box's outline and faces enclose all that is drawn inside the box, and not much more.

mod boxes;
mod oracle;
mod worlds;

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::occlusion::{Footprint, OrientedBox, Screen};
use antumbra::raster::{ObjectAssembler, for_each_sample};
use antumbra::scene::Scene;
use antumbra::view::{Camera, PictureSize, Projection};
use boxes::{Placed, any_view, mesh_in_cube};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES};

#[test]
fn the_outline_and_the_faces_enclose_all_that_is_drawn_in_the_box() {
    let mut chance = Chance::seeded(51);
    let size = PictureSize::new(83, 61).unwrap();
    let (mut samples, mut sloped) = (0_u64, 0_u64);
    for round in 0..12_000 {
        let (placed, camera) = any_view(&mut chance);
        let screen = Screen::new(camera, size);
        let projected = placed.on(&screen);
        let footprint = projected.footprint();
        let mesh = mesh_in_cube(&mut chance);
        let outline_and_faces = match footprint {
            Footprint::Unbounded => continue,
            Footprint::Nowhere => None,
            Footprint::Within(rect) => Some((projected.outline(&rect), projected.faces(&rect))),
        };
        ObjectAssembler::new(camera, size).assemble(
            &mesh,
            &placed.world_from_cube,
            |_| true,
            |drawn| {
                for_each_sample(&drawn.triangle, 0..size.height() as i32, |x, y, depth| {
                    let Some((outline, faces)) = &outline_and_faces else {
                        panic!("round {round}: a sample of a box that is nowhere");
                    };
                    let [first, last] = outline.columns(y);
                    assert!(outline.y[0] <= y && y <= outline.y[1], "round {round}");
                    assert!(
                        first <= x && x <= last,
                        "round {round}: {x} in {first}..={last}"
                    );
                    let bound = faces.nearest_over([x, x], [y, y]);
                    assert!(depth <= bound, "round {round}: {depth:e} before {bound:e}");
                    samples += 1;
                    sloped += u64::from(bound < faces.nearest());
                });
            },
        );
    }
    assert!(
        samples > 1_000_000 && sloped > samples / 2,
        "{samples} samples, {sloped} sloped"
    );
}

/// Where a ray enters a box, slab by slab, as a depth; none if it misses.
fn entry_depth(
    camera: &Camera,
    size: PictureSize,
    placed: &Placed,
    px: f64,
    py: f64,
) -> Option<f64> {
    let up = match *camera.projection() {
        Projection::Perspective { fov_y, .. } => (fov_y * 0.5).tan(),
        Projection::Orthographic { height, .. } => height * 0.5,
    };
    let right = (px / size.width() as f64 * 2.0 - 1.0) * up * size.aspect();
    let upward = (1.0 - py / size.height() as f64 * 2.0) * up;
    let sideways = camera.right() * right + camera.up() * upward;
    let (origin, direction) = match camera.projection() {
        Projection::Perspective { .. } => (DVec3::ZERO, camera.forward() + sideways),
        Projection::Orthographic { .. } => (sideways, camera.forward()),
    };
    let into_cube = placed.world_from_cube.matrix3.inverse();
    let o = into_cube * (origin + (camera.eye() - placed.shape.center));
    let d = into_cube * direction;
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (a, b) = ((-1.0 - o[axis]) / d[axis], (1.0 - o[axis]) / d[axis]);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter <= leave).then(|| camera.projection().depth_at(enter))
}

/// In ordinary worlds an outline's samples lie within a hundredth of a pixel of the box, and the bound there is the
/// depth at which a ray enters the box, or nearly so.
#[test]
fn the_outline_and_the_faces_are_tight() {
    let mut chance = Chance::seeded(52);
    let size = PictureSize::new(160, 120).unwrap();
    let (mut inside, mut count) = (0_u64, 0_u64);
    for round in 0..3_000 {
        let half = DVec3::new(
            chance.real(0.1, 2.0),
            chance.real(0.1, 2.0),
            chance.real(0.1, 2.0),
        );
        let aligned = chance.one_in(2);
        let turned = if aligned {
            DMat3::IDENTITY
        } else {
            worlds::rotation(&mut chance)
        };
        let mut matrix3 = turned * DMat3::from_diagonal(half);
        if !aligned && chance.one_in(2) {
            matrix3.z_axis = -matrix3.z_axis;
        }
        let placed = Placed {
            shape: OrientedBox {
                center: DVec3::ZERO,
                half_axes: [matrix3.x_axis, matrix3.y_axis, matrix3.z_axis],
            },
            world_from_cube: DAffine3::from_mat3(matrix3),
            aligned,
        };
        let distance = chance.real(4.0, 40.0);
        let camera = worlds::camera(&mut chance, DVec3::ZERO, distance);
        let projected = placed.on(&Screen::new(camera, size));
        let Footprint::Within(rect) = projected.footprint() else {
            continue;
        };
        let (outline, faces) = (projected.outline(&rect), projected.faces(&rect));
        count += 1;
        for y in rect.y[0]..=rect.y[1] {
            let [first, last] = outline.columns(y);
            for x in first..=last {
                let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                // A sharp corner is grown farther than its sides.
                let near_by = |off: f64| {
                    [
                        (-off, -off),
                        (-off, off),
                        (off, -off),
                        (off, off),
                        (0.0, 0.0),
                    ]
                    .map(|(dx, dy)| entry_depth(&camera, size, &placed, px + dx, py + dy))
                };
                assert!(
                    near_by(0.01).iter().any(Option::is_some),
                    "round {round}: {x}, {y}"
                );
                // Nowhere nearer than the box gets within a hundredth of a pixel, and at a ridge as much again, but
                // for the rounding to f32 and the error of the triangles' formula.
                let around = near_by(0.01);
                if around.iter().all(Option::is_some) {
                    let depths = || around.into_iter().flatten();
                    let nearest = depths().fold(f64::NEG_INFINITY, f64::max);
                    let farthest = depths().fold(f64::INFINITY, f64::min);
                    let bound = f64::from(faces.nearest_over([x, x], [y, y]));
                    let spare = nearest.abs().max(f64::from(rect.nearest_depth).abs()) * 1e-6;
                    assert!(
                        bound <= nearest + (nearest - farthest) + spare,
                        "round {round}: {bound:e} for {farthest:e} to {nearest:e}"
                    );
                    inside += 1;
                }
            }
        }
    }
    assert!(
        count > 1_000 && inside > 100_000,
        "{count} boxes, {inside} samples"
    );
}

fn projections() -> [Projection; 2] {
    [
        Projection::Perspective {
            fov_y: 1.2,
            near: 0.1,
            far: None,
        },
        Projection::Orthographic {
            height: 20.0,
            near: 0.1,
            far: None,
        },
    ]
}

/// The eye in the plane of a face, or as far from it as rounding can tell: the face is seen edge-on, before and behind
/// change from one step to the next, and what is drawn on it stays within.
#[test]
fn a_face_in_the_eyes_own_plane_bounds_nothing_wrongly() {
    let mut chance = Chance::seeded(54);
    let size = PictureSize::new(83, 61).unwrap();
    let mut samples = 0;
    for round in 0..4_000 {
        let home = worlds::home(&mut chance);
        let projection = projections()[round % 2];
        let eye = home;
        let camera = Camera::look_at(eye, home - DVec3::Z, DVec3::Y, projection).unwrap();
        let gap = [0.0, 1e-15, 1e-13, 1e-10, 1e-7, 1e-5, 1e-3][chance.whole(0, 6) as usize]
            * if chance.one_in(2) { 1.0 } else { -1.0 };
        let tilt = [0.0, 1e-9, 1e-4][chance.whole(0, 2) as usize];
        // One face is at x = gap, all but seen from the side.
        let half = DVec3::new(
            chance.real(0.01, 2.0),
            chance.real(0.01, 2.0),
            chance.real(0.01, 3.0),
        );
        let center = eye + DVec3::new(gap + half.x, chance.real(-1.0, 1.0), -0.2 - half.z);
        let matrix3 = DMat3::from_cols(
            DVec3::new(half.x, 0.0, 0.0),
            DVec3::new(0.0, half.y, 0.0),
            DVec3::new(tilt * half.z, 0.0, half.z),
        );
        let placed = Placed {
            shape: OrientedBox {
                center,
                half_axes: [matrix3.x_axis, matrix3.y_axis, matrix3.z_axis],
            },
            world_from_cube: DAffine3 {
                matrix3,
                translation: center,
            },
            aligned: tilt == 0.0,
        };
        let projected = placed.on(&Screen::new(camera, size));
        let Footprint::Within(rect) = projected.footprint() else {
            continue;
        };
        let (outline, faces) = (projected.outline(&rect), projected.faces(&rect));
        let mesh = mesh_in_cube(&mut chance);
        ObjectAssembler::new(camera, size).assemble(
            &mesh,
            &placed.world_from_cube,
            |_| true,
            |drawn| {
                for_each_sample(&drawn.triangle, 0..size.height() as i32, |x, y, depth| {
                    let [first, last] = outline.columns(y);
                    assert!(first <= x && x <= last, "round {round}");
                    assert!(depth <= faces.nearest_over([x, x], [y, y]), "round {round}");
                    samples += 1;
                });
            },
        );
    }
    assert!(samples > 300_000, "{samples} samples");
}

/// An object's own box holds it, wherever its numbers come from: from local coordinates far from the origin that its
/// matrix brings back, too.
#[test]
fn an_objects_own_box_holds_all_that_is_drawn_of_it() {
    let mut chance = Chance::seeded(55);
    let size = PictureSize::new(71, 53).unwrap();
    let (mut boxes, mut samples) = (0, 0);
    for round in 0..8_000 {
        let home = worlds::home(&mut chance);
        let kind = SHAPES[round % SHAPES.len()];
        let (mesh, place) = worlds::placed(&mut chance, kind, DOUBLE_SIDED, home, 1.0);
        let scene = Scene::new(vec![mesh], vec![worlds::object(0, place)]).unwrap();
        let Some(own) = scene.own_box(0) else {
            continue;
        };
        let distance = chance.real(1.5, 8.0);
        let camera = worlds::camera(&mut chance, home, distance);
        let projected = Screen::new(camera, size).project_oriented_box(&own.shape, own.growth);
        let Footprint::Within(rect) = projected.footprint() else {
            continue;
        };
        boxes += 1;
        let (outline, faces) = (projected.outline(&rect), projected.faces(&rect));
        ObjectAssembler::new(camera, size).assemble(
            &scene.meshes()[0],
            &place,
            |_| true,
            |drawn| {
                for_each_sample(&drawn.triangle, 0..size.height() as i32, |x, y, depth| {
                    let [first, last] = outline.columns(y);
                    assert!(first <= x && x <= last, "round {round}");
                    assert!(depth <= faces.nearest_over([x, x], [y, y]), "round {round}");
                    samples += 1;
                });
            },
        );
    }
    assert!(
        boxes > 1_000 && samples > 300_000,
        "{boxes} boxes, {samples} samples"
    );
}
