//! Pictures by a graphics processor, or what stands in for one: with culling and without they are the same.

mod cli;
mod oracle;
mod worlds;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::final_pass::gpu::{GpuPass, NOBODY};
use antumbra::final_pass::{Image, render_image};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::occluders::Budget;
use antumbra::scene::{Alpha, Material, Mesh, Object, Scene};
use antumbra::view::{Camera, CameraPath, PictureSize, Projection, Slack};
use antumbra_fixtures::{Kind, Recipe, generate};
use cli::{Folder, stderr, stdout, succeed};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES, SINGLE_SIDED, mesh, placed};

fn size(width: u32, height: u32) -> PictureSize {
    PictureSize::new(width, height).expect("a size")
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

fn all_of(scene: &Scene) -> Vec<u32> {
    (0..scene.objects().len() as u32).collect()
}

fn pass_of(scene: &Arc<Scene>) -> GpuPass {
    GpuPass::new(scene.clone()).unwrap_or_else(|e| panic!("{e}"))
}

fn culler_of(scene: &Arc<Scene>, size: PictureSize, slack: Slack) -> Culler {
    let settings = Settings {
        slack,
        threads: 1,
        ..Settings::new(size)
    };
    Culler::new(scene.clone(), settings).expect("threads")
}

/// How far pictures are from the CPU's.
#[derive(Debug, Default)]
struct Difference {
    pixels: usize,
    differing: usize,
    /// By more than 2 of 255.
    plainly: usize,
}

impl Difference {
    fn add(&mut self, a: &Image, b: &Image) {
        self.pixels += a.pixels().len();
        self.differing += a.differing_pixels(b);
        self.plainly += a.pixels_differing_by_more(b, 2);
    }

    fn shares(&self) -> [f64; 2] {
        [self.differing, self.plainly].map(|d| d as f64 / self.pixels as f64)
    }
}

/// Draws every `every`th frame of a path with culling and without, which has to be the same; says how far that is from the
/// CPU's pictures.
fn judge(
    name: &str,
    scene: &Arc<Scene>,
    path: &CameraPath,
    size: PictureSize,
    every: usize,
) -> Difference {
    let mut pass = pass_of(scene);
    let mut culler = culler_of(scene, size, Slack::GPU);
    let all = all_of(scene);
    let (mut difference, mut culled) = (Difference::default(), 0);
    for (frame, camera) in path.cameras().iter().enumerate().step_by(every) {
        let visible = culler.cull(camera).visible;
        culled += all.len() - visible.len();
        let picture = pass.render(camera, size, &visible).expect("a picture");
        let whole = pass.render(camera, size, &all).expect("a picture");
        assert!(
            picture == whole,
            "{name}, frame {frame}: culling changes pixels"
        );
        difference.add(&picture, &render_image(scene, camera, size, &visible));
    }
    let [differing, plainly] = difference.shares().map(|share| 100.0 * share);
    println!(
        "{name}: {culled} culled; {differing:.4} % of the pixels differ from the CPU's, {plainly:.4} % by more than 2 of 255; {}",
        pass.device()
    );
    assert!(culled > 0, "{name}: nothing was culled");
    difference
}

fn city() -> (Arc<Scene>, CameraPath) {
    let fixture = generate(&Recipe {
        triangles: Some(60_000),
        ..Recipe::new(Kind::City)
    })
    .expect("enough triangles");
    let thread = std::thread::current();
    let name = thread.name().unwrap_or("main").to_owned();
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("gpu-{name}.glb"));
    let out = std::fs::File::create(&file).expect("the file can be written");
    fixture.write_glb(out).expect("the file can be written");
    let scene = Scene::load(&file).expect("a sound file");
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
    let _ = std::fs::remove_file(&file);
    (Arc::new(scene), path)
}

#[test]
fn pictures_of_the_city_are_the_same_with_culling_and_without_and_close_to_the_cpus() {
    let (scene, path) = city();
    let shares = judge("city", &scene, &path, size(637, 411), 12).shares();
    // Edges, and roundings by one step of a byte.
    assert!(shares[0] < 0.01 && shares[1] < 0.002, "{shares:?}");
}

#[test]
fn pictures_of_real_scenes_are_the_same_with_culling_and_without_and_close_to_the_cpus() {
    let folder = std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    );
    for (name, every) in [("castle", 8), ("clinic", 12), ("falcon", 22)] {
        let file = folder.join(format!("{name}.glb"));
        if !file.exists() {
            eprintln!("skipped: there is no {}", file.display());
            continue;
        }
        let scene = Arc::new(Scene::load(&file).expect("a scene"));
        let path = CameraPath::load(&folder.join(format!("{name}.path.json"))).expect("a path");
        let shares = judge(name, &scene, &path, size(1280, 768), every).shares();
        assert!(shares[0] < 0.01 && shares[1] < 0.002, "{name}: {shares:?}");
    }
}

