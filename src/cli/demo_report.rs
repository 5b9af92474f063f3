//! The demo's page: what was done, the pictures, and a table of the frames. No scripts, nothing from elsewhere.

use std::fmt::Write;

use antumbra::measure::Report;

use super::output::{count_of, percent, thousands};

/// The names of the demo's pictures.
#[derive(Debug, Default)]
pub struct Pictures {
    /// All frames on one sheet.
    pub sheet: String,
    /// Frames, in the order of the report's.
    pub frames: Vec<String>,
    /// Frames with what the culling did.
    pub overlays: Vec<String>,
}

const STYLE: &str = "\
body { background: #12151a; color: #dfe4ea; font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem }
h1, h2 { font-weight: 600; line-height: 1.2 }
h2 { margin-top: 2.5rem }
img { display: block; height: auto; margin: 1rem 0; width: 100% }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; width: 100% }
th, td { border-bottom: 1px solid #2c323a; padding: .3rem .6rem; text-align: right }
th { color: #9aa4b0; font-weight: 500 }
tfoot td { border-bottom: 0; font-weight: 600 }
a { color: #56b4e9 }
.numbers { display: flex; flex-wrap: wrap; gap: 2rem }
.numbers b { display: block; font-size: 1.8rem; line-height: 1.2 }
";

/// The page, HTML.
pub fn report_page(report: &Report, pictures: &Pictures) -> String {
    let sum = |of: fn(&antumbra::measure::FrameReport) -> u64| -> u64 {
        report.frames.iter().map(of).sum()
    };
    let totals = &report.totals;
    let (culled, hidden) = (sum(|f| f.culled), sum(|f| f.exactly_hidden));
    let (drawn, unculled) = (sum(|f| f.triangles_drawn), sum(|f| f.triangles_in_frustum));
    let mut page = String::new();
    let mut put = |text: std::fmt::Arguments<'_>| {
        page.write_fmt(text).expect("a string takes everything");
        page.push('\n');
    };
    put(format_args!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>Antumbra: a walk through a city</title>\n<style>\n{STYLE}</style>\n\
         <h1>A walk through a city</h1>\n\
         <p>A city of {} objects and {} triangles. In each frame Antumbra asks which of the objects in the camera's \
         frustum may be seen, and leaves out those that stand behind others. The pictures show the survivors only; \
         they equal the pictures of the whole city, pixel for pixel.</p>",
        thousands(report.scene.objects),
        thousands(report.scene.triangles),
    ));
    put(format_args!(
        "<div class=\"numbers\">\
         <div><b>{:.1} %</b>of the hidden objects culled</div>\
         <div><b>{}</b>wrong pixels in {} frames</div>\
         <div><b>{:.2} ms</b>a frame, {}, {}</div>\
         <div><b>{:.0} %</b>of the triangles in the frustum left to draw</div></div>",
        percent(culled, hidden),
        totals.wrong_pixels,
        report.frames.len(),
        totals.time_us_mean.total / 1000.0,
        count_of(report.settings.threads as u64, "thread"),
        report.settings.simd,
        percent(drawn, unculled),
    ));
    put(format_args!("<h2>What the culling did</h2>"));
    for name in &pictures.overlays {
        put(format_args!(
            "<a href=\"{name}\"><img src=\"{name}\" alt=\"A frame, the same frame from behind the camera, and the \
             occlusion maps\"></a>"
        ));
    }
    put(format_args!(
        "<h2>The walk</h2>\n<a href=\"{0}\"><img src=\"{0}\" alt=\"All frames of the walk\"></a>",
        pictures.sheet
    ));
    put(format_args!(
        "<h2>Frame by frame</h2>\n<p>Judged against an exact picture of the whole city at {} x {} pixels. \
         <i>Exactly hidden</i> objects own no pixel of it; a <i>wrong pixel</i> is one that culling changes.</p>\n\
         <table><thead><tr><th>frame<th>in frustum<th>exactly hidden<th>culled<th>of hidden<th>wrong pixels\
         <th>select<th>raster<th>pyramid<th>test<th>total, ms</thead><tbody>",
        report.settings.size[0], report.settings.size[1],
    ));
    for (f, name) in report.frames.iter().zip(&pictures.frames) {
        let t = &f.time_us;
        put(format_args!(
            "<tr><td><a href=\"{name}\">{}</a><td>{}<td>{}<td>{}<td>{:.1} %<td>{}<td>{:.2}<td>{:.2}<td>{:.2}\
             <td>{:.2}<td>{:.2}",
            f.frame,
            thousands(f.in_frustum),
            thousands(f.exactly_hidden),
            thousands(f.culled),
            percent(f.culled, f.exactly_hidden),
            f.wrong_pixels,
            t.select / 1000.0,
            t.raster / 1000.0,
            t.pyramid / 1000.0,
            t.test / 1000.0,
            t.total / 1000.0,
        ));
    }
    let t = &totals.time_us_mean;
    put(format_args!(
        "</tbody><tfoot><tr><td>all<td>{}<td>{}<td>{}<td>{:.1} %<td>{}<td>{:.2}<td>{:.2}<td>{:.2}<td>{:.2}<td>{:.2}\
         </tfoot></table>",
        thousands(sum(|f| f.in_frustum)),
        thousands(hidden),
        thousands(culled),
        percent(culled, hidden),
        totals.wrong_pixels,
        t.select / 1000.0,
        t.raster / 1000.0,
        t.pyramid / 1000.0,
        t.test / 1000.0,
        t.total / 1000.0,
    ));
    put(format_args!(
        "<p>A perfect test of the objects' bounding boxes on screen would find {:.1} %.</p>\n</html>",
        totals.ideal_box_culled_of_hidden * 100.0
    ));
    page
}
