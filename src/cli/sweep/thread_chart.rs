//! How frames scale with threads: measured, and predicted for more than there are.

use antumbra::measure::Sweep;

use super::Figure;
use super::axis::{Axis, number};
use super::plot::{COLORS, Look, Mark, Plot};

/// The chart, and what to see in it.
pub fn thread_chart(swept: &Sweep) -> Figure {
    let scaling = &swept.scaling;
    let measured: Vec<(f64, f64)> = scaling
        .measured
        .iter()
        .map(|m| (m.threads as f64, m.speed_up))
        .collect();
    let mut predicted = vec![(1.0, 1.0)];
    predicted.extend(
        scaling
            .predicted
            .iter()
            .map(|p| (p.threads as f64, p.speed_up)),
    );
    let all = || measured.iter().chain(&predicted);
    let most = all().map(|p| p.0).fold(1.0, f64::max);
    let highest = all().map(|p| p.1).fold(1.0, f64::max);
    let mut plot = Plot::new(
        "Speed-up against threads",
        Axis::log("threads (logarithmic)", [1.0, most].into_iter()).at_powers_of_two(),
        Axis::log(
            "speed-up, times one thread (logarithmic)",
            [all().map(|p| p.1).fold(1.0, f64::min), highest * 1.5].into_iter(),
        ),
    );
    let linear = Look {
        color: "#777",
        mark: Mark::None,
        dashes: "2 4",
        width: 1.5,
    };
    let end = most.min(highest * 1.5);
    plot.line(&[(1.0, 1.0), (end, end)], linear);
    let by_model = Look {
        color: COLORS[1],
        mark: Mark::Ring,
        dashes: "7 4",
        width: 2.0,
    };
    plot.line(&predicted, by_model);
    let by_clock = Look {
        color: COLORS[0],
        mark: Mark::Square,
        dashes: "",
        width: 2.4,
    };
    plot.line(&measured, by_clock);
    plot.key(by_clock, "measured");
    plot.key(by_model, "predicted");
    plot.key(linear, "linear");
    for &(threads, speed_up) in &predicted[1..] {
        plot.note((threads, speed_up), false, &format!("{speed_up:.2}"));
    }
    for &(threads, speed_up) in measured.iter().skip(1) {
        plot.note((threads, speed_up), true, &format!("{speed_up:.2}"));
    }
    let clock = scaling.measured.last().map_or(String::new(), |m| {
        format!(
            "Measured on {} of this machine's threads: {:.2} times as quick as one ({} \u{b5}s a frame). ",
            m.threads,
            m.speed_up,
            number(m.time_us)
        )
    });
    let model = scaling.predicted.last().map_or(String::new(), |p| {
        format!(
            "On {} threads {:.2} times is predicted; what they wait for longest then is work called <i>{}</i>, {:.0} % of the time. ",
            p.threads,
            p.speed_up,
            p.limited_by,
            100.0 * p.limited_share
        )
    });
    Figure {
        file: "sweep-threads.svg",
        title: "Threads",
        caption: format!(
            "{clock}{model}The prediction puts the tasks of each stage, as long as they took on one thread, on so many imagined ones (list scheduling). It leaves out \
             waking threads up, handing out tasks, and all that they cost each other, so it says what the shape of the work allows and \
             no more. On a machine that does other work besides, less is measured."
        ),
        svg: plot.finish(),
    }
}
