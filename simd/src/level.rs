//! Which instruction set the loops run on.

use std::fmt;
use std::str::FromStr;

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

    /// The levels whose instructions this machine has, whether or not this build has loops for them.
    pub fn of_machine() -> Vec<Level> {
        Level::ALL
            .into_iter()
            .filter(|level| level.is_of_machine())
            .collect()
    }

    #[cfg(target_arch = "x86_64")]
    fn is_of_machine(self) -> bool {
        use std::arch::is_x86_feature_detected as has;
        match self {
            Level::Scalar => true,
            Level::Sse42 => has!("sse4.2"),
            Level::Avx2 => has!("avx2"),
            Level::Avx512 => {
                has!("avx512f") && has!("avx512bw") && has!("avx512vl") && has!("avx512dq")
            }
            Level::Neon => false,
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn is_of_machine(self) -> bool {
        self == Level::Scalar || self == Level::Neon && cfg!(target_arch = "aarch64")
    }

    /// The levels that this build has loops for and this machine can run, the best last.
    pub fn available() -> &'static [Level] {
        &[Level::Scalar]
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
