//! The picture of the survivors is the picture of the scene.

mod oracle;
mod worlds;

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use antumbra::cull::{Culler, Settings, VisibleSet};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::occluders::{Budget, Selection};
use antumbra::prepare::{ClusterId, GridLayout, SampledCluster, VisibilityGrid};
use antumbra::raster::{ObjectAssembler, for_each_sample};
use antumbra::scene::{Alpha, Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, MapScale, PictureSize, Projection};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES, SINGLE_SIDED, Shape};

/// Owner and depth of each pixel: opaque and masked surfaces in the order given, the first keeps the pixel at equal
/// depth. And the translucent objects with a sample before that.
#[derive(Debug, PartialEq)]
struct Picture {
    pixels: Vec<Option<(u32, f32)>>,
    translucent: Vec<u32>,
}

fn picture(scene: &Scene, objects: &[u32], camera: &Camera, size: PictureSize) -> Picture {
    let mut pixels: Vec<Option<(u32, f32)>> = vec![None; size.width() * size.height()];
    let mut assembler = ObjectAssembler::new(*camera, size);
    let mut for_samples = |object: u32, translucent: bool, visit: &mut dyn FnMut(usize, f32)| {
        let placed = &scene.objects()[object as usize];
        assembler.assemble(
            &scene.meshes()[placed.mesh],
            &placed.world_from_local,
            |m| (m.alpha == Alpha::Blend) == translucent,
            |t| {
                for_each_sample(&t.triangle, 0..size.height() as i32, |x, y, depth| {
                    visit(y as usize * size.width() + x as usize, depth);
                });
            },
        );
    };
    for &object in objects {
        for_samples(object, false, &mut |at, depth| {
            if pixels[at].is_none_or(|(_, old)| depth > old) {
                pixels[at] = Some((object, depth));
            }
        });
    }
    let mut translucent = Vec::new();
    for &object in objects {
        let mut before = false;
        for_samples(object, true, &mut |at, depth| {
            before |= pixels[at].is_none_or(|(_, old)| depth > old);
        });
        translucent.extend(before.then_some(object));
    }
    Picture {
        pixels,
        translucent,
    }
}

fn owners(picture: &Picture) -> Vec<u32> {
    let mut owners: Vec<u32> = picture
        .pixels
        .iter()
        .flatten()
        .map(|&(object, _)| object)
        .collect();
    owners.extend(&picture.translucent);
    owners.sort_unstable();
    owners.dedup();
    owners
}

fn all_of(scene: &Scene) -> Vec<u32> {
    (0..scene.objects().len() as u32).collect()
}

fn settings(size: PictureSize) -> Settings {
    Settings {
        threads: 2,
        ..Settings::new(size)
    }
}

/// Objects of all sorts around a place: shared meshes, several surfaces, mirrored and uneven placements, masks and
/// glass, occluders that are none, proxies, and some that are never to be culled.
fn any_scene(chance: &mut Chance, home: DVec3, count: i32) -> Scene {
    let materials = [
        DOUBLE_SIDED,
        DOUBLE_SIDED,
        SINGLE_SIDED,
        Material {
            alpha: Alpha::Mask,
            ..DOUBLE_SIDED
        },
        Material {
            alpha: Alpha::Blend,
            ..DOUBLE_SIDED
        },
        Material {
            alpha: Alpha::Blend,
            ..SINGLE_SIDED
        },
    ];
    let (mut meshes, mut objects): (Vec<Mesh>, Vec<Object>) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let place = home + worlds::direction(chance) * chance.real(0.0, 10.0);
        let radius = if chance.one_in(4) {
            chance.real(3.0, 7.0)
        } else {
            chance.real(0.1, 2.0)
        };
        let mut placed = if !objects.is_empty() && chance.one_in(3) {
            // Another placement of a mesh that stands elsewhere already.
            let other = &objects[chance.whole(0, objects.len() as i32 - 1) as usize];
            let turned = worlds::rotation(chance);
            let shift = worlds::direction(chance) * 4.0;
            let matrix3 = turned * other.world_from_local.matrix3;
            let about = other.world_from_local.translation - home;
            Object {
                world_from_local: DAffine3 {
                    matrix3,
                    translation: home + turned * about + shift,
                },
                occluder_proxy: None,
                ..other.clone()
            }
        } else {
            let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
            let material = materials[chance.whole(0, materials.len() as i32 - 1) as usize];
            let (mut mesh, place) = worlds::placed(chance, kind, material, place, radius);
            if mesh.triangles.len() > 1 && chance.one_in(4) {
                let half = mesh.triangles.len() / 2;
                let other = materials[chance.whole(0, materials.len() as i32 - 1) as usize];
                mesh.surfaces = vec![
                    Surface {
                        triangles: 0..half,
                        material,
                    },
                    Surface {
                        triangles: half..mesh.triangles.len(),
                        material: other,
                    },
                ];
            }
            meshes.push(mesh);
            worlds::object(meshes.len() - 1, place)
        };
        placed.never_cull = chance.one_in(12);
        placed.never_occlude = chance.one_in(8);
        objects.push(placed);
    }
    Scene::new(meshes, objects).unwrap()
}

