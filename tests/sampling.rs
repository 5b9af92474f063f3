//! Sampled visibility: what it finds, how frames use it, and what it may take.

mod cli;
mod oracle;
mod worlds;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use antumbra::cull::{Culler, Settings, VisibleSet};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::occluders::{Budget, Selection};
use antumbra::prepare::{
    ClusterId, GridLayout, MOST_CLUSTERS_PER_VIEWPOINT, SampledCluster, VisibilityGrid,
    VisibilityGridError,
};
use antumbra::raster::{ObjectAssembler, for_each_sample};
use antumbra::sampling::{SamplingSettings, sample_visibility};
use antumbra::scene::{Aabb, Material, Object, Scene};
use antumbra::view::{Camera, PictureSize, Projection};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SINGLE_SIDED, Shape};

/// Rooms of walls of several cells, with balls and boxes in them; one object is no occluder.
fn rooms(chance: &mut Chance) -> Arc<Scene> {
    let kinds = [Shape::Wall(7), Shape::Cube, Shape::Ball(3)];
    let materials: [Material; 3] = [DOUBLE_SIDED, SINGLE_SIDED, DOUBLE_SIDED];
    let meshes = kinds.into_iter().zip(materials).map(|(kind, material)| {
        let (points, triangles) = worlds::shape(chance, kind);
        let positions = points.iter().map(|p| p.to_array().map(|v| v as f32));
        worlds::mesh(positions.collect(), triangles, material)
    });
    let meshes: Vec<_> = meshes.collect();
    let mut objects: Vec<Object> = Vec::new();
    let turned = worlds::rotation(chance);
    for wall in 0..6 {
        let matrix3 = antumbra::glam::DMat3::from_diagonal(DVec3::new(9.0, 5.0, 1.0));
        let translation = DVec3::new(0.0, 0.0, f64::from(wall) * 6.0 - 15.0);
        objects.push(worlds::object(
            0,
            DAffine3 {
                matrix3,
                translation,
            },
        ));
    }
    for i in 0..120 {
        let mut at = |reach: f64| chance.real(-reach, reach);
        let translation = DVec3::new(at(8.0), at(4.0), at(18.0));
        let matrix3 = turned * (0.2 + 0.1 * (i % 5) as f64);
        objects.push(worlds::object(
            1 + i % 2,
            DAffine3 {
                matrix3,
                translation,
            },
        ));
    }
    objects[20].never_occlude = true;
    Arc::new(Scene::new(meshes, objects).expect("a sound scene"))
}

fn settings(threads: usize) -> Settings {
    Settings {
        threads,
        ..Settings::new(PictureSize::new(200, 120).expect("a size"))
    }
}

fn culler(scene: &Arc<Scene>) -> Culler {
    Culler::new(scene.clone(), settings(1)).expect("threads")
}

fn bounds(scene: &Scene) -> Aabb {
    scene.bvh().nodes[0].bounds()
}

fn sampling(scene: &Scene, spacing: f64) -> SamplingSettings {
    let layout = GridLayout::with_spacing(&bounds(scene), spacing).expect("a layout");
    SamplingSettings {
        face: PictureSize::new(64, 64).expect("a size"),
        ..SamplingSettings::new(layout)
    }
}

fn made(culler: &Culler, settings: &SamplingSettings) -> VisibilityGrid {
    sample_visibility(culler, settings, |_, _| ()).expect("a grid")
}

fn looking(eye: DVec3, along: DVec3) -> Camera {
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.01,
        far: None,
    };
    Camera::look_at(eye, eye + along, DVec3::Y, projection).expect("a camera")
}

