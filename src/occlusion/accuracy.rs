//! What may be lost, and the thresholds of the pyramid that follow from it (HOM §5.3).
//!
//! A user says how large a hole between occluders may be ignored: `L` uncovered pixels in any window of a base cell's size. A
//! window meets at most four base cells, so a quarter of `L` may be ignored in each, and all of it may lie in one corner: so
//! no more than that in any coarser cell either. That is the worst case, and it is rare. The distribution factor `D`, from 1 to
//! 4, says how much better it is assumed to be (HOM §5.3.3.1): at level `k ≥ base`, with cells of `mₖ²` pixels,
//!
//! ```text
//!   Hₖ = D^(k − base + 1)·L/4 uncovered pixels are ignored      T_base = 1 − D·L/4m²,  Tₖ₊₁ = 1 − D·(1 − Tₖ)/4
//! ```
//!
//! The two are the same, as `Tₖ = 1 − Hₖ/mₖ²`. Opacities are kept as counts, so it is the counts that are compared: a cell is opaque
//! if no more than `⌊Hₖ⌋` of its pixels are uncovered. (The thesis' example of 3×3 pixels in cells of 8×8 gives 0.86 for level 0. That is
//! `1 − L/m²`; its own formula gives 0.93 with `D = 2`. The formula is followed here.) Only with `D = 1` is the hole's size a
//! promise. What it bounds is a count, not a shape: long slits stay under it. Below four pixels it ignores nothing then.
//!
//! Transparency thresholds (HOM §5.3.1, §5.3.3.2) are the other way round: a cell with little coverage is taken for uncovered, so
//! that what is behind it is visible without a closer look. `Tₜ,ₖ₊₁ = D·Tₜ,ₖ/4`: the covered pixels that are lost grow by `D` from level to
//! level. This loses occlusion and no objects; 0, the default, loses nothing.

use antumbra_simd::TILE_SIZE;

use crate::view::{MapScale, Slack};

/// How much may be lost.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Accuracy {
    /// Nothing that owns a pixel is ever culled.
    #[default]
    Exact,
    /// Small holes between occluders are ignored, and what shows only through them is culled.
    Approximate(Approximation),
}

impl Accuracy {
    /// What may be ignored, if anything may.
    pub fn approximation(&self) -> Option<&Approximation> {
        match self {
            Accuracy::Exact => None,
            Accuracy::Approximate(approximation) => Some(approximation),
        }
    }

    /// Whether nothing is lost: no cell is opaque that is not.
    pub fn is_exact(&self) -> bool {
        let ignores = |approximation: &Approximation| {
            let levels = approximation.base_level..=approximation.coarsest_level.min(16);
            { levels }.any(|level| approximation.ignored(level) > 0.0)
        };
        !self.approximation().is_some_and(ignores)
    }

    /// The map's scale that goes well with it: the picture's own, or where holes are ignored anyway a quarter (HOM §8.2.2).
    pub fn map_scale(&self) -> MapScale {
        match self {
            Accuracy::Exact => MapScale::Full,
            Accuracy::Approximate(_) => MapScale::Quarter,
        }
    }

    /// Sub-pixels of the map by which occluders are pulled in. Where holes are assumed to be distributed favourably, a sample of a
    /// coarse map stands for its block if its middle is covered, as in HOM §8.2.2, and other roundings than ours count for nothing.
    pub(super) fn inset(&self, scale: MapScale, slack: Slack) -> i32 {
        match self.approximation() {
            Some(approximation) if approximation.distribution > 1.0 && !self.is_exact() => 0,
            _ => scale.inset() + slack.inset(scale),
        }
    }
}

/// Which holes are ignored; see the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approximation {
    /// `L`: uncovered pixels of the picture, in any window of a base cell's size.
    pub hole: u32,
    /// The base level: its cells are `8·2^base_level` pixels wide. Of finer cells nothing is ignored.
    pub base_level: u8,
    /// `D`, from 1, where the hole's size is a promise, to 4, where coarse cells have the same threshold as fine ones.
    pub distribution: f64,
    /// The transparency threshold of base cells, from 0 to 1: such a share of their pixels may be covered and lost.
    pub transparency: f64,
    /// The coarsest level whose cells are looked at (HOM §8.2.4 uses five).
    pub coarsest_level: u8,
}

impl Default for Approximation {
    /// 64 pixels in any window of 8×8, distributed as HOM assumes, on five levels, and no occlusion lost. (With all levels castle has
    /// 0.011 % wrong pixels instead of 0.001, for nothing.)
    fn default() -> Approximation {
        Approximation {
            hole: 64,
            base_level: 0,
            distribution: 2.0,
            transparency: 0.0,
            coarsest_level: 4,
        }
    }
}

impl Approximation {
    /// The default for holes of another size.
    pub fn of_hole(hole: u32) -> Approximation {
        Approximation {
            hole,
            ..Approximation::default()
        }
    }

    /// The promise: no more than `hole` uncovered pixels are ignored in any window of 8×8, however they lie.
    pub fn promise(hole: u32) -> Approximation {
        Approximation {
            hole,
            distribution: 1.0,
            ..Approximation::default()
        }
    }

    /// From which opacity on a cell of a level is opaque, from 0 to 1; level 0 has cells of 8×8 pixels.
    pub fn opacity_threshold(&self, level: u8) -> f64 {
        1.0 - self.grown(f64::from(self.hole) / 4.0, level) / pixels_of(level)
    }