/// A camera a small step from another, looking somewhere near.
fn stepped(chance: &mut Chance, camera: &Camera) -> Camera {
    let step = worlds::direction(chance) * chance.real(0.0, 0.3);
    let ahead = camera.forward() + worlds::direction(chance) * chance.real(0.0, 0.1);
    let eye = camera.eye() + step;
    Camera::look_at(eye, eye + ahead, camera.up(), *camera.projection()).unwrap()
}

/// A grid around a place whose lists are nonsense: any clusters of the scene, with any solid angles. Some lists are empty, and some
/// eyes are too far from all viewpoints.
fn nonsense_grid(chance: &mut Chance, culler: &Culler, home: DVec3) -> VisibilityGrid {
    let spacing = chance.real(2.0, 12.0);
    let layout = GridLayout {
        first: home - DVec3::splat(spacing),
        spacing,
        counts: [3; 3],
    };
    let scene = culler.scene();
    let clusters = (0..).zip(scene.objects()).flat_map(|(number, object)| {
        let mesh = culler.clusters().occluder(object);
        let count = mesh.map_or(0, |mesh| mesh.clusters().len() as u32);
        (0..count).map(move |cluster| ClusterId {
            object: number,
            cluster,
        })
    });
    let clusters: Vec<ClusterId> = clusters.collect();
    let lists: Vec<Vec<SampledCluster>> = (0..27)
        .map(|_| {
            let one_in = [1, 2, 6, 1_000_000][chance.whole(0, 3) as usize];
            let ids = clusters.iter().filter(|_| chance.one_in(one_in)).copied();
            let ids: Vec<ClusterId> = ids.collect();
            let sampled = ids.into_iter().map(|id| SampledCluster {
                id,
                solid_angle: chance.real(0.0, 12.0) as f32,
            });
            sampled.collect()
        })
        .collect();
    VisibilityGrid::new(layout, &lists).unwrap()
}

/// What holds of any frame.
fn check(culler: &Culler, camera: &Camera, found: &VisibleSet, what: &str) {
    let (scene, settings) = (culler.scene(), culler.settings());
    let in_frustum = culler.in_frustum(camera);
    let size = settings.size;
    let truth = picture(scene, &all_of(scene), camera, size);
    let survivors = picture(scene, &found.visible, camera, size);
    let lost: Vec<u32> = owners(&truth)
        .into_iter()
        .filter(|o| !found.visible.contains(o))
        .collect();
    assert!(lost.is_empty(), "{what}: lost {lost:?}");
    assert!(survivors == truth, "{what}: the pictures differ");
    assert!(
        found.visible.is_sorted() && in_frustum.is_sorted(),
        "{what}"
    );
    assert!(
        found.visible.iter().all(|o| in_frustum.contains(o)),
        "{what}"
    );
    for &object in &in_frustum {
        let kept = found.visible.contains(&object);
        assert!(
            kept || !scene.objects()[object as usize].never_cull,
            "{what}: {object} is never to be culled"
        );
    }
    let statistics = &found.statistics;
    assert_eq!(statistics.objects_visible, found.visible.len() as u64);
    let triangles = found
        .occluders
        .iter()
        .map(|drawn| u64::from(drawn.triangles));
    let triangles: u64 = triangles.sum();
    assert_eq!(statistics.occluder_triangles, triangles, "{what}");
    if let Budget::Triangles(most) = settings.budget {
        assert!(statistics.occluder_triangles <= most, "{what}");
    }
    let ids = found.occluders.iter().map(|drawn| drawn.id);
    let different: HashSet<_> = ids.collect();
    assert_eq!(
        different.len(),
        found.occluders.len(),
        "{what}: drawn twice"
    );
}

