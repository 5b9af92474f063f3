//! Numbers under stress, judged by exact arithmetic: `docs/numerics.md` says what is promised, and has the table that
//!
//! ```sh
//! cargo test --release --test numerics -- --nocapture --test-threads=1
//! ```
//!
//! prints, a row for each kind of stress.

mod oracle;
mod worlds;

#[path = "numerics/exact.rs"]
mod exact;
#[path = "numerics/judge.rs"]
mod judge;
#[path = "numerics/numbers.rs"]
mod numbers;
#[path = "numerics/scatter.rs"]
mod scatter;
#[path = "numerics/shapes.rs"]
mod shapes;
#[path = "numerics/sizes.rs"]
mod sizes;
#[path = "numerics/tally.rs"]
mod tally;
#[path = "numerics/truth.rs"]
mod truth;
#[path = "numerics/views.rs"]
mod views;
#[path = "numerics/world.rs"]
mod world;

use antumbra_simd::Level;
use oracle::Chance;
use tally::Tally;
use world::World;

/// A snap to the grid is off by 1/512 pixel at the most; little is left for all else.
const POSITION: f64 = 1.0 / 512.0 + 1e-6;

/// Rounding to f32 is half a step.
const HALF_A_STEP: f64 = 0.5 + 1e-3;

/// Where the transform's own rounding shows in a sample's depth: of vertices cut a million million times nearer than they lie, or
/// within a hair of the eye in a world far off.
const A_FEW_STEPS: f64 = 64.0;

/// Judges `count` worlds of a kind, on one instruction set after the other.
fn stress(
    kind: &str,
    seed: u64,
    count: usize,
    nearer: f64,
    mut world: impl FnMut(&mut Chance) -> World,
) {
    let mut chance = Chance::seeded(seed);
    let mut tally = Tally::default();
    let levels = Level::available();
    for round in 0..count {
        let world = world(&mut chance);
        let level = levels[round % levels.len()];
        let said = format!("{kind}, round {round}");
        judge::judge(&world, level, round % 3 == 0, &mut tally, &said);
    }
    println!("\n{}", tally.row(kind));
    assert_eq!(tally.false_culls, 0, "{:?}", tally.first_false_cull);
    assert!(tally.position <= POSITION, "{} px", tally.position);
    assert!(tally.nearer <= nearer, "{} steps", tally.nearer);
    // Whatever a sample's is: tiles keep more distance than all but the last rounding.
    assert!(
        tally.stored_nearer <= HALF_A_STEP,
        "{} steps",
        tally.stored_nearer
    );
    // A test of something: enough is seen, and enough is hidden.
    assert!(
        tally.samples > 10 * count as u64 && tally.owners > count as u64,
        "{} samples, {} owners",
        tally.samples,
        tally.owners
    );
    assert!(tally.hidden > count as u64 / 4, "{} hidden", tally.hidden);
}

#[test]
fn a_world_ten_million_units_away_loses_nothing() {
    stress(
        "far-away world, 10⁷ units",
        101,
        800,
        A_FEW_STEPS,
        views::far_away,
    );
}

#[test]
fn depth_from_a_thousandth_to_a_thousand_million_loses_nothing() {
    stress("depth 10⁻³ to 10⁹", 102, 800, HALF_A_STEP, |chance| {
        views::long_range(chance, Some(1e9))
    });
}

#[test]
fn infinite_depth_loses_nothing() {
    stress(
        "depth 10⁻³ to infinity",
        103,
        800,
        HALF_A_STEP,
        |chance| views::long_range(chance, None),
    );
}

#[test]
fn reversed_depth_loses_nothing_at_either_end() {
    stress(
        "the ends of depth",
        104,
        800,
        HALF_A_STEP,
        views::ends_of_depth,
    );
}

#[test]
fn orthographic_views_lose_nothing() {
    stress("orthographic", 105, 800, HALF_A_STEP, views::orthographic);
}

#[test]
fn a_view_of_one_degree_loses_nothing() {
    stress("field of view of 1°", 106, 800, HALF_A_STEP, |chance| {
        views::field_of_view(chance, 1.0)
    });
}

#[test]
fn a_view_of_179_degrees_loses_nothing() {
    stress("field of view of 179°", 107, 800, HALF_A_STEP, |chance| {
        views::field_of_view(chance, 179.0)
    });
}

