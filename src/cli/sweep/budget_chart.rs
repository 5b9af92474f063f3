//! The charts of a sweep: culled against triangles drawn, or against time, a line for each way to choose occluders.
//!
//! Lines differ by colour and by the shape of their points, so that they can be told apart without colours. Their names stand
//! beside the chart, where no line runs beneath them.

use antumbra::measure::{ORACLE, Sweep, SweepPoint};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Anything = Box<dyn std::error::Error>;

const SIZE: (u32, u32) = (1080, 600);
/// What the names take at the right, in pixels.
const NAMES_WIDTH: u32 = 176;
/// From one name to the next.
const NAMES_APART: i32 = 28;

/// Okabe and Ito's palette, which differs for every kind of colour vision; its yellow is too light for lines on white and darkened.
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(86, 180, 233),
    RGBColor(0, 158, 115),
    RGBColor(230, 159, 0),
    RGBColor(204, 121, 167),
    RGBColor(110, 110, 110),
    RGBColor(213, 94, 0),
    RGBColor(148, 130, 10),
];

/// What the points of a line look like; one fewer than colours, so that together they differ for longer.
const MARKS: [Mark; 5] = [
    Mark::Disc,
    Mark::Triangle,
    Mark::Cross,
    Mark::Square,
    Mark::Ring,
];

#[derive(Clone, Copy)]
enum Mark {
    Disc,
    Triangle,
    Cross,
    Square,
    Ring,
}

impl Mark {
    /// The mark around a place, `half` as large, in pixels.
    fn at<'a>(
        self,
        (x, y): (i32, i32),
        half: i32,
        color: RGBColor,
    ) -> DynElement<'static, SVGBackend<'a>, (i32, i32)> {
        let place = (x, y);
        match self {
            Mark::Disc => Circle::new(place, half, color.filled()).into_dyn(),
            Mark::Triangle => TriangleMarker::new(place, half + 1, color.filled()).into_dyn(),
            Mark::Cross => Cross::new(place, half, color.stroke_width(2)).into_dyn(),
            Mark::Square => {
                let corners = [(x - half, y - half), (x + half, y + half)];
                Rectangle::new(corners, color.filled()).into_dyn()
            }
            Mark::Ring => Circle::new(place, half, color.stroke_width(2)).into_dyn(),
        }
    }
}

/// What a line looks like.
#[derive(Clone, Copy)]
struct Look {
    color: RGBColor,
    mark: Mark,
    width: u32,
    is_dashed: bool,
}

impl Look {
    /// Of the line of a name, the `number`th.
    fn of(name: &str, number: usize) -> Look {
        let look = Look {
            color: COLORS[number % COLORS.len()],
            mark: MARKS[number % MARKS.len()],
            width: 2,
            is_dashed: false,
        };
        match name {
            ORACLE => Look {
                color: BLACK,
                mark: Mark::Ring,
                is_dashed: true,
                ..look
            },
            "contribution" => Look {
                mark: Mark::Disc,
                width: 4,
                ..look
            },
            _ => look,
        }
    }

    /// A line through places on an area, in pixels.
    fn draw(self, area: &Area<'_>, places: &[(i32, i32)]) -> Result<(), Anything> {
        let style = self.color.stroke_width(self.width);
        if self.is_dashed {
            area.draw(&DashedPathElement::new(places.iter().copied(), 7, 5, style))?;
        } else {
            area.draw(&PathElement::new(places, style))?;
        }
        for &place in places {
            area.draw(&self.mark.at(place, 4, self.color))?;
        }
        Ok(())
    }
}

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
            Against::Triangles => "triangles drawn as occluders in a frame (logarithmic)",
            Against::Time => "time a frame takes, in microseconds (logarithmic)",
        }
    }
}

