//! What the stages of a frame cost one by one: all occluders in the frustum drawn, the pyramid, and questions in batches.
//!
//! `cargo bench --bench stages`, on the generated city and, where they are, on the castle and Sponza. A frame of the
//! culler asks before it draws; here everything is drawn, unasked.

mod common;

use std::hint::black_box;

use antumbra::cull::{Culler, Level};
use antumbra::occluders::{distance_keys, object_of, sort_nearest};
use antumbra::occlusion::{Footprint, Occluder, OcclusionBuffer, OcclusionMap};
use antumbra::prepare::ClusteredScene;
use antumbra::raster::{ClusterAssembler, CullMode, Geometry, Positions, TileBuffer};
use antumbra::scene::{Aabb, Scene};
use antumbra::view::Camera;
use antumbra_fixtures::Kind;
use antumbra_simd::spans::SpanBlocks;
use common::clusters::{Canvas, cluster};
use common::{Stage, quick, settings, size};
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

/// A scene seen by the camera of its path that has most in its frustum.
struct View {
    name: &'static str,
    scene: std::sync::Arc<Scene>,
    camera: Camera,
    /// Those of the objects in the frustum that occlude, nearest first.
    occluders: Vec<u32>,
    in_frustum: Vec<u32>,
}

fn views() -> Vec<View> {
    let real = ["castle", "sponza"].map(|name| (name, Stage::real(name, 1)));
    let city = (Kind::City.name(), Some(Stage::generated(Kind::City, None)));
    let stages = real.into_iter().chain([city]);
    stages
        .filter_map(|(name, stage)| {
            let stage = stage?;
            let culler = Culler::new(stage.scene.clone(), settings()).expect("threads");
            let seen = |camera: Camera| (culler.in_frustum(&camera), camera);
            let seen = stage.cameras.into_iter().map(seen);
            let (in_frustum, camera) = seen.max_by_key(|(objects, _)| objects.len())?;
            let clusters = ClusteredScene::new(&stage.scene);
            let objects = stage.scene.objects();
            let mut occluders = in_frustum.clone();
            occluders.retain(|&o| clusters.occluder(&objects[o as usize]).is_some());
            let mut keys = Vec::new();
            distance_keys(&stage.scene, camera.eye(), occluders.into_iter(), &mut keys);
            let count = keys.len();
            sort_nearest(&mut keys, count);
            let occluders: Vec<u32> = keys.into_iter().map(object_of).collect();
            Some(View {
                name,
                scene: stage.scene,
                camera,
                occluders,
                in_frustum,
            })
        })
        .collect()
}

impl View {
    /// The occluders' triangles, as the culler assembles them.
    fn assemble(
        &self,
        clusters: &ClusteredScene,
        nothing: &TileBuffer,
        level: Level,
        blocks: &mut SpanBlocks,
    ) {
        let mut assembler = ClusterAssembler::default();
        blocks.clear();
        for &object in &self.occluders {
            let object = &self.scene.objects()[object as usize];
            let Some(mesh) = clusters.occluder(object) else {
                continue;
            };
            let screen = self
                .camera
                .screen_from_local(size(), &object.world_from_local);
            let single_sided = if object.is_mirrored() {
                CullMode::Front
            } else {
                CullMode::Back
            };
            for (index, of_mesh) in mesh.clusters().iter().enumerate() {
                let cull = if of_mesh.double_sided {
                    CullMode::None
                } else {
                    single_sided
                };
                let geometry = cluster(mesh.geometry(index));
                assembler.assemble(level, geometry, &screen, cull, nothing, blocks);
            }
        }
    }

    /// The occluders' meshes with their indices one by one, as an engine hands them over.
    fn geometry(&self) -> Vec<(Vec<u32>, u32)> {
        let mesh = |&object: &u32| {
            let mesh = self.scene.objects()[object as usize].mesh;
            let triangles = &self.scene.meshes()[mesh].triangles;
            (triangles.iter().flatten().copied().collect(), object)
        };
        self.occluders.iter().map(mesh).collect()
    }

