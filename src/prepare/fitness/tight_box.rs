//! A tight box around a mesh, turned as the mesh wants it.
//!
//! The box along a mesh's own axes is loose where these mean nothing: a diagonal wall that was exported in world coordinates fills
//! next to nothing of it. The least box of all is expensive to find. So three are tried, and the one with the least surface is
//! taken: along the mesh's axes, along the principal axes of its surface, and along its largest triangle (which finds what is
//! boxy where the principal axes are undecided: a square column).

use glam::{DAffine3, DVec3};

/// Another box has to have so much less surface before the mesh's own axes are given up.
const CLEARLY_SMALLER: f64 = 0.99;

/// After so many rotations of each pair of axes, nothing is left to rotate: the method converges quadratically.
const SWEEPS: usize = 8;

/// A box with three axes at right angles, local units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TightBox {
    /// Unit vectors.
    pub axes: [DVec3; 3],
    /// The least coordinates along the axes.
    pub min: [f64; 3],
    /// The largest coordinates along the axes.
    pub max: [f64; 3],
}

impl TightBox {
    /// Around triangles, given by their corners; none around nothing.
    pub fn around(triangles: &[[DVec3; 3]]) -> Option<TightBox> {
        let own = TightBox::along([DVec3::X, DVec3::Y, DVec3::Z], triangles)?;
        let others = [principal_axes(triangles), axes_of_largest(triangles)];
        let others = others.into_iter().flatten();
        let boxes = others.filter_map(|axes| TightBox::along(axes, triangles));
        Some(boxes.fold(own, |least, other| {
            if other.half_area() < CLEARLY_SMALLER * least.half_area() {
                other
            } else {
                least
            }
        }))
    }

    fn along(axes: [DVec3; 3], triangles: &[[DVec3; 3]]) -> Option<TightBox> {
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &corner in triangles.iter().flatten() {
            for (k, axis) in axes.iter().enumerate() {
                let at = axis.dot(corner);
                min[k] = if at < min[k] { at } else { min[k] };
                max[k] = if at > max[k] { at } else { max[k] };
            }
        }
        (min[0] <= max[0]).then_some(TightBox { axes, min, max })
    }

    /// How far it reaches along its axes.
    pub fn size(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.max[k] - self.min[k])
    }

    /// A unit vector across the largest face, where the box is placed in the world; zero if none has an area.
    pub fn across_largest_face(&self, world_from_local: &DAffine3) -> DVec3 {
        let size = self.size();
        let [x, y, z] =
            std::array::from_fn(|k| world_from_local.matrix3 * (self.axes[k] * size[k]));
        let across = [y.cross(z), z.cross(x), x.cross(y)];
        let largest = across.into_iter().fold(DVec3::ZERO, |largest, other| {
            if other.length_squared() > largest.length_squared() {
                other
            } else {
                largest
            }
        });
        let length = largest.length();
        if length > 0.0 && length.is_finite() {
            largest / length
        } else {
            DVec3::ZERO
        }
    }

    fn half_area(&self) -> f64 {
        let [x, y, z] = self.size();
        x * y + y * z + z * x
    }
}

/// The axes of what is gathered along two directions; none if these tell no plane.
fn axes_from(first: DVec3, across: DVec3) -> Option<[DVec3; 3]> {
    let unit = |v: DVec3| {
        let length = v.length();
        (length > 0.0 && length.is_finite()).then(|| v / length)
    };
    let (first, across) = (unit(first)?, unit(across)?);
    Some([first, across, first.cross(across)])
}

/// Along the second longest edge of the triangle with the largest area, and across it. Of the half of a rectangle, that is one of
/// the rectangle's sides.
fn axes_of_largest(triangles: &[[DVec3; 3]]) -> Option<[DVec3; 3]> {
    let across = |&[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a);
    let mut largest = triangles.first()?;
    for triangle in triangles {
        if across(triangle).length_squared() > across(largest).length_squared() {
            largest = triangle;
        }
    }
    let [a, b, c] = *largest;
    let mut edges = [b - a, c - b, a - c];
    edges.sort_by(|e, f| e.length_squared().total_cmp(&f.length_squared()));
    axes_from(edges[1], across(largest))
}

/// The eigenvectors of the covariance of all points of the triangles (C. G. J. Jacobi's rotations).
fn principal_axes(triangles: &[[DVec3; 3]]) -> Option<[DVec3; 3]> {
    // Counted from a point of the mesh, so that a mesh far from its origin loses no digits.
    let base = triangles.first()?[0];
    let (mut area, mut sum) = (0.0, DVec3::ZERO);
    let mut products = [[0.0; 3]; 3];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| corner - base);
        let twice = (b - a).cross(c - a).length();
        let middle = a + b + c;
        area += twice;
        sum += middle * twice;
        for i in 0..3 {
            for j in 0..3 {
                let of_corners = a[i] * a[j] + b[i] * b[j] + c[i] * c[j];
                products[i][j] += twice * (middle[i] * middle[j] + of_corners);
            }
        }
    }
    if area <= 0.0 || !area.is_finite() {
        return None;
    }
    let mean = sum / (3.0 * area);
    let mut matrix: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| products[i][j] / (12.0 * area) - mean[i] * mean[j])
    });
    let mut axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for _ in 0..SWEEPS {
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut matrix, &mut axes, i, j);
        }
    }
    axes_from(axes[0], axes[1])
}

