//! Pairs triangles that share an edge, so that two are drawn as one quadrilateral.
//!
//! A pair is worth having if it will nearly always be convex and nearly flat on screen, whatever the view: convex and
//! nearly flat in space. Which pairs come out decides only how much there is to do, never what is hidden: a
//! quadrilateral that is not convex on screen is drawn as its triangles.

use glam::DVec3;

/// Two triangles make a quadrilateral if the cosine between their normals is at least this. With 0.95, and the bend on
/// screen limited likewise ([`antumbra_simd::quad`]), castle takes 3 % more instructions, Sponza 5.
const LEAST_COSINE: f64 = 0.8;

/// Triangles as quadrilaterals `a b c d`: the triangles `a b c` and `a c d`, or one where `c` and `d` are the same. They
/// stand where the first of their triangles stood.
pub fn paired(positions: &[[f32; 3]], triangles: &[[u8; 3]]) -> Vec<[u8; 4]> {
    let points: Vec<DVec3> = positions
        .iter()
        .map(|p| DVec3::from(p.map(f64::from)))
        .collect();
    let mut pairs = candidates(&points, triangles, LEAST_COSINE);
    // The best first; of equals, the first.
    pairs.sort_by(|a, b| b.worth.total_cmp(&a.worth).then(a.of.cmp(&b.of)));
    let mut partner: Vec<Option<(usize, [u8; 4])>> = vec![None; triangles.len()];
    for pair in &pairs {
        let [first, second] = pair.of;
        if partner[first].is_none() && partner[second].is_none() {
            partner[first] = Some((second, pair.quad));
            partner[second] = Some((first, pair.quad));
        }
    }
    let quad = |(index, &[a, b, c]): (usize, &[u8; 3])| match partner[index] {
        None => Some([a, b, c, c]),
        Some((other, quad)) => (index < other).then_some(quad),
    };
    triangles.iter().enumerate().filter_map(quad).collect()
}

/// The pairs of triangles of these quadrilaterals that share an edge, and are not the same one's already: convex, and less bent than a right
/// angle.
pub fn pairs_beside(positions: &[[f32; 3]], quads: &[[u8; 4]]) -> Vec<[u8; 4]> {
    let points: Vec<DVec3> = positions
        .iter()
        .map(|p| DVec3::from(p.map(f64::from)))
        .collect();
    let (mut triangles, mut quad_of) = (Vec::new(), Vec::new());
    for (quad, &[a, b, c, d]) in quads.iter().enumerate() {
        triangles.push([a, b, c]);
        quad_of.push(quad);
        if c != d {
            triangles.push([a, c, d]);
            quad_of.push(quad);
        }
    }
    candidates(&points, &triangles, 0.0)
        .iter()
        .filter(|pair| quad_of[pair.of[0]] != quad_of[pair.of[1]])
        .map(|pair| pair.quad)
        .collect()
}

/// Two triangles that could be one quadrilateral.
struct Pair {
    of: [usize; 2],
    quad: [u8; 4],
    worth: f64,
}

/// All pairs that share an edge, which one runs through forwards and the other backwards, and are flat and convex enough.
fn candidates(points: &[DVec3], triangles: &[[u8; 3]], least_cosine: f64) -> Vec<Pair> {
    let mut edges: Vec<([u8; 2], usize, usize)> = Vec::with_capacity(3 * triangles.len());
    for (index, t) in triangles.iter().enumerate() {
        for corner in 0..3 {
            edges.push(([t[corner], t[(corner + 1) % 3]], index, corner));
        }
    }
    edges.sort_unstable();
    let mut pairs = Vec::new();
    for &([from, to], first, corner) in &edges {
        let start = edges.partition_point(|e| e.0 < [to, from]);
        for &(_, second, other_corner) in edges[start..]
            .iter()
            .take_while(|e| e.0 == [to, from])
            .filter(|e| e.1 > first)
        {
            // The first is `from to b`, the second `to from d`.
            let b = triangles[first][(corner + 2) % 3];
            let d = triangles[second][(other_corner + 2) % 3];
            let quad = [to, b, from, d];
            if let Some(worth) = worth(quad.map(|i| points[usize::from(i)]), least_cosine) {
                pairs.push(Pair {
                    of: [first, second],
                    quad,
                    worth,
                });
            }
        }
    }
    pairs
}

/// How well a quadrilateral `a b c d` does for the triangles `a b c` and `a c d`; none if it is bent or not convex.
fn worth([a, b, c, d]: [DVec3; 4], least_cosine: f64) -> Option<f64> {
    let corners = [(a, b, c), (c, d, a), (b, c, d), (d, a, b)];
    let normals = corners.map(|(p, q, r)| (q - p).cross(r - q));
    let [first, second, ..] = normals;
    let lengths = first.length() * second.length();
    let cosine = first.dot(second) / lengths;
    let along = first + second;
    let least = normals
        .iter()
        .map(|normal| normal.dot(along))
        .fold(f64::INFINITY, f64::min);
    // How far from being a triangle it is: least corner against the area, 1 for a parallelogram.
    let squareness = least / along.length_squared() * 2.0;
    (cosine >= least_cosine && least > 0.0).then_some(squareness)
}