/// The share of the sphere that each object owns, from pictures of the whole scene on the faces of a cube.
fn owned(scene: &Scene, eye: DVec3, near: f64, size: PictureSize) -> BTreeMap<u32, f64> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut owned = BTreeMap::new();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let up = if axis == 1 { DVec3::Z } else { DVec3::Y };
        let projection = Projection::Perspective {
            fov_y: std::f64::consts::FRAC_PI_2,
            near,
            far: None,
        };
        let camera =
            Camera::look_at(eye, eye + axes[axis] * sign, up, projection).expect("a camera");
        let mut assembler = ObjectAssembler::new(camera, size);
        let mut pixels = vec![(f32::NEG_INFINITY, None); size.width() * size.height()];
        for (number, object) in (0..).zip(scene.objects()) {
            if object.never_occlude {
                continue;
            }
            let (mesh, place) = (&scene.meshes()[object.mesh], &object.world_from_local);
            assembler.assemble(mesh, place, Material::occludes, |t| {
                let rows = 0..size.height() as i32;
                for_each_sample(&t.triangle, rows, |x, y, depth| {
                    let pixel = &mut pixels[y as usize * size.width() + x as usize];
                    if depth > pixel.0 {
                        *pixel = (depth, Some(number));
                    }
                });
            });
        }
        for (i, (_, owner)) in pixels.into_iter().enumerate() {
            let half = size.width() as f64 / 2.0;
            let u = ((i % size.width()) as f64 + 0.5) / half - 1.0;
            let v = ((i / size.width()) as f64 + 0.5) / half - 1.0;
            let angle = (1.0 / half / half) / (1.0 + u * u + v * v).powf(1.5);
            if let Some(owner) = owner {
                *owned.entry(owner).or_insert(0.0) += angle;
            }
        }
    }
    owned
}

/// Lists hold what pictures of the whole scene show, neither more nor less, and each with its part of the sphere.
#[test]
fn lists_are_what_a_cube_of_pictures_shows() {
    let scene = rooms(&mut Chance::seeded(91));
    let culler = culler(&scene);
    let settings = SamplingSettings {
        most_clusters: usize::MAX,
        ..sampling(&scene, 5.0)
    };
    let grid = made(&culler, &settings);
    let viewpoints = settings.layout.viewpoints() as usize;
    assert!(viewpoints > 20 && grid.len() > 500);
    for viewpoint in 0..viewpoints {
        let eye = settings.layout.viewpoint(viewpoint);
        let near = settings.layout.spacing / 1000.0;
        let truth = owned(&scene, eye, near, settings.face);
        let mut found: BTreeMap<u32, f64> = BTreeMap::new();
        for seen in grid.seen_from(viewpoint) {
            *found.entry(seen.id.object).or_insert(0.0) += f64::from(seen.solid_angle);
        }
        assert!(truth.keys().eq(found.keys()), "viewpoint {viewpoint}");
        for (object, angle) in &truth {
            assert!((angle - found[object]).abs() < 1e-4 * angle);
        }
    }
}

#[test]
fn making_gives_the_same_bits_for_any_number_of_threads() {
    let scene = rooms(&mut Chance::seeded(92));
    let culler = culler(&scene);
    let settings = SamplingSettings {
        most_clusters: 40,
        ..sampling(&scene, 2.0)
    };
    assert!(settings.layout.viewpoints() > 200);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        pool.install(|| made(&culler, &settings).to_bytes())
    };
    let alone = with(1);
    for threads in [2, 5] {
        assert!(with(threads) == alone, "{threads} threads");
    }
}

/// Cold frames from many places, by both selections that use a grid.
fn frames(
    scene: &Arc<Scene>,
    grid: &Arc<VisibilityGrid>,
    threads: usize,
) -> Vec<(VisibleSet, u64)> {
    let mut chance = Chance::seeded(93);
    let mut frames = Vec::new();
    for occluders in [Selection::Sampled, Selection::Contribution] {
        for budget in [Budget::All, Budget::Auto, Budget::Triangles(150)] {
            let settings = Settings {
                occluders,
                budget,
                ..settings(threads)
            };
            let mut culler = Culler::new(scene.clone(), settings).expect("threads");
            culler.set_visibility_grid(grid.clone()).expect("its scene");
            for _ in 0..6 {
                let reach = bounds(scene).size() * 0.6;
                let mut at = || chance.real(-1.0, 1.0);
                let eye = DVec3::new(at(), at(), at()) * reach;
                culler.forget();
                let mut found = culler.cull(&looking(eye, worlds::direction(&mut chance)));
                found.times = Default::default();
                let hash = culler.buffer().map_or(0, |buffer| buffer.tiles().hash());
                frames.push((found, hash));
            }
        }
    }
    frames
}

#[test]
fn using_gives_the_same_bits_for_any_number_of_threads() {
    let scene = rooms(&mut Chance::seeded(94));
    let grid = Arc::new(made(&culler(&scene), &sampling(&scene, 3.0)));
    let alone = format!("{:?}", frames(&scene, &grid, 1));
    for threads in [2, 5] {
        assert!(
            format!("{:?}", frames(&scene, &grid, threads)) == alone,
            "{threads} threads"
        );
    }
}

