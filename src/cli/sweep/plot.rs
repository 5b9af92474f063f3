//! Plots as SVG, made to be read on paper too: black axes with titles and units, thin grids, marks that differ by shape as well as by
//! colour, lines that differ by dashes.
//!
//! Written by hand: the plotting libraries at hand set text as a screen of fixed size needs it, and have no axis that is logarithmic and
//! shows zero.

use std::fmt::Write;

use super::page::escaped;
use crate::cli::output::thousands;

/// What a plot measures across and down, in the units of the SVG: about 1/96 inch on a page.
pub const SIZE: (f64, f64) = (960.0, 500.0);
/// What axes and their numbers take at the left and below.
const LEFT: f64 = 100.0;
const BELOW: f64 = 66.0;
const ABOVE: f64 = 20.0;
/// What the legend takes at the right.
const LEGEND: f64 = 250.0;
/// From one line of the legend to the next.
const LEADING: f64 = 22.0;
/// Where a logarithmic axis that shows zero becomes logarithmic, as a share of its length.
const ZERO_SHARE: f64 = 0.14;

/// Okabe and Ito's palette, which differs for every kind of colour vision; its yellow is too light for lines on white and darkened.
pub const COLORS: [&str; 8] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#6e6e6e", "#e69f00", "#94820a",
];

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
    fn ticks(&self) -> Vec<(f64, String)> {
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

/// A mark at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Disc,
    Square,
    Triangle,
    Diamond,
    Cross,
    Ring,
    /// A small grey ring, for what stands in the background.
    Faint,
    None,
}

/// The marks of things that are told apart.
pub const MARKS: [Mark; 5] = [
    Mark::Disc,
    Mark::Square,
    Mark::Triangle,
    Mark::Diamond,
    Mark::Cross,
];

/// What a line and its marks look like.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// As CSS has it.
    pub color: &'static str,
    /// At each of its points.
    pub mark: Mark,
    /// Lengths of dashes and gaps; empty for a line without gaps.
    pub dashes: &'static str,
    /// 0 for marks alone.
    pub width: f64,
}

/// A plot in the making.
pub struct Plot {
    svg: String,
    x: Axis,
    y: Axis,
    legend: f64,
}

