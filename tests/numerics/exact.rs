//! Exact arithmetic on what floats are: whole numbers times powers of two. Sums and products of such numbers are such numbers
//! again, without a greatest common divisor ever being looked for, and a fraction is a pair of them.
#![allow(dead_code)] // Each program uses its own share.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

use num_bigint::{BigInt, Sign};

/// `mantissa · 2^exponent`.
#[derive(Clone, Debug)]
pub struct Dyadic {
    mantissa: BigInt,
    exponent: i64,
}

impl Dyadic {
    /// What a finite float stands for.
    pub fn of(value: f64) -> Dyadic {
        assert!(value.is_finite(), "{value}");
        let bits = value.to_bits();
        let (biased, fraction) = ((bits >> 52 & 0x7ff) as i64, bits & ((1 << 52) - 1));
        let (whole, exponent) = if biased == 0 {
            (fraction, -1074)
        } else {
            (fraction | 1 << 52, biased - 1075)
        };
        if whole == 0 {
            return Dyadic::whole(0);
        }
        let zeros = whole.trailing_zeros();
        let mantissa = BigInt::from(whole >> zeros);
        Dyadic {
            mantissa: if value < 0.0 { -mantissa } else { mantissa },
            exponent: exponent + i64::from(zeros),
        }
    }

    pub fn whole(value: i64) -> Dyadic {
        Dyadic {
            mantissa: value.into(),
            exponent: 0,
        }
    }

    /// −1, 0 or 1.
    pub fn sign(&self) -> i32 {
        match self.mantissa.sign() {
            Sign::Minus => -1,
            Sign::NoSign => 0,
            Sign::Plus => 1,
        }
    }

    pub fn abs(&self) -> Dyadic {
        Dyadic {
            mantissa: self.mantissa.magnitude().clone().into(),
            exponent: self.exponent,
        }
    }

    /// This number as a multiple of `2^exponent`, which has to divide it.
    fn in_units_of(&self, exponent: i64) -> BigInt {
        &self.mantissa << (self.exponent - exponent) as u64
    }

    fn aligned(&self, other: &Dyadic) -> (BigInt, BigInt, i64) {
        let exponent = self.exponent.min(other.exponent);
        (
            self.in_units_of(exponent),
            other.in_units_of(exponent),
            exponent,
        )
    }

    /// The largest whole number that is not above this number divided by `by`, which is above 0.
    pub fn floor_of_ratio(&self, by: &Dyadic) -> BigInt {
        let (above, below, _) = self.aligned(by);
        let (quotient, rest) = (&above / &below, &above % &below);
        // Division of these numbers goes towards 0.
        if rest.sign() == Sign::Minus {
            quotient - 1
        } else {
            quotient
        }
    }

    /// Rounded to 64 bits and a power of two.
    fn leading(&self) -> (f64, i64) {
        let bits = self.mantissa.bits() as i64;
        let shift = bits - 64;
        let top = if shift > 0 {
            self.mantissa.magnitude() >> shift as u64
        } else {
            self.mantissa.magnitude() << (-shift) as u64
        };
        let top = u64::try_from(top).expect("64 bits") as f64;
        (f64::from(self.sign()) * top, self.exponent + shift)
    }

    /// This number divided by another, not 0, within 2⁻⁵⁰ of itself; what is too large is infinite.
    pub fn ratio(&self, by: &Dyadic) -> f64 {
        if self.sign() == 0 {
            return 0.0;
        }
        let ((a, up), (b, down)) = (self.leading(), by.leading());
        let mut power = up - down;
        let mut value = a / b;
        while power != 0 && value != 0.0 && value.is_finite() {
            let step = power.clamp(-1000, 1000);
            value *= 2_f64.powi(step as i32);
            power -= step;
        }
        value
    }

    pub fn approximately(&self) -> f64 {
        self.ratio(&Dyadic::whole(1))
    }
}

impl Add for &Dyadic {
    type Output = Dyadic;
    fn add(self, other: &Dyadic) -> Dyadic {
        if self.sign() == 0 {
            return other.clone();
        }
        if other.sign() == 0 {
            return self.clone();
        }
        let (a, b, exponent) = self.aligned(other);
        Dyadic {
            mantissa: a + b,
            exponent,
        }
    }
}

