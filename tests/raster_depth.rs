//! Depths of samples and of tile parts, against exact rational numbers and a depth buffer with one depth a pixel.

mod oracle;

use antumbra::raster::{TileBuffer, for_each_sample};
use antumbra::view::PictureSize;
use antumbra_simd::coverage::PART_MASKS;
use antumbra_simd::spans::SpanPolygon;
use antumbra_simd::tile::UNCOVERED;
use antumbra_simd::triangle::{CullMode, DepthPlane, Triangle};
use antumbra_simd::vertex::ScreenVertex;
use antumbra_simd::{GUARD_BAND, PART_HEIGHT, TILE_SIZE};
use num_rational::BigRational;
use oracle::{Chance, cases, vertex};
use proptest::prelude::*;

fn exact(v: f64) -> BigRational {
    BigRational::from_float(v).unwrap()
}

fn whole(v: i64) -> BigRational {
    BigRational::from_integer(v.into())
}

/// Depths of perspective views (0 to 1, mostly far away) and of orthographic ones, with ties and next neighbours.
fn depth() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => 0.0..1.0,
        1 => 1e-7..2e-7,
        1 => -1e6..1e6,
        1 => (0..4_i32).prop_map(|i| 0.25 + f64::from(i) * f64::EPSILON),
        1 => (0..4_i32).prop_map(|i| 0.25 + f64::from(i) * f64::from(f32::EPSILON) / 8.0),
        1 => Just(1.0),
    ]
}

fn corner() -> impl Strategy<Value = ScreenVertex> {
    let place = prop_oneof![
        6 => (-500..6_000_i32, -500..6_000_i32),
        2 => ((-3..24_i32).prop_map(|i| 128 * i), (-3..24_i32).prop_map(|i| 128 * i)),
        1 => (-GUARD_BAND..=GUARD_BAND, -GUARD_BAND..=GUARD_BAND),
    ];
    (place, depth()).prop_map(|(p, d)| vertex(p, d))
}

/// Any triangle, or a sliver: its third corner a few sub-pixels off the line between the others.
fn corners() -> impl Strategy<Value = [ScreenVertex; 3]> {
    let sliver = (
        corner(),
        corner(),
        0..=64_i64,
        -2..=2_i32,
        -2..=2_i32,
        depth(),
    )
        .prop_map(|(a, b, at, x, y, depth)| {
            let between = |a: i32, b: i32, off: i32| {
                let on_line = (i64::from(a) + (i64::from(b) - i64::from(a)) * at / 64) as i32;
                (on_line + off).clamp(-GUARD_BAND, GUARD_BAND)
            };
            [
                a,
                b,
                vertex((between(a.x, b.x, x), between(a.y, b.y, y)), depth),
            ]
        });
    prop_oneof![[corner(), corner(), corner()], sliver]
}

const SIZE: (i32, i32) = (23, 21);

fn set_up(corners: [ScreenVertex; 3]) -> Option<Triangle> {
    Triangle::new(corners, CullMode::None).and_then(|t| t.within(SIZE.0, SIZE.1))
}

fn samples(t: &Triangle) -> Vec<(i32, i32, f32)> {
    let mut samples = Vec::new();
    for_each_sample(t, 0..SIZE.1, |x, y, depth| samples.push((x, y, depth)));
    samples
}

fn range(corners: &[ScreenVertex; 3]) -> [f64; 2] {
    let depths = corners.map(|v| v.depth);
    [
        depths.iter().copied().fold(f64::INFINITY, f64::min),
        depths.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]
}

proptest! {
    #![proptest_config(cases(6_000))]

    #[test]
    fn no_sample_is_nearer_or_farther_than_the_vertices(corners in corners()) {
        let [farthest, nearest] = range(&corners);
        for (x, y, depth) in set_up(corners).iter().flat_map(samples) {
            prop_assert!(farthest as f32 <= depth && depth <= nearest as f32, "({}, {}): {}", x, y, depth);
        }
    }

    #[test]
    fn a_tile_part_is_nowhere_nearer_than_its_samples(corners in corners()) {
        if let Some(t) = set_up(corners) {
            prop_assert_eq!(nearer_than_a_sample(&t), None);
        }
    }
}

/// A sample that is farther than what the triangle leaves in its tile part, if there is one.
fn nearer_than_a_sample(t: &Triangle) -> Option<(i32, i32, f32)> {
    let part_depth = SpanPolygon::of_triangle(t, 0).depth;
    samples(t).into_iter().find(|&(x, y, depth)| {
        let first = y / PART_HEIGHT * PART_HEIGHT;
        let rows = [first.max(t.y[0]), (first + PART_HEIGHT - 1).min(t.y[1])];
        let bound = part_depth.over(x / TILE_SIZE, rows);
        !(part_depth.farthest <= bound && bound <= depth)
    })
}

