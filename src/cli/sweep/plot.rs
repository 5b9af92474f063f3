//! Plots as SVG, made to be read on paper too: black axes with titles and units, thin grids, marks that differ by shape as well as by
//! colour, lines that differ by dashes.
//!
//! Written by hand: the plotting libraries at hand set text as a screen of fixed size needs it, and have no axis that is logarithmic and
//! shows zero.

use std::fmt::Write;

use super::axis::Axis;
use super::page::escaped;

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
/// Okabe and Ito's palette, which differs for every kind of colour vision; its yellow is too light for lines on white and darkened.
pub const COLORS: [&str; 8] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#6e6e6e", "#e69f00", "#94820a",
];

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
        if let Some(share) = y.break_at() {
            // The axis is broken between zero and where the logarithm begins.
            let at = bottom - share * (bottom - ABOVE);
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
            escaped(x.title())
        ));
        let middle = (ABOVE + bottom) / 2.0;
        self.put(format_args!(
            "<text class=\"axis\" transform=\"translate(18 {middle:.1}) rotate(-90)\" text-anchor=\"middle\" \
             font-weight=\"600\">{}</text>",
            escaped(y.title())
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
