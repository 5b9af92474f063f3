//! Which samples a triangle covers: exactly those of the top-left rule, each once along a shared edge.

mod oracle;

use antumbra_simd::GUARD_BAND;
use oracle::{Chance, Point, cases, hits, inside_outline, true_hits};
use proptest::prelude::*;

/// Vertices of the sorts that break rasterizers: anywhere near the picture, on sample centres and pixel corners,
/// within a sub-pixel of each other, and at the guard band's ends.
fn corner() -> impl Strategy<Value = Point> {
    let near = -800..6_000_i32;
    let far = prop_oneof![
        -GUARD_BAND..=GUARD_BAND,
        Just(GUARD_BAND),
        Just(-GUARD_BAND)
    ];
    let centre = (-3..24_i32).prop_map(|i| 128 * i);
    let close = 2_040..2_056_i32;
    prop_oneof![
        4 => (near.clone(), near),
        4 => (centre.clone(), centre),
        1 => (close.clone(), close),
        1 => (far.clone(), far),
    ]
}

fn triangle() -> impl Strategy<Value = [Point; 3]> {
    let any = [corner(), corner(), corner()];
    // Two corners far apart, and the third a few sub-pixels off the line between them.
    let sliver = (corner(), corner(), 0..=64_i64, -3..=3_i32, -3..=3_i32).prop_map(
        |(a, b, at, off_x, off_y)| {
            let between =
                |a: i32, b: i32| (i64::from(a) + (i64::from(b) - i64::from(a)) * at / 64) as i32;
            let limit = |v: i32| v.clamp(-GUARD_BAND, GUARD_BAND);
            [
                a,
                b,
                (
                    limit(between(a.0, b.0) + off_x),
                    limit(between(a.1, b.1) + off_y),
                ),
            ]
        },
    );
    prop_oneof![2 => any, 1 => sliver]
}

proptest! {
    #![proptest_config(cases(4_000))]

    #[test]
    fn covers_exactly_the_samples_of_the_top_left_rule(t in triangle(), w in 1..27_i32, h in 1..27_i32) {
        prop_assert_eq!(hits(&[t], w, h), true_hits(&[t], w, h));
    }

    #[test]
    fn two_triangles_on_a_shared_edge_hit_no_sample_twice_and_miss_none(
        a in corner(), b in corner(), c in corner(), d in corner(),
    ) {
        let wide = |v: i32| i128::from(v);
        let turn = |p: Point| {
            let cross = (wide(b.0) - wide(a.0)) * (wide(p.1) - wide(a.1))
                - (wide(b.1) - wide(a.1)) * (wide(p.0) - wide(a.0));
            cross.signum()
        };
        // On different sides of the edge they make a quadrilateral; half of the cases do.
        if turn(c) * turn(d) != -1 {
            return Ok(());
        }
        let (w, h) = (23, 23);
        let both = hits(&[[a, b, c], [b, a, d]], w, h);
        let outline = [a, d, b, c];
        for (i, &n) in both.iter().enumerate() {
            let (x, y) = (i as i32 % w, i as i32 / w);
            prop_assert_eq!(n, u32::from(inside_outline(&outline, x, y)), "sample ({}, {})", x, y);
        }
    }
}

/// A vertex with neighbours in all eight octants, some of them on the octants' borders.
fn fan(chance: &mut Chance, centre: Point, reach: i32) -> Vec<Point> {
    let mut rim = Vec::new();
    for octant in 0..8 {
        let long = chance.whole(1, reach);
        let short = match chance.whole(0, 3) {
            0 => 0,
            1 => long - 1,
            _ => chance.whole(0, long - 1),
        };
        // (long, short) turned into the octant, so that angles never fall: an even octant starts on an axis.
        let (along, across) = if octant % 2 == 0 {
            (long, short)
        } else {
            (short + 1, long)
        };
        let (mut x, mut y) = (along, across);
        for _ in 0..octant / 2 {
            (x, y) = (-y, x);
        }
        rim.push((centre.0 + x, centre.1 + y));
    }
    rim
}