/// Near a viewpoint only what its list names is drawn; elsewhere, and without a grid, frames are those of the nearest objects.
#[test]
fn frames_take_the_list_of_the_nearest_viewpoint_or_the_nearest_objects() {
    let scene = rooms(&mut Chance::seeded(95));
    let mut sampled = Culler::new(
        scene.clone(),
        Settings {
            occluders: Selection::Sampled,
            ..settings(1)
        },
    )
    .expect("threads");
    let mut nearest = sampled
        .another(Settings {
            occluders: Selection::Nearest,
            ..settings(1)
        })
        .expect("threads");
    let layout = sampling(&scene, 4.0);
    let grid = Arc::new(made(&sampled, &layout));
    let mut alike = |sampled: &mut Culler, camera: &Camera| {
        let (a, b) = (sampled.cull(camera), nearest.cull(camera));
        assert_eq!((a.visible, &a.occluders), (b.visible, &b.occluders));
        a.occluders
    };
    let inside = looking(grid.layout().viewpoint(30) + DVec3::splat(0.7), DVec3::Z);
    let without = alike(&mut sampled, &inside);
    sampled
        .set_visibility_grid(grid.clone())
        .expect("its scene");
    let found = sampled.cull(&inside);
    let near = grid.viewpoint_near(inside.eye());
    assert_eq!(near, Some(30));
    let named: BTreeSet<ClusterId> = grid.seen_from(30).iter().map(|seen| seen.id).collect();
    let drawn: Vec<ClusterId> = found.occluders.iter().map(|drawn| drawn.id).collect();
    assert!(!drawn.is_empty() && drawn.iter().all(|id| named.contains(id)));
    assert_ne!(found.occluders, without);
    let outside = looking(DVec3::new(0.0, 0.0, 60.0), DVec3::NEG_Z);
    assert!(!alike(&mut sampled, &outside).is_empty());
    // Parallel lines begin nowhere.
    let parallel = Projection::Orthographic {
        height: 10.0,
        near: 0.1,
        far: None,
    };
    let eye = inside.eye();
    let parallel = Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, parallel).expect("a camera");
    alike(&mut sampled, &parallel);
}

fn worth(culler: &Culler, seen: &SampledCluster) -> f32 {
    let object = &culler.scene().objects()[seen.id.object as usize];
    let mesh = culler.clusters().occluder(object).expect("an occluder");
    let triangles = mesh.clusters()[seen.id.cluster as usize].triangle_count;
    seen.worth(triangles.into())
}

/// What hides most for its triangles goes first, for as long as it fits.
#[test]
fn a_budget_takes_what_is_worth_most() {
    let scene = rooms(&mut Chance::seeded(96));
    let first = culler(&scene);
    let grid = Arc::new(made(&first, &sampling(&scene, 4.0)));
    let drawn = |most, camera: &Camera| {
        let settings = Settings {
            occluders: Selection::Sampled,
            budget: Budget::Triangles(most),
            ..settings(1)
        };
        let mut culler = first.another(settings).expect("threads");
        culler.set_visibility_grid(grid.clone()).expect("its scene");
        culler.cull(camera)
    };
    let middle = grid
        .layout()
        .viewpoint(grid.layout().viewpoints() as usize / 2);
    let cameras = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z].map(|d| looking(middle, d));
    let viewpoint = grid.viewpoint_near(middle).expect("it sees something");
    let mut left_out_of_all = 0;
    for camera in &cameras {
        let all = drawn(u64::MAX, camera);
        for most in [0, 30, 60, 100] {
            let some = drawn(most, camera);
            assert!(some.statistics.occluder_triangles <= most);
            let is_drawn = |set: &VisibleSet, seen: &SampledCluster| {
                set.occluders.iter().any(|drawn| drawn.id == seen.id)
            };
            let list = grid.seen_from(viewpoint);
            let taken = list.iter().filter(|seen| is_drawn(&some, seen));
            let least = taken
                .map(|s| worth(&first, s))
                .fold(f32::INFINITY, f32::min);
            let left_out = |seen: &&SampledCluster| is_drawn(&all, seen) && !is_drawn(&some, seen);
            for seen in list.iter().filter(left_out) {
                assert!(worth(&first, seen) <= least, "{most}: {seen:?}");
                left_out_of_all += 1;
            }
        }
    }
    assert!(left_out_of_all > 20, "{left_out_of_all}");
}

