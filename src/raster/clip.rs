//! Clips a triangle in homogeneous screen space: near plane, far plane, and the four sides of the guard band.
//!
//! Sutherland and Hodgman's algorithm, plane after plane. An edge is always cut from its canonical end (the lesser
//! of its two vertices in a total order of their bits), so that two triangles that share the edge get the same point
//! bit for bit, and stay watertight. Cuts *along* a plane are never shared: beyond them there is nothing to draw.

use antumbra_simd::GUARD_BAND;
use antumbra_simd::vertex::{ClipVertex, ScreenTransform, ScreenVertex};

/// A triangle cut by six planes has at most nine corners.
const MOST_CORNERS: usize = 9;

/// A convex polygon in homogeneous screen space.
struct Polygon {
    corners: [ClipVertex; MOST_CORNERS],
    len: usize,
}

impl Polygon {
    fn push(&mut self, v: ClipVertex) {
        // Rounding can make a polygon concave by an ulp and so cut it once too often; the corner lost is no more
        // than that ulp away from its neighbours.
        if self.len < MOST_CORNERS {
            self.corners[self.len] = v;
            self.len += 1;
        }
    }

    fn corners(&self) -> &[ClipVertex] {
        &self.corners[..self.len]
    }
}

fn canonical_order(a: &ClipVertex, b: &ClipVertex) -> bool {
    let key = |v: &ClipVertex| [v.x, v.y, v.depth, v.w];
    key(a)
        .iter()
        .zip(&key(b))
        .map(|(a, b)| a.total_cmp(b))
        .find(|o| o.is_ne())
        .is_none_or(|o| o.is_lt())
}

fn cut(a: ClipVertex, b: ClipVertex, distance: impl Fn(&ClipVertex) -> f64) -> ClipVertex {
    let (p, q) = if canonical_order(&a, &b) {
        (a, b)
    } else {
        (b, a)
    };
    let (dp, dq) = (distance(&p), distance(&q));
    let t = dp / (dp - dq);
    let mix = |p: f64, q: f64| p + (q - p) * t;
    ClipVertex {
        x: mix(p.x, q.x),
        y: mix(p.y, q.y),
        depth: mix(p.depth, q.depth),
        w: mix(p.w, q.w),
    }
}

fn clip(polygon: &mut Polygon, distance: impl Fn(&ClipVertex) -> f64) {
    // Most planes cut nothing off.
    if polygon.corners().iter().all(|v| distance(v) >= 0.0) {
        return;
    }
    let mut out = Polygon { len: 0, ..*polygon };
    let corners = polygon.corners();
    for (i, &b) in corners.iter().enumerate() {
        let a = corners[(i + corners.len() - 1) % corners.len()];
        let (a_in, b_in) = (distance(&a) >= 0.0, distance(&b) >= 0.0);
        if a_in != b_in {
            out.push(cut(a, b, &distance));
        }
        if b_in {
            out.push(b);
        }
    }
    *polygon = out;
}

/// A corner that clipping made, on the guard band's border and the near plane at the farthest: a cut through coordinates
/// whose rounding is wider than the band would otherwise overflow the fixed-point arithmetic, and one at the near plane
/// be nearer by an ulp.
fn within_limits(v: ScreenVertex, t: &ScreenTransform) -> ScreenVertex {
    ScreenVertex {
        x: v.x.clamp(-GUARD_BAND, GUARD_BAND),
        y: v.y.clamp(-GUARD_BAND, GUARD_BAND),
        depth: if v.depth > t.near_depth {
            t.near_depth
        } else {
            v.depth
        },
    }
}