impl Plot {
    /// Axes, grid and titles; `about` is read out in place of the picture.
    pub fn new(about: &str, x: Axis, y: Axis) -> Plot {
        let (width, height) = SIZE;
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
             aria-label=\"{}\" font-family=\"system-ui, Helvetica, Arial, sans-serif\" font-size=\"15\" fill=\"#000\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n",
            escaped(about)
        );
        let mut plot = Plot {
            svg,
            x,
            y,
            legend: ABOVE + 8.0,
        };
        plot.axes();
        plot
    }

    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        self.svg.write_fmt(text).expect("a string takes everything");
        self.svg.push('\n');
    }

    fn right() -> f64 {
        SIZE.0 - LEGEND
    }

    fn bottom() -> f64 {
        SIZE.1 - BELOW
    }

    /// Where a point lies.
    pub fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (
            LEFT + self.x.share(x) * (Self::right() - LEFT),
            Self::bottom() - self.y.share(y) * (Self::bottom() - ABOVE),
        )
    }

    fn axes(&mut self) {
        let (right, bottom) = (Self::right(), Self::bottom());
        let (x, y) = (self.x.clone(), self.y.clone());
        for (value, label) in x.ticks() {
            let at = LEFT + x.share(value) * (right - LEFT);
            self.put(format_args!(
                "<path d=\"M{at:.1} {ABOVE}V{bottom}\" stroke=\"#ddd\"/>\
                 <path d=\"M{at:.1} {bottom}v5\" stroke=\"#000\"/>\
                 <text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
                bottom + 21.0
            ));
        }
        for (value, label) in y.ticks() {
            let at = bottom - y.share(value) * (bottom - ABOVE);
            self.put(format_args!(
                "<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"#ddd\"/>\
                 <path d=\"M{LEFT} {at:.1}h-5\" stroke=\"#000\"/>\
                 <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                LEFT - 9.0,
                at + 5.0
            ));
        }
        self.put(format_args!(
            "<path d=\"M{LEFT} {ABOVE}V{bottom}H{right}\" fill=\"none\" stroke=\"#000\" stroke-width=\"1.5\"/>"
        ));
        if matches!(y.shape, Shape::LogWithZero { .. }) {
            // The axis is broken between zero and where the logarithm begins.
            let at = bottom - ZERO_SHARE / 2.0 * (bottom - ABOVE);
            self.put(format_args!(
                "<path d=\"M{0} {1:.1}h4\" stroke=\"#fff\" stroke-width=\"6\"/>\
                 <path d=\"M{2} {3:.1}l14 -6M{2} {4:.1}l14 -6\" stroke=\"#000\" stroke-width=\"1.2\"/>",
                LEFT - 2.0,
                at,
                LEFT - 7.0,
                at + 6.0,
                at
            ));
        }
        self.put(format_args!(
            "<text class=\"axis\" x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\" font-weight=\"600\">{}</text>",
            (LEFT + right) / 2.0,
            SIZE.1 - 14.0,
            escaped(&x.title)
        ));
        let middle = (ABOVE + bottom) / 2.0;
        self.put(format_args!(
            "<text class=\"axis\" transform=\"translate(18 {middle:.1}) rotate(-90)\" text-anchor=\"middle\" \
             font-weight=\"600\">{}</text>",
            escaped(&y.title)
        ));
    }

    /// A line through points, with a mark at each.
    pub fn line(&mut self, points: &[(f64, f64)], look: Look) {
        let places: Vec<_> = points.iter().map(|p| self.place(*p)).collect();
        self.path(&places, look);
    }

    fn path(&mut self, places: &[(f64, f64)], look: Look) {
        if look.width > 0.0 && places.len() > 1 {
            let mut d = String::new();
            for (i, (x, y)) in places.iter().enumerate() {
                let letter = if i == 0 { 'M' } else { 'L' };
                let _ = write!(d, "{letter}{x:.1} {y:.1}");
            }
            self.put(format_args!(
                "<path d=\"{d}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-dasharray=\"{}\" \
                 stroke-linejoin=\"round\"/>",
                look.color,
                look.width,
                if look.dashes.is_empty() { "none" } else { look.dashes }
            ));
        }
        for place in places {
            self.mark(*place, look.mark, look.color);
        }
    }

    fn mark(&mut self, (x, y): (f64, f64), mark: Mark, color: &str) {
        match mark {
            Mark::Disc => self.put(format_args!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{color}\" stroke=\"#fff\"/>"
            )),
            Mark::Square => self.put(format_args!(
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"9\" height=\"9\" fill=\"{color}\" stroke=\"#fff\"/>",
                x - 4.5,
                y - 4.5
            )),
            Mark::Triangle => self.put(format_args!(
                "<path d=\"M{x:.1} {:.1}l5.8 10h-11.6z\" fill=\"{color}\" stroke=\"#fff\"/>",
                y - 6.2
            )),
            Mark::Diamond => self.put(format_args!(
                "<path d=\"M{x:.1} {:.1}l6 6l-6 6l-6 -6z\" fill=\"{color}\" stroke=\"#fff\"/>",
                y - 6.0
            )),
            Mark::Cross => self.put(format_args!(
                "<path d=\"M{:.1} {:.1}l9 9m0 -9l-9 9\" stroke=\"{color}\" stroke-width=\"2.2\"/>",
                x - 4.5,
                y - 4.5
            )),
            Mark::Ring => self.put(format_args!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\" fill=\"#fff\" stroke=\"{color}\" stroke-width=\"2\"/>"
            )),
            Mark::Faint => self.put(format_args!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"none\" stroke=\"#777\"/>"
            )),
            Mark::None => {}
        }
    }

    /// A short text above a point, or below it.
    pub fn note(&mut self, point: (f64, f64), is_below: bool, text: &str) {
        let (x, y) = self.place(point);
        let y = if is_below { y + 20.0 } else { y - 10.0 };
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\" font-size=\"13\" stroke=\"#fff\" \
             stroke-width=\"3\" paint-order=\"stroke\">{}</text>",
            escaped(text)
        ));
    }

    /// A short text at the right of a point.
    pub fn note_beside(&mut self, point: (f64, f64), text: &str) {
        let (x, y) = self.place(point);
        self.put(format_args!(
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"13\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">{}</text>",
            x + 9.0,
            y + 12.0,
            escaped(text)
        ));
    }

    /// A letter in a circle, off a point in a direction in pixels.
    pub fn badge(&mut self, point: (f64, f64), (dx, dy): (f64, f64), text: &str) {
        let (x, y) = self.place(point);
        let (at_x, at_y) = (x + dx, y + dy);
        self.put(format_args!(
            "<path d=\"M{x:.1} {y:.1}L{at_x:.1} {at_y:.1}\" stroke=\"#000\" stroke-width=\".8\"/>"
        ));
        self.badge_at((at_x, at_y), text);
    }

    fn badge_at(&mut self, (x, y): (f64, f64), text: &str) {
        self.put(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"9\" fill=\"#fff\" stroke=\"#000\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"13\" font-weight=\"600\">{}</text>",
            y + 4.3,
            escaped(text)
        ));
    }

    /// A line of the legend: what something looks like, and what it is.
    pub fn key(&mut self, look: Look, text: &str) {
        let (x, y) = (Self::right() + 18.0, self.legend);
        let ends = [(x, y), (x + 32.0, y)];
        let look_of_line = Look {
            mark: Mark::None,
            ..look
        };
        self.path(&ends, look_of_line);
        self.mark((x + 16.0, y), look.mark, look.color);
        self.legend_text(x + 42.0, text);
    }

    /// A line of the legend: what a letter stands for.
    pub fn badge_key(&mut self, letter: &str, text: &str) {
        let x = Self::right() + 18.0;
        self.badge_at((x + 10.0, self.legend), letter);
        self.legend_text(x + 26.0, text);
    }

    /// A heading in the legend.
    pub fn heading(&mut self, text: &str) {
        let x = Self::right() + 18.0;
        let y = self.legend + 5.0;
        self.put(format_args!(
            "<text x=\"{x}\" y=\"{y:.1}\" font-weight=\"600\" font-size=\"14\">{}</text>",
            escaped(text)
        ));
        self.legend += LEADING;
    }

    fn legend_text(&mut self, x: f64, text: &str) {
        let y = self.legend + 4.5;
        self.put(format_args!(
            "<text x=\"{x}\" y=\"{y:.1}\" font-size=\"14\">{}</text>",
            escaped(text)
        ));
        self.legend += LEADING;
    }

    /// How many more lines the legend has room for.
    pub fn room(&self) -> usize {
        ((SIZE.1 - 8.0 - self.legend) / LEADING).max(0.0) as usize
    }

    /// Space in the legend.
    pub fn gap(&mut self) {
        self.legend += LEADING / 2.0;
    }

    /// The SVG.
    pub fn finish(mut self) -> String {
        self.svg += "</svg>\n";
        self.svg
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