proptest! {
    #![proptest_config(cases(1_500))]

    /// The bound that the docs of [`DepthPlane`] derive, and one rounding to f32. A sliver may be off by its whole range,
    /// by nothing more, and is never too near.
    #[test]
    fn a_depth_is_within_a_bound_of_the_exact_plane(corners in corners()) {
        let Some(t) = set_up(corners) else { return Ok(()) };
        let covered = samples(&t);
        let [a, b, c] = corners;
        let cross = |a: (i64, i64), b: (i64, i64), p: (i64, i64)| {
            (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)
        };
        let place = |v: ScreenVertex| (i64::from(v.x), i64::from(v.y));
        let (pa, pb, pc) = (place(a), place(b), place(c));
        let area = cross(pa, pb, pc);
        let span = |p: i64, q: i64, r: i64| p.max(q).max(r) - p.min(q).min(r);
        let (width, height) = (span(pa.0, pb.0, pc.0), span(pa.1, pb.1, pc.1));
        let [farthest, nearest] = range(&corners);
        let largest = farthest.abs().max(nearest.abs());
        let range = exact(nearest) - exact(farthest);
        let is_sliver = width as f64 * height as f64 > 16_777_216.0 * area.abs() as f64;
        let slope_error = exact(DepthPlane::SLOPE_ERROR) * range.clone();
        let slack = exact(largest * (2_f64.powi(-24) + 2_f64.powi(-50)) + 2_f64.powi(-150));
        let bound = if is_sliver { range } else { slope_error } + slack.clone();
        for (x, y, depth) in covered.into_iter().step_by(7) {
            let p = (256 * i64::from(x) + 128, 256 * i64::from(y) + 128);
            let plane = exact(a.depth) * whole(cross(pb, pc, p))
                + exact(b.depth) * whole(cross(pc, pa, p))
                + exact(c.depth) * whole(cross(pa, pb, p));
            let error = plane / whole(area) - exact(f64::from(depth));
            prop_assert!(!is_sliver || error >= -slack.clone(), "({}, {}): {} is too near", x, y, depth);
            let error = if error < whole(0) { -error } else { error };
            prop_assert!(error <= bound, "({}, {}): {} off by {}", x, y, depth, error);
        }
    }
}

/// A depth buffer with one depth a pixel, strictly nearer replaces.
fn depth_of_each_pixel(triangles: &[Triangle], size: PictureSize) -> Vec<Option<f32>> {
    let mut pixels = vec![None; size.width() * size.height()];
    for t in triangles {
        for_each_sample(t, 0..size.height() as i32, |x, y, depth| {
            let pixel: &mut Option<f32> = &mut pixels[y as usize * size.width() + x as usize];
            if pixel.is_none_or(|old| depth > old) {
                *pixel = Some(depth);
            }
        });
    }
    pixels
}

/// The farthest of the nearest depths over a part's covered pixels, and whether all its pixels are covered.
fn truth_of_part(
    pixels: &[Option<f32>],
    size: PictureSize,
    tile: usize,
    part: usize,
) -> Option<f32> {
    let (tile_x, tile_y) = (tile % size.tiles_across(), tile / size.tiles_across());
    (0..64)
        .filter(|bit| PART_MASKS[part] >> bit & 1 == 1)
        .map(|bit| (8 * tile_x + bit % 8, 8 * tile_y + bit / 8))
        .filter(|&(x, y)| x < size.width() && y < size.height())
        .filter_map(|(x, y)| pixels[y * size.width() + x])
        .reduce(f32::min)
}

fn check_tiles(tiles: &TileBuffer, pixels: &[Option<f32>]) {
    let size = tiles.size();
    for (tile, (&coverage, depths)) in tiles.coverage().iter().zip(tiles.depths()).enumerate() {
        let (tile_x, tile_y) = (tile % size.tiles_across(), tile / size.tiles_across());
        for bit in 0..64 {
            let (x, y) = (8 * tile_x + bit % 8, 8 * tile_y + bit / 8);
            let inside = x < size.width() && y < size.height();
            let drawn = inside && pixels[y * size.width() + x].is_some();
            assert_eq!(coverage >> bit & 1 == 1, drawn, "pixel ({x}, {y})");
        }
        for (part, &depth) in depths.iter().enumerate() {
            match truth_of_part(pixels, size, tile, part) {
                Some(truth) => assert!(
                    depth <= truth,
                    "tile {tile}, part {part}: {depth} > {truth}"
                ),
                None => assert_eq!(depth, UNCOVERED),
            }
        }
    }
}