/// Shapes of all sorts close together, some translucent or cut out, some before the near plane.
fn clutter(chance: &mut Chance) -> Scene {
    let mut meshes: Vec<Mesh> = Vec::new();
    let mut objects = Vec::new();
    for _ in 0..60 {
        let place = DVec3::new(
            chance.real(-6.0, 6.0),
            chance.real(-6.0, 6.0),
            chance.real(-6.0, 6.0),
        );
        let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
        let alpha = match chance.whole(0, 9) {
            0 => Alpha::Mask,
            1 => Alpha::Blend,
            _ => Alpha::Opaque,
        };
        let color = std::array::from_fn(|_| chance.real(0.1, 0.9) as f32);
        let sides = if chance.one_in(2) {
            SINGLE_SIDED
        } else {
            DOUBLE_SIDED
        };
        let material = Material {
            alpha,
            color,
            ..sides
        };
        let radius = 10_f64.powf(chance.real(-1.0, 0.7));
        let (mesh, place) = placed(chance, kind, material, place, radius);
        objects.push(object(meshes.len(), place));
        meshes.push(mesh);
    }
    Scene::new(meshes, objects).expect("a scene")
}

fn anywhere(chance: &mut Chance) -> Camera {
    let mut point = || {
        let mut at = || chance.real(-7.0, 7.0);
        DVec3::new(at(), at(), at())
    };
    let (eye, target) = (point(), point());
    let far = chance.one_in(3).then_some(11.0);
    let projection = if chance.one_in(4) {
        Projection::Orthographic {
            height: chance.real(2.0, 20.0),
            near: chance.real(-3.0, 1.0),
            far: Some(25.0),
        }
    } else {
        Projection::Perspective {
            fov_y: chance.real(0.3, 2.0),
            near: 10_f64.powf(chance.real(-3.0, 0.0)),
            far,
        }
    };
    Camera::look_at(eye, target, DVec3::Y, projection).expect("a camera")
}

/// The objects that own a pixel.
fn owners(pass: &GpuPass, camera: &Camera, size: PictureSize, objects: &[u32]) -> Vec<u32> {
    let mut owners = pass.owners(camera, size, objects).expect("owners");
    owners.sort_unstable();
    owners.dedup();
    owners.retain(|&owner| owner != NOBODY);
    owners
}

/// Where the samples of a pixel are that has four, and half a pixel away.
const SAMPLES: [[f64; 2]; 6] = [
    [-0.125, -0.375],
    [0.375, -0.125],
    [-0.375, 0.125],
    [0.125, 0.375],
    [-0.5, -0.5],
    [0.5, 0.5],
];

#[test]
fn never_culls_what_owns_a_pixel_on_the_device() {
    let size = size(203, 121);
    let (mut culled, mut seen_elsewhere) = (0, 0);
    for seed in 0..12 {
        let mut chance = Chance::seeded(seed);
        let scene = Arc::new(clutter(&mut chance));
        let mut pass = pass_of(&scene);
        let mut cullers = [Slack::GPU, Slack::GPU_MULTISAMPLED, Slack::NONE]
            .map(|slack| culler_of(&scene, size, slack));
        let mut jittered = culler_of(&scene, size, Slack::GPU);
        let all = all_of(&scene);
        for view in 0..25 {
            let camera = anywhere(&mut chance);
            let [visible, around, unsafe_ones] = cullers
                .each_mut()
                .map(|culler| culler.cull(&camera).visible);
            culled += all.len() - visible.len();
            let of = |visible: &[u32], owner: &u32| visible.binary_search(owner).is_ok();
            for owner in owners(&pass, &camera, size, &all) {
                assert!(of(&visible, &owner), "{seed}, view {view}: object {owner}");
            }
            for sample in SAMPLES {
                let there = camera.jittered(sample.into()).expect("within the pixel");
                let owners = owners(&pass, &there, size, &all);
                // Several samples a pixel: all have to be kept by one question. Or one a frame: each by its own.
                let of_it = jittered.cull(&there).visible;
                for owner in owners {
                    assert!(
                        of(&around, &owner) && of(&of_it, &owner),
                        "{seed}, view {view}, sample {sample:?}: object {owner}"
                    );
                    seen_elsewhere += usize::from(!of(&unsafe_ones, &owner));
                }
            }
            let picture = pass.render(&camera, size, &visible).expect("a picture");
            let whole = pass.render(&camera, size, &all).expect("a picture");
            assert!(
                picture == whole,
                "{seed}, view {view}: culling changes pixels"
            );
        }
    }
    println!(
        "{culled} culled; without a slack {seen_elsewhere} of those seen at other samples would be"
    );
    assert!(culled > 1000 && seen_elsewhere > 0);
}

