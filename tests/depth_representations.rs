//! Whatever is kept of depth, nothing visible is culled: the same claims for every representation.

mod oracle;
mod worlds;

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::cull::{Culler, Settings, VisibleSet};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::measure::{MeasureSettings, Reference, run};
use antumbra::occluders::{Budget, Selection};
use antumbra::occlusion::{Accuracy, Approximation, DepthMap, DepthRepresentation, SampleRect};
use antumbra::prepare::Prepared;
use antumbra::scene::{Alpha, Material, Mesh, Object, Scene};
use antumbra::view::{Camera, CameraPath, MapScale, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES, SINGLE_SIDED, Shape};

const PLANE: usize = 0;
const ESTIMATION: usize = 1;
const NO_BACKGROUND: usize = 2;
const HIERARCHICAL: usize = 3;

/// The pyramid of N-th farthest values.
fn farthest_but(nth: u32) -> DepthRepresentation {
    DepthRepresentation::Hierarchical {
        nth: NonZeroU32::new(nth).expect("not 0"),
    }
}

/// Objects of all sorts around a place: large and small, mirrored and uneven placements, masks and glass, occluders that are
/// none, proxies, and some that are never to be culled.
fn any_scene(chance: &mut Chance, home: DVec3, count: i32) -> Arc<Scene> {
    let with = |alpha| Material {
        alpha,
        ..DOUBLE_SIDED
    };
    let materials = [
        DOUBLE_SIDED,
        DOUBLE_SIDED,
        SINGLE_SIDED,
        with(Alpha::Mask),
        with(Alpha::Blend),
    ];
    let (mut meshes, mut objects): (Vec<Mesh>, Vec<Object>) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let place = home + worlds::direction(chance) * chance.real(0.0, 10.0);
        let radius = if chance.one_in(4) {
            chance.real(3.0, 7.0)
        } else {
            chance.real(0.1, 2.0)
        };
        let mut placed = if chance.one_in(8) {
            // A closed object, and a proxy well inside it.
            let scales = [1.0, 0.8].map(|scale| {
                let (points, triangles) = worlds::shape(chance, Shape::Cube);
                let position = |p: &DVec3| (*p * scale).to_array().map(|v| v as f32);
                let positions = points.iter().map(position).collect();
                worlds::mesh(positions, triangles, SINGLE_SIDED)
            });
            meshes.extend(scales);
            let matrix3 = worlds::rotation(chance) * radius;
            let place = DAffine3 {
                matrix3,
                translation: place,
            };
            Object {
                occluder_proxy: Some(meshes.len() - 1),
                ..worlds::object(meshes.len() - 2, place)
            }
        } else {
            let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
            let material = materials[chance.whole(0, materials.len() as i32 - 1) as usize];
            let (mesh, place) = worlds::placed(chance, kind, material, place, radius);
            meshes.push(mesh);
            worlds::object(meshes.len() - 1, place)
        };
        placed.never_cull = chance.one_in(12);
        placed.never_occlude = chance.one_in(8);
        objects.push(placed);
    }
    Arc::new(Scene::new(meshes, objects).unwrap())
}

fn generated_city() -> (Arc<Scene>, CameraPath) {
    let recipe = Recipe {
        triangles: Some(60_000),
        ..Recipe::new(Kind::City)
    };
    let fixture = generate(&recipe).expect("enough triangles");
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("depth-city.glb");
    let out = std::fs::File::create(&file).expect("the file can be written");
    fixture.write_glb(out).expect("the file can be written");
    let scene = Scene::load(&file).expect("a sound file");
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
    (Arc::new(scene), path)
}

fn cullers(scene: &Arc<Scene>, settings: Settings) -> [Culler; 4] {
    DepthRepresentation::ALL
        .map(|depth| Culler::new(scene.clone(), Settings { depth, ..settings }).expect("threads"))
}