/// Clips a triangle and gives what is left as triangles on the sub-pixel grid, a fan with the triangle's own winding. It begins at the
/// canonical corner, so that it is the same whichever corner the triangle is said to begin with: clusters turn triangles when they
/// pair them, and depths hang on the fan. A triangle with a vertex that is not finite gives none.
pub fn clip_triangle(
    triangle: [ClipVertex; 3],
    t: &ScreenTransform,
    mut emit: impl FnMut([ScreenVertex; 3]),
) {
    let finite = |v: &ClipVertex| [v.x, v.y, v.depth, v.w].iter().all(|c| c.is_finite());
    if !triangle.iter().all(finite) {
        return;
    }
    let band = f64::from(GUARD_BAND);
    let is_first = |i: usize| (0..3).all(|other| canonical_order(&triangle[i], &triangle[other]));
    let first = (0..3).find(|&i| is_first(i)).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|i| triangle[(first + i) % 3]);
    let mut polygon = Polygon {
        corners: [a, b, c, a, a, a, a, a, a],
        len: 3,
    };
    clip(&mut polygon, |v| t.near_depth * v.w - v.depth);
    if t.far_depth > f64::NEG_INFINITY {
        clip(&mut polygon, |v| v.depth - t.far_depth * v.w);
    }
    clip(&mut polygon, |v| band * v.w + v.x);
    clip(&mut polygon, |v| band * v.w - v.x);
    clip(&mut polygon, |v| band * v.w + v.y);
    clip(&mut polygon, |v| band * v.w - v.y);
    // Written so that a NaN ends here: numbers that overflow cut to anything.
    let drawable = |v: &ClipVertex| v.w > 0.0 && finite(v);
    if polygon.len < 3 || !polygon.corners().iter().all(drawable) {
        return;
    }
    let mut snapped = polygon.corners().iter().map(|v| within_limits(v.snap(), t));
    let (Some(first), Some(mut last)) = (snapped.next(), snapped.next()) else {
        return;
    };
    for next in snapped {
        emit([first, last, next]);
        last = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCREEN: ScreenTransform = ScreenTransform {
        x: [0.0; 4],
        y: [0.0; 4],
        depth: [0.0; 4],
        w: [0.0; 4],
        near_depth: 1.0,
        far_depth: f64::NEG_INFINITY,
    };

    fn vertex(x: f64, y: f64, w: f64) -> ClipVertex {
        ClipVertex {
            x: x * 256.0,
            y: y * 256.0,
            depth: 0.5,
            w,
        }
    }

    #[test]
    fn triangles_that_share_a_clipped_edge_share_its_points() {
        // The quad's diagonal crosses the near plane and the guard band, and lies between them within the band.
        let (a, b) = (vertex(-466_000.1, 7.7, -2.3), vertex(900_000.7, 13.3, 5.9));
        let points_of = |triangle| {
            let mut points = Vec::new();
            clip_triangle(triangle, &SCREEN, |t| points.extend(t.map(|v| (v.x, v.y))));
            points
        };
        let left = points_of([a, b, vertex(10.0, 500.0, 3.0)]);
        let right = points_of([b, a, vertex(500.0, -200.0, 2.0)]);
        let shared: Vec<_> = left.iter().filter(|p| right.contains(p)).collect();
        let distinct: std::collections::BTreeSet<_> = shared.into_iter().collect();
        assert_eq!(distinct.len(), 2, "{left:?} {right:?}");
    }

    /// Clusters turn triangles: what is drawn must not hang on it.
    #[test]
    fn a_turned_triangle_gives_the_same_fan() {
        // Two corners behind the eye, or one: three and four corners are left, or more where the guard band cuts too.
        let wide = [(3e5, -2e5, 4.0), (-4e5, 1e5, 1.5), (9e4, 8e5, 2.0)];
        let one_behind = [(5.0, 9.0, 4.0), (40.0, 2.0, -1.5), (9.0, 70.0, 2.0)];
        let mut longest = 0;
        for corners in [wide, one_behind] {
            let [a, b, c] = corners.map(|(x, y, w)| vertex(x, y, w));
            let fan_of = |triangle| {
                let mut fan = Vec::new();
                clip_triangle(triangle, &SCREEN, |t| fan.push(t));
                fan
            };
            let fan = fan_of([a, b, c]);
            longest = longest.max(fan.len());
            assert_eq!(fan, fan_of([b, c, a]));
            assert_eq!(fan, fan_of([c, a, b]));
        }
        assert!(longest > 1, "there is more than one way to draw it");
    }

    #[test]
    fn nothing_behind_the_near_plane_is_left() {
        clip_triangle(
            [
                vertex(0.0, 0.0, 0.1),
                vertex(9.0, 0.0, -1.0),
                vertex(0.0, 9.0, 0.4),
            ],
            &SCREEN,
            |t| {
                panic!("{t:?}");
            },
        );
    }

    #[test]
    fn clipped_vertices_stay_in_the_guard_band_and_behind_the_near_plane() {
        // Beyond about 1e22 the rounding of a cut is wider than the band.
        for size in [1.0, 1e10, 1e18, 1e25, 1e40, 1e300] {
            let mut count = 0;
            clip_triangle(
                [
                    vertex(0.0, 0.0, 1.0),
                    vertex(1e12 * size, 5e11 * size, 3.0),
                    vertex(-3e9 * size, 8e12 * size, -7.0),
                ],
                &SCREEN,
                |t| {
                    count += 1;
                    for v in t {
                        assert!(v.x.abs() <= GUARD_BAND && v.y.abs() <= GUARD_BAND, "{v:?}");
                        assert!(v.depth <= SCREEN.near_depth, "{v:?}");
                    }
                },
            );
            assert!(count > 0 || size > 1e20);
        }
    }

    #[test]
    fn what_overflows_on_the_way_gives_nothing() {
        let large = f64::MAX / 512.0;
        for (x, w) in [(large, 1.0), (1.0, large), (large, large), (-large, large)] {
            let corners = [vertex(x, -x, w), vertex(-x, x, -w), vertex(x, x, w)];
            clip_triangle(corners, &SCREEN, |t| {
                for v in t {
                    assert!(v.x.abs() <= GUARD_BAND && v.y.abs() <= GUARD_BAND, "{v:?}");
                    assert!(v.depth.is_finite() && v.depth <= SCREEN.near_depth, "{v:?}");
                }
            });
        }
    }
}