/// Walls on both sides of slits that are a sub-pixel wide, whose sides lie where roundings to the grid turn: ours close some of them,
/// the device's others. Behind each is a lamp, which only the slit may show.
#[test]
fn a_lamp_behind_a_slit_that_only_the_device_leaves_open_is_kept() {
    let (width, height) = (320, 400);
    let size = size(width, height);
    let projection = Projection::Orthographic {
        height: f64::from(height),
        near: 1.0,
        far: Some(20.0),
    };
    let (target, up) = (DVec3::new(0.3, -0.5, 0.7), DVec3::new(0.2, 0.9, -0.1));
    let camera = Camera::look_at(DVec3::ZERO, target, up, projection).expect("a camera");
    // A pixel is a unit.
    let rectangle = |x: [f64; 2], y: [f64; 2], distance: f64| {
        [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]: [usize; 2]| {
            let p = camera.right() * x[i] + camera.up() * y[j] + camera.forward() * distance;
            p.as_vec3().to_array()
        })
    };
    let mut chance = Chance::seeded(1);
    let mut walls = Vec::new();
    let mut meshes = Vec::new();
    let quad = vec![[0, 1, 2], [0, 2, 3]];
    for column in 0..width / 8 {
        for row in 0..height / 8 {
            let left = f64::from(8 * column) - f64::from(width) / 2.0;
            let low = f64::from(8 * row) - f64::from(height) / 2.0;
            let sample = left + 4.5;
            let mut side = |steps: f64| sample + (steps + chance.real(-0.01, 0.01)) / 256.0;
            let (right_of_one, left_of_other) = (side(-0.5), side(0.5));
            let y = [low - 0.6, low + 8.6];
            walls.extend(rectangle([left - 0.6, right_of_one], y, 2.0));
            walls.extend(rectangle([left_of_other, left + 8.6], y, 2.0));
            let lamp = rectangle([left + 4.1, left + 4.9], [low + 3.1, low + 3.9], 9.0);
            meshes.push(mesh(lamp.to_vec(), quad.clone(), DOUBLE_SIDED));
        }
    }
    let lamps = meshes.len();
    let quads = 0..walls.len() as u32 / 4;
    let triangles = quads.flat_map(|i| quad.iter().map(move |t| t.map(|c| c + 4 * i)));
    meshes.push(mesh(walls, triangles.collect(), DOUBLE_SIDED));
    let objects = (0..meshes.len()).map(|mesh| object(mesh, DAffine3::IDENTITY));
    let scene = Arc::new(Scene::new(meshes, objects.collect()).expect("a scene"));

    let pass = pass_of(&scene);
    let mut seen = owners(&pass, &camera, size, &all_of(&scene));
    seen.retain(|&object| (object as usize) < lamps);
    let lost = |slack: Slack| {
        let settings = Settings {
            slack,
            budget: Budget::All,
            ..Settings::new(size)
        };
        let mut culler = Culler::new(scene.clone(), settings).expect("threads");
        let visible = culler.cull(&camera).visible;
        let lost = { seen.iter() }.filter(|lamp| visible.binary_search(lamp).is_err());
        (lost.count(), scene.objects().len() - visible.len())
    };
    let (without, culled) = lost(Slack::NONE);
    println!(
        "{} of {lamps} lamps are seen; without a slack {culled} are culled, of which {without} are seen",
        seen.len()
    );
    assert_eq!(lost(Slack::GPU).0, 0);
    assert!(without > 0);
}

#[test]
fn the_command_draws_checks_and_compares() {
    let folder = Folder::new("gpu_render").with_scene();
    let (scene, path, out) = (
        folder.file("yard.obj"),
        folder.file("yard.path.json"),
        folder.file("out"),
    );
    let text = stdout(&succeed(&[
        "render",
        &scene,
        "--path",
        &path,
        "--size",
        "321x200",
        "--final-pass",
        "gpu",
        "--check",
        "--compare",
        "--out",
        &out,
    ]));
    for expected in [
        "2 culled",
        "byte for byte",
        "drawn by",
        "differ from the CPU",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    let marked = image::open(format!("{out}/compared_0000.png")).expect("a picture");
    assert_eq!((marked.width(), marked.height()), (321, 200));
}

/// No driver is found: the folder that is named has none.
#[test]
fn without_a_device_the_command_says_so() {
    let folder = Folder::new("gpu_none").with_scene();
    let output = std::process::Command::new(cli::EXE)
        .args([
            "render",
            &folder.file("yard.obj"),
            "--final-pass",
            "gpu",
            "--out",
            &folder.file("out"),
        ])
        .env("VK_DRIVER_FILES", folder.file("none.json"))
        .env("VK_ICD_FILENAMES", folder.file("none.json"))
        .output()
        .expect("the command starts");
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("no graphics processor"),
        "{}",
        stderr(&output)
    );
}
