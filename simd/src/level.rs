//! Which instruction set the loops run on.

use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

/// An instruction set that a loop can be asked to run on. Each gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Level {
    /// The plain form that defines every loop.
    Scalar,
    /// x86-64 with SSE4.2, four lanes.
    Sse42,
    /// x86-64 with AVX2, eight lanes.
    Avx2,
    /// x86-64 with AVX-512, sixteen lanes.
    Avx512,
    /// 64-bit Arm.
    Neon,
}

/// The level asked for cannot be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelUnavailable(pub Level);

impl fmt::Display for LevelUnavailable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = Level::available().iter().map(ToString::to_string).collect();
        write!(
            f,
            "the level {} is not available here; available: {}",
            self.0,
            names.join(", ")
        )
    }
}

impl std::error::Error for LevelUnavailable {}

impl Level {
    /// Every level there is a name for.
    pub const ALL: [Level; 5] = [
        Level::Scalar,
        Level::Sse42,
        Level::Avx2,
        Level::Avx512,
        Level::Neon,
    ];

    /// The levels that this build has loops for and this machine can run, the best last.
    pub fn available() -> &'static [Level] {
        static AVAILABLE: LazyLock<Vec<Level>> = LazyLock::new(|| {
            let runs = |&level: &Level| level == Level::Scalar || level.token().is_some();
            Level::ALL.into_iter().filter(runs).collect()
        });
        &AVAILABLE
    }

    /// What vector loops are dispatched by; none for the plain form, and where the machine lacks the instructions.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn token(self) -> Option<fearless_simd::Level> {
        use fearless_simd::Level as Token;
        let best = Token::new();
        match self {
            Level::Sse42 => best.as_sse4_2().map(Token::Sse4_2),
            Level::Avx2 => best.as_avx2().map(Token::Avx2),
            Level::Avx512 => best.as_avx512().map(Token::Avx512),
            Level::Scalar | Level::Neon => None,
        }
    }

    /// What vector loops are dispatched by; none for the plain form, and where the machine lacks the instructions.
    #[cfg(target_arch = "aarch64")]
    pub(crate) fn token(self) -> Option<fearless_simd::Level> {
        (self == Level::Neon).then(fearless_simd::Level::new)
    }

    /// What vector loops are dispatched by: here there are none.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub(crate) fn token(self) -> Option<fearless_simd::Level> {
        None
    }

    /// The fastest level available.
    pub fn best() -> Level {
        *Level::available()
            .last()
            .expect("the scalar level is always there")
    }

    /// The level itself, if it can be had here.
    ///
    /// # Errors
    /// If this build has no loops for it, or the machine lacks the instructions.
    pub fn require(self) -> Result<Level, LevelUnavailable> {
        if Level::available().contains(&self) {
            Ok(self)
        } else {
            Err(LevelUnavailable(self))
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Level::Scalar => "scalar",
            Level::Sse42 => "sse4.2",
            Level::Avx2 => "avx2",
            Level::Avx512 => "avx512",
            Level::Neon => "neon",
        })
    }
}

impl FromStr for Level {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        Level::ALL
            .into_iter()
            .find(|level| level.to_string() == s)
            .ok_or_else(|| format!("no level `{s}`: use scalar, sse4.2, avx2, avx512 or neon"))
    }
}
