//! What a mesh covers of its box, seen along one of the box's axes.

use glam::DVec3;

use super::tight_box::TightBox;

/// A face is sampled at so many places along either side: as many as a word has bits.
pub const SAMPLES: usize = u64::BITS as usize;

/// The samples of a face of a box that its mesh covers, in a projection at right angles to the face.
///
/// ```text
/// rows[63] | bit 63 … bit 0 |   bit i of rows[j] is the sample (i + ½, j + ½) of 64 × 64,
///    ⋮     |                |   the rows along the second of the axes that span the face
/// rows[0]  | bit 63 … bit 0 |
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Silhouette {
    rows: [u64; SAMPLES],
}

impl Silhouette {
    /// Of triangles within their box, along its axis `k`; the face is spanned by the axes k + 1 and k + 2 (mod 3). None if the
    /// face has no area.
    pub fn along(k: usize, bounds: &TightBox, triangles: &[[DVec3; 3]]) -> Option<Silhouette> {
        let spanning = [(k + 1) % 3, (k + 2) % 3];
        let size = bounds.size();
        let scales = spanning.map(|axis| SAMPLES as f64 / size[axis]);
        if !scales.iter().all(|scale| scale.is_finite()) {
            return None;
        }
        let mut silhouette = Silhouette { rows: [0; SAMPLES] };
        for corners in triangles {
            silhouette.cover(corners.map(|corner| {
                [0, 1].map(|i| {
                    let axis = spanning[i];
                    (bounds.axes[axis].dot(corner) - bounds.min[axis]) * scales[i]
                })
            }));
        }
        Some(silhouette)
    }

    /// Covers the samples of a triangle, its edges included.
    fn cover(&mut self, [a, b, c]: [[f64; 2]; 3]) {
        let range = |k: usize| {
            let (mut least, mut most) = (a[k], a[k]);
            for at in [b[k], c[k]] {
                least = if at < least { at } else { least };
                most = if at > most { at } else { most };
            }
            let (first, last) = ((least - 0.5).ceil(), (most - 0.5).floor());
            (first.max(0.0) as usize, last.min(SAMPLES as f64 - 1.0))
        };
        let ((first_x, last_x), (first_y, last_y)) = (range(0), range(1));
        if last_x < first_x as f64 || last_y < first_y as f64 {
            return;
        }
        let side = |from: [f64; 2], to: [f64; 2], x: f64, y: f64| {
            (to[0] - from[0]) * (y - from[1]) - (to[1] - from[1]) * (x - from[0])
        };
        for j in first_y..=last_y as usize {
            for i in first_x..=last_x as usize {
                let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
                let sides = [side(a, b, x, y), side(b, c, x, y), side(c, a, x, y)];
                if sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0) {
                    self.rows[j] |= 1 << i;
                }
            }
        }
    }

    /// Which share of the face is covered.
    pub fn share(&self) -> f64 {
        let covered: u32 = self.rows.iter().map(|row| row.count_ones()).sum();
        f64::from(covered) / (SAMPLES * SAMPLES) as f64
    }

    /// Whether all samples of a rectangle and those right around it are covered. It is given in shares of the face: from 0 to 1
    /// along each side.
    pub fn is_covered(&self, x: [f64; 2], y: [f64; 2]) -> bool {
        let range = |[from, to]: [f64; 2]| {
            let first = (from * SAMPLES as f64 - 0.5).floor().max(0.0);
            let last = (to * SAMPLES as f64 - 0.5).ceil().min(SAMPLES as f64 - 1.0);
            (first <= last).then_some([first as usize, last as usize])
        };
        let (Some(x), Some(y)) = (range(x), range(y)) else {
            return false;
        };
        let mask = u64::MAX >> (SAMPLES - 1 - (x[1] - x[0])) << x[0];
        let mut rows = self.rows[y[0]..=y[1]].iter();
        rows.all(|row| row & mask == mask)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall_with_a_window() -> Vec<[DVec3; 3]> {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let rectangles = [
            (0.0, 0.0, 8.0, 1.0),
            (0.0, 3.0, 8.0, 4.0),
            (0.0, 1.0, 2.0, 3.0),
            (6.0, 1.0, 8.0, 3.0),
        ];
        let halves = rectangles.iter().flat_map(|&(x0, y0, x1, y1)| {
            let [a, b, c, d] = [at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)];
            [[a, b, c], [a, c, d]]
        });
        halves.collect()
    }

    #[test]
    fn a_window_is_open_and_the_wall_is_not() {
        let wall = wall_with_a_window();
        let bounds = TightBox::around(&wall).expect("a box");
        let seen = Silhouette::along(2, &bounds, &wall).expect("a face");
        // The window takes 4 × 2 of 8 × 4.
        assert_eq!(seen.share(), 0.75);
        assert!(seen.is_covered([0.0, 1.0], [0.0, 0.24]));
        assert!(seen.is_covered([0.0, 0.24], [0.0, 1.0]));
        assert!(!seen.is_covered([0.0, 1.0], [0.0, 0.3]));
        assert!(!seen.is_covered([0.4, 0.6], [0.4, 0.6]));
        assert!(
            seen.is_covered([0.001, 0.002], [0.1, 0.1]),
            "no sample there"
        );
        assert!(!seen.is_covered([0.501, 0.502], [0.5, 0.5]), "nor there");
        // From its edges there is nothing to see.
        assert_eq!(Silhouette::along(0, &bounds, &wall), None);
        assert_eq!(Silhouette::along(1, &bounds, &wall), None);
    }

    #[test]
    fn either_side_covers() {
        let triangle = [
            DVec3::ZERO,
            DVec3::new(64.0, 0.0, 0.0),
            DVec3::new(0.0, 64.0, 0.0),
        ];
        let [a, b, c] = triangle;
        let bounds = TightBox {
            axes: [DVec3::X, DVec3::Y, DVec3::Z],
            min: [0.0; 3],
            max: [64.0, 64.0, 0.0],
        };
        let front = Silhouette::along(2, &bounds, &[[a, b, c]]);
        assert_eq!(front, Silhouette::along(2, &bounds, &[[c, b, a]]));
        // Half of the samples, and those on its edge.
        assert_eq!(
            front.expect("a face").share(),
            (64.0 * 64.0 + 64.0) / 2.0 / 4096.0
        );
    }
}
