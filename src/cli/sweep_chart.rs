//! The chart of a sweep: culled against triangles drawn, a line for each way to choose occluders.

use antumbra::measure::{Sweep, SweepPoint};
use plotters::prelude::*;

const SIZE: (u32, u32) = (960, 600);

/// Okabe and Ito's palette, which differs for every kind of colour vision, and black.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(86, 180, 233),
    RGBColor(0, 158, 115),
    RGBColor(230, 159, 0),
    RGBColor(204, 121, 167),
    RGBColor(110, 110, 110),
    RGBColor(213, 94, 0),
];

/// Numbers that begin with 1, 2 or 5 are written; there is no room for all.
fn label(number: f64) -> String {
    let text = format!("{number:.0}");
    if text.starts_with(['1', '2', '5']) {
        text
    } else {
        String::new()
    }
}

/// The chart as SVG.
///
/// # Errors
/// If it cannot be drawn.
pub fn chart(name: &str, swept: &Sweep) -> Result<String, Box<dyn std::error::Error>> {
    let points = &swept.points;
    let drawn = |p: &SweepPoint| p.occluder_triangles.max(1.0);
    let least = points.iter().map(drawn).fold(f64::INFINITY, f64::min);
    let most = points.iter().map(drawn).fold(1.0, f64::max);
    let culled = points.iter().map(|p| p.culled_of_hidden);
    let (worst, best) = (
        culled.clone().fold(1.0, f64::min),
        culled.fold(0.0, f64::max),
    );
    let mut picture = String::new();
    {
        let area = SVGBackend::with_string(&mut picture, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let title = format!(
            "{name}: culled of the hidden objects, mean of {} frames",
            swept.frames
        );
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 20))
            .margin(16)
            .x_label_area_size(44)
            .y_label_area_size(56)
            .build_cartesian_2d(
                (least * 0.9..most * 1.1).log_scale(),
                (worst - 0.02).max(0.0)..(best + 0.05).min(1.0),
            )?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_desc("triangles drawn as occluders in a frame")
            .y_desc("culled of the hidden")
            .x_label_formatter(&|&x| label(x))
            .y_label_formatter(&|y| format!("{:.0} %", y * 100.0))
            .label_style(("sans-serif", 15))
            .draw()?;
        for (points, color) in points
            .chunk_by(|a, b| a.occluders == b.occluders)
            .zip(COLORS.into_iter().cycle())
        {
            let mut line: Vec<(f64, f64)> = points
                .iter()
                .map(|p| (drawn(p), p.culled_of_hidden))
                .collect();
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
            let style = color.stroke_width(if points[0].occluders == "contribution" {
                4
            } else {
                2
            });
            chart
                .draw_series(LineSeries::new(line.clone(), style))?
                .label(&points[0].occluders)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style));
            chart.draw_series(
                line.into_iter()
                    .map(|at| Circle::new(at, 3, color.filled())),
            )?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerRight)
            .background_style(WHITE.mix(0.8))
            .border_style(RGBColor(200, 200, 200))
            .label_font(("sans-serif", 15))
            .draw()?;
        area.present()?;
    }
    Ok(picture)
}