    fn draw(&self, geometry: &[(Vec<u32>, u32)], buffer: &mut OcclusionBuffer) {
        buffer.clear(&self.camera);
        for (indices, object) in geometry {
            let object = &self.scene.objects()[*object as usize];
            let positions = Positions::packed(&self.scene.meshes()[object.mesh].positions);
            buffer.draw(&Occluder {
                geometry: Geometry::new(positions, indices).expect("in range"),
                world_from_local: object.world_from_local,
                cull_mode: CullMode::Back,
            });
        }
    }

    fn boxes(&self) -> impl Iterator<Item = &Aabb> {
        self.in_frustum
            .iter()
            .map(|&object| &self.scene.bounds()[object as usize])
    }
}

fn raster(c: &mut Criterion) {
    for view in views() {
        let name = view.name;
        let level = Level::best();
        let clusters = ClusteredScene::new(&view.scene);
        let nothing = TileBuffer::new(size());
        let mut blocks = SpanBlocks::default();
        view.assemble(&clusters, &nothing, level, &mut blocks);
        let triangles = blocks
            .iter()
            .map(|b| u64::from(b.present.count_ones()))
            .sum();

        let mut group = c.benchmark_group("raster");
        group.throughput(Throughput::Elements(triangles));
        group.bench_function(BenchmarkId::new("clusters assembled", name), |b| {
            let mut blocks = SpanBlocks::default();
            b.iter(|| view.assemble(&clusters, &nothing, level, &mut blocks));
        });
        group.bench_function(BenchmarkId::new("clusters filled", name), |b| {
            let empty = Canvas::new(size());
            let fill = |canvas: &mut Canvas| canvas.fill(level, &blocks);
            b.iter_batched_ref(|| empty.clone(), fill, BatchSize::LargeInput);
        });
        group.bench_function(BenchmarkId::new("meshes drawn", name), |b| {
            let geometry = view.geometry();
            let mut buffer = OcclusionBuffer::new(size(), view.camera);
            b.iter(|| view.draw(&geometry, &mut buffer));
        });
    }
}

fn questions(c: &mut Criterion) {
    for view in views() {
        let name = view.name;
        let mut buffer = OcclusionBuffer::new(size(), view.camera);
        view.draw(&view.geometry(), &mut buffer);
        buffer.finish();
        let footprints = || {
            let mut footprints = Vec::new();
            let level = Level::best();
            buffer
                .screen()
                .footprints_of_aabbs(level, view.boxes(), &mut footprints);
            footprints
        };

        let mut group = c.benchmark_group("questions");
        group.throughput(Throughput::Elements(view.in_frustum.len() as u64));
        group.bench_function(BenchmarkId::new("footprints", name), |b| b.iter(footprints));
        let footprints = footprints();
        let rectangle_hides = |f: &Footprint| buffer.test(*f).is_hidden();
        group.bench_function(BenchmarkId::new("rectangles", name), |b| {
            b.iter(|| footprints.iter().filter(|f| rectangle_hides(f)).count());
        });
        group.bench_function(BenchmarkId::new("boxes", name), |b| {
            b.iter(|| {
                view.boxes()
                    .filter(|b| buffer.test_aabb(b).is_hidden())
                    .count()
            });
        });
        let undecided: Vec<&Aabb> = view
            .boxes()
            .zip(&footprints)
            .filter_map(|(b, f)| (!rectangle_hides(f)).then_some(b))
            .collect();
        group.throughput(Throughput::Elements(undecided.len() as u64));
        group.bench_function(
            BenchmarkId::new("boxes that rectangles do not hide", name),
            |b| {
                b.iter(|| {
                    undecided
                        .iter()
                        .filter(|b| buffer.test_aabb(b).is_hidden())
                        .count()
                });
            },
        );
        group.finish();

        let mut map = OcclusionMap::new(buffer.tiles());
        c.bench_function(&format!("pyramid/{name}"), |b| {
            b.iter(|| map.build(black_box(buffer.tiles())));
        });
    }
}

criterion_group!(name = benches; config = quick(); targets = raster, questions);
criterion_main!(benches);
