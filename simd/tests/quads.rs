//! A quadrilateral drawn as one is its two triangles: the same samples, and nowhere nearer.

mod chance;

use antumbra_simd::PART_HEIGHT;
use antumbra_simd::coverage::coverage_of_tile;
use antumbra_simd::quad::Quad;
use antumbra_simd::spans::SpanPolygon;
use antumbra_simd::triangle::{CullMode, Triangle};
use antumbra_simd::vertex::ScreenVertex;
use chance::Chance;

const SIZE: i32 = 96;

/// A corner of a quadrilateral on a plane, a little beside it, on the grid or on its half pixels.
fn any_corner(chance: &mut Chance, reach: i32, plane: [f64; 3], bend: f64) -> ScreenVertex {
    let half_pixels = chance.whole(0, 3) == 0;
    let mut coordinate = || {
        let v = chance.whole(-reach, 256 * SIZE + reach);
        if half_pixels { v / 128 * 128 } else { v }
    };
    let (x, y) = (coordinate(), coordinate());
    let depth = plane[0] + plane[1] * f64::from(x) + plane[2] * f64::from(y);
    ScreenVertex {
        x,
        y,
        depth: depth + chance.real(-bend, bend),
    }
}

#[test]
fn covers_the_samples_of_its_triangles_and_is_nowhere_nearer() {
    let mut chance = Chance(11);
    let (mut whole, mut apart, mut samples) = (0, 0, 0_u64);
    for round in 0..60_000 {
        let reach = [0, 3_000, 1 << 22][round % 3];
        let plane = [
            chance.real(0.2, 1.0),
            chance.real(-1e-5, 1e-5),
            chance.real(-1e-5, 1e-5),
        ];
        let bend = [0.0, 1e-6, 1e-2][chance.whole(0, 2) as usize];
        let mut corners = [(); 4].map(|()| any_corner(&mut chance, reach, plane, bend));
        if chance.whole(0, 9) == 0 {
            // Slender: along one line but for a little.
            for v in &mut corners {
                v.y = v.x / 3 + chance.whole(-2, 2);
            }
        }
        let [a, b, c, d] = corners;
        let cull = [CullMode::None, CullMode::Back, CullMode::Front][chance.whole(0, 2) as usize];
        let triangles: Vec<Triangle> = [[a, b, c], [a, c, d]]
            .into_iter()
            .filter_map(|t| Triangle::new(t, cull)?.within(SIZE, SIZE))
            .collect();
        let polygon = match Quad::new(corners, cull, SIZE, SIZE, 0) {
            Quad::Apart => {
                apart += 1;
                continue;
            }
            Quad::Nothing => {
                let covers = |t: &Triangle| {
                    (0..SIZE / 8).any(|y| (0..SIZE / 8).any(|x| coverage_of_tile(t, x, y) != 0))
                };
                assert!(!triangles.iter().any(covers), "{corners:?}");
                continue;
            }
            Quad::Whole(polygon) => polygon,
        };
        whole += 1;
        for (y, x) in (0..SIZE / 8).flat_map(|y| (0..SIZE / 8).map(move |x| (y, x))) {
            let masks: Vec<u64> = triangles
                .iter()
                .map(|t| coverage_of_tile(t, x, y))
                .collect();
            let exact = masks.iter().fold(0, |all, mask| all | mask);
            assert_eq!(polygon.coverage_of_tile(x, y), exact, "{corners:?}");
            for (triangle, mask) in triangles.iter().zip(masks) {
                for bit in (0..64).filter(|bit| mask >> bit & 1 == 1) {
                    let (column, row) = (8 * x + bit % 8, 8 * y + bit / 8);
                    let depth = part_depth(&polygon, x, row);
                    assert!(depth <= triangle.depth.at(column, row), "{corners:?}");
                    samples += 1;
                }
            }
        }
    }
    assert!(
        whole > 5_000 && apart > 5_000 && samples > 1_000_000,
        "{whole} {apart} {samples}"
    );
}

/// What a polygon leaves in the part of a column of tiles that a row belongs to.
fn part_depth(polygon: &SpanPolygon, tile_x: i32, row: i32) -> f32 {
    let first = row / PART_HEIGHT * PART_HEIGHT;
    let last = first + PART_HEIGHT - 1;
    let rows = [first.max(polygon.y[0]), last.min(polygon.y[1])];
    polygon.depth.over(tile_x, rows)
}

/// Flat, a quadrilateral is as near as its triangles, but for what rounding may be off.
#[test]
fn a_flat_one_loses_next_to_nothing() {
    let vertex = |x: i32, y: i32| ScreenVertex {
        x: 256 * x,
        y: 256 * y,
        depth: 0.25 + f64::from(x) / 512.0 + f64::from(y) / 4096.0,
    };
    let corners = [vertex(3, 5), vertex(61, 9), vertex(70, 50), vertex(1, 64)];
    let Quad::Whole(polygon) = Quad::new(corners, CullMode::None, SIZE, SIZE, 0) else {
        panic!("it is flat and convex");
    };
    let [a, b, c, _] = corners;
    let triangle = Triangle::new([a, b, c], CullMode::None).expect("it has an area");
    for (tile_x, row) in [(2, 12), (4, 20), (6, 36)] {
        // The farthest sample of the part is its upper left one.
        let farthest = triangle.depth.at(8 * tile_x, row);
        let lost = farthest - part_depth(&polygon, tile_x, row);
        assert!((0.0..1e-5).contains(&lost), "{lost}");
    }
}
