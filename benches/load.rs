//! From a file to a culler: a scene, which has to be prepared, and the archive of what was.
//!
//! Needs the real scenes, see `common`.

mod common;

use std::path::Path;
use std::sync::Arc;

use antumbra::cull::Culler;
use antumbra::prepare::Prepared;
use antumbra::scene::Scene;
use common::{quick, real_scene, settings};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};

fn load(c: &mut Criterion) {
    let mut group = c.benchmark_group("load");
    // On one thread, as the frames.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = pool.build().expect("threads");
    for name in ["castle", "sponza", "clinic", "falcon"] {
        let Some(file) = real_scene(name) else {
            continue;
        };
        let archive = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.antumbra"));
        let prepared = Prepared::load(&file).expect("a scene");
        prepared.save(&archive).expect("an archive");
        group.bench_function(BenchmarkId::new("scene", name), |b| {
            b.iter(|| {
                let scene = pool.install(|| Scene::load(&file)).expect("a scene");
                Culler::new(Arc::new(scene), settings()).expect("threads")
            });
        });
        group.bench_function(BenchmarkId::new("archive", name), |b| {
            b.iter(|| {
                let prepared = pool.install(|| Prepared::load(&archive));
                let prepared = prepared.expect("an archive");
                Culler::with_prepared(&prepared, settings()).expect("threads")
            });
        });
        let _ = std::fs::remove_file(&archive);
    }
    group.finish();
}

criterion_group! { name = benches; config = quick(); targets = load }
criterion_main!(benches);
