//! What time buys: the time of a frame against wrong pixels, and against missed culls.
//!
//! Every setting has its mark. Those of the Pareto front, which no other beats at both, are joined by a line, and named.

use antumbra::measure::{LEAST_HIDDEN, Sweep, SweepPoint};

use super::axis::{Axis, number};
use super::plot::{COLORS, Look, MARKS, Mark, Plot};
use super::{Figure, name_of};
use crate::cli::output::count_of;

/// What time is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// Pixels of the id picture that change.
    WrongPixels,
    /// Hidden objects that are not culled.
    MissedCulls,
}

impl Error {
    fn of(self, point: &SweepPoint) -> f64 {
        match self {
            Error::WrongPixels => point.wrong_pixels_a_frame,
            Error::MissedCulls => 100.0 * point.missed_culls,
        }
    }

    /// Whether a point is drawn.
    fn takes(self, point: &SweepPoint) -> bool {
        match self {
            Error::WrongPixels => !point.series.is_empty(),
            Error::MissedCulls => !point.is_oracle(),
        }
    }

    /// The points that nothing beats.
    pub fn front(self, swept: &Sweep) -> Vec<&SweepPoint> {
        match self {
            Error::WrongPixels => swept.front(|p| p.on_front_of_wrong_pixels),
            Error::MissedCulls => swept.front(|p| p.on_front_of_missed_culls),
        }
    }

    fn axis(self) -> &'static str {
        match self {
            Error::WrongPixels => "wrong pixels a frame, mean (logarithmic, with 0)",
            Error::MissedCulls => "hidden objects not culled, % (logarithmic, with 0)",
        }
    }
}

/// The chart, and what to see in it.
pub fn trade_chart(swept: &Sweep, error: Error) -> Figure {
    let points = || swept.points.iter().filter(|p| error.takes(p));
    let front = error.front(swept);
    let place = |p: &SweepPoint| (p.time_us, error.of(p));
    let errors = Axis::log_with_zero(error.axis(), points().map(|p| error.of(p)));
    let mut plot = Plot::new(
        &format!("Time a frame against {}", error.axis()),
        Axis::log(
            "time a frame, \u{b5}s, mean (logarithmic)",
            points().map(|p| p.time_us),
        ),
        match error {
            Error::WrongPixels => errors,
            Error::MissedCulls => errors.up_to(100.0),
        },
    );
    let faint = Look {
        color: "#777",
        mark: Mark::Faint,
        dashes: "",
        width: 0.0,
    };
    let others: Vec<_> = points()
        .filter(|p| p.series.is_empty())
        .map(place)
        .collect();
    plot.line(&others, faint);
    let joined = Look {
        color: "#000",
        mark: Mark::None,
        dashes: "6 4",
        width: 1.6,
    };
    plot.line(&front.iter().map(|p| place(p)).collect::<Vec<_>>(), joined);
    plot.key(joined, "Pareto front");
    // A line for each depth representation and scale, through its holes.
    let mut variants: Vec<&SweepPoint> = swept.variants().collect();
    variants.sort_by(|a, b| {
        let key = |p: &SweepPoint| (p.depth.clone(), p.map_scale, p.hole);
        key(a).cmp(&key(b))
    });
    let has_depths = variants.iter().any(|p| p.depth != variants[0].depth);
    let lines = variants.chunk_by(|a, b| a.map_scale == b.map_scale && a.depth == b.depth);
    for (number, line) in lines.enumerate() {
        let look = Look {
            color: COLORS[number % COLORS.len()],
            mark: MARKS[number % MARKS.len()],
            dashes: "1 4",
            width: 1.2,
        };
        plot.line(&line.iter().map(|p| place(p)).collect::<Vec<_>>(), look);
        if error == Error::WrongPixels {
            for point in line.iter().filter(|p| p.hole > 0) {
                plot.note_beside(place(point), &point.hole.to_string());
            }
        }
        let scale = match line[0].map_scale {
            1 => "full-size map".to_owned(),
            scale => format!("map at 1/{scale}"),
        };
        let depth = if has_depths {
            format!(", {}", line[0].depth)
        } else {
            String::new()
        };
        plot.key(look, &(scale + &depth));
    }
    let weak = swept.variants().filter(|p| !p.hides_enough).map(place);
    let weak: Vec<_> = weak.collect();
    if error == Error::WrongPixels && !weak.is_empty() {
        let hollow = Look {
            color: "#000",
            mark: Mark::Ring,
            dashes: "",
            width: 0.0,
        };
        plot.line(&weak, hollow);
        plot.key(hollow, "hides too little");
    }
    if !others.is_empty() {
        plot.key(faint, "other selections, budgets");
    }
    plot.gap();
    plot.heading("on the front, quickest first");
    let room = plot.room();
    let shown = if front.len() > room {
        room.saturating_sub(1)
    } else {
        front.len()
    };
    let mut last: Option<((f64, f64), usize)> = None;
    for (i, point) in front.iter().take(shown).enumerate() {
        let letter = letter(i);
        let (x, y) = plot.place(place(point));
        // Letters of points that lie close together go in turns above, to the right and to the left.
        let turn = match last {
            Some(((lx, ly), turn)) if (lx - x).hypot(ly - y) < 34.0 => (turn + 1) % TURNS.len(),
            _ => 0,
        };
        last = Some(((x, y), turn));
        plot.badge(place(point), TURNS[turn], &letter);
        plot.badge_key(&letter, &name_of(point));
    }
    if shown < front.len() {
        plot.heading(&format!("and {} more: see the table", front.len() - shown));
    }
    Figure {
        file: match error {
            Error::WrongPixels => "sweep-wrong-pixels.svg",
            Error::MissedCulls => "sweep-missed-culls.svg",
        },
        title: match error {
            Error::WrongPixels => "Time against wrong pixels",
            Error::MissedCulls => "Time against missed culls",
        },
        caption: caption(swept, error, &front),
        svg: plot.finish(),
    }
}

