//! What ARCHITECTURE.md says of memory: bytes a tile, and what a culler keeps beside its scene.

use std::alloc::System;
use std::sync::Arc;

use antumbra::cull::{Culler, Settings, VisibleSet};
use antumbra::glam::{DAffine3, DMat4, DVec3};
use antumbra::occlusion::{Accuracy, Approximation, OcclusionBuffer};
use antumbra::prepare::{Cluster, ClusteredScene};
use antumbra::scene::{Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, PictureSize, Projection};
use antumbra_fixtures::{Kind, Recipe, generate};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// What `make` gives, and the bytes of heap that it holds.
fn held<T>(make: impl FnOnce() -> T) -> (T, f64) {
    let region = Region::new(ALLOCATOR);
    let made = make();
    let change = region.change();
    let bytes = change.bytes_allocated as f64 - change.bytes_deallocated as f64;
    (made, bytes)
}

#[track_caller]
fn assert_at_most(what: &str, bytes: f64, count: usize, most: f64) {
    let each = bytes / count as f64;
    eprintln!("{what}: {each:.1} bytes, {count} of them");
    assert!(each <= most, "{what}: {each:.1} bytes, not {most}");
}

fn size() -> PictureSize {
    PictureSize::new(1280, 768).expect("a size")
}

fn city() -> Scene {
    let fixture = generate(&Recipe::new(Kind::City)).expect("the default city");
    let meshes = fixture.parts.into_iter().map(|part| Mesh {
        name: part.name,
        surfaces: vec![Surface {
            triangles: 0..part.triangles.len(),
            material: Material::default(),
        }],
        positions: part.positions.into(),
        triangles: part.triangles.into(),
    });
    let objects = fixture.nodes.into_iter().map(|node| Object {
        name: node.name,
        mesh: node.part,
        world_from_local: DAffine3::from_mat4(DMat4::from_cols_array(&node.matrix.map(f64::from))),
        never_cull: false,
        never_occlude: false,
        occluder_proxy: None,
    });
    Scene::new(meshes.collect(), objects.collect()).expect("a sound scene")
}

/// From above, so that the whole scene is in the frustum.
fn overview(scene: &Scene) -> Camera {
    let world = scene.bvh().nodes[0].bounds();
    let (middle, reach) = (world.center(), world.size().length());
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.1,
        far: None,
    };
    let eye = middle + DVec3::new(0.0, 2.0 * reach, 1.0);
    Camera::look_at(eye, middle, DVec3::Y, projection).expect("a camera")
}

fn a_tile_takes_33_bytes_and_29_more_where_holes_may_be_ignored() {
    let camera = overview(&city());
    let tiles = size().tiles_across() * size().tiles_down();
    let (mut buffer, bytes) = held(|| OcclusionBuffer::new(size(), camera));
    assert_at_most("tile", bytes, tiles, 33.0);
    let approximate = Accuracy::Approximate(Approximation::default());
    let ((), of_holes) = held(|| buffer.set_accuracy(approximate));
    assert_at_most("tile with holes", of_holes, tiles, 29.5);
}

fn an_occluding_triangle_takes_28_bytes_of_which_20_are_in_use() {
    let scene = city();
    // On this thread, where allocations are counted.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread();
    let _pool = pool.build().expect("no threads needed");
    let (clusters, held) = held(|| ClusteredScene::new(&scene));
    let used = clusters.memory_use();
    assert_at_most("triangle", used.bytes as f64, used.triangles, 20.0);
    // What the vectors have grown to, and of it the clusters' records.
    assert_at_most("triangle, held", held, used.triangles, 28.0);
    let records = used.clusters * size_of::<Cluster>();
    assert_at_most("record", records as f64, used.clusters, 96.0);
}

fn a_culler_keeps_560_bytes_for_an_object_in_the_frustum() {
    let scene = Arc::new(city());
    let (objects, camera) = (scene.objects().len(), overview(&scene));
    let settings = Settings {
        threads: 1,
        ..Settings::new(size())
    };
    let mut culler = Culler::new(scene, settings).expect("threads");
    let mut found = VisibleSet::default();
    let ((), bytes) = held(|| culler.cull_into(&camera, &mut found));
    assert_eq!(culler.in_frustum(&camera).len(), objects);
    let tiles = size().tiles_across() * size().tiles_down();
    assert_at_most("object", bytes - 33.0 * tiles as f64, objects, 560.0);
}

/// One test, since every allocation of the process is counted.
#[test]
fn memory_is_what_the_architecture_says() {
    a_tile_takes_33_bytes_and_29_more_where_holes_may_be_ignored();
    an_occluding_triangle_takes_28_bytes_of_which_20_are_in_use();
    a_culler_keeps_560_bytes_for_an_object_in_the_frustum();
}
