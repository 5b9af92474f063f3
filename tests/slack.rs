//! Culling with a slack is right for any final pass within it: here for devices that are as far from ours as they may be, vertex by
//! vertex and by chance, and draw by plain loops in f64.

mod oracle;
mod worlds;

use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::scene::{Material, Object, Scene};
use antumbra::view::{Camera, MapScale, PictureSize, Projection, Slack};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SINGLE_SIDED, Shape, mesh, placed};

const SIZE: [u32; 2] = [96, 64];

fn size() -> PictureSize {
    PictureSize::new(SIZE[0], SIZE[1]).expect("a size")
}

fn object(mesh: usize, world_from_local: DAffine3) -> Object {
    Object {
        name: String::new(),
        mesh,
        world_from_local,
        never_cull: false,
        never_occlude: false,
        occluder_proxy: None,
    }
}

/// A piece of a wall, in cells that are bent, but for its outline.
fn piece(
    chance: &mut Chance,
    x: [f64; 2],
    y: [f64; 2],
    at: impl Fn(f64, f64, f64) -> [f32; 3],
) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let n = chance.whole(1, 4) as u32;
    let cell = (x[1] - x[0]).min(y[1] - y[0]) / f64::from(n);
    let bend = cell * 10_f64.powf(chance.real(-4.0, -0.5));
    let along =
        |ends: [f64; 2], i: u32| ends[0] + (ends[1] - ends[0]) * f64::from(i) / f64::from(n);
    let mut positions = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let is_inner = i % n != 0 && j % n != 0;
            let mut off = |most: f64| {
                if is_inner {
                    chance.real(-most, most)
                } else {
                    0.0
                }
            };
            let (x, y) = (along(x, i) + off(0.3 * cell), along(y, j) + off(0.3 * cell));
            positions.push(at(x, y, off(bend)));
        }
    }
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
    (positions, triangles.collect())
}

/// Walls that meet without a gap, before the camera at the origin, and things not far behind them.
fn world(chance: &mut Chance) -> Scene {
    let distance = chance.real(3.0, 30.0);
    let (across, down) = (chance.whole(1, 4) as usize, chance.whole(1, 4) as usize);
    let reach = distance * chance.real(0.4, 0.9);
    let mut cuts = |count: usize| -> Vec<f64> {
        let mut cuts: Vec<f64> = (0..=count)
            .map(|i| reach * (2.0 * i as f64 / count as f64 - 1.0))
            .collect();
        for cut in &mut cuts[1..count] {
            *cut += reach / count as f64 * chance.real(-0.7, 0.7);
        }
        cuts
    };
    let (columns, rows) = (cuts(across), cuts(down));
    // Tilted, so that depth has a slope; all before the eye.
    let tilt = [chance.real(-0.4, 0.4), chance.real(-0.4, 0.4)];
    let at = |x: f64, y: f64, bend: f64| {
        let away = distance + tilt[0] * x + tilt[1] * y + bend;
        [x as f32, y as f32, -away as f32]
    };
    let mut meshes = Vec::new();
    let mut objects = Vec::new();
    for x in columns.windows(2) {
        for y in rows.windows(2) {
            let single = chance.one_in(2);
            let material = if single { SINGLE_SIDED } else { DOUBLE_SIDED };
            let (positions, triangles) = piece(chance, [x[0], x[1]], [y[0], y[1]], at);
            objects.push(object(meshes.len(), DAffine3::IDENTITY));
            meshes.push(mesh(positions, triangles, material));
        }
    }
    for _ in 0..40 {
        let (x, y) = (
            chance.real(-1.2, 1.2) * reach,
            chance.real(-1.2, 1.2) * reach,
        );
        let radius = distance * 10_f64.powf(chance.real(-2.5, -1.0));
        let behind = 1.8 * radius + distance * 10_f64.powf(chance.real(-5.0, -1.0));
        let wall = distance + tilt[0] * x + tilt[1] * y;
        let place = DVec3::new(x, y, -(wall + behind));
        let kind = [Shape::Cube, Shape::Wall(1), Shape::Ball(1)][chance.whole(0, 2) as usize];
        let material: Material = SINGLE_SIDED;
        let (mesh, place) = placed(chance, kind, material, place, radius);
        objects.push(object(meshes.len(), place));
        meshes.push(mesh);
    }
    Scene::new(meshes, objects).expect("a scene")
}

fn camera() -> Camera {
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.1,
        far: None,
    };
    Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).expect("a camera")
}

