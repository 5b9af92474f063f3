//! The study's page: charts with what to see in them, tables, and how all was found. No scripts, nothing from elsewhere, and nothing that
//! differs between runs but what was measured.

use std::fmt::Write;

use antumbra::measure::{ORACLE, Sweep, SweepPoint};

use super::trade_chart::{Error, letter};
use super::{Figure, axis, name_of};
use crate::cli::output::{count_of, thousands};

const STYLE: &str = "\
:root { color-scheme: light dark; --paper: #fff; --ink: #1b1f24; --faint: #5a6572; --line: #d5dae0; --best: #eef6fb }
@media (prefers-color-scheme: dark) { :root { --paper: #12151a; --ink: #dfe4ea; --faint: #9aa4b0; --line: #2c323a; --best: #1b2a35 } }
body { background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 62rem; padding: 0 1rem }
h1, h2, h3 { font-weight: 600; line-height: 1.2 }
h1 { margin-bottom: .5rem }
h2 { margin-top: 3rem }
h3 { margin: 0 0 .6rem }
section { margin: 2.2rem 0 }
.scroll + h3 { margin-top: 2rem }
figure { margin: 0 }
.paper { background: #fff; border: 1px solid var(--line); border-radius: .4rem; overflow: hidden; padding: .4rem }
figure svg { display: block; height: auto; width: 100% }
figcaption { margin: .6rem 0 0; max-width: 56rem }
.scroll { overflow-x: auto }
table { border-collapse: collapse; font-size: .92em; font-variant-numeric: tabular-nums; width: 100% }
th, td { border-bottom: 1px solid var(--line); padding: .2rem .6rem; text-align: right; white-space: nowrap }
th { color: var(--faint); font-weight: 500; vertical-align: bottom; white-space: normal }
th:first-child, td:first-child, .left { text-align: left }
tbody + tbody tr:first-child td { border-top: 2px solid var(--line) }
.best { background: var(--best); font-weight: 600 }
dl { display: grid; gap: .2rem 1.5rem; grid-template-columns: max-content 1fr }
dt { color: var(--faint) }
dd { margin: 0 }
@page { margin: 13mm }
@media print {
  :root { color-scheme: light; --paper: #fff; --ink: #000; --faint: #333; --line: #bbb; --best: #eee }
  body { font-size: 10pt; margin: 0; max-width: none; padding: 0 }
  h2, h3 { break-after: avoid }
  section, tr, dl { break-inside: avoid }
  section { margin: .8rem 0 }
  figure svg { margin: 0 auto; width: 84% }
  figcaption { line-height: 1.35; margin-top: .2rem; max-width: none }
  h2 { margin-top: 1.4rem }
  thead { display: table-header-group }
  .paper { border: 0; padding: 0 }
  .scroll { overflow: visible }
  th, td { padding: .1rem .4rem }
}
";

/// What the page is about.
pub struct Header<'a> {
    /// The scene's file.
    pub scene: &'a str,
    /// The camera path's file.
    pub path: &'a str,
}

/// Text that may stand in HTML.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            c => out.push(c),
        }
    }
    out
}

/// A page in the making.
struct Page(String);

impl Page {
    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        self.0.write_fmt(text).expect("a string takes everything");
        self.0.push('\n');
    }
}

/// The page, HTML.
pub fn sweep_page(header: &Header<'_>, swept: &Sweep, figures: &[Figure]) -> String {
    let mut page = Page(String::new());
    let scene = escaped(header.scene);
    page.put(format_args!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>Antumbra: a study of {scene}</title>\n<style>\n{STYLE}</style>\n\
         <h1>Occlusion culling of {scene}</h1>\n\
         <p>What settings cost in time, what they hide, and what they get wrong.</p>"
    ));
    facts(&mut page, header, swept);
    for figure in figures {
        let svg = &figure.svg;
        page.put(format_args!(
            "<section>\n<h3>{}</h3>\n<figure>\n<div class=\"paper\">\n{svg}</div>\n<figcaption>{}</figcaption>\n</figure>\n</section>",
            figure.title, figure.caption
        ));
        match figure.file {
            "sweep-wrong-pixels.svg" => front(&mut page, swept, Error::WrongPixels),
            "sweep-missed-culls.svg" => front(&mut page, swept, Error::MissedCulls),
            _ => {}
        }
    }
    page.put(format_args!(
        "<h2>All figures</h2>\n<p>Means over the judged frames. <i>Hidden</i> objects are those in the frustum that own no \
         pixel of the exact picture; <i>false culls</i> are objects that own one and were culled, in all frames. Times are the \
         least of three repeats; the oracle's leave out finding the clusters.</p>"
    ));
    variants(&mut page, swept);
    choices(&mut page, swept);
    page.put(format_args!("</html>"));
    page.0
}