/// What holds of any frame.
fn check(culler: &Culler, camera: &Camera, truth: &Reference, found: &VisibleSet, what: &str) {
    let (scene, settings) = (culler.scene(), culler.settings());
    let is_kept = |object: u32| found.visible.binary_search(&object).is_ok();
    assert!(found.visible.is_sorted(), "{what}");
    let lost: Vec<u32> = truth.visible_objects().filter(|&o| !is_kept(o)).collect();
    assert!(lost.is_empty(), "{what}: lost {lost:?}");
    let wrong = truth.wrong_pixels(scene, camera, &found.visible);
    assert_eq!(wrong, 0, "{what}: the pictures differ");
    let in_frustum = culler.in_frustum(camera);
    for &object in &in_frustum {
        let may_go = !scene.objects()[object as usize].never_cull;
        assert!(
            may_go || is_kept(object),
            "{what}: {object} is never culled"
        );
    }
    assert!(found.visible.iter().all(|o| in_frustum.contains(o)));
    let triangles = found.occluders.iter().map(|o| u64::from(o.triangles));
    assert_eq!(found.statistics.occluder_triangles, triangles.sum::<u64>());
    if let Budget::Triangles(most) = settings.budget {
        assert!(found.statistics.occluder_triangles <= most, "{what}");
    }
}

/// How many of the objects in the frustum are culled.
fn culled(culler: &Culler, camera: &Camera, found: &VisibleSet) -> usize {
    culler.in_frustum(camera).len() - found.visible.len()
}

#[test]
fn never_culls_what_owns_a_pixel() {
    let mut chance = Chance::seeded(181);
    let mut all_culled = [0; 4];
    for round in 0..120 {
        let (width, height) = (chance.whole(1, 140) as u32, chance.whole(1, 100) as u32);
        let size = PictureSize::new(width, height).unwrap();
        let home = worlds::home(&mut chance);
        let count = chance.whole(1, 90);
        let scene = any_scene(&mut chance, home, count);
        let settings = Settings {
            budget: match round % 4 {
                0 => Budget::All,
                1 => Budget::Auto,
                2 => Budget::Triangles(chance.whole(0, 300) as u64),
                _ => Budget::Triangles(chance.whole(0, 40) as u64),
            },
            occluders: Selection::ALL[round % 8],
            threads: 2,
            ..Settings::new(size)
        };
        let mut cullers = cullers(&scene, settings);
        for (view, distance) in [0.5, 3.0, 12.0, 14.0, 40.0].into_iter().enumerate() {
            let camera = worlds::camera(&mut chance, home, distance);
            let truth = Reference::new(&scene, &camera, size);
            for (culler, all_culled) in cullers.iter_mut().zip(&mut all_culled) {
                let found = culler.cull(&camera);
                let depth = culler.settings().depth;
                let what = format!("{depth}, round {round}, view {view}");
                check(culler, &camera, &truth, &found, &what);
                *all_culled += culled(culler, &camera, &found);
            }
        }
    }
    // What covers no sample is culled by all; the finer ones do better.
    assert!(all_culled[PLANE] > 300, "{all_culled:?}");
    assert!(all_culled[HIERARCHICAL] > 1_500, "{all_culled:?}");
    let order = [PLANE, ESTIMATION, HIERARCHICAL, NO_BACKGROUND].map(|i| all_culled[i]);
    assert!(order.is_sorted(), "{order:?}");
}

#[test]
fn never_culls_what_owns_a_pixel_of_a_generated_city() {
    let (scene, path) = generated_city();
    let size = PictureSize::new(320, 200).unwrap();
    for budget in [Budget::All, Budget::Auto, Budget::Triangles(1_000)] {
        let settings = Settings {
            budget,
            threads: 2,
            ..Settings::new(size)
        };
        let mut cullers = cullers(&scene, settings);
        let mut all_culled = [0; 4];
        for camera in path.cameras().iter().step_by(path.cameras().len() / 8) {
            let truth = Reference::new(&scene, camera, size);
            for (culler, all_culled) in cullers.iter_mut().zip(&mut all_culled) {
                let found = culler.cull(camera);
                let what = format!("{}, {budget:?}", culler.settings().depth);
                check(culler, camera, &truth, &found, &what);
                *all_culled += culled(culler, camera, &found);
            }
        }
        let is_limited = matches!(budget, Budget::Triangles(_));
        let hides_much = all_culled[HIERARCHICAL] > 500;
        assert!(hides_much || is_limited, "{budget:?}: {all_culled:?}");
    }
}

