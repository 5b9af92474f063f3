//! How a frame grows with the scene, on one thread.
//!
//! - `growth/triangles`: a town of 1,024 blocks, each finer and finer.
//! - `growth/teapots`: 1,185 teapots, finer and finer: curved surfaces, seen from within the cloud.
//! - `growth/objects`: a town of ever more blocks of 12 triangles.
//! - `growth/city`: the generated city, which grows in both.
//!
//! `cargo bench --bench growth` goes up to a million triangles and 100,000 objects; ten times as many take minutes to
//! make and are there with `ANTUMBRA_BENCH_LARGE=1`. Each size also says on stderr what a frame finds and draws.

mod common;

use antumbra_fixtures::Kind;
use common::town::town;
use common::{Stage, bench_frames, large_too, quick, settings};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};

/// More triangles than this take long to make.
const MANY_TRIANGLES: u64 = 2_000_000;

/// Likewise objects.
const MANY_OBJECTS: u64 = 200_000;

fn grow(
    c: &mut Criterion,
    what: &str,
    sizes: impl IntoIterator<Item = u64>,
    many: u64,
    stage: impl Fn(u64) -> Stage,
) {
    let mut group = c.benchmark_group("growth");
    for size in sizes {
        if size > many && !large_too() {
            eprintln!("skipped: growth/{what}/{size}; ANTUMBRA_BENCH_LARGE=1 measures it too");
            continue;
        }
        bench_frames(&mut group, BenchmarkId::new(what, size), settings(), || {
            stage(size)
        });
    }
}

fn triangles(c: &mut Criterion) {
    const SIDE: u32 = 32;
    let fineness = |triangles: u64| (triangles / (12 * u64::from(SIDE * SIDE))).isqrt() as u32;
    let sizes = [1, 3, 9, 29].map(|f| u64::from(12 * f * f * SIDE * SIDE));
    grow(c, "triangles", sizes, MANY_TRIANGLES, |triangles| {
        town(SIDE, fineness(triangles), false)
    });
}

fn teapots(c: &mut Criterion) {
    let sizes = [130_000, 1_000_000, 10_000_000];
    grow(c, "teapots", sizes, MANY_TRIANGLES, |triangles| {
        Stage::generated(Kind::Teapots, Some(triangles))
    });
}

fn objects(c: &mut Criterion) {
    let sizes = [32, 100, 316, 1_000].map(|side| side * side);
    grow(c, "objects", sizes, MANY_OBJECTS, |objects| {
        town(objects.isqrt() as u32, 1, true)
    });
}

fn city(c: &mut Criterion) {
    let sizes = [10_000, 100_000, 1_000_000, 10_000_000];
    grow(c, "city", sizes, MANY_TRIANGLES, |triangles| {
        Stage::generated(Kind::City, Some(triangles))
    });
}

criterion_group!(name = benches; config = quick(); targets = triangles, teapots, objects, city);
criterion_main!(benches);