#[test]
fn lists_are_bounded_and_so_is_memory() {
    let scene = rooms(&mut Chance::seeded(97));
    let culler = culler(&scene);
    let all = made(
        &culler,
        &SamplingSettings {
            most_clusters: usize::MAX,
            ..sampling(&scene, 4.0)
        },
    );
    let viewpoints = all.layout().viewpoints() as usize;
    let longest = (0..viewpoints).map(|v| all.seen_from(v).len()).max();
    assert!(longest > Some(30) && longest <= Some(MOST_CLUSTERS_PER_VIEWPOINT));
    let few = made(
        &culler,
        &SamplingSettings {
            most_clusters: 10,
            ..sampling(&scene, 4.0)
        },
    );
    let worth = |seen: &SampledCluster| worth(&culler, seen);
    for viewpoint in 0..viewpoints {
        let (few, all) = (few.seen_from(viewpoint), all.seen_from(viewpoint));
        assert_eq!(few.len(), all.len().min(10));
        let least = few.iter().map(worth).fold(f32::INFINITY, f32::min);
        let left_out = all.iter().filter(|seen| !few.contains(seen));
        assert!(left_out.map(worth).all(|worth| worth <= least));
    }
    assert!(few.memory_bytes() <= 4 * (viewpoints + 1) + 12 * 10 * viewpoints);
    assert!(few.to_bytes().len() <= few.memory_bytes() + 64);
    let angular = SamplingSettings {
        least_solid_angle: 0.1,
        ..sampling(&scene, 4.0)
    };
    let large = made(&culler, &angular);
    let mut seen = (0..viewpoints).flat_map(|v| large.seen_from(v));
    assert!(large.len() < all.len() && seen.all(|seen| seen.solid_angle >= 0.1));
}

#[test]
fn a_grid_of_another_scene_is_refused() {
    let scene = rooms(&mut Chance::seeded(98));
    let mut culler = culler(&scene);
    let layout = GridLayout {
        first: DVec3::ZERO,
        spacing: 1.0,
        counts: [1; 3],
    };
    let mut gives = |object, cluster| {
        let seen = SampledCluster {
            id: ClusterId { object, cluster },
            solid_angle: 1.0,
        };
        let grid = VisibilityGrid::new(layout, &[vec![seen]]).expect("a grid");
        culler.set_visibility_grid(Arc::new(grid))
    };
    assert_eq!(gives(0, 0), Ok(()));
    for (object, cluster) in [(0, 500), (126, 0), (u32::MAX, u32::MAX), (20, 0)] {
        let unknown = VisibilityGridError::OtherScene(ClusterId { object, cluster });
        assert_eq!(gives(object, cluster), Err(unknown));
    }
    assert!(culler.visibility_grid().is_none());
}

#[test]
fn a_grid_is_made_and_used_on_the_command_line() {
    let folder = cli::Folder::new("sampling").with_scene();
    let (scene, path) = (folder.file("yard.obj"), folder.file("yard.path.json"));
    let (whole, boxed) = (folder.file("yard.antumbra"), folder.file("box.antumbra"));
    let made = cli::succeed(&["prepare", &scene, "--grid-spacing", "1.5", "-o", &whole]);
    assert!(cli::stdout(&made).contains("viewpoints, 1.500 apart"));
    let wanted = ["prepare", &scene, "--visibility-grid", "5"];
    let within = ["--grid-box", "-1,0,5,1,2,9", "-o", &boxed];
    let made = cli::succeed(&[wanted, within].concat());
    assert!(!cli::stdout(&made).contains(" 0 clusters"));
    for archive in [&whole, &boxed] {
        let measure = ["measure", archive, "--path", &path, "--size", "320x192"];
        let report = cli::succeed(&[&measure[..], &["--occluders", "sampled"]].concat());
        assert!(cli::stdout(&report).contains("false culls: 0; wrong pixels: 0"));
    }
    let measure = ["measure", &scene, "--path", &path, "--size", "320x192"];
    let without = cli::succeed(&[&measure[..], &["--occluders", "sampled"]].concat());
    assert!(cli::stderr(&without).contains("--visibility-grid"));
    let refused = cli::antumbra(&["prepare", &scene, "--grid-spacing", "0", "-o", &boxed]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(cli::stderr(&refused).contains("spacing"));
}