#[test]
fn a_fan_around_a_vertex_hits_each_sample_once() {
    let mut chance = Chance::seeded(1);
    let (w, h) = (29, 19);
    for round in 0..3_000 {
        let centre = match round % 3 {
            0 => (
                128 + 256 * chance.whole(0, w - 1),
                128 + 256 * chance.whole(0, h - 1),
            ),
            1 => (256 * chance.whole(0, w), 256 * chance.whole(0, h)),
            _ => (chance.whole(0, 256 * w), chance.whole(0, 256 * h)),
        };
        let reach = [3, 300, 5_000, GUARD_BAND / 2][round % 4];
        let rim = fan(&mut chance, centre, reach);
        let blades: Vec<[Point; 3]> = (0..8).map(|i| [centre, rim[i], rim[(i + 1) % 8]]).collect();
        for (i, n) in hits(&blades, w, h).into_iter().enumerate() {
            let (x, y) = (i as i32 % w, i as i32 / w);
            assert_eq!(
                n,
                u32::from(inside_outline(&rim, x, y)),
                "sample ({x}, {y}), centre {centre:?}, rim {rim:?}"
            );
        }
    }
}

/// Splits a triangle at grid points inside it, over and over. A point on a border splits that side in two; it lies
/// exactly on the line, so the neighbour need not know.
fn split(chance: &mut Chance, whole: [Point; 3], pieces: usize) -> Vec<[Point; 3]> {
    let mut all = vec![whole];
    while all.len() < pieces {
        let at = chance.whole(0, all.len() as i32 - 1) as usize;
        let [a, b, c] = all.swap_remove(at);
        let (u, v) = (chance.real(0.0, 1.0), chance.real(0.0, 1.0));
        let (u, v) = if u + v > 1.0 {
            (1.0 - u, 1.0 - v)
        } else {
            (u, v)
        };
        let mix = |a: i32, b: i32, c: i32| {
            let (a, b, c) = (f64::from(a), f64::from(b), f64::from(c));
            (a + (b - a) * u + (c - a) * v).round() as i32
        };
        let p = (mix(a.0, b.0, c.0), mix(a.1, b.1, c.1));
        let turn = |a: Point, b: Point| {
            (i64::from(b.0) - i64::from(a.0)) * (i64::from(p.1) - i64::from(a.1))
                - (i64::from(b.1) - i64::from(a.1)) * (i64::from(p.0) - i64::from(a.0))
        };
        let turns = [turn(a, b), turn(b, c), turn(c, a)];
        if turns.iter().all(|&t| t >= 0) || turns.iter().all(|&t| t <= 0) {
            all.extend([[a, b, p], [b, c, p], [c, a, p]]);
        } else {
            all.push([a, b, c]); // Rounded out of the triangle.
        }
    }
    all
}

#[test]
fn splitting_a_triangle_on_the_grid_changes_no_sample() {
    let mut chance = Chance::seeded(2);
    for round in 0..300 {
        let reach = [700, 6_000, 100_000, GUARD_BAND][round % 4];
        let (w, h) = (chance.whole(1, 40), chance.whole(1, 40));
        let mut corner = || (chance.whole(-reach, reach), chance.whole(-reach, reach));
        let whole = [corner(), corner(), corner()];
        let pieces = split(&mut chance, whole, 60);
        assert_eq!(hits(&pieces, w, h), hits(&[whole], w, h), "{whole:?}");
    }
}

#[test]
fn the_outline_oracle_agrees_with_the_triangle_oracle() {
    let mut chance = Chance::seeded(3);
    for _ in 0..500 {
        let mut corner = || (128 * chance.whole(-2, 20), 128 * chance.whole(-2, 20));
        let t = [corner(), corner(), corner()];
        for (i, n) in true_hits(&[t], 9, 9).into_iter().enumerate() {
            assert_eq!(
                n == 1,
                inside_outline(&t, i as i32 % 9, i as i32 / 9),
                "{t:?}"
            );
        }
    }
}