/// What was measured, and how.
fn facts(page: &mut Page, header: &Header<'_>, swept: &Sweep) {
    let s = &swept.settings;
    let accuracy = match s.hole {
        0 => s.accuracy.clone(),
        hole => format!(
            "{}, holes up to {} ignored",
            s.accuracy,
            count_of(hole.into(), "pixel")
        ),
    };
    let facts = [
        (
            "scene",
            format!(
                "{}, {}, {}",
                escaped(header.scene),
                count_of(swept.objects, "object"),
                count_of(swept.triangles, "triangle")
            ),
        ),
        (
            "camera path",
            format!(
                "{}, {} judged ({})",
                escaped(header.path),
                count_of(swept.frames as u64, "frame"),
                match s.every {
                    1 => "all of it".to_owned(),
                    every => format!("one in {every}"),
                }
            ),
        ),
        ("picture", format!("{} x {} pixels", s.size[0], s.size[1])),
        (
            "settings",
            format!(
                "unless a chart says otherwise {accuracy}, map at 1/{}, occluders by {}, budget {}; holes distributed by factor {}",
                s.map_scale, s.occluders, s.budget, s.distribution
            ),
        ),
        (
            "machine",
            format!("{}, {}", count_of(s.threads as u64, "thread"), s.simd),
        ),
    ];
    page.put(format_args!("<dl>"));
    for (what, value) in facts {
        page.put(format_args!("<dt>{what}<dd>{value}"));
    }
    page.put(format_args!("</dl>"));
}

/// The settings of a front, with the letters that they have on its chart.
fn front(page: &mut Page, swept: &Sweep, error: Error) {
    page.put(format_args!(
        "<section><h3>The front of this chart</h3><div class=\"scroll\"><table><thead><tr><th>on the chart<th class=\"left\">setting<th>time a frame, &micro;s\
         <th>wrong pixels a frame<th>hidden not culled<th>false culls</thead><tbody>"
    ));
    for (i, p) in error.front(swept).into_iter().enumerate() {
        page.put(format_args!(
            "<tr><td>{}<td class=\"left\">{}<td>{}<td>{}<td>{:.2} %<td>{}",
            letter(i),
            name_of(p),
            axis::number(p.time_us),
            axis::number(p.wrong_pixels_a_frame),
            100.0 * p.missed_culls,
            p.false_culls
        ));
    }
    page.put(format_args!("</tbody></table></div></section>"));
}

/// Holes, scales and depth representations.
fn variants(page: &mut Page, swept: &Sweep) {
    page.put(format_args!(
        "<h3>Holes, scales of the map, and representations of depth</h3>\n<div class=\"scroll\"><table><thead><tr><th>depth<th>map<th>holes up to, pixels<th>time a frame, &micro;s\
         <th>wrong pixels a frame<th>hidden not culled<th>false culls<th>triangles drawn as occluders</thead>"
    ));
    let mut points: Vec<&SweepPoint> = swept.variants().chain(swept.depths()).collect();
    points.sort_by_key(|p| (p.depth.clone(), p.map_scale, p.hole));
    for points in points.chunk_by(|a, b| a.map_scale == b.map_scale && a.depth == b.depth) {
        page.put(format_args!("<tbody>"));
        for p in points {
            page.put(format_args!(
                "<tr><td>{}<td>1/{}<td>{}<td>{}<td>{}<td>{:.2} %<td>{}<td>{}",
                p.depth,
                p.map_scale,
                match p.hole {
                    0 => "exact".to_owned(),
                    hole => thousands(hole.into()),
                },
                axis::number(p.time_us),
                axis::number(p.wrong_pixels_a_frame),
                100.0 * p.missed_culls,
                p.false_culls,
                thousands(p.occluder_triangles.round() as u64),
            ));
        }
        page.put(format_args!("</tbody>"));
    }
    page.put(format_args!("</table></div>"));
}

