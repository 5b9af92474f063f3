//! The oracle counts the pixels of the exact picture, and what stands behind its clusters is asked like everything else.

mod oracle;
mod worlds;

use std::collections::BTreeMap;
use std::sync::Arc;

use antumbra::cull::{Culler, Settings, VisibleSet};
use antumbra::final_pass::draw_objects;
use antumbra::glam::{DAffine3, DVec3};
use antumbra::measure::{Oracle, Owner, Reference, within};
use antumbra::occluders::Budget;
use antumbra::prepare::ClusterId;
use antumbra::scene::{Alpha, Material, Object, Scene};
use antumbra::view::{Camera, PictureSize, Projection};
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES, SINGLE_SIDED, Shape};

fn size() -> PictureSize {
    PictureSize::new(160, 100).expect("a size")
}

fn culler(scene: &Arc<Scene>) -> Culler {
    let settings = Settings {
        threads: 1,
        ..Settings::new(size())
    };
    Culler::new(scene.clone(), settings).expect("threads")
}

/// How many pixels of the id picture each object owns.
fn pixels_of_objects(scene: &Scene, camera: &Camera) -> BTreeMap<u32, u32> {
    let all: Vec<u32> = (0..scene.objects().len() as u32).collect();
    let mut pixels = vec![(f32::NEG_INFINITY, None); size().width() * size().height()];
    draw_objects(
        scene,
        camera,
        size(),
        &all,
        |material| material.alpha != Alpha::Blend,
        &mut pixels,
        |pixel, fragment| {
            if fragment.depth > pixel.0 {
                *pixel = (fragment.depth, Some(fragment.object));
            }
        },
    );
    let mut counts = BTreeMap::new();
    for object in pixels.iter().filter_map(|(_, object)| *object) {
        *counts.entry(object).or_insert(0) += 1;
    }
    counts
}

/// Shapes of one material each around a place; translucent and masked ones among them.
fn any_scene(chance: &mut Chance, home: DVec3) -> Scene {
    let alpha = |alpha| Material {
        alpha,
        ..DOUBLE_SIDED
    };
    let materials = [
        DOUBLE_SIDED,
        SINGLE_SIDED,
        alpha(Alpha::Mask),
        alpha(Alpha::Blend),
    ];
    let (mut meshes, mut objects) = (Vec::new(), Vec::new());
    for number in 0..40 {
        let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
        let material = materials[chance.whole(0, materials.len() as i32 - 1) as usize];
        let place = home + worlds::direction(chance) * chance.real(0.0, 10.0);
        let (mesh, at) = worlds::placed(chance, kind, material, place, 2.0);
        meshes.push(mesh);
        objects.push(Object {
            never_occlude: chance.one_in(6),
            ..worlds::object(number, at)
        });
    }
    Scene::new(meshes, objects).expect("a sound scene")
}

/// Each pixel of an object that occludes belongs to one of its clusters, and none of another object to any.
#[test]
fn clusters_share_the_pixels_of_their_objects() {
    let chance = &mut Chance::seeded(31);
    let mut owned = 0;
    for _ in 0..20 {
        let home = worlds::home(chance);
        let scene = Arc::new(any_scene(chance, home));
        let culler = culler(&scene);
        let oracle = Oracle::new(&scene, culler.clusters());
        let camera = worlds::camera(chance, home, 15.0);
        let owners = oracle.owners(&camera, size());
        let mut of_clusters = BTreeMap::new();
        for owner in &owners {
            let object = &scene.objects()[owner.id.object as usize];
            let mesh = culler.clusters().occluder(object).expect("an occluder");
            let cluster = &mesh.clusters()[owner.id.cluster as usize];
            assert_eq!(owner.triangles, u32::from(cluster.triangle_count));
            *of_clusters.entry(owner.id.object).or_insert(0) += owner.pixels;
        }
        let mut of_objects = pixels_of_objects(&scene, &camera);
        of_objects.retain(|&object, _| {
            let object = &scene.objects()[object as usize];
            culler.clusters().occluder(object).is_some()
        });
        assert_eq!(of_clusters, of_objects);
        let density = |o: &Owner| f64::from(o.pixels) / f64::from(o.triangles);
        assert!(owners.is_sorted_by(|a, b| density(a) >= density(b)));
        owned += owners.len();
    }
    assert!(owned > 200, "{owned} clusters are too few to say anything");
}