fn rect(x: [i32; 2], y: [i32; 2], nearest_depth: f32) -> SampleRect {
    SampleRect {
        x,
        y,
        nearest_depth,
    }
}

/// A rectangle anywhere in a picture, small or large.
fn any_rect(chance: &mut Chance, size: PictureSize) -> SampleRect {
    let mut span = |samples: usize| {
        let most = samples as i32 - 1;
        let first = chance.whole(0, most);
        let side = [1, 4, 20, 400][chance.whole(0, 3) as usize];
        [first, (first + chance.whole(0, side)).min(most)]
    };
    let (x, y) = (span(size.width()), span(size.height()));
    rect(x, y, chance.real(0.0, 1.0) as f32)
}

/// The least depth of the exact picture over the covered samples of a rectangle, if there is one.
fn farthest_truth(culler: &Culler, truth: &Reference, of: &SampleRect) -> Option<f32> {
    let buffer = culler.buffer().unwrap();
    let covered = (of.y[0]..=of.y[1])
        .flat_map(|y| (of.x[0]..=of.x[1]).map(move |x| [x as usize, y as usize]))
        .filter(|&[x, y]| buffer.pixel(x, y).is_some());
    let depths = covered.map(|[x, y]| truth.depths().at(x, y));
    depths.min_by(f32::total_cmp)
}

/// The boundary is nowhere nearer than the nearest surface: what is as far as the exact picture is behind nothing.
#[test]
fn no_representation_is_nearer_than_the_picture() {
    let mut chance = Chance::seeded(182);
    let (mut asked, mut tight, mut samples) = (0, 0, 0);
    for round in 0..40 {
        let size = PictureSize::new(150, 110).unwrap();
        let home = worlds::home(&mut chance);
        let scene = any_scene(&mut chance, home, 60);
        let settings = Settings {
            budget: Budget::All,
            threads: 1,
            ..Settings::new(size)
        };
        let mut cullers = cullers(&scene, settings);
        let distance = [0.5, 6.0, 12.0][round % 3];
        let camera = worlds::camera(&mut chance, home, distance);
        let truth = Reference::new(&scene, &camera, size);
        let rects: Vec<SampleRect> = (0..300).map(|_| any_rect(&mut chance, size)).collect();
        for culler in &mut cullers {
            culler.cull(&camera);
            let depth = culler.depth_map().unwrap_or(&DepthMap::NoBackground);
            let is_hierarchical = matches!(depth, DepthMap::Hierarchical(_));
            let tiles = culler.buffer().unwrap().tiles();
            let every_sample = (0..size.height() as i32)
                .flat_map(|y| (0..size.width() as i32).map(move |x| rect([x, x], [y, y], 0.0)));
            for of in every_sample.chain(rects.iter().copied()) {
                let Some(farthest) = farthest_truth(culler, &truth, &of) else {
                    continue;
                };
                let as_far = rect(of.x, of.y, farthest);
                assert!(
                    !depth.is_behind(tiles, &as_far),
                    "{}, round {round}: {as_far:?}",
                    culler.settings().depth
                );
                asked += 1;
                if is_hierarchical && of.x[0] == of.x[1] && of.y[0] == of.y[1] {
                    let a_little_farther = farthest - farthest.abs() * 1e-5 - 1e-6;
                    let behind = rect(of.x, of.y, a_little_farther);
                    tight += usize::from(depth.is_behind(tiles, &behind));
                    samples += 1;
                }
            }
        }
    }
    assert!(asked > 500_000, "{asked}");
    // Of what is cut out or does not occlude there is a picture, but no depth; of what has a proxy, the proxy's.
    assert!(tight * 2 > samples, "{tight} of {samples}");
}