/// Selections and budgets.
fn choices(page: &mut Page, swept: &Sweep) {
    page.put(format_args!(
        "<h3>Selections and budgets</h3>\n<p>The most that is culled with each budget stands out, the oracle aside.</p>\n\
         <div class=\"scroll\"><table><thead><tr><th>occluders<th>budget, triangles<th>triangles drawn<th>culled of the hidden\
         <th>time a frame, &micro;s<th>false culls</thead>"
    ));
    let points: Vec<&SweepPoint> = swept.choices().collect();
    for of_one in points.chunk_by(|a, b| a.occluders == b.occluders) {
        page.put(format_args!("<tbody>"));
        for p in of_one {
            let mut rivals = points
                .iter()
                .filter(|r| r.budget == p.budget && r.occluders != ORACLE);
            let is_best = p.occluders != ORACLE
                && p.budget.parse::<u64>().is_ok()
                && rivals.all(|r| r.culled_of_hidden <= p.culled_of_hidden);
            page.put(format_args!(
                "<tr{}><td>{}<td>{}<td>{}<td>{:.1} %<td>{}<td>{}",
                if is_best { " class=\"best\"" } else { "" },
                p.occluders,
                p.budget.parse().map_or(p.budget.clone(), thousands),
                thousands(p.occluder_triangles.round() as u64),
                100.0 * p.culled_of_hidden,
                thousands(p.time_us.round() as u64),
                p.false_culls,
            ));
        }
        page.put(format_args!("</tbody>"));
    }
    page.put(format_args!("</table></div>"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use antumbra::measure::{Scaling, SweptWith};

    fn point(occluders: &str, culled_of_hidden: f64) -> SweepPoint {
        SweepPoint {
            occluders: occluders.to_owned(),
            budget: "2000".to_owned(),
            occluder_triangles: 1_999.6,
            culled_of_hidden,
            time_us: 12.4,
            is_base: true,
            ..SweepPoint::default()
        }
    }

    #[test]
    fn the_best_selection_stands_out_and_names_are_escaped() {
        let swept = Sweep {
            objects: 1,
            triangles: 2,
            settings: SweptWith {
                size: [320, 192],
                threads: 1,
                simd: "scalar".to_owned(),
                accuracy: "exact".to_owned(),
                hole: 0,
                map_scale: 1,
                occluders: "contribution".to_owned(),
                budget: "auto".to_owned(),
                distribution: 2.0,
                every: 8,
            },
            frames: 3,
            points: vec![
                point("nearest", 0.25),
                point("weight", 0.5),
                point(ORACLE, 0.75),
            ],
            path: Vec::new(),
            scaling: Scaling::default(),
        };
        let figure = Figure {
            file: "a.svg",
            title: "A",
            caption: "what to see".to_owned(),
            svg: "<svg></svg>".to_owned(),
        };
        let header = Header {
            scene: "a<b>.glb",
            path: "p.json",
        };
        let page = sweep_page(&header, &swept, &[figure]);
        assert!(page.contains("a&lt;b&gt;.glb") && !page.contains("a<b>"));
        assert!(
            page.contains("<tr class=\"best\"><td>weight<td>2,000<td>2,000<td>50.0 %<td>12<td>0")
        );
        assert_eq!(page.matches("<tr class=\"best\"").count(), 1);
        assert!(page.contains("<svg></svg>"));
        assert!(page.contains("<figcaption>what to see"));
        assert!(page.contains("320 x 192 pixels") && page.contains("one in 8"));
    }
}