/// What masked surfaces cover belongs to nobody, and what translucent ones cover to what is behind.
#[test]
fn masked_surfaces_own_what_they_cover() {
    let wall = |material| {
        let chance = &mut Chance::seeded(1);
        let (points, triangles) = worlds::shape(chance, Shape::Wall(1));
        let narrow = |p: DVec3| [p.x as f32, p.y as f32, p.z as f32];
        let positions = points.into_iter().map(narrow).collect();
        worlds::mesh(positions, triangles, material)
    };
    let camera = Camera::look_at(
        DVec3::new(0.0, 0.0, 5.0),
        DVec3::ZERO,
        DVec3::Y,
        Projection::Orthographic {
            height: 2.0,
            near: 0.1,
            far: None,
        },
    );
    let camera = camera.expect("a camera");
    // The front wall covers the right half of the picture, and the back wall all of its height.
    let at = |x, z| DAffine3::from_translation(DVec3::new(x, 0.0, z));
    let pixels = |alpha| {
        let front = Material {
            alpha,
            ..DOUBLE_SIDED
        };
        let objects = vec![
            worlds::object(0, at(0.0, 0.0)),
            worlds::object(1, at(1.0, 1.0)),
        ];
        let scene = Scene::new(vec![wall(DOUBLE_SIDED), wall(front)], objects);
        let scene = Arc::new(scene.expect("a sound scene"));
        let owners = Oracle::new(&scene, culler(&scene).clusters()).owners(&camera, size());
        let of = |object| {
            let its = owners.iter().filter(|owner| owner.id.object == object);
            its.map(|owner| owner.pixels).sum::<u32>()
        };
        [of(0), of(1)]
    };
    // 100 × 100 pixels, half of them behind the other wall.
    assert_eq!(pixels(Alpha::Blend), [10_000, 0]);
    assert_eq!(pixels(Alpha::Mask), [5_000, 0]);
    assert_eq!(pixels(Alpha::Opaque), [5_000, 8_000]);
}

/// Only given clusters are drawn, however few, and nothing that owns a pixel is lost.
#[test]
fn what_is_culled_behind_clusters_is_hidden() {
    let chance = &mut Chance::seeded(32);
    let (mut few, mut many) = (0, 0);
    for _ in 0..20 {
        let home = worlds::home(chance);
        let scene = Arc::new(any_scene(chance, home));
        let mut culler = culler(&scene);
        let oracle = Oracle::new(&scene, culler.clusters());
        let camera = worlds::camera(chance, home, 15.0);
        let owners = oracle.owners(&camera, size());
        let reference = Reference::new(&scene, &camera, size());
        let in_frustum = culler.in_frustum(&camera).len();
        let mut culled = |budget| {
            let given = within(budget, &owners);
            let mut found = VisibleSet::default();
            culler.cull_behind(&camera, &given, &mut found);
            for object in reference.visible_objects() {
                assert!(found.visible.contains(&object), "{object} is lost");
            }
            let drawn: Vec<ClusterId> = found.occluders.iter().map(|drawn| drawn.id).collect();
            assert!(drawn.iter().all(|id| given.contains(id)));
            if let Budget::Triangles(most) = budget {
                assert!(found.statistics.occluder_triangles <= most);
            }
            in_frustum - found.visible.len()
        };
        few += culled(Budget::Triangles(0));
        many += culled(Budget::All);
    }
    assert!(many > few, "clusters hide nothing: {few}, {many}");
}

/// The oracle's frames leave no trace in those of a path.
#[test]
fn frames_behind_clusters_are_not_remembered() {
    let chance = &mut Chance::seeded(33);
    let scene = Arc::new(any_scene(chance, DVec3::ZERO));
    let cameras: Vec<Camera> = (0..4)
        .map(|_| worlds::camera(chance, DVec3::ZERO, 15.0))
        .collect();
    let walk = |is_disturbed: bool| {
        let mut culler = culler(&scene);
        let oracle = Oracle::new(&scene, culler.clusters());
        let frames = cameras.iter().map(|camera| {
            if is_disturbed {
                let given = within(Budget::All, &oracle.owners(camera, size()));
                culler.cull_behind(camera, &given, &mut VisibleSet::default());
            }
            let found = culler.cull(camera);
            (found.visible, found.occluders)
        });
        frames.collect::<Vec<_>>()
    };
    assert_eq!(walk(true), walk(false));
}

/// A budget takes them in their order, up to the first that does not fit.
#[test]
fn a_budget_ends_at_the_first_that_does_not_fit() {
    let owner = |object, triangles| Owner {
        id: ClusterId { object, cluster: 0 },
        triangles,
        pixels: 100,
    };
    let owners = [owner(3, 10), owner(1, 20), owner(2, 5)];
    let objects = |budget| {
        let ids = within(budget, &owners).into_iter().map(|id| id.object);
        ids.collect::<Vec<u32>>()
    };
    assert_eq!(objects(Budget::Triangles(29)), [3]);
    assert_eq!(objects(Budget::Triangles(30)), [3, 1]);
    assert_eq!(objects(Budget::All), [3, 1, 2]);
    assert!(objects(Budget::Triangles(9)).is_empty());
}