#[test]
fn never_culls_what_owns_a_pixel() {
    let mut chance = Chance::seeded(81);
    let (mut culled, mut kept) = (0, 0);
    for round in 0..150 {
        let size =
            PictureSize::new(chance.whole(1, 140) as u32, chance.whole(1, 100) as u32).unwrap();
        let home = worlds::home(&mut chance);
        let count = chance.whole(1, 90);
        let scene = Arc::new(any_scene(&mut chance, home, count));
        let budget = match round % 4 {
            0 => Budget::Triangles(chance.whole(0, 300) as u64),
            1 => Budget::All,
            _ => Budget::Auto,
        };
        // Half of them by contribution.
        let occluders = match round % 16 {
            of_papers @ 0..8 => Selection::ALL[of_papers],
            _ => Selection::Contribution,
        };
        let settings = Settings {
            occluders,
            budget,
            map_scale: MapScale::ALL[round / 2 % 3],
            ..settings(size)
        };
        let mut culler = Culler::new(scene.clone(), settings).unwrap();
        if occluders == Selection::Sampled || round % 3 == 0 {
            let grid = nonsense_grid(&mut chance, &culler, home);
            culler.set_visibility_grid(Arc::new(grid)).unwrap();
        }
        let mut camera = worlds::camera(&mut chance, home, 12.0);
        for view in 0..12 {
            // Now and then somewhere else, and from there small steps, of which frames remember something.
            if view % 3 == 0 {
                let distance = [0.5, 12.0, 14.0, 40.0][view / 3];
                camera = worlds::camera(&mut chance, home, distance);
                if round % 2 == 0 {
                    culler.forget();
                }
            } else {
                camera = stepped(&mut chance, &camera);
            }
            let found = culler.cull(&camera);
            check(
                &culler,
                &camera,
                &found,
                &format!("round {round}, view {view}"),
            );
            culled += culler.in_frustum(&camera).len() - found.visible.len();
            kept += found.visible.len();
        }
    }
    assert!(
        culled > 3_000 && kept > 3_000,
        "{culled} culled, {kept} kept"
    );
}

/// However soon the time is over, what is drawn by then hides what it hides and nothing else; and with time enough, nothing differs
/// from the budget that chooses itself.
#[test]
fn a_budget_of_time_loses_culling_and_nothing_else() {
    let mut chance = Chance::seeded(83);
    let size = PictureSize::new(120, 90).unwrap();
    let (mut drawn, mut with_time_enough) = (Vec::new(), 0);
    for (us, occluders) in [
        (0, Selection::Nearest),
        (0, Selection::Contribution),
        (5, Selection::Contribution),
        (20, Selection::Contribution),
        (50, Selection::SolidAngle),
        (50, Selection::Contribution),
        (60_000_000, Selection::Contribution),
        (60_000_000, Selection::Nearest),
    ] {
        let scene = Arc::new(any_scene(&mut chance, DVec3::ZERO, 80));
        let of = |budget| {
            let settings = Settings {
                occluders,
                budget,
                ..settings(size)
            };
            Culler::new(scene.clone(), settings).unwrap()
        };
        let mut timed = of(Budget::Time(Duration::from_micros(us)));
        let mut chosen = of(Budget::Auto);
        let mut camera = worlds::camera(&mut chance, DVec3::ZERO, 12.0);
        let mut clusters = 0;
        for view in 0..8 {
            let found = timed.cull(&camera);
            check(
                &timed,
                &camera,
                &found,
                &format!("{us} us, {occluders}, view {view}"),
            );
            clusters += found.occluders.len();
            let without = chosen.cull(&camera);
            if us > 1_000_000 {
                assert_eq!(found.visible, without.visible);
                assert_eq!(found.occluders, without.occluders);
                with_time_enough += found.occluders.len();
            }
            camera = stepped(&mut chance, &camera);
        }
        drawn.push(clusters);
    }
    assert_eq!(drawn[..2], [0, 0], "there was no time");
    assert!(with_time_enough > 100, "{with_time_enough}");
}

