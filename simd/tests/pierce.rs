//! The ray through a sample meets what would be drawn there.

mod chance;

use antumbra_simd::Level;
use antumbra_simd::assemble::{Cluster, VERTEX_PADDING};
use antumbra_simd::coverage::coverage_of_tile;
use antumbra_simd::pierce::{PierceMemory, pierce};
use antumbra_simd::triangle::{CullMode, Triangle};
use antumbra_simd::vertex::{ScreenTransform, transform};
use chance::Chance;

const SIZE: i32 = 64;

/// The nearest depth that is drawn at a sample, as triangles on the grid have it.
fn drawn_at(
    cluster: Cluster<'_>,
    t: &ScreenTransform,
    cull: CullMode,
    [x, y]: [i32; 2],
) -> Option<f64> {
    let vertex = |i: u8| {
        let i = usize::from(i);
        transform(t, [cluster.x[i], cluster.y[i], cluster.z[i]])
    };
    let triangles = cluster
        .quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let depths = triangles.filter_map(|corners| {
        let corners = corners.map(vertex);
        let inside = corners.iter().all(|v| v.is_inside(t));
        let triangle = inside.then(|| corners.map(|v| v.snap()))?;
        let triangle = Triangle::new(triangle, cull)?.within(SIZE, SIZE)?;
        let mask = coverage_of_tile(&triangle, x / 8, y / 8);
        (mask >> (y % 8 * 8 + x % 8) & 1 == 1).then(|| f64::from(triangle.depth.at(x, y)))
    });
    depths.fold(None, |most, depth| {
        Some(most.map_or(depth, |m: f64| m.max(depth)))
    })
}

#[test]
fn a_ray_meets_what_is_drawn() {
    let mut chance = Chance(5);
    let mut memory = PierceMemory::default();
    let (mut alike, mut different, mut met) = (0, 0, 0);
    for round in 0..300 {
        let reach = [0.3, 1.0, 4.0][round % 3];
        let count = chance.whole(4, 100) as usize;
        let mut axis = |from: f64, to: f64| {
            let mut values: Vec<f32> = (0..count).map(|_| chance.real(from, to) as f32).collect();
            values.resize(count.next_multiple_of(VERTEX_PADDING), values[count - 1]);
            values
        };
        let (x, y, z) = (axis(-reach, reach), axis(-reach, reach), axis(1.5, 9.0));
        let mut index = || chance.whole(0, count as i32 - 1) as u8;
        let quads: Vec<[u8; 4]> = (0..20)
            .map(|i| {
                let [a, b, c, d] = std::array::from_fn(|_| index());
                [a, b, c, if i % 2 == 0 { c } else { d }]
            })
            .collect();
        let screen = ScreenTransform {
            x: [256.0 * 64.0, 0.0, 256.0 * 32.0, 0.0],
            y: [0.0, 256.0 * 64.0, 256.0 * 32.0, 0.0],
            depth: [0.0, 0.0, 0.0, 1.0],
            w: [0.0, 0.0, 1.0, 0.0],
            near_depth: 1.0,
            far_depth: f64::NEG_INFINITY,
        };
        let cull = [CullMode::None, CullMode::Back, CullMode::Front][round / 3 % 3];
        let cluster = Cluster {
            x: &x,
            y: &y,
            z: &z,
            vertices: count,
            quads: &quads,
        };
        for _ in 0..20 {
            let sample = [0, 1].map(|_| chance.whole(0, SIZE - 1));
            let depth = pierce(Level::Scalar, cluster, &screen, cull, sample, &mut memory);
            for &level in Level::available() {
                assert_eq!(
                    pierce(level, cluster, &screen, cull, sample, &mut memory),
                    depth,
                    "{level}"
                );
            }
            met += usize::from(depth.is_some());
            let is_alike = match (depth, drawn_at(cluster, &screen, cull, sample)) {
                (Some(ray), Some(drawn)) => (ray - drawn).abs() < 0.02 * drawn,
                (ray, drawn) => ray.is_none() && drawn.is_none(),
            };
            *(if is_alike { &mut alike } else { &mut different }) += 1;
        }
    }
    assert!(
        met > 1_000 && different * 100 < alike,
        "{met} {alike} {different}"
    );
}

/// Parts of a polygon behind the eye are not seen, those before it are.
#[test]
fn a_ray_meets_what_reaches_behind_the_eye() {
    let pad = |v: [f32; 4]| {
        let mut padded = v.to_vec();
        padded.resize(VERTEX_PADDING, v[3]);
        padded
    };
    // A floor from behind the eye to far ahead, one unit below.
    let (x, y, z) = (
        pad([-5.0, 5.0, 5.0, -5.0]),
        pad([1.0; 4]),
        pad([-9.0, -9.0, 50.0, 50.0]),
    );
    let quads = [[0, 1, 2, 3]];
    let cluster = Cluster {
        x: &x,
        y: &y,
        z: &z,
        vertices: 4,
        quads: &quads,
    };
    let screen = ScreenTransform {
        x: [256.0 * 64.0, 0.0, 256.0 * 32.0, 0.0],
        y: [0.0, 256.0 * 64.0, 256.0 * 32.0, 0.0],
        depth: [0.0, 0.0, 0.0, 0.1],
        w: [0.0, 0.0, 1.0, 0.0],
        near_depth: 1.0,
        far_depth: f64::NEG_INFINITY,
    };
    let at = |cull, row| {
        let mut memory = PierceMemory::default();
        pierce(
            Level::Scalar,
            cluster,
            &screen,
            cull,
            [32, row],
            &mut memory,
        )
    };
    // Half a picture below the middle it is two units ahead.
    let depth = at(CullMode::None, 63).expect("the floor");
    assert!((depth - 0.1 / (64.0 / 31.5)).abs() < 1e-3, "{depth}");
    assert_eq!(at(CullMode::None, 20), None);
    let sides = [CullMode::Back, CullMode::Front].map(|cull| at(cull, 63).is_some());
    assert_ne!(sides[0], sides[1]);
}
