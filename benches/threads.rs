//! How a frame scales with threads: 1, 2, 4 … and as many as the machine runs at once.
//!
//! `cargo bench --bench threads`. The answers are the same for any number (`tests/same_bits.rs`); here is what each
//! costs.

mod common;

use std::thread::available_parallelism;

use antumbra::cull::Settings;
use antumbra_fixtures::Kind;
use common::{Stage, bench_frames, quick, settings};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};

fn threads(c: &mut Criterion) {
    let most = available_parallelism().map_or(1, usize::from);
    let mut counts: Vec<usize> = std::iter::successors(Some(1), |n| Some(2 * n))
        .take_while(|&n| n < most)
        .collect();
    counts.push(most);

    let real = ["castle", "sponza", "clinic"].map(|name| (name, Stage::real(name, 6)));
    let generated = Kind::City;
    let stages = real
        .into_iter()
        .filter_map(|(name, stage)| Some((name, stage?)))
        .chain([(generated.name(), Stage::generated(generated, None))]);
    let mut group = c.benchmark_group("threads");
    for (name, stage) in stages {
        for &threads in &counts {
            let settings = Settings {
                threads,
                ..settings()
            };
            bench_frames(
                &mut group,
                BenchmarkId::new(name, threads),
                settings,
                || stage.clone(),
            );
        }
    }
}

criterion_group!(name = benches; config = quick(); targets = threads);
criterion_main!(benches);