/// What a pass is missing for is kept, and never anything lost.
#[test]
fn fewer_passes_lose_culling_and_nothing_else() {
    let size = PictureSize::new(120, 90).unwrap();
    let kept = [1, 2, 3, u32::MAX].map(|most_passes| {
        let mut chance = Chance::seeded(84);
        let (mut kept, mut passes) = (0, 0);
        for _ in 0..12 {
            let scene = Arc::new(any_scene(&mut chance, DVec3::ZERO, 80));
            let settings = Settings {
                most_passes,
                ..settings(size)
            };
            let mut culler = Culler::new(scene.clone(), settings).unwrap();
            let mut camera = worlds::camera(&mut chance, DVec3::ZERO, 12.0);
            for view in 0..8 {
                let found = culler.cull(&camera);
                let what = format!("{most_passes} passes, view {view}");
                check(&culler, &camera, &found, &what);
                assert!(found.statistics.passes < u64::from(most_passes));
                kept += found.visible.len();
                passes += found.statistics.passes;
                camera = stepped(&mut chance, &camera);
            }
        }
        assert_eq!(passes == 0, most_passes == 1);
        kept
    });
    // One pass keeps a tenth more than as many as pay; two are nearly as good here, since they ask all once more in the end.
    assert!(kept[0] * 10 > kept[3] * 11, "{kept:?}");
    assert!(kept[1] * 10 < kept[0] * 9, "{kept:?}");
}

/// A wall before a crowd: inner nodes are hidden with all that is below them, but for what is never to be culled.
#[test]
fn a_hidden_node_ends_its_subtree_and_spares_what_is_never_culled() {
    let mut chance = Chance::seeded(82);
    let size = PictureSize::new(120, 90).unwrap();
    let (points, triangles) = worlds::shape(&mut chance, Shape::Cube);
    let positions = points
        .iter()
        .map(|p| p.to_array().map(|v| v as f32))
        .collect();
    let cube = worlds::mesh(positions, triangles, SINGLE_SIDED);
    let at = |place: DVec3, scale: DVec3| {
        DAffine3::from_scale_rotation_translation(scale, Default::default(), place)
    };
    let wall = worlds::object(
        0,
        at(DVec3::new(0.0, 0.0, -5.0), DVec3::new(40.0, 40.0, 0.1)),
    );
    let mut objects = vec![wall];
    for i in 0..2_000 {
        let place = DVec3::new(
            chance.real(-9.0, 9.0),
            chance.real(-9.0, 9.0),
            chance.real(-40.0, -12.0),
        );
        let mut object = worlds::object(0, at(place, DVec3::splat(0.1)));
        object.never_cull = i % 100 == 7;
        objects.push(object);
    }
    let scene = Arc::new(Scene::new(vec![cube], objects).unwrap());
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.1,
        far: None,
    };
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).unwrap();
    let mut culler = Culler::new(scene.clone(), settings(size)).unwrap();
    let found = culler.cull(&camera);
    check(&culler, &camera, &found, "the crowd");
    let spared = culler
        .in_frustum(&camera)
        .iter()
        .filter(|&&o| scene.objects()[o as usize].never_cull)
        .count();
    assert!(spared > 5);
    assert_eq!(found.visible.len(), 1 + spared);
    assert!(found.statistics.nodes_hidden > 0);
    assert!(
        found.statistics.objects_tested < 500,
        "{:?}",
        found.statistics
    );
    assert!(found.occluders.len() < 100);
}

fn sequence(scene: &Arc<Scene>, cameras: &[Camera], settings: Settings) -> Vec<(VisibleSet, u64)> {
    let mut culler = Culler::new(scene.clone(), settings).unwrap();
    cameras
        .iter()
        .map(|camera| {
            let mut found = culler.cull(camera);
            found.times = Default::default();
            (found, culler.buffer().unwrap().tiles().hash())
        })
        .collect()
}

