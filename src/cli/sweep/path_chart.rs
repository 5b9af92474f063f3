//! HOM's two graphs (§8.3.1): frame rates along the path with and without occlusion culling, and triangles left after each step.

use antumbra::measure::{Sweep, SweepPoint};

use super::Figure;
use super::axis::{Axis, number};
use super::plot::{COLORS, Look, Mark, Plot};

const SOLID: Look = Look {
    color: COLORS[0],
    mark: Mark::None,
    dashes: "",
    width: 2.4,
};

/// The axis along the path.
pub fn frames_axis(swept: &Sweep) -> Axis {
    let last = swept.path.last().map_or(0, |frame| frame.frame);
    Axis::between("frame of the path", 0.0, last as f64)
}

fn mean(values: impl Iterator<Item = f64>, swept: &Sweep) -> f64 {
    values.sum::<f64>() / swept.frames.max(1) as f64
}

/// Frames a second, if every triangle that is drawn costs `triangle_ns` downstream; with `base`'s culling and without.
pub fn frame_rates(swept: &Sweep, base: &SweepPoint, triangle_ns: f64) -> Figure {
    let rate = |us: f64| if us > 0.0 { 1e6 / us } else { 0.0 };
    let draw_us = |triangles: u64| triangles as f64 * triangle_ns / 1000.0;
    let frames = || swept.path.iter().zip(&base.series);
    let with: Vec<(f64, f64)> = frames()
        .map(|(_, f)| (f.frame as f64, rate(f.time_us + draw_us(f.triangles_drawn))))
        .collect();
    let without: Vec<(f64, f64)> = frames()
        // Of an empty frustum no rate can be told.
        .filter(|(p, _)| p.triangles_in_frustum > 0)
        .map(|(p, _)| (p.frame as f64, rate(draw_us(p.triangles_in_frustum))))
        .collect();
    let values = with.iter().chain(&without).map(|p| p.1);
    let mut plot = Plot::new(
        "Frames a second along the path, with and without occlusion culling",
        frames_axis(swept),
        Axis::log("frames a second (logarithmic)", values),
    );
    let dashed = Look {
        color: COLORS[1],
        dashes: "7 4",
        ..SOLID
    };
    plot.line(&without, dashed);
    plot.line(&with, SOLID);
    plot.key(SOLID, "frustum and occlusion");
    plot.key(dashed, "frustum culling alone");
    let culling_us = mean(base.series.iter().map(|f| f.time_us), swept);
    let saved = mean(
        frames().map(|(p, f)| p.triangles_in_frustum as f64 - f.triangles_drawn as f64),
        swept,
    );
    let quicker = with.iter().filter(|(frame, rate)| {
        let alone = without.iter().find(|(other, _)| other == frame);
        alone.is_some_and(|(_, alone)| rate > alone)
    });
    let pays = if saved > 0.0 {
        format!(
            "Culling takes {} \u{b5}s a frame and saves {} triangles, so on this path it pays from {} ns a triangle on.",
            number(culling_us),
            number(saved),
            number(culling_us * 1000.0 / saved)
        )
    } else {
        "On this path nothing is culled, so it never pays.".to_owned()
    };
    Figure {
        file: "sweep-frame-rates.svg",
        title: "Frame rate along the path",
        caption: format!(
            "HOM's frame-rate graph (\u{a7}8.3.1): where the solid line is above the dashed one, culling pays. No frame is drawn on a \
             GPU here: a triangle that is passed on is taken to cost {} ns (<code>--triangle-ns</code>), frustum culling alone nothing, \
             and culling and drawing to follow each other. With this price {} of {} frames are quicker with culling. {pays}",
            number(triangle_ns),
            quicker.count(),
            swept.frames
        ),
        svg: plot.finish(),
    }
}

/// Triangles left after each step.
pub fn triangles_left(swept: &Sweep, base: &SweepPoint) -> Figure {
    let of_path = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let numbers = swept.path.iter().enumerate();
        numbers.map(|(i, p)| (p.frame as f64, of(i))).collect()
    };
    let all = of_path(&|_| swept.triangles as f64);
    let in_frustum = of_path(&|i| swept.path[i].triangles_in_frustum as f64);
    let drawn = of_path(&|i| base.series[i].triangles_drawn as f64);
    let exact = of_path(&|i| swept.path[i].triangles_exactly_visible as f64);
    let steps = [
        ("in the scene", &all, "#000", "2 3", 1.6),
        ("after frustum culling", &in_frustum, COLORS[1], "7 4", 2.0),
        ("after occlusion culling", &drawn, COLORS[0], "", 2.6),
        ("of objects exactly visible", &exact, COLORS[2], "2 2", 2.2),
    ];
    let values = steps
        .iter()
        .flat_map(|(_, line, ..)| line.iter().map(|p| p.1));
    let mut plot = Plot::new(
        "Triangles left after each step, along the path",
        frames_axis(swept),
        Axis::log_with_zero(
            "triangles (logarithmic, with 0)",
            values.collect::<Vec<_>>().into_iter(),
        ),
    );
    for (name, line, color, dashes, width) in steps {
        let look = Look {
            color,
            mark: Mark::None,
            dashes,
            width,
        };
        plot.line(line, look);
        plot.key(look, name);
    }
    let mean_of = |line: &[(f64, f64)]| number(mean(line.iter().map(|p| p.1), swept).round());
    Figure {
        file: "sweep-triangles.svg",
        title: "Triangles left after each step",
        caption: format!(
            "HOM's culling graph (\u{a7}8.3.1): from the dashed line to the solid one is what occlusion culling removes; from there to the line of \
             the exactly visible is what a perfect test of whole objects would remove as well. All triangles of an object count if \
             a pixel of it is seen. On the mean, of {} triangles in the scene {} are in the frustum, {} are left after occlusion \
             culling, and {} belong to objects that own a pixel.",
            number(swept.triangles as f64),
            mean_of(&in_frustum),
            mean_of(&drawn),
            mean_of(&exact)
        ),
        svg: plot.finish(),
    }
}
