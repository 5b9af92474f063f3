//! What a frame costs, stage by stage, on the generated city.
//!
//! `cargo bench --bench frame` prints times with their spread; criterion compares with the run before.

use std::hint::black_box;
use std::io::Write;
use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::occlusion::OcclusionMap;
use antumbra::raster::{ObjectAssembler, TileBuffer};
use antumbra::scene::Scene;
use antumbra::view::{Camera, CameraPath, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};
use criterion::{Criterion, criterion_group, criterion_main};

/// A city of the default size and a camera in one of its streets.
fn city() -> (Arc<Scene>, Camera) {
    let fixture = generate(&Recipe::new(Kind::City)).expect("the default city");
    let file = std::env::temp_dir().join(format!("antumbra-bench-{}.glb", std::process::id()));
    let mut glb = Vec::new();
    fixture.write_glb(&mut glb).expect("a Vec takes everything");
    std::fs::File::create(&file)
        .and_then(|mut f| f.write_all(&glb))
        .expect("a file in the temporary folder");
    let scene = Scene::load(&file).expect("a generated scene");
    std::fs::remove_file(&file).expect("the file just written");
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a generated path");
    (Arc::new(scene), path.cameras()[path.cameras().len() / 3])
}

fn frame(c: &mut Criterion) {
    let (scene, camera) = city();
    let size = PictureSize::new(1280, 768).expect("a size");
    let settings = Settings {
        threads: 1,
        ..Settings::new(size)
    };
    let mut culler = Culler::new(scene.clone(), settings).expect("a thread");

    c.bench_function("cull", |b| b.iter(|| black_box(culler.cull(&camera))));

    let in_frustum = culler.cull(&camera).in_frustum;
    let buffer = culler.buffer().expect("a frame was culled");
    c.bench_function(&format!("ask {} boxes", in_frustum.len()), |b| {
        b.iter(|| {
            let hidden = |&&o: &&u32| buffer.test_aabb(&scene.bounds()[o as usize]).is_hidden();
            in_frustum.iter().filter(hidden).count()
        });
    });

    let mut assembler = ObjectAssembler::new(camera, size);
    let mut assemble = || {
        let mut triangles = Vec::new();
        for &object in &in_frustum {
            let placed = &scene.objects()[object as usize];
            let mesh = &scene.meshes()[placed.mesh];
            assembler.assemble(
                mesh,
                &placed.world_from_local,
                |_| true,
                |t| triangles.push(t.triangle),
            );
        }
        triangles
    };
    let triangles = assemble();
    c.bench_function("assemble all in the frustum", |b| b.iter(&mut assemble));

    let mut tiles = TileBuffer::new(size);
    c.bench_function(&format!("fill {} triangles", triangles.len()), |b| {
        b.iter(|| {
            tiles.clear();
            tiles.fill(&triangles);
        });
    });

    let mut map = OcclusionMap::new(&tiles);
    c.bench_function("pyramid", |b| b.iter(|| map.build(&tiles)));
}

criterion_group!(benches, frame);
criterion_main!(benches);