#[test]
fn same_bits_for_any_thread_count() {
    let mut chance = Chance::seeded(83);
    for _ in 0..6 {
        let home = worlds::home(&mut chance);
        let scene = Arc::new(any_scene(&mut chance, home, 400));
        let size = PictureSize::new(230, 170).unwrap();
        let cameras: Vec<Camera> = (0..4)
            .map(|_| worlds::camera(&mut chance, home, 12.0))
            .collect();
        for budget in [Budget::All, Budget::Auto, Budget::Triangles(700)] {
            let with = |threads| {
                sequence(
                    &scene,
                    &cameras,
                    Settings {
                        threads,
                        budget,
                        ..Settings::new(size)
                    },
                )
            };
            let alone = format!("{:?}", with(1));
            for threads in [2, 5, 3] {
                assert_eq!(format!("{:?}", with(threads)), alone, "{threads} threads");
            }
        }
    }
}

/// In order, a frame is judged by itself: what was drawn before it leaves no trace.
#[test]
fn a_frame_does_not_depend_on_those_before_it() {
    let mut chance = Chance::seeded(84);
    let home = worlds::home(&mut chance);
    let scene = Arc::new(any_scene(&mut chance, home, 150));
    let size = PictureSize::new(97, 61).unwrap();
    let cameras: Vec<Camera> = (0..12)
        .map(|_| worlds::camera(&mut chance, home, 12.0))
        .collect();
    let settings = Settings {
        occluders: Selection::Nearest,
        ..settings(size)
    };
    let in_a_row = sequence(&scene, &cameras, settings);
    for (camera, expected) in cameras.iter().zip(in_a_row) {
        let alone = sequence(&scene, &[*camera], settings).remove(0);
        assert_eq!(format!("{alone:?}"), format!("{expected:?}"));
    }
}

/// A closed, convex object and a proxy well inside it. Both the object's own far side and things inside it are seen
/// when the eye is inside, or the near plane cuts the object open; the proxy must not hide them.
#[test]
fn a_proxy_inside_its_object_hides_nothing_that_owns_a_pixel() {
    let mut chance = Chance::seeded(85);
    let size = PictureSize::new(70, 50).unwrap();
    let mut used = 0;
    for round in 0..400 {
        let home = worlds::home(&mut chance);
        let (mut meshes, mut objects) = (Vec::new(), Vec::new());
        for _ in 0..30 {
            let kind = if chance.one_in(2) {
                Shape::Cube
            } else {
                Shape::Ball(2)
            };
            let material = if chance.one_in(2) {
                SINGLE_SIDED
            } else {
                DOUBLE_SIDED
            };
            let place = home + worlds::direction(&mut chance) * chance.real(0.0, 8.0);
            let radius = chance.real(0.3, 4.0);
            let (points, triangles) = worlds::shape(&mut chance, kind);
            let positions = points
                .iter()
                .map(|p| p.to_array().map(|v| v as f32))
                .collect();
            meshes.push(worlds::mesh(positions, triangles, material));
            let matrix3 = worlds::rotation(&mut chance) * radius;
            let mut object = worlds::object(
                meshes.len() - 1,
                DAffine3 {
                    matrix3,
                    translation: place,
                },
            );
            let (points, triangles) = worlds::shape(&mut chance, Shape::Cube);
            let inside = if kind == Shape::Cube { 0.8 } else { 0.4 };
            let positions = points
                .iter()
                .map(|p| (*p * inside).to_array().map(|v| v as f32))
                .collect();
            meshes.push(worlds::mesh(positions, triangles, SINGLE_SIDED));
            object.occluder_proxy = Some(meshes.len() - 1);
            objects.push(object);
        }
        let scene = Arc::new(Scene::new(meshes, objects).unwrap());
        let mut culler = Culler::new(scene.clone(), settings(size)).unwrap();
        let camera = worlds::camera(&mut chance, home, [1.0, 4.0, 12.0][round % 3]);
        let found = culler.cull(&camera);
        check(&culler, &camera, &found, &format!("round {round}"));
        used += found.occluders.len();
    }
    assert!(used > 2_000, "{used} proxies drawn");
}