/// What one keeps of the same surfaces is no nearer than what the next one keeps: the plane than the cells, and these than the
/// samples. A cell of the pyramid may reach beyond a rectangle, so that is said of single samples alone.
#[test]
fn a_finer_representation_hides_no_less() {
    let mut chance = Chance::seeded(183);
    let (mut by_plane, mut by_cells) = (0, 0);
    for round in 0..60 {
        let size = PictureSize::new(170, 90).unwrap();
        let home = worlds::home(&mut chance);
        let scene = any_scene(&mut chance, home, 50);
        let settings = Settings {
            budget: Budget::Triangles(60),
            threads: 1,
            ..Settings::new(size)
        };
        let mut cullers = cullers(&scene, settings);
        let camera = worlds::camera(&mut chance, home, 12.0);
        let found = [PLANE, ESTIMATION, HIERARCHICAL].map(|i| cullers[i].cull(&camera));
        let tiles = cullers[PLANE].buffer().unwrap().tiles();
        for culler in [ESTIMATION, HIERARCHICAL].map(|i| &cullers[i]) {
            assert!(
                culler.buffer().unwrap().tiles() == tiles,
                "the same is drawn"
            );
        }
        let is_kept = |o: &u32| found[0].visible.binary_search(o).is_ok();
        assert!(found[1].visible.iter().all(is_kept), "round {round}");
        let [plane, cells, samples] =
            [PLANE, ESTIMATION, HIERARCHICAL].map(|i| cullers[i].depth_map().unwrap());
        for _ in 0..2_000 {
            let mut of = any_rect(&mut chance, size);
            if chance.one_in(2) {
                of.nearest_depth *= 0.1;
            }
            let is_behind_plane = plane.is_behind(tiles, &of);
            let is_behind_cells = cells.is_behind(tiles, &of);
            assert!(!is_behind_plane || is_behind_cells, "round {round}: {of:?}");
            by_plane += usize::from(is_behind_plane);
            let sample = rect([of.x[0]; 2], [of.y[0]; 2], of.nearest_depth);
            if cells.is_behind(tiles, &sample) {
                by_cells += 1;
                assert!(
                    samples.is_behind(tiles, &sample),
                    "round {round}: {sample:?}"
                );
            }
        }
    }
    assert!(
        by_plane > 1_000 && by_cells > by_plane,
        "{by_plane}, {by_cells}"
    );
}

/// Exact accuracy takes N = 1 whatever is asked for; where nothing may be lost, N = 1 is exact; and a greater N hides no less.
#[test]
fn the_first_farthest_is_exact_and_the_nth_hides_no_less() {
    let mut chance = Chance::seeded(184);
    let (mut kept_exactly, mut kept_by_fifth) = (0, 0);
    for _ in 0..40 {
        let size = PictureSize::new(140, 100).unwrap();
        let home = worlds::home(&mut chance);
        let scene = any_scene(&mut chance, home, 80);
        let camera = worlds::camera(&mut chance, home, 12.0);
        let with = |accuracy, depth| {
            let settings = Settings {
                accuracy,
                depth,
                threads: 1,
                ..Settings::new(size)
            };
            let mut culler = Culler::new(scene.clone(), settings).expect("threads");
            culler.cull(&camera).visible
        };
        let ignores_nothing = Accuracy::Approximate(Approximation::of_hole(0));
        let exact = with(Accuracy::Exact, farthest_but(1));
        assert_eq!(with(Accuracy::Exact, farthest_but(5)), exact);
        assert_eq!(with(ignores_nothing, farthest_but(1)), exact);
        let fifth = with(ignores_nothing, farthest_but(5));
        assert!(fifth.iter().all(|o| exact.contains(o)));
        kept_exactly += exact.len();
        kept_by_fifth += fifth.len();
    }
    assert!(
        kept_by_fifth < kept_exactly,
        "{kept_by_fifth}, {kept_exactly}"
    );
}