/// Where letters stand beside their marks.
const TURNS: [(f64, f64); 4] = [(14.0, -17.0), (-16.0, -15.0), (22.0, 4.0), (4.0, -38.0)];

/// The letter of a point of the front.
pub fn letter(number: usize) -> String {
    let letter = char::from(b'a' + (number % 26) as u8);
    letter.to_string().repeat(1 + number / 26)
}

fn caption(swept: &Sweep, error: Error, front: &[&SweepPoint]) -> String {
    let ends = match front {
        [] => String::new(),
        [only] => format!(
            " Here one setting is best at both: {} ({} \u{b5}s).",
            name_of(only),
            number(only.time_us)
        ),
        [quickest, .., best] => format!(
            " It leads here from {} ({} \u{b5}s, {}) to {} ({} \u{b5}s, {}).",
            name_of(quickest),
            number(quickest.time_us),
            amount(error, quickest),
            name_of(best),
            number(best.time_us),
            amount(error, best)
        ),
    };
    let settings = &swept.settings;
    let what = match error {
        Error::WrongPixels => format!(
            "A pixel is wrong if it shows another object than the exact picture does (DYN \u{a7}4.3). The number at a mark is the \
             size of holes that are ignored, in pixels; marks without one are exact and lie on the line of 0, below the break of \
             the axis: no pixel of {} is wrong. \
             All settings here choose occluders by {} with budget {}. Those that hide less than {:.0} % of what the best of them hides are \
             rings, and left out of the front: that little is hidden soon, and without errors.",
            count_of(swept.frames as u64, "frame"),
            settings.occluders,
            settings.budget,
            100.0 * LEAST_HIDDEN
        ),
        Error::MissedCulls => "A cull is missed if an object in the frustum owns no pixel of the exact picture and is drawn all \
             the same: it costs time downstream, and no pixel is wrong. With holes ignored more is culled, some of it wrongly, \
             which this chart does not show."
            .to_owned(),
    };
    format!(
        "Left and down is better. The dashed line is the Pareto front: no other setting here is both as quick and as good as one \
         on it.{ends} {what} Dotted lines join the hole sizes of a map's scale. Points that differ by a few per cent of time may change \
         places from run to run."
    )
}

fn amount(error: Error, point: &SweepPoint) -> String {
    match error {
        Error::WrongPixels => format!("{} wrong pixels a frame", number(error.of(point))),
        Error::MissedCulls => format!("{} % missed", number(error.of(point))),
    }
}