/// Turns axes `i` and `j` so that they do not vary together any more.
fn rotate(matrix: &mut [[f64; 3]; 3], axes: &mut [DVec3; 3], i: usize, j: usize) {
    let off = matrix[i][j];
    if off == 0.0 {
        return;
    }
    let theta = (matrix[j][j] - matrix[i][i]) / (2.0 * off);
    let root = (theta * theta + 1.0).sqrt();
    let tangent = if theta < 0.0 {
        -1.0 / (root - theta)
    } else {
        1.0 / (root + theta)
    };
    if !tangent.is_finite() {
        return;
    }
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    for row in matrix.iter_mut() {
        let (a, b) = (row[i], row[j]);
        (row[i], row[j]) = (cosine * a - sine * b, sine * a + cosine * b);
    }
    let (a, b) = (matrix[i], matrix[j]);
    matrix[i] = std::array::from_fn(|k| cosine * a[k] - sine * b[k]);
    matrix[j] = std::array::from_fn(|k| sine * a[k] + cosine * b[k]);
    let (a, b) = (axes[i], axes[j]);
    axes[i] = a * cosine - b * sine;
    axes[j] = a * sine + b * cosine;
}

#[cfg(test)]
mod tests {
    use super::super::tests::BOX_FACES;
    use super::*;

    /// The faces of a box along some axes.
    fn block(axes: [DVec3; 3], center: DVec3, half: [f64; 3]) -> Vec<[DVec3; 3]> {
        let corner = |i: usize| {
            let sign = |k: usize| if i >> k & 1 == 1 { half[k] } else { -half[k] };
            center + axes[0] * sign(0) + axes[1] * sign(1) + axes[2] * sign(2)
        };
        let halves = BOX_FACES
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        halves.map(|corners| corners.map(corner)).collect()
    }

    fn turned() -> [DVec3; 3] {
        let x = DVec3::new(3.0, 1.0, 2.0).normalize();
        let y = x.cross(DVec3::Y).normalize();
        [x, y, x.cross(y)]
    }

    fn sorted(mut size: [f64; 3]) -> [f64; 3] {
        size.sort_by(f64::total_cmp);
        size
    }

    #[test]
    fn a_turned_box_has_its_own_box() {
        let place = DVec3::new(900.0, -50.0, 7.0);
        // The second is square across, so that its principal axes are any.
        for half in [[3.0, 2.0, 0.25], [5.0, 0.5, 0.5]] {
            let found = TightBox::around(&block(turned(), place, half)).expect("a box");
            let (found, true_size) = (sorted(found.size()), sorted(half.map(|h| 2.0 * h)));
            for (a, b) in found.iter().zip(true_size) {
                assert!((a - b).abs() < 1e-9, "{found:?} instead of {true_size:?}");
            }
        }
    }

    #[test]
    fn a_box_along_the_axes_keeps_them() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        for half in [[1.0; 3], [4.0, 2.0, 1.0], [1.0, 0.0, 1.0]] {
            let found = TightBox::around(&block(axes, DVec3::ONE, half)).expect("a box");
            assert_eq!(found.axes, axes);
            assert_eq!(found.size(), half.map(|h| 2.0 * h));
        }
    }

    #[test]
    fn the_largest_face_is_found_where_the_box_stands() {
        let found = TightBox::around(&block(turned(), DVec3::ZERO, [3.0, 2.0, 0.25]));
        let found = found.expect("a box");
        let across = found.across_largest_face(&DAffine3::IDENTITY);
        assert!((across.dot(turned()[2]).abs() - 1.0).abs() < 1e-9);
        // Eight times as thick, and the largest face is another one.
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let upright = TightBox::around(&block(axes, DVec3::ZERO, [3.0, 2.0, 0.25]));
        let thick = DAffine3::from_scale(DVec3::new(1.0, 1.0, 16.0));
        assert_eq!(
            upright.expect("a box").across_largest_face(&thick).abs(),
            DVec3::Y
        );
    }

    #[test]
    fn what_has_no_area_has_a_box() {
        assert_eq!(TightBox::around(&[]), None);
        let needle = [DVec3::ZERO, DVec3::ONE, DVec3::ONE * 2.0];
        let found = TightBox::around(&[needle]).expect("a box");
        assert!(found.size().iter().all(|size| size.is_finite()));
    }
}
