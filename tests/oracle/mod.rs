//! What is true, found without the code under test: exact integers and plain loops over samples.
#![allow(dead_code, unused_imports)] // Each test file uses its own share.

mod coverage;

use antumbra::raster::for_each_sample;
use antumbra_simd::triangle::{CullMode, Triangle};
use antumbra_simd::vertex::ScreenVertex;
pub use coverage::{Point, covers, inside_outline, side};
use proptest::test_runner::{Config, RngSeed};

/// A vertex at a grid point.
pub fn vertex((x, y): Point, depth: f64) -> ScreenVertex {
    ScreenVertex { x, y, depth }
}

/// How often each pixel of a picture is hit by triangles, all at depth ½, both sides drawn.
pub fn hits(triangles: &[[Point; 3]], width: i32, height: i32) -> Vec<u32> {
    let mut hits = vec![0; (width * height) as usize];
    for corners in triangles {
        let set_up = Triangle::new(corners.map(|p| vertex(p, 0.5)), CullMode::None);
        if let Some(triangle) = set_up.and_then(|t| t.within(width, height)) {
            for_each_sample(&triangle, 0..height, |x, y, _| {
                hits[(y * width + x) as usize] += 1;
            });
        }
    }
    hits
}

/// The same by the oracle.
pub fn true_hits(triangles: &[[Point; 3]], width: i32, height: i32) -> Vec<u32> {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| triangles.iter().filter(|&&t| covers(t, x, y)).count() as u32)
        .collect()
}

/// Property tests draw the same cases on every run, unless `PROPTEST_RNG_SEED` says otherwise.
pub fn cases(cases: u32) -> Config {
    let mut config = Config {
        failure_persistence: None,
        max_shrink_iters: 20_000,
        ..Config::with_cases(cases)
    };
    if config.rng_seed == RngSeed::Random {
        config.rng_seed = RngSeed::Fixed(0x616e_7475_6d62_7261);
    }
    config
}

/// SplitMix64 (Steele, Lea and Flood 2014): enough chance for loops that want no shrinking.
pub struct Chance(pub u64);

impl Chance {
    /// The same on every run, unless `ANTUMBRA_TEST_SEED` is set: each value of it gives other cases.
    pub fn seeded(seed: u64) -> Chance {
        let other = std::env::var("ANTUMBRA_TEST_SEED").ok();
        let other = other.map_or(0, |s| s.parse().expect("ANTUMBRA_TEST_SEED is a number"));
        let mut mixed = Chance(seed);
        if other != 0 {
            mixed.0 = mixed.bits() ^ Chance(other).bits();
        }
        mixed
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// An integer from `low` to `high`, ends included.
    pub fn whole(&mut self, low: i32, high: i32) -> i32 {
        let count = (i64::from(high) - i64::from(low) + 1) as u64;
        (i64::from(low) + (self.bits() % count) as i64) as i32
    }

    /// A number from `low` to `high`.
    pub fn real(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    pub fn one_in(&mut self, n: u64) -> bool {
        self.bits().is_multiple_of(n)
    }
}
