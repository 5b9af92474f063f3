//! Instruction sets.

use antumbra::cull::Level;

use crate::arguments::chosen;
use crate::status::AntumbraStatus::ANTUMBRA_ERROR_LEVEL;
use crate::status::Error;

/// An instruction set for the hot loops. Each gives the same bits.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraLevel {
    /// The best that the machine has.
    ANTUMBRA_LEVEL_BEST = 0,
    /// None: the plain form that defines every loop.
    ANTUMBRA_LEVEL_SCALAR = 1,
    /// x86-64 with SSE4.2.
    ANTUMBRA_LEVEL_SSE42 = 2,
    /// x86-64 with AVX2.
    ANTUMBRA_LEVEL_AVX2 = 3,
    /// x86-64 with AVX-512.
    ANTUMBRA_LEVEL_AVX512 = 4,
    /// 64-bit Arm.
    ANTUMBRA_LEVEL_NEON = 5,
}

use AntumbraLevel::*;

const LEVELS: [(u32, Option<Level>); 6] = [
    (ANTUMBRA_LEVEL_BEST as u32, None),
    (ANTUMBRA_LEVEL_SCALAR as u32, Some(Level::Scalar)),
    (ANTUMBRA_LEVEL_SSE42 as u32, Some(Level::Sse42)),
    (ANTUMBRA_LEVEL_AVX2 as u32, Some(Level::Avx2)),
    (ANTUMBRA_LEVEL_AVX512 as u32, Some(Level::Avx512)),
    (ANTUMBRA_LEVEL_NEON as u32, Some(Level::Neon)),
];

/// The level of a number.
pub fn level(number: u32) -> Result<Level, Error> {
    let Some(level) = chosen(number, &LEVELS, "the level")? else {
        return Ok(Level::best());
    };
    { level.require() }.map_err(|error| Error::new(ANTUMBRA_ERROR_LEVEL, error))
}

/// The best level of this machine: an AntumbraLevel, never ANTUMBRA_LEVEL_BEST itself.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_best_level() -> u32 {
    let best = Some(Level::best());
    let found = LEVELS.iter().find(|(_, level)| *level == best);
    found.map_or(ANTUMBRA_LEVEL_SCALAR as u32, |(number, _)| *number)
}