/// The objects that own a pixel where a device draws them that is off by so much.
fn owners(scene: &Scene, camera: &Camera, off: Slack, chance: &mut Chance) -> Vec<u32> {
    let [width, height] = SIZE.map(|s| s as usize);
    let mut pixels: Vec<(f64, u32)> = vec![(f64::NEG_INFINITY, u32::MAX); width * height];
    let screen = camera.screen_from_eye(size());
    // As far as it may be, or anything less.
    let mut any = |most: f64| match chance.whole(0, 3) {
        0 => chance.real(-most, most),
        1 => 0.0,
        2 => most,
        _ => -most,
    };
    for (number, object) in scene.objects().iter().enumerate() {
        let mesh = &scene.meshes()[object.mesh];
        let bounds = &scene.bounds()[number];
        let farthest = (bounds.min - camera.eye()).abs();
        let farthest = farthest.max((bounds.max - camera.eye()).abs()).length();
        let moved = off.position() * farthest;
        // What is left to transforms of the pixels is in `moved` already.
        let grid = off.pixels() * 5.0 / 8.0;
        let vertices: Vec<[f64; 3]> = { mesh.positions.iter() }
            .map(|p| {
                let p = object
                    .world_from_local
                    .transform_point3(DVec3::from(p.map(f64::from)));
                let p = p - camera.eye();
                let row = |r: [f64; 4]| DVec3::new(r[0], r[1], r[2]).dot(p) + r[3];
                let length = |r: [f64; 4]| DVec3::new(r[0], r[1], r[2]).length();
                let w = row(screen.w) + any(moved) * length(screen.w);
                // From the middle of the picture, in pixels: rows are off each on its own.
                let side = |r: [f64; 4], pixels: u32, off: f64| {
                    let half = f64::from(pixels) * 128.0;
                    let r = std::array::from_fn(|i| r[i] - half * screen.w[i]);
                    ((row(r) + off * length(r)) / w + half) / 256.0
                };
                let x = side(screen.x, SIZE[0], any(moved)) + any(grid);
                let y = side(screen.y, SIZE[1], any(moved)) + any(grid);
                [x, y, row(screen.depth) / w + any(off.depth())]
            })
            .collect();
        for surface in mesh.surfaces.iter() {
            for &triangle in &mesh.triangles[surface.triangles.clone()] {
                let mut corners = triangle.map(|i| vertices[i as usize]);
                // A matrix that mirrors does not turn a mesh inside out.
                if object.world_from_local.matrix3.determinant() < 0.0 {
                    corners.swap(1, 2);
                }
                draw(corners, surface.material.double_sided, |x, y, depth| {
                    let pixel = &mut pixels[y * width + x];
                    if depth > pixel.0 {
                        *pixel = (depth, number as u32);
                    }
                });
            }
        }
    }
    let mut owners: Vec<u32> = pixels
        .iter()
        .map(|p| p.1)
        .filter(|&o| o != u32::MAX)
        .collect();
    owners.sort_unstable();
    owners.dedup();
    owners
}

/// Calls `visit` for the pixels whose centres are in a triangle or on its border: fronts run counter-clockwise.
fn draw([a, b, c]: [[f64; 3]; 3], both_sides: bool, mut visit: impl FnMut(usize, usize, f64)) {
    let edge = |a: [f64; 3], b: [f64; 3], x: f64, y: f64| {
        (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
    };
    let area = edge(a, b, c[0], c[1]);
    // Where y points down.
    if area == 0.0 || area > 0.0 && !both_sides {
        return;
    }
    let samples = |axis: usize| {
        let least = a[axis].min(b[axis]).min(c[axis]);
        let largest = a[axis].max(b[axis]).max(c[axis]);
        let last = f64::from(SIZE[axis]);
        let [first, last] =
            [(least - 0.5).ceil(), (largest - 0.5).floor()].map(|end| end.clamp(-1.0, last));
        (first.max(0.0) as usize)..((last + 1.0).clamp(0.0, f64::from(SIZE[axis])) as usize)
    };
    for y in samples(1) {
        for x in samples(0) {
            let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
            let shares = [edge(b, c, px, py), edge(c, a, px, py), edge(a, b, px, py)];
            let [wa, wb, wc] = shares.map(|share| share / area);
            if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 {
                visit(x, y, wa * a[2] + wb * b[2] + wc * c[2]);
            }
        }
    }
}

/// How many objects were culled, and how many of these own a pixel on devices that are off by so much.
fn lost(slack: Slack, off: Slack, scale: MapScale, worlds: u64) -> [usize; 2] {
    let camera = camera();
    let mut lost = [0; 2];
    for seed in 0..worlds {
        let mut chance = Chance::seeded(seed);
        let scene = Arc::new(world(&mut chance));
        let settings = Settings {
            slack,
            map_scale: scale,
            threads: 1,
            ..Settings::new(size())
        };
        let mut culler = Culler::new(scene.clone(), settings).expect("threads");
        let visible = culler.cull(&camera).visible;
        lost[0] += scene.objects().len() - visible.len();
        for _ in 0..4 {
            let owners = owners(&scene, &camera, off, &mut chance);
            lost[1] += { owners.iter() }
                .filter(|owner| visible.binary_search(owner).is_err())
                .count();
        }
    }
    lost
}

#[test]
fn never_culls_what_owns_a_pixel_on_a_device_within_the_slack() {
    let much = Slack::new(2.0, 1e-3, 1e-3).expect("in range");
    let little = Slack::new(0.3, 1e-5, 1e-4).expect("in range");
    for slack in [much, little, Slack::GPU, Slack::GPU_MULTISAMPLED] {
        for scale in MapScale::ALL {
            let [culled, lost] = lost(slack, slack, scale, 60);
            assert_eq!(lost, 0, "{slack:?}, scale {scale}: of {culled} culled");
            let fewest = if slack == much { 100 } else { 500 };
            assert!(culled > fewest, "{slack:?}, scale {scale}: {culled} culled");
        }
    }
}

/// Without one of its parts, something is lost on such a device: the test above can fail.
#[test]
fn each_part_of_a_slack_is_needed() {
    let parts = [[0.5, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]];
    for [pixels, position, depth] in parts {
        let off = Slack::new(pixels, position, depth).expect("in range");
        let [culled, lost] = lost(Slack::NONE, off, MapScale::Full, 60);
        assert!(lost > 0, "{off:?}: none lost of {culled}");
    }
}
