//! The axes of plots: linear, logarithmic, and logarithmic with a place for zero, which an exact setting's errors need.

use crate::cli::output::thousands;

/// Where a logarithmic axis that shows zero becomes logarithmic, as a share of its length.
const ZERO_SHARE: f64 = 0.14;

/// How an axis turns values into places.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Linear,
    Log,
    /// 0, a gap, and a logarithm from `first` on.
    LogWithZero {
        first: f64,
    },
}

/// An axis: a range of values and what they are.
#[derive(Clone, Debug)]
pub struct Axis {
    title: String,
    shape: Shape,
    from: f64,
    to: f64,
    /// Whether powers of two are written along it.
    is_of_twos: bool,
}

impl Axis {
    /// All values and no more, evenly.
    pub fn between(title: &str, from: f64, to: f64) -> Axis {
        let to = if to > from { to } else { from + 1.0 };
        Axis::new(title, Shape::Linear, from, to)
    }

    /// Around all values, which are positive, logarithmically.
    pub fn log(title: &str, values: impl Iterator<Item = f64> + Clone) -> Axis {
        let positive = values.filter(|v| *v > 0.0);
        let least = positive.clone().fold(f64::INFINITY, f64::min);
        let most = positive.fold(0.0, f64::max);
        let (least, most) = if most > 0.0 {
            (least, most)
        } else {
            (1.0, 10.0)
        };
        Axis::new(title, Shape::Log, least / 1.12, most * 1.12)
    }

    /// From 0 to somewhat more than all values, logarithmically but for a gap above 0 where no value lies.
    pub fn log_with_zero(title: &str, values: impl Iterator<Item = f64> + Clone) -> Axis {
        let positive = values.filter(|v| *v > 0.0);
        let least = positive.clone().fold(f64::INFINITY, f64::min);
        let most = positive.fold(0.0, f64::max);
        let (least, most) = if most > 0.0 {
            (least, most)
        } else {
            (1.0, 1.0)
        };
        let mut first = 10f64.powf(least.log10().floor());
        for step in [5.0, 2.0] {
            if first * step <= least {
                first *= step;
                break;
            }
        }
        let to = (most * 1.4).max(first * 10.0);
        Axis::new(title, Shape::LogWithZero { first }, 0.0, to)
    }

    fn new(title: &str, shape: Shape, from: f64, to: f64) -> Axis {
        Axis {
            title: title.to_owned(),
            shape,
            from,
            to,
            is_of_twos: false,
        }
    }

    /// The same axis, but not beyond a value that nothing can exceed.
    pub fn up_to(self, most: f64) -> Axis {
        let least = match self.shape {
            Shape::LogWithZero { first } => first * 1.2,
            Shape::Linear | Shape::Log => self.from,
        };
        Axis {
            to: self.to.min(most).max(least),
            ..self
        }
    }

    /// With powers of two along it.
    pub fn at_powers_of_two(self) -> Axis {
        Axis {
            is_of_twos: true,
            ..self
        }
    }

    /// Where in a gap above zero it is broken, from 0 to 1.
    pub fn break_at(&self) -> Option<f64> {
        matches!(self.shape, Shape::LogWithZero { .. }).then_some(ZERO_SHARE / 2.0)
    }

    /// What it measures, with its unit.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Where a value lies, from 0 to 1.
    pub fn share(&self, value: f64) -> f64 {
        match self.shape {
            Shape::Linear => (value - self.from) / (self.to - self.from),
            Shape::Log => (value / self.from).ln() / (self.to / self.from).ln(),
            Shape::LogWithZero { .. } if value <= 0.0 => 0.0,
            Shape::LogWithZero { first } => {
                let share = (value / first).ln() / (self.to / first).ln();
                ZERO_SHARE + (1.0 - ZERO_SHARE) * share.max(0.0)
            }
        }
    }

    /// The values that are written along it, and how.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let values: Vec<f64> = match self.shape {
            Shape::Linear => {
                let step = round_step((self.to - self.from) / 6.0);
                let first = (self.from / step).ceil() as i64;
                let last = (self.to / step + 1e-9).floor() as i64;
                (first..=last).map(|i| i as f64 * step).collect()
            }
            Shape::Log if self.is_of_twos => {
                let powers = (0..16).map(|power| f64::from(1 << power));
                powers
                    .filter(|v| *v >= self.from && *v <= self.to)
                    .collect()
            }
            Shape::Log => log_ticks(self.from, self.to),
            Shape::LogWithZero { first } => {
                let mut ticks = vec![0.0];
                ticks.extend(log_ticks(first, self.to));
                ticks
            }
        };
        values
            .into_iter()
            .map(|value| (value, number(value)))
            .collect()
    }
}

/// The next of 1, 2, 5, 10, 20 … times a power of ten.
fn round_step(least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    let fitting = steps.into_iter().find(|step| step * decade >= least);
    fitting.unwrap_or(10.0) * decade
}

/// The numbers along a logarithmic axis: the fewer of each decade the more decades there are.
fn log_ticks(from: f64, to: f64) -> Vec<f64> {
    let steps: &[f64] = match to / from {
        ratio if ratio < 12.0 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
        ratio if ratio < 1_000.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let decades = from.log10().floor() as i32..=to.log10().ceil() as i32;
    let all = decades.flat_map(|d| steps.iter().map(move |step| step * 10f64.powi(d)));
    // A factor for what powers of ten round away.
    all.filter(|v| *v >= from * (1.0 - 1e-9) && *v <= to)
        .collect()
}

/// A number for people: thousands apart, small ones with the digits they need.
pub fn number(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if value.abs() >= 100.0 || (value.abs() >= 1.0 && value.fract() == 0.0) {
        thousands(value.round() as u64)
    } else {
        let digits = (2 - value.abs().log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.digits$}");
        match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn zero_has_its_place_on_a_logarithmic_axis() {
        let axis = Axis::log_with_zero("pixels", [0.0, 0.25, 90.0].into_iter());
        assert_eq!(
            labels(&axis),
            ["0", "0.2", "0.5", "1", "2", "5", "10", "20", "50", "100"]
        );
        assert_eq!(axis.share(0.0), 0.0);
        assert!((axis.share(0.2) - ZERO_SHARE).abs() < 1e-9);
        assert!((0.9..1.0).contains(&axis.share(90.0)));
    }

    #[test]
    fn nothing_but_zeros_can_be_drawn() {
        for axis in [
            Axis::log_with_zero("pixels", [0.0, 0.0].into_iter()),
            Axis::between("frames", 0.0, 0.0),
            Axis::log_with_zero("%", [100.0].into_iter()).up_to(100.0),
            Axis::log("us", [0.0].into_iter()),
        ] {
            assert!(axis.share(1.0).is_finite(), "{axis:?}");
            assert!(axis.ticks().len() > 1, "{axis:?}");
        }
    }

    #[test]
    fn numbers_have_the_digits_they_need() {
        let shown = [0.0, 0.002, 0.25, 1.5, 12.34, 400.2, 50_000.0].map(number);
        assert_eq!(
            shown,
            ["0", "0.002", "0.25", "1.5", "12.3", "400", "50,000"]
        );
    }
}