#[test]
fn a_part_is_never_nearer_than_the_nearest_occluder_at_any_of_its_pixels() {
    let mut chance = Chance::seeded(21);
    for round in 0..400 {
        let (w, h) = (chance.whole(1, 70), chance.whole(1, 50));
        let size = PictureSize::new(w as u32, h as u32).unwrap();
        let reach = [200, 2_000, 20_000][round % 3];
        let mut triangles = Vec::new();
        for _ in 0..chance.whole(1, 120) {
            let middle = (chance.whole(0, 256 * w), chance.whole(0, 256 * h));
            let base = chance.real(0.0, 1.0);
            let slope = [0.0, 1e-9, 0.05, 1.0][chance.whole(0, 3) as usize];
            let corner = |chance: &mut Chance| {
                let at = (
                    middle.0 + chance.whole(-reach, reach),
                    middle.1 + chance.whole(-reach, reach),
                );
                vertex(at, (base + chance.real(-slope, slope)).clamp(1e-6, 1.0))
            };
            let corners = std::array::from_fn(|_| corner(&mut chance));
            triangles.extend(Triangle::new(corners, CullMode::None).and_then(|t| t.within(w, h)));
        }
        let mut tiles = TileBuffer::new(size);
        tiles.fill(&triangles);
        check_tiles(&tiles, &depth_of_each_pixel(&triangles, size));
    }
}

/// Where every triangle covers the whole part and no two overlap in depth, nothing is lost but a rounding, in any order.
#[test]
fn a_part_is_as_near_as_its_samples_where_triangles_cover_it_one_behind_the_other() {
    let mut chance = Chance::seeded(22);
    let size = PictureSize::new(24, 16).unwrap();
    for round in 0..300 {
        let layers = chance.whole(1, 8);
        let mut triangles: Vec<Triangle> = (0..layers)
            .map(|layer| {
                let base = f64::from(layer + 1) / 10.0;
                let mut depth = || base + chance.real(0.0, 0.09);
                let large = [(-9_000, -9_000), (70_000, -9_000), (-9_000, 70_000)];
                let corners = large.map(|p| vertex(p, depth()));
                Triangle::new(corners, CullMode::None)
                    .unwrap()
                    .within(24, 16)
                    .unwrap()
            })
            .collect();
        match round % 3 {
            0 => triangles.reverse(), // Front to back.
            1 => {}
            _ => {
                for i in (1..triangles.len()).rev() {
                    triangles.swap(i, chance.whole(0, i as i32) as usize);
                }
            }
        }
        let mut tiles = TileBuffer::new(size);
        tiles.fill(&triangles);
        let pixels = depth_of_each_pixel(&triangles, size);
        for (tile, depths) in tiles.depths().iter().enumerate() {
            for (part, &depth) in depths.iter().enumerate() {
                let truth = truth_of_part(&pixels, size, tile, part).expect("it is covered");
                assert!(
                    (0.0..1e-5).contains(&(truth - depth)),
                    "{depth}, not {truth}"
                );
            }
        }
    }
}

/// Depths as an orthographic view of a universe might give them; slopes overflow, and nothing comes out that is not a
/// depth between the vertices.
#[test]
fn enormous_depths_stay_between_their_vertices_and_keep_their_order() {
    let mut chance = Chance::seeded(23);
    for round in 0..20_000 {
        let scale = [1e30, 1e100, 1e300, f64::MAX][round % 4];
        let corners: [ScreenVertex; 3] = std::array::from_fn(|_| {
            let at = (chance.whole(-500, 6_000), chance.whole(-500, 6_000));
            let depth = match chance.whole(0, 3) {
                0 => 0.0,
                1 => -scale,
                _ => -scale * chance.real(0.0, 1.0),
            };
            vertex(at, depth)
        });
        let Some(t) = set_up(corners) else { continue };
        let [farthest, nearest] = range(&corners);
        for (x, y, depth) in samples(&t) {
            assert!(
                farthest as f32 <= depth && depth <= nearest as f32,
                "{corners:?} at ({x}, {y}): {depth}"
            );
        }
        assert_eq!(nearer_than_a_sample(&t), None, "{corners:?}");
    }
}

/// Depths that f32 holds in few steps, or none: as of near planes of 10⁻³⁰, or of worlds larger than any.
#[test]
fn depths_too_small_for_f32_stay_nowhere_nearer_than_their_samples() {
    let mut chance = Chance::seeded(24);
    let size = PictureSize::new(SIZE.0 as u32, SIZE.1 as u32).unwrap();
    for round in 0..6_000 {
        let scale = [1e-44, 1e-42, 1e-38, 1e-46][round % 4];
        let triangles: Vec<Triangle> = (0..3)
            .filter_map(|_| {
                set_up(std::array::from_fn(|_| {
                    let at = (chance.whole(-500, 6_000), chance.whole(-500, 6_000));
                    vertex(at, scale * chance.real(0.0, 3.0))
                }))
            })
            .collect();
        for t in &triangles {
            assert_eq!(nearer_than_a_sample(t), None, "{t:?}");
        }
        let mut tiles = TileBuffer::new(size);
        tiles.fill(&triangles);
        check_tiles(&tiles, &depth_of_each_pixel(&triangles, size));
    }
}
