//! Wrong pixels frame by frame, for each size of holes (as in DYN figure 8), with what is known to bound them.

use antumbra::measure::{Sweep, SweepPoint};

use super::Figure;
use super::axis::{Axis, number};
use super::path_chart::frames_axis;
use super::plot::{COLORS, Look, MARKS, Mark, Plot};
use crate::cli::output::count_of;

const DASHES: [&str; 4] = ["", "7 3", "2 3", "9 3 2 3"];

/// Whether no more pixels can be wrong than were ignored.
fn is_bounded(swept: &Sweep, point: &SweepPoint) -> bool {
    point.map_scale == 1 || swept.settings.distribution <= 1.0
}

/// The chart of a map's scale; none if no holes were ignored at it.
pub fn wrong_pixels(swept: &Sweep, map_scale: u32, file: &'static str) -> Option<Figure> {
    let variants = swept.variants();
    let depth = &swept.base().or(swept.variants().next())?.depth;
    let mut lines: Vec<&SweepPoint> = variants
        .filter(|p| p.map_scale == map_scale && p.hole > 0 && p.depth == *depth)
        .collect();
    lines.sort_by_key(|p| p.hole);
    let largest = *lines.last()?;
    let series =
        |p: &SweepPoint, of: fn(&antumbra::measure::PointFrame) -> u64| -> Vec<(f64, f64)> {
            let frames = p.series.iter();
            frames.map(|f| (f.frame as f64, of(f) as f64)).collect()
        };
    let bound = is_bounded(swept, largest).then(|| series(largest, |f| f.ignored_pixels));
    let wrong = lines.iter().flat_map(|p| series(p, |f| f.wrong_pixels));
    let values: Vec<f64> = wrong
        .chain(bound.iter().flatten().copied())
        .map(|p| p.1)
        .collect();
    let mut plot = Plot::new(
        "Wrong pixels of each frame of the path",
        frames_axis(swept),
        Axis::log_with_zero("wrong pixels (logarithmic, with 0)", values.into_iter()),
    );
    if let Some(bound) = &bound {
        let look = Look {
            color: "#777",
            mark: Mark::None,
            dashes: "1 3",
            width: 2.0,
        };
        plot.line(bound, look);
        plot.key(look, &format!("bound for holes of {}", largest.hole));
    }
    let few = swept.frames <= 60;
    for (i, point) in lines.iter().enumerate() {
        let look = Look {
            color: COLORS[i % COLORS.len()],
            mark: if few {
                MARKS[i % MARKS.len()]
            } else {
                Mark::None
            },
            dashes: DASHES[i % DASHES.len()],
            width: 1.8,
        };
        plot.line(&series(point, |f| f.wrong_pixels), look);
        let mean = number(point.wrong_pixels_a_frame);
        plot.key(look, &format!("holes of {} (mean {mean})", point.hole));
    }
    let pixels = swept.settings.size[0] * swept.settings.size[1];
    let worst = largest.series.iter().map(|f| f.wrong_pixels).max();
    let scale = match map_scale {
        1 => "a map as large as the picture".to_owned(),
        scale => format!("a map at 1/{scale} of the picture's size"),
    };
    let bound = match bound {
        Some(bound) => format!(
            "The dotted line is the number of pixels that were ignored with the largest holes ({} a frame), a bound: no other pixel can \
             be wrong.",
            number(bound.iter().map(|p| p.1).sum::<f64>() / swept.frames.max(1) as f64)
        ),
        None => "At this scale the ignored pixels are no bound, as a sample of the map stands for its block once its \
                 middle is covered; none is drawn."
            .to_owned(),
    };
    Some(Figure {
        file,
        title: if map_scale == 1 {
            "Wrong pixels frame by frame, full-size map"
        } else {
            "Wrong pixels frame by frame, coarsest map"
        },
        caption: format!(
            "As DYN's figure 8, with {scale}: how evenly errors are spread over the path. At {} pixels a picture, holes of {} give {} wrong \
             pixels a frame on the mean ({} % of the picture) and {} in the worst one. {bound} Exact culling has none in any frame.",
            number(pixels as f64),
            largest.hole,
            number(largest.wrong_pixels_a_frame),
            number(100.0 * largest.wrong_pixels_a_frame / pixels as f64),
            count_of(worst.unwrap_or(0), "pixel")
        ),
        svg: plot.finish(),
    })
}