#[test]
fn what_meets_the_plane_of_the_eye_loses_nothing() {
    stress("w near 0", 108, 800, A_FEW_STEPS, views::eye_plane);
}

#[test]
fn slivers_and_needles_lose_nothing() {
    stress(
        "slivers and needles",
        109,
        800,
        HALF_A_STEP,
        shapes::slivers_and_needles,
    );
}

#[test]
fn huge_triangles_lose_nothing() {
    stress("huge triangles", 110, 800, A_FEW_STEPS, shapes::huge);
}

#[test]
fn layers_in_one_plane_lose_nothing() {
    stress("coplanar layers", 111, 800, HALF_A_STEP, shapes::coplanar);
}

#[test]
fn layers_less_than_an_f32_step_apart_lose_nothing() {
    stress(
        "layers 0.1 to 3 f32 steps apart",
        119,
        800,
        HALF_A_STEP,
        shapes::close_layers,
    );
}

#[test]
fn t_junctions_lose_nothing() {
    stress("T-junctions", 112, 400, HALF_A_STEP, shapes::t_junctions);
}

#[test]
fn subnormal_and_all_but_infinite_positions_lose_nothing() {
    stress(
        "subnormal and near-overflow positions",
        113,
        800,
        HALF_A_STEP,
        numbers::extreme_positions,
    );
}

#[test]
fn worlds_of_all_sizes_lose_nothing() {
    stress(
        "worlds of 10⁻²⁸ to 10²⁸ units",
        114,
        800,
        HALF_A_STEP,
        numbers::extreme_worlds,
    );
}

#[test]
fn mirrored_matrices_lose_nothing() {
    stress(
        "mirrored matrices",
        115,
        800,
        HALF_A_STEP,
        numbers::mirrored,
    );
}

#[test]
fn singular_matrices_lose_nothing() {
    stress(
        "singular matrices",
        116,
        800,
        HALF_A_STEP,
        numbers::singular,
    );
}

#[test]
fn pictures_of_all_small_sizes_lose_nothing() {
    stress(
        "pictures of 1×1 to 301×7",
        117,
        800,
        HALF_A_STEP,
        sizes::small_pictures,
    );
}

#[test]
fn pictures_of_the_largest_sizes_lose_nothing() {
    let mut chance = Chance::seeded(118);
    let mut tally = Tally::default();
    for (width, height) in [(16_384, 1), (1, 16_384), (16_384, 9), (13, 16_384)] {
        for _ in 0..20 {
            sizes::judge_large(&mut chance, width, height, &mut tally);
        }
    }
    sizes::judge_large(&mut chance, 4_099, 2_051, &mut tally);
    for _ in 0..4 {
        sizes::judge_large(&mut chance, 16_384, 16_384, &mut tally);
    }
    println!("\n{}", tally.row("pictures of 16384×1 to 16384×16384"));
    assert_eq!(tally.false_culls, 0, "{:?}", tally.first_false_cull);
    assert!(tally.position <= POSITION, "{} px", tally.position);
    assert!(
        tally.stored_nearer <= HALF_A_STEP,
        "{} steps",
        tally.stored_nearer
    );
    assert!(
        tally.owners > 50 && tally.hidden > 50,
        "{} {}",
        tally.owners,
        tally.hidden
    );
}

/// The rows of the camera define the picture; that they are what the angle says is a claim of its own.
#[test]
fn the_tangent_of_the_narrowest_and_the_widest_view_is_right_to_a_few_steps() {
    let mut worst = 0.0;
    for degrees in [
        1e-4, 0.01, 1.0, 30.0, 60.0, 90.0, 120.0, 170.0, 179.0, 179.9, 179.999,
    ] {
        let error = views::error_of_tangent(f64::to_radians(degrees));
        tally::keep_largest(&mut worst, error);
    }
    println!("the tangent of half a field of view is off by {worst:.3} f64 steps at the most");
    assert!(worst <= 4.0, "{worst} steps");
}

#[test]
fn the_head_of_the_table() {
    println!("\n{}", tally::HEAD);
    assert_eq!(
        tally::HEAD.matches('|').count(),
        Tally::default().row("").matches('|').count()
    );
}
