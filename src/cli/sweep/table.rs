//! A sweep's figures as CSV, and as a table for people.

use antumbra::measure::Sweep;

/// All points with all their settings.
pub fn csv(swept: &Sweep) -> String {
    let mut out = "occluders,budget,occluder_triangles,culled_of_hidden,time_us,false_culls,depth,accuracy,hole,map_scale,\
                   wrong_pixels,wrong_pixels_a_frame,missed_culls,on_front_of_wrong_pixels,on_front_of_missed_culls\n"
        .to_owned();
    for p in &swept.points {
        out += &format!(
            "{},{},{:.1},{:.6},{:.1},{},{},{},{},{},{},{:.3},{:.6},{},{}\n",
            p.occluders,
            p.budget,
            p.occluder_triangles,
            p.culled_of_hidden,
            p.time_us,
            p.false_culls,
            p.depth,
            p.accuracy,
            p.hole,
            p.map_scale,
            p.wrong_pixels,
            p.wrong_pixels_a_frame,
            p.missed_culls,
            p.on_front_of_wrong_pixels,
            p.on_front_of_missed_culls,
        );
    }
    out
}

/// The judged frames, for every hole and scale.
pub fn frames_csv(swept: &Sweep) -> String {
    let mut out = "depth,hole,map_scale,frame,in_frustum,exactly_visible,triangles_in_frustum,triangles_exactly_visible,\
                   time_us,triangles_drawn,wrong_pixels,ignored_pixels\n"
        .to_owned();
    for p in swept.variants() {
        for (path, f) in swept.path.iter().zip(&p.series) {
            out += &format!(
                "{},{},{},{},{},{},{},{},{:.1},{},{},{}\n",
                p.depth,
                p.hole,
                p.map_scale,
                path.frame,
                path.in_frustum,
                path.exactly_visible,
                path.triangles_in_frustum,
                path.triangles_exactly_visible,
                f.time_us,
                f.triangles_drawn,
                f.wrong_pixels,
                f.ignored_pixels,
            );
        }
    }
    out
}

/// The figures for people.
pub fn table(name: &str, swept: &Sweep) -> String {
    let mut out = format!(
        "{name}, {} frames\n\n        occluders |   budget |         depth | hole | map | triangles drawn |  culled | us a frame | wrong px a frame\n",
        swept.frames
    );
    for p in &swept.points {
        out += &format!(
            "{:>17} | {:>8} | {:>13} | {:>4} | 1/{} | {:>15.0} | {:>5.1} % | {:>10.0} | {:>16.1}\n",
            p.occluders,
            p.budget,
            p.depth,
            p.hole,
            p.map_scale,
            p.occluder_triangles,
            100.0 * p.culled_of_hidden,
            p.time_us,
            p.wrong_pixels_a_frame,
        );
    }
    out
}