/// The numbers that are written along a logarithmic axis: the fewer of each decade the more there are of these.
fn ticks(least: f64, most: f64) -> Vec<f64> {
    let steps: &[f64] = match most / least {
        ratio if ratio < 8.0 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
        ratio if ratio < 2_000.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let decades = (0..12).map(|decade| (0..decade).fold(0.1, |number, _| number * 10.0));
    let numbers = decades.flat_map(|decade| steps.iter().map(move |step| step * decade));
    numbers
        .filter(|number| (least..=most).contains(number))
        .collect()
}

/// A number with its thousands apart.
fn label(number: f64) -> String {
    if number < 10.0 {
        format!("{number:.1}")
    } else {
        crate::cli::output::thousands(number.round() as u64)
    }
}

/// A chart as SVG.
///
/// # Errors
/// If it cannot be drawn.
pub fn chart(name: &str, swept: &Sweep, against: Against) -> Result<String, Anything> {
    let points: Vec<&SweepPoint> = swept.choices().collect();
    let across = |p: &SweepPoint| against.of(p);
    let least = points
        .iter()
        .map(|p| across(p))
        .fold(f64::INFINITY, f64::min);
    let most = points.iter().map(|p| across(p)).fold(least, f64::max);
    let (left, right) = (least * 0.9, most * 1.1);
    let culled = points.iter().map(|p| p.culled_of_hidden);
    let (worst, best) = (
        culled.clone().fold(1.0, f64::min),
        culled.fold(0.0, f64::max),
    );
    let mut picture = String::new();
    {
        let all = SVGBackend::with_string(&mut picture, SIZE).into_drawing_area();
        all.fill(&WHITE)?;
        let (area, names) = all.split_horizontally(SIZE.0 - NAMES_WIDTH);
        let title = format!(
            "{name}: how many of the hidden objects are culled (mean of {})",
            crate::cli::output::count_of(swept.frames as u64, "frame")
        );
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 20))
            .margin(16)
            .x_label_area_size(48)
            .y_label_area_size(64)
            .build_cartesian_2d(
                (left..right)
                    .log_scale()
                    .with_key_points(ticks(left, right)),
                (worst - 0.02).max(0.0)..(best + 0.02).min(1.0),
            )?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .x_desc(against.axis())
            .y_desc("culled of the hidden objects, %")
            .x_label_formatter(&|&x| label(x))
            .y_label_formatter(&|y| format!("{:.0}", y * 100.0))
            .label_style(("sans-serif", 15))
            .draw()?;
        let lines = points.chunk_by(|a, b| a.occluders == b.occluders);
        for (number, points) in lines.enumerate() {
            let look = Look::of(&points[0].occluders, number);
            let (chosen, mut line): (Vec<&SweepPoint>, Vec<&SweepPoint>) =
                points.iter().partition(|p| p.budget == "auto");
            // In the order of what is drawn, whatever that takes.
            line.sort_by(|a, b| a.occluder_triangles.total_cmp(&b.occluder_triangles));
            let place = |p: &&SweepPoint| chart.backend_coord(&(across(p), p.culled_of_hidden));
            let places: Vec<(i32, i32)> = line.iter().map(place).collect();
            look.draw(&all, &places)?;
            for at in chosen.iter().map(place) {
                all.draw(&look.mark.at(at, 4, look.color))?;
                all.draw(&Circle::new(at, 9, look.color.stroke_width(2)))?;
            }
            let y = 72 + number as i32 * NAMES_APART;
            look.draw(&names, &[(6, y), (24, y), (42, y)])?;
            let font = ("sans-serif", 15).into_font();
            names.draw(&Text::new(points[0].occluders.clone(), (54, y - 7), font))?;
            if !chosen.is_empty() {
                let y = y + NAMES_APART * (swept_lines(swept) - number) as i32 + 6;
                names.draw(&look.mark.at((24, y), 4, look.color))?;
                names.draw(&Circle::new((24, y), 9, look.color.stroke_width(2)))?;
                for (row, text) in ["the budget that", "chooses itself"].iter().enumerate() {
                    let font = ("sans-serif", 14).into_font();
                    names.draw(&Text::new(*text, (54, y - 14 + 16 * row as i32), font))?;
                }
            }
        }
        all.present()?;
    }
    Ok(picture)
}

fn swept_lines(swept: &Sweep) -> usize {
    let points: Vec<&SweepPoint> = swept.choices().collect();
    points.chunk_by(|a, b| a.occluders == b.occluders).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(least: f64, most: f64) -> Vec<String> {
        ticks(least, most).into_iter().map(label).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        assert_eq!(
            labels(420.0, 3_300.0),
            ["500", "600", "800", "1,000", "1,500", "2,000", "3,000"]
        );
        assert_eq!(labels(0.9, 30.0), ["1.0", "2.0", "5.0", "10", "20"]);
        assert_eq!(
            labels(15.0, 600_000.0),
            ["100", "1,000", "10,000", "100,000"]
        );
    }
}
