//! What a frame costs, on one thread: six real scenes where there are any, and the generated ones.
//!
//! `cargo bench --bench frame` measures the mean frame of a walk on every instruction set of the machine. Real scenes
//! are read from the folder `ANTUMBRA_SCENES`, by default `../shared/scenes`, and left out where there are none. The
//! power plant, 12.2 million triangles, is there with `ANTUMBRA_BENCH_LARGE=1`.

mod common;

use antumbra::cull::Settings;
use antumbra_fixtures::Kind;
use common::{Stage, bench_frames, fast_levels, large_too, quick, settings};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};

/// The real scenes, and every how many frames of their paths.
const REAL: [(&str, usize); 6] = [
    ("castle", 1),
    ("sponza", 1),
    ("clinic", 6),
    ("falcon", 6),
    ("cistern", 6),
    ("delft", 6),
];

fn real(c: &mut Criterion) {
    let mut group = c.benchmark_group("frame");
    for (name, every) in REAL {
        let Some(stage) = Stage::real(name, every) else {
            continue;
        };
        for &level in fast_levels() {
            let settings = Settings {
                level,
                ..settings()
            };
            bench_frames(&mut group, BenchmarkId::new(name, level), settings, || {
                stage.clone()
            });
        }
    }
}

fn generated(c: &mut Criterion) {
    let mut group = c.benchmark_group("frame");
    for kind in Kind::ALL {
        if kind == Kind::PowerPlant && !large_too() {
            eprintln!("skipped: {kind}; ANTUMBRA_BENCH_LARGE=1 measures it too");
            continue;
        }
        for &level in fast_levels() {
            let settings = Settings {
                level,
                ..settings()
            };
            bench_frames(
                &mut group,
                BenchmarkId::new(kind.name(), level),
                settings,
                || Stage::generated(kind, None),
            );
        }
    }
}

criterion_group!(name = benches; config = quick(); targets = real, generated);
criterion_main!(benches);
