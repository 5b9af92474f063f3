//! The triangles of a surface that is drawn elsewhere, for whoever needs their depth at each sample.
//!
//! The final pass writes each triangle's depth by a formula that begins at the triangle's first corner. Which corner that is, is not
//! known here: clusters turn triangles when they pair them. What turning changes is rounding, and is taken off ([`LoweredPlane`]).

use antumbra_simd::TILE_SIZE;
use antumbra_simd::triangle::{CullMode, DepthPlane, Triangle};
use antumbra_simd::vertex::{ClipVertex, ScreenTransform, ScreenVertex, transform};

use super::clip::clip_triangle;
use crate::prepare::ClusterGeometry;
use crate::view::PictureSize;

/// How far two formulas of one plane may lie from each other, as a part of the range of the vertices' depths: twice
/// [`DepthPlane::SLOPE_ERROR`], for the one and for the other.
const TURNING_ERROR: f64 = 2.0 * DepthPlane::SLOPE_ERROR;

/// The same as a part of the depths themselves: twice 2⁻⁵⁰, and the roundings of the difference. Rounding to f32 keeps order.
const ROUNDING_ERROR: f64 = 1.0 / (1_u64 << 48) as f64;

/// Samples of a row of a tile.
const ROW: usize = TILE_SIZE as usize;

/// Triangles that are ready to be drawn.
#[derive(Clone, Debug, Default)]
pub struct SurfaceTriangles {
    triangles: Vec<Triangle>,
    /// The vertices of the cluster that is being added.
    corners: Vec<(ClipVertex, Option<ScreenVertex>)>,
}

/// A plane, and by how much what any formula of it says may be farther than what this one says.
#[derive(Clone, Copy, Debug)]
pub struct LoweredPlane {
    plane: DepthPlane,
    error: f64,
}

impl SurfaceTriangles {
    /// Forgets all triangles.
    pub fn clear(&mut self) {
        self.triangles.clear();
    }

    /// Adds those triangles of a cluster that can cover a sample of the picture.
    pub fn add(
        &mut self,
        cluster: &ClusterGeometry<'_>,
        screen: &ScreenTransform,
        cull: CullMode,
        size: PictureSize,
    ) {
        let set_up = |vertices: [ScreenVertex; 3]| {
            let triangle = Triangle::new(vertices, cull);
            triangle.and_then(|t| t.within(size.width() as i32, size.height() as i32))
        };
        self.corners.clear();
        self.corners.extend((0..cluster.vertex_count).map(|i| {
            let corner = transform(screen, [cluster.x[i], cluster.y[i], cluster.z[i]]);
            let is_inside = corner.is_inside(screen);
            (corner, is_inside.then(|| corner.snap()))
        }));
        for triangle in cluster.triangles() {
            let corners = triangle.map(|i| self.corners[usize::from(i)]);
            if let [(_, Some(a)), (_, Some(b)), (_, Some(c))] = corners {
                self.triangles.extend(set_up([a, b, c]));
            } else {
                let corners = corners.map(|(corner, _)| corner);
                clip_triangle(corners, screen, |vertices| {
                    self.triangles.extend(set_up(vertices));
                });
            }
        }
    }

    /// The triangles.
    pub fn iter(&self) -> impl Iterator<Item = &Triangle> {
        self.triangles.iter()
    }
}

impl LoweredPlane {
    /// That of a triangle.
    pub fn new(plane: DepthPlane) -> LoweredPlane {
        let magnitude = if plane.nearest > -plane.farthest {
            plane.nearest
        } else {
            -plane.farthest
        };
        let range = plane.nearest - plane.farthest;
        LoweredPlane {
            plane,
            error: range * TURNING_ERROR + magnitude * ROUNDING_ERROR,
        }
    }

    /// The nearest that the plane is anywhere.
    pub fn nearest(&self) -> f32 {
        self.plane.nearest as f32
    }

    /// Depths at the samples of a row of a tile, the first of which is in column `x`, that no formula of the plane is farther than.
    #[inline]
    pub fn depths_of_row(&self, x: i32, y: i32) -> [f32; ROW] {
        std::array::from_fn(|column| self.lowered(x + column as i32, y))
    }

    #[inline]
    fn lowered(&self, x: i32, y: i32) -> f32 {
        let p = &self.plane;
        // As `DepthPlane::at` has it, but for the rounding in the end.
        let depth = (p.depth + p.slope_y * (f64::from(y) - p.origin_y))
            + p.slope_x * (f64::from(x) - p.origin_x);
        let depth = if depth > p.nearest { p.nearest } else { depth } - self.error;
        // No formula leaves the range of the vertices' depths. In this order a NaN comes out as the farthest.
        if depth > p.farthest {
            depth as f32
        } else {
            p.farthest as f32
        }
    }
}

#[cfg(test)]
mod tests {
    use antumbra_simd::SUBPIXELS;

    use super::*;

    fn turned(v: [ScreenVertex; 3], turn: usize) -> DepthPlane {
        let v = [0, 1, 2].map(|i| v[(i + turn) % 3]);
        Triangle::new(v, CullMode::None).expect("a triangle").depth
    }

    /// Whichever corner a formula begins at, it is no farther than what any other says here.
    #[test]
    fn turning_a_triangle_changes_no_more_than_is_taken_off() {
        let mut state = 7_u64;
        let mut random = |most: i32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as i32 % most
        };
        let mut differ = 0;
        for round in 0..2_000 {
            let mut at = |reach: i32| [random(2 * reach) - reach, random(2 * reach) - reach];
            let reach = if round % 2 == 0 { 100_000 } else { 4_000_000 };
            let (a, b, mut c) = (at(reach), at(reach), at(reach));
            // Half of them are long and thin: rounding changes most there.
            if round % 2 == 1 {
                let third = |i: usize| a[i] + (b[i] - a[i]) / 3;
                c = [third(0), third(1) + random(3)];
            }
            let v = [a, b, c].map(|[x, y]| ScreenVertex {
                x,
                y,
                depth: 0.5 + f64::from(x) * 3.3e-8 - f64::from(y) * 2.1e-8,
            });
            if Triangle::new(v, CullMode::None).is_none() {
                continue;
            }
            let planes = [0, 1, 2].map(|turn| turned(v, turn));
            let lowered = planes.map(LoweredPlane::new);
            for _ in 0..20 {
                // Beside a corner, where depth is within its bounds.
                let mut near = |v: i32| v / SUBPIXELS + random(9) - 4;
                let (x, y) = (near(c[0]), near(c[1]));
                for (a, lowered) in planes.iter().zip(&lowered) {
                    for b in &planes {
                        let depths = lowered.depths_of_row(x - 3, y);
                        assert!(depths[3] <= b.at(x, y), "{a:?} {b:?} at {x}, {y}");
                        assert!(b.at(x, y) - depths[3] <= 1e-6, "{a:?} {b:?} at {x}, {y}");
                        differ += i32::from(a.at(x, y) != b.at(x, y));
                    }
                }
            }
        }
        assert!(differ > 0, "there is something to take off");
    }
}
