//! The lesser and the greater of two numbers, the first where they compare as equal: of zeros with different signs, and of
//! NaN, the instructions that machines have for this make different choices.

use fearless_simd::Simd;
use fearless_simd::prelude::*;

#[inline(always)]
pub(crate) fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

#[inline(always)]
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// [`lesser`], lane by lane.
#[inline(always)]
pub(crate) fn least<S: Simd>(a: S::f64s, b: S::f64s) -> S::f64s {
    b.simd_lt(a).select(b, a)
}

/// [`greater`], lane by lane.
#[inline(always)]
pub(crate) fn largest<S: Simd>(a: S::f64s, b: S::f64s) -> S::f64s {
    b.simd_gt(a).select(b, a)
}
