//! A sweep's page: the charts, the figures and how they were found. No scripts, nothing from elsewhere.

use std::fmt::Write;

use antumbra::measure::{ORACLE, Sweep};

use super::output::{count_of, thousands};

const STYLE: &str = "\
:root { color-scheme: light dark; --paper: #fff; --ink: #1b1f24; --faint: #5a6572; --line: #d5dae0; --best: #eef6fb }
@media (prefers-color-scheme: dark) { :root { --paper: #12151a; --ink: #dfe4ea; --faint: #9aa4b0; --line: #2c323a; --best: #1b2a35 } }
body { background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 64rem; padding: 0 1rem }
h1, h2 { font-weight: 600; line-height: 1.2 }
h2 { margin-top: 2.5rem }
figure { background: #fff; border: 1px solid var(--line); border-radius: .4rem; margin: 1.5rem 0; overflow: hidden }
figure svg { display: block; height: auto; width: 100% }
.scroll { overflow-x: auto }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; width: 100% }
th, td { border-bottom: 1px solid var(--line); padding: .25rem .6rem; text-align: right; white-space: nowrap }
th { color: var(--faint); font-weight: 500 }
th:first-child, td:first-child { text-align: left }
tbody + tbody tr:first-child td { border-top: 2px solid var(--line) }
.best { background: var(--best); font-weight: 600 }
dl { display: grid; gap: .2rem 1.5rem; grid-template-columns: max-content 1fr }
dt { color: var(--faint) }
dd { margin: 0 }
";

/// Text that may stand in HTML.
fn escaped(text: &str) -> String {
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

/// The page, HTML. `charts` are culling against triangles and against time, as SVG; `path` is the name of the camera path's file.
pub fn sweep_page(name: &str, path: &str, swept: &Sweep, charts: [&str; 2]) -> String {
    let mut page = String::new();
    let mut put = |text: std::fmt::Arguments<'_>| {
        page.write_fmt(text).expect("a string takes everything");
        page.push('\n');
    };
    let (name, path) = (escaped(name), escaped(path));
    let s = &swept.settings;
    put(format_args!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>Antumbra: choosing occluders in {name}</title>\n<style>\n{STYLE}</style>\n\
         <h1>Choosing occluders in {name}</h1>\n\
         <p>Each line is a way to choose which triangles are drawn as occluders. The higher, the more of the hidden objects \
         are culled behind them; the farther to the left, the fewer triangles or the less time that takes. <i>oracle</i> is no such way, but \
         what to hold them against: of each frame, the clusters of triangles that own the most pixels of the exact picture \
         for their number.</p>"
    ));
    for (chart, against) in charts.iter().zip(["triangles drawn as occluders", "time"]) {
        // Within HTML it begins without a declaration.
        let svg = chart.find("<svg").map_or("", |at| &chart[at..]);
        put(format_args!(
            "<figure role=\"img\" aria-label=\"Culled of the hidden objects against {against}; the table below has the same \
             figures\">\n{svg}</figure>"
        ));
    }
    put(format_args!("<h2>How it was measured</h2>\n<dl>"));
    let accuracy = match s.hole {
        0 => s.accuracy.clone(),
        hole => format!(
            "{}, holes up to {} ignored",
            s.accuracy,
            count_of(hole.into(), "pixel")
        ),
    };
    for (what, value) in [
        (
            "scene",
            format!(
                "{name}, {}, {}",
                count_of(swept.objects, "object"),
                count_of(swept.triangles, "triangle")
            ),
        ),
        (
            "camera path",
            format!(
                "{path}, {} judged ({})",
                count_of(swept.frames as u64, "frame"),
                match s.every {
                    1 => "all of it".to_owned(),
                    every => format!("one in {every}"),
                }
            ),
        ),
        ("picture", format!("{} x {} pixels", s.size[0], s.size[1])),
        ("accuracy", accuracy),
        (
            "machine",
            format!("{}, {}", count_of(s.threads as u64, "thread"), s.simd),
        ),
    ] {
        put(format_args!("<dt>{what}<dd>{value}"));
    }
    put(format_args!(
        "</dl>\n<h2>Figures</h2>\n<p>Means over the judged frames. <i>Hidden</i> objects are those in the frustum that own no \
         pixel of the exact picture; <i>false culls</i> are objects that own one and were culled, in all frames. Times are the \
         least of three repeats; the oracle's leave out finding the clusters. The most that is culled with each budget stands \
         out, the oracle aside.</p>\n\
         <div class=\"scroll\"><table><thead><tr><th>occluders<th>budget, triangles<th>triangles drawn<th>culled of the hidden\
         <th>time a frame, &micro;s<th>false culls</thead>"
    ));
    for points in swept.points.chunk_by(|a, b| a.occluders == b.occluders) {
        put(format_args!("<tbody>"));
        for p in points {
            let rivals = swept.points.iter();
            let mut rivals = rivals.filter(|r| r.budget == p.budget && r.occluders != ORACLE);
            let is_best = p.occluders != ORACLE
                && p.budget.parse::<u64>().is_ok()
                && rivals.all(|r| r.culled_of_hidden <= p.culled_of_hidden);
            put(format_args!(
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
        put(format_args!("</tbody>"));
    }
    put(format_args!("</table></div>\n</html>"));
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use antumbra::measure::{SweepPoint, SweptWith};

    fn point(occluders: &str, culled_of_hidden: f64) -> SweepPoint {
        SweepPoint {
            occluders: occluders.to_owned(),
            budget: "2000".to_owned(),
            occluder_triangles: 1_999.6,
            culled_of_hidden,
            time_us: 12.4,
            false_culls: 0,
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
                every: 8,
            },
            frames: 3,
            points: vec![
                point("nearest", 0.25),
                point("weight", 0.5),
                point(ORACLE, 0.75),
            ],
        };
        let page = sweep_page(
            "a<b>.glb",
            "p.json",
            &swept,
            ["<?xml?><svg></svg>", "<svg>2</svg>"],
        );
        assert!(page.contains("a&lt;b&gt;.glb") && !page.contains("a<b>"));
        assert!(
            page.contains("<tr class=\"best\"><td>weight<td>2,000<td>2,000<td>50.0 %<td>12<td>0")
        );
        assert_eq!(page.matches("<tr class=\"best\"").count(), 1);
        assert!(
            page.contains("<svg></svg>")
                && page.contains("<svg>2</svg>")
                && !page.contains("<?xml")
        );
        assert!(page.contains("320 x 192 pixels") && page.contains("one in 8"));
    }
}
