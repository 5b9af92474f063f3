//! The selections: culled against triangles drawn, or against time, a line for each way to choose occluders.

use antumbra::measure::{ORACLE, Sweep, SweepPoint};

use super::Figure;
use super::axis::Axis;
use super::plot::{COLORS, Look, MARKS, Mark, Plot};

/// What culling is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The triangles that are drawn as occluders.
    Triangles,
    /// The time that frames take.
    Time,
}

impl Against {
    fn of(self, point: &SweepPoint) -> f64 {
        match self {
            Against::Triangles => point.occluder_triangles.max(1.0),
            Against::Time => point.time_us.max(0.1),
        }
    }

    fn axis(self) -> &'static str {
        match self {
            Against::Triangles => "triangles drawn as occluders, a frame (logarithmic)",
            Against::Time => "time a frame, \u{b5}s, mean (logarithmic)",
        }
    }
}

const DASHES: [&str; 3] = ["", "8 3", "3 3"];

/// What the line of a name looks like, the `number`th.
fn look_of(name: &str, number: usize) -> Look {
    let look = Look {
        color: COLORS[number % COLORS.len()],
        // One mark fewer than colours, so that together they differ for longer.
        mark: MARKS[number % MARKS.len()],
        dashes: DASHES[number % DASHES.len()],
        width: 1.8,
    };
    match name {
        ORACLE => Look {
            color: "#000",
            mark: Mark::Ring,
            dashes: "2 4",
            ..look
        },
        "contribution" => Look {
            mark: Mark::Disc,
            dashes: "",
            width: 3.2,
            ..look
        },
        _ => look,
    }
}

/// The chart, and what to see in it.
pub fn budget_chart(swept: &Sweep, against: Against) -> Figure {
    let points: Vec<&SweepPoint> = swept.choices().collect();
    let place = |p: &SweepPoint| (against.of(p), 100.0 * p.culled_of_hidden);
    let culled = || points.iter().map(|p| place(p).1);
    let mut plot = Plot::new(
        &format!("Culled of the hidden objects against {}", against.axis()),
        Axis::log(against.axis(), points.iter().map(|p| place(p).0)),
        Axis::between(
            "hidden objects culled, %",
            (culled().fold(100.0, f64::min) - 2.0).max(0.0),
            (culled().fold(0.0, f64::max) + 2.0).min(100.0),
        ),
    );
    let mut auto = None;
    let lines = points.chunk_by(|a, b| a.occluders == b.occluders);
    for (number, points) in lines.enumerate() {
        let name = &points[0].occluders;
        let look = look_of(name, number);
        let (chosen, mut line): (Vec<&SweepPoint>, Vec<&SweepPoint>) =
            points.iter().partition(|p| p.budget == "auto");
        // In the order of what is drawn, whatever that takes.
        line.sort_by(|a, b| a.occluder_triangles.total_cmp(&b.occluder_triangles));
        plot.line(&line.iter().map(|p| place(p)).collect::<Vec<_>>(), look);
        plot.key(look, name);
        auto = chosen.first().map(|p| place(p)).or(auto);
    }
    if let Some(auto) = auto {
        plot.gap();
        plot.badge(auto, (14.0, 18.0), "a");
        plot.line(&[auto], look_of("contribution", 6));
        plot.badge_key("a", "budget that chooses itself");
    }
    let (file, title, what) = match against {
        Against::Triangles => (
            "sweep.svg",
            "Selections: culled for triangles drawn",
            "The farther to the left, the fewer triangles that takes.",
        ),
        Against::Time => (
            "sweep-time.svg",
            "Selections: culled for time",
            "The farther to the left, the less time that takes. The oracle's leaves out finding the clusters.",
        ),
    };
    Figure {
        file,
        title,
        caption: format!(
            "Each line is a way to choose which triangles are drawn as occluders, exactly and on the map of the base settings; its points \
             are budgets. The higher, the more of the hidden objects are culled. {what} <i>oracle</i> is no such way, but what to hold them \
             against: of each frame, the clusters of triangles that own the most pixels of the exact picture for their number."
        ),
        svg: plot.finish(),
    }
}