#[test]
fn same_bits_for_any_thread_count() {
    let mut chance = Chance::seeded(185);
    for _ in 0..4 {
        let home = worlds::home(&mut chance);
        let scene = any_scene(&mut chance, home, 400);
        let size = PictureSize::new(230, 170).unwrap();
        let cameras: Vec<Camera> = (0..3)
            .map(|_| worlds::camera(&mut chance, home, 12.0))
            .collect();
        for depth in DepthRepresentation::ALL {
            for budget in [Budget::All, Budget::Auto, Budget::Triangles(300)] {
                let with = |threads| {
                    let settings = Settings {
                        depth,
                        threads,
                        budget,
                        ..Settings::new(size)
                    };
                    let mut culler = Culler::new(scene.clone(), settings).expect("threads");
                    let frame = |camera| {
                        let mut found = culler.cull(camera);
                        found.times = Default::default();
                        let hash = culler.buffer().unwrap().tiles().hash();
                        (format!("{found:?} {hash}"), culler.depth_map().cloned())
                    };
                    cameras.iter().map(frame).collect::<Vec<_>>()
                };
                let alone = with(1);
                for threads in [2, 5] {
                    assert!(
                        with(threads) == alone,
                        "{depth}, {budget}, {threads} threads"
                    );
                }
            }
        }
    }
}

/// A frame leaves no trace in the next, nor does one of given clusters.
#[test]
fn a_frame_does_not_depend_on_those_before_it() {
    let mut chance = Chance::seeded(186);
    let scene = any_scene(&mut chance, DVec3::ZERO, 120);
    let size = PictureSize::new(97, 61).unwrap();
    for depth in DepthRepresentation::ALL {
        let settings = Settings {
            depth,
            occluders: Selection::Nearest,
            threads: 1,
            ..Settings::new(size)
        };
        let culler = || Culler::new(scene.clone(), settings).expect("threads");
        let mut in_a_row = culler();
        for view in 0..8 {
            let camera = worlds::camera(&mut chance, DVec3::ZERO, 12.0);
            let found = in_a_row.cull(&camera);
            let mut alone = culler();
            assert_eq!(
                alone.cull(&camera).visible,
                found.visible,
                "{depth}, {view}"
            );
            assert!(alone.depth_map() == in_a_row.depth_map(), "{depth}, {view}");
            let drawn: Vec<_> = found.occluders.iter().map(|drawn| drawn.id).collect();
            let mut again = VisibleSet::default();
            in_a_row.cull_behind(&camera, &drawn, &mut again);
            let truth = Reference::new(&scene, &camera, size);
            check(&in_a_row, &camera, &truth, &again, "given clusters");
        }
    }
}

/// A coarse map's samples stand for blocks of pixels, which none but the default one keeps depths of.
#[test]
fn a_coarse_map_has_the_default_representation() {
    let mut chance = Chance::seeded(187);
    let scene = any_scene(&mut chance, DVec3::ZERO, 80);
    let settings = Settings {
        map_scale: MapScale::Half,
        threads: 1,
        ..Settings::new(PictureSize::new(140, 100).unwrap())
    };
    let camera = worlds::camera(&mut chance, DVec3::ZERO, 12.0);
    let found = cullers(&scene, settings).map(|mut culler| {
        let found = culler.cull(&camera);
        assert!(culler.depth_map().is_none());
        (found.visible, found.occluders)
    });
    assert!(found.iter().all(|other| *other == found[0]));
}

fn scenes() -> PathBuf {
    std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    )
}

/// On real scenes, where there are any.
#[test]
fn never_culls_what_owns_a_pixel_of_real_scenes() {
    for name in ["castle", "sponza", "clinic", "cistern", "delft", "falcon"] {
        let file = scenes().join(format!("{name}.glb"));
        if !file.exists() {
            eprintln!("skipped: there is no {}", file.display());
            continue;
        }
        let path = scenes().join(format!("{name}.path.json"));
        let path = CameraPath::load(&path).expect("a path");
        let prepared = Prepared::new(Arc::new(Scene::load(&file).expect("a scene")));
        for depth in DepthRepresentation::ALL {
            for budget in [Budget::Triangles(1_000), Budget::Auto] {
                let settings = MeasureSettings {
                    cull: Settings {
                        depth,
                        budget,
                        ..Settings::new(PictureSize::new(640, 384).expect("a size"))
                    },
                    cold: true,
                    every: path.cameras().len() / 3,
                    animate: None,
                    simulate_threads: false,
                };
                let totals = run(&prepared, &path, &settings, |_, _| {})
                    .expect("threads")
                    .totals;
                let errors = (totals.false_culls, totals.wrong_pixels);
                assert_eq!(errors, (0, 0), "{name}, {depth}, {budget}");
            }
        }
    }
}
