//! `sweep` compares the ways to choose occluders, and leaves a chart and its figures.

mod cli;

use cli::{Folder, stdout, succeed};
use serde_json::Value;

#[test]
fn a_sweep_leaves_a_chart_and_its_figures() {
    let folder = Folder::new("sweep").with_scene();
    let (scene, path) = (folder.file("yard.obj"), folder.file("yard.path.json"));
    let out = folder.file("swept");
    let said = succeed(&[
        "sweep",
        &scene,
        "--path",
        &path,
        "--size",
        "320x192",
        "--budgets",
        "2,12",
        "--holes",
        "0,64",
        "--map-scales",
        "1,2,4",
        "--out",
        &out,
    ]);
    let read = |file: &str| std::fs::read_to_string(format!("{out}/{file}")).expect(file);
    let swept: Value = serde_json::from_str(&read("sweep.json")).expect("JSON");
    let points = swept["points"].as_array().expect("a list");
    // Each selection and the oracle with two budgets and without one; contribution also with its own. Then two holes at three
    // scales, of which one is there already, and three more representations of depth.
    assert_eq!(points.len(), 8 * 3 + 1 + 2 * 3 - 1 + 3);
    for point in points {
        if point["hole"] == 0 {
            assert_eq!(point["false_culls"], 0, "{point}");
            assert_eq!(point["wrong_pixels"], 0, "{point}");
        }
        let budget = point["budget"].as_str().expect("a name");
        if let Ok(most) = budget.parse::<f64>() {
            assert!(
                point["occluder_triangles"].as_f64() <= Some(most),
                "{point}"
            );
        }
    }
    let names: Vec<&str> = points
        .iter()
        .filter(|point| point["budget"] == "all" && point["is_base"] == true)
        .map(|point| point["occluders"].as_str().expect("a name"))
        .collect();
    assert_eq!(
        names,
        [
            "nearest",
            "z-plane",
            "solid-angle",
            "weight",
            "previous-visible",
            "coherent",
            "contribution",
            "oracle"
        ]
    );
    let of_oracle = |budget: &str| {
        let mut named = points.iter().filter(|point| point["occluders"] == "oracle");
        let point = named.find(|point| point["budget"] == budget);
        point.expect("a point")["culled_of_hidden"].as_f64()
    };
    // The wall's clusters hide the box behind it, in the frames that look there; two triangles of it do not.
    assert_eq!(of_oracle("12"), Some(1.0));
    assert_eq!(of_oracle("2"), Some(0.0));
    let csv = read("sweep.csv");
    assert_eq!(csv.lines().count(), 1 + points.len());
    let columns = csv.lines().next().expect("names").split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns));
    let frames = swept["frames"].as_u64().expect("a count") as usize;
    assert_eq!(read("sweep-frames.csv").lines().count(), 1 + 6 * frames);
    let has_front = |key: &str| points.iter().any(|point| point[key] == true);
    assert!(has_front("on_front_of_wrong_pixels") && has_front("on_front_of_missed_culls"));
    let chart = read("sweep.svg");
    let page = read("sweep.html");
    assert!(page.contains(&chart[chart.find("<svg").expect("a picture")..]));
    assert!(page.contains("yard.obj, 3 objects, 36 triangles"), "{page}");
    assert!(!page.contains("<script") && !page.contains("src="));
    let charts = [
        "sweep.svg",
        "sweep-time.svg",
        "sweep-wrong-pixels.svg",
        "sweep-missed-culls.svg",
        "sweep-frame-rates.svg",
        "sweep-triangles.svg",
        "sweep-frames.svg",
        "sweep-frames-coarse.svg",
        "sweep-threads.svg",
    ];
    for file in charts {
        let chart = read(file);
        assert!(page.contains(&chart), "{file} is not on the page");
        assert_eq!(chart.matches("class=\"axis\"").count(), 2, "{file}");
    }
    assert_eq!(page.matches("<figcaption>").count(), charts.len());
    for name in names {
        assert!(chart.contains(name), "{name} is not in the chart");
        assert!(page.contains(&format!("<td>{name}")), "{name}");
        assert!(stdout(&said).contains(name));
    }
}