impl Neg for &Dyadic {
    type Output = Dyadic;
    fn neg(self) -> Dyadic {
        Dyadic {
            mantissa: -&self.mantissa,
            exponent: self.exponent,
        }
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;
    fn sub(self, other: &Dyadic) -> Dyadic {
        self + &-other
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;
    fn mul(self, other: &Dyadic) -> Dyadic {
        Dyadic {
            mantissa: &self.mantissa * &other.mantissa,
            exponent: self.exponent + other.exponent,
        }
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Dyadic) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Dyadic) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Dyadic) -> Ordering {
        if self.sign() != other.sign() || self.sign() == 0 {
            return self.sign().cmp(&other.sign());
        }
        let (a, b, _) = self.aligned(other);
        a.cmp(&b)
    }
}

/// One number over another that is above 0.
#[derive(Clone, Debug)]
pub struct Fraction {
    pub above: Dyadic,
    pub below: Dyadic,
}

impl Fraction {
    pub fn of(value: f64) -> Fraction {
        Fraction {
            above: Dyadic::of(value),
            below: Dyadic::whole(1),
        }
    }

    pub fn approximately(&self) -> f64 {
        self.above.ratio(&self.below)
    }

    /// A float less this number, rounded once.
    pub fn taken_from(&self, value: f64) -> f64 {
        (&(&Dyadic::of(value) * &self.below) - &self.above).ratio(&self.below)
    }
}

impl PartialEq for Fraction {
    fn eq(&self, other: &Fraction) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Fraction {}

impl PartialOrd for Fraction {
    fn partial_cmp(&self, other: &Fraction) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Fraction {
    fn cmp(&self, other: &Fraction) -> Ordering {
        (&self.above * &other.below).cmp(&(&other.above * &self.below))
    }
}

/// The distance from an f32 of about this size to the next.
pub fn f32_step(value: f64) -> f64 {
    let magnitude = value.abs().max(f64::from(f32::MIN_POSITIVE));
    let exponent = (magnitude.to_bits() >> 52) as i64 - 1023;
    2_f64.powi((exponent - 23) as i32)
}

/// The same for f64.
pub fn f64_step(value: f64) -> f64 {
    value.abs().max(f64::MIN_POSITIVE).next_up() - value.abs().max(f64::MIN_POSITIVE)
}

#[test]
fn exact_numbers_are_what_floats_say() {
    let numbers = [
        0.0,
        1.0,
        -1.5,
        0.1,
        -1e300,
        5e-324,
        f64::MAX,
        -f64::MIN_POSITIVE,
        3e-310,
    ];
    for a in numbers {
        assert_eq!(Dyadic::of(a).approximately(), a);
        for b in numbers {
            assert_eq!(Dyadic::of(a).cmp(&Dyadic::of(b)), a.total_cmp(&b));
            if b != 0.0 && (a / b).is_normal() {
                let ratio = Dyadic::of(a).ratio(&Dyadic::of(b));
                assert!(
                    (ratio - a / b).abs() <= (a / b).abs() * 1e-15,
                    "{a:e} / {b:e}"
                );
            }
        }
    }
    // Sums that a float cannot hold, and rounding towards minus infinity.
    let sum = &(&Dyadic::of(1e300) + &Dyadic::of(5e-324)) - &Dyadic::of(1e300);
    assert_eq!(sum, Dyadic::of(5e-324));
    let floor = |a: f64, b: f64| Dyadic::of(a).floor_of_ratio(&Dyadic::of(b));
    assert_eq!(floor(-7.0, 2.0), BigInt::from(-4));
    assert_eq!(floor(7.0, 2.0), BigInt::from(3));
    assert_eq!(floor(-8.0, 2.0), BigInt::from(-4));
    let third = Fraction {
        above: Dyadic::whole(1),
        below: Dyadic::whole(3),
    };
    assert!(third.taken_from(1.0 / 3.0).abs() < 2e-17 && third.taken_from(1.0 / 3.0) != 0.0);
}