    /// Up to how many uncovered pixels a cell of a level is opaque.
    pub(super) fn ignored(&self, level: u8) -> f64 {
        self.grown(f64::from(self.hole) / 4.0, level).floor()
    }

    /// Up to which opacity a cell of a level is transparent.
    pub fn transparency_threshold(&self, level: u8) -> f64 {
        self.lost(level) / pixels_of(level)
    }

    /// Up to how many covered pixels a cell of a level is transparent.
    fn lost(&self, level: u8) -> f64 {
        let of_base = self.transparency.clamp(0.0, 1.0) * pixels_of(self.base_level);
        // The factor that comes with the base level's hole is not in this one.
        self.grown(of_base / self.factor(), level).floor()
    }

    fn factor(&self) -> f64 {
        if self.distribution > 1.0 {
            self.distribution.min(4.0)
        } else {
            1.0
        }
    }

    /// What a count of pixels is worth at a level: `D` times as much from level to level.
    fn grown(&self, count: f64, level: u8) -> f64 {
        if level < self.base_level || level > self.coarsest_level {
            return 0.0;
        }
        let mut grown = count;
        for _ in self.base_level..=level {
            grown *= self.factor();
        }
        grown
    }
}

/// Pixels of a cell.
fn pixels_of(level: u8) -> f64 {
    let edge = f64::from(TILE_SIZE) * f64::from(level).exp2();
    edge * edge
}

/// The thresholds as samples of a map, level by level of its pyramid: level 0 is its tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Thresholds {
    /// Up to how many uncovered samples a cell is opaque.
    ignored: Vec<u32>,
    /// Up to how many covered samples a cell is transparent.
    lost: Vec<u32>,
}

impl Thresholds {
    /// Those of a map with so many levels.
    pub fn new(accuracy: &Accuracy, scale: MapScale, levels: usize) -> Thresholds {
        let none = Thresholds {
            ignored: vec![0; levels],
            lost: vec![0; levels],
        };
        let Some(approximation) = accuracy.approximation() else {
            return none;
        };
        // A coarse map's tile is a cell of a coarser level.
        let first = scale.pixels().trailing_zeros() as usize;
        let samples = |pixels: f64| (pixels / f64::from(scale.pixels() * scale.pixels())) as u32;
        let level = |i: usize| (first + i).min(usize::from(u8::MAX)) as u8;
        Thresholds {
            ignored: (0..levels)
                .map(|i| samples(approximation.ignored(level(i))))
                .collect(),
            lost: (0..levels)
                .map(|i| samples(approximation.lost(level(i))))
                .collect(),
        }
    }

    /// Up to how many uncovered samples a cell of a level is opaque.
    pub fn ignored(&self, level: usize) -> u32 {
        self.ignored.get(level).copied().unwrap_or(0)
    }

    /// Up to how many covered samples a cell of a level is transparent.
    pub fn lost(&self, level: usize) -> u32 {
        self.lost.get(level).copied().unwrap_or(0)
    }

    /// How many uncovered samples a cell of a level may have at the most if it consists of finer cells that are opaque.
    pub fn passed_below(&self, level: usize) -> u64 {
        let of_finer = |finer: usize| u64::from(self.ignored(finer)) << (2 * (level - finer));
        (0..level).map(of_finer).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// HOM §8.4.2: cells of 20×16 pixels, holes of 96, D = 2: 0.85 for the finest level. With cells of 16×16 it is 1 − 2·96/(4·256).
    #[test]
    fn thresholds_follow_the_formulas() {
        let of_amr = Approximation {
            hole: 96,
            base_level: 1,
            ..Approximation::default()
        };
        assert_eq!(of_amr.opacity_threshold(0), 1.0);
        let mut threshold = 1.0 - 2.0 * 96.0 / (4.0 * 256.0);
        for level in 1..5 {
            assert_eq!(of_amr.opacity_threshold(level), threshold);
            threshold = 1.0 - 2.0 * (1.0 - threshold) / 4.0;
        }
        let of_example = Approximation::of_hole(9);
        assert!((of_example.opacity_threshold(0) - 0.93).abs() < 0.001);
        let sparse = Approximation {
            transparency: 0.5,
            ..Approximation::default()
        };
        assert_eq!(
            [0, 1, 2].map(|k| sparse.transparency_threshold(k)),
            [0.5, 0.25, 0.125]
        );
    }

    #[test]
    fn the_promise_is_the_same_at_all_levels() {
        let promise = Approximation::promise(64);
        assert_eq!([0, 1, 4].map(|level| promise.ignored(level)), [16.0; 3]);
        assert_eq!(promise.ignored(promise.coarsest_level + 1), 0.0);
        assert_eq!(Approximation::promise(3).ignored(0), 0.0);
        assert_eq!(Approximation::of_hole(0).ignored(7), 0.0);
    }

    #[test]
    fn a_coarse_map_counts_its_own_samples() {
        let accuracy = Accuracy::Approximate(Approximation::of_hole(64));
        let full = Thresholds::new(&accuracy, MapScale::Full, 5);
        assert_eq!([0, 1, 2].map(|k| full.ignored(k)), [32, 64, 128]);
        let quarter = Thresholds::new(&accuracy, MapScale::Quarter, 3);
        assert_eq!([0, 1, 2].map(|k| quarter.ignored(k)), [8, 16, 32]);
        let exact = Thresholds::new(&Accuracy::Exact, MapScale::Full, 5);
        assert!((0..5).all(|k| exact.ignored(k) == 0 && exact.lost(k) == 0));
    }
}
