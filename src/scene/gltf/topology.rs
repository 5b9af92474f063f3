//! Which vertices make a triangle, for each primitive mode (glTF §3.7.2.1).
//!
//! The winding of a strip alternates; the specification turns every second triangle round, so that all keep the
//! winding of the first:
//!
//! ```text
//! strip  1---3---5    0 1 2 | 1 3 2 | 2 3 4 | 3 5 4
//!       /  \/ \ /     (the i-th: i, i + 1 + i % 2, i + 2 - i % 2)
//!      0---2---4
//! fan    1 2 0 | 2 3 0 | 3 4 0
//! ```

use ::gltf::json::mesh::Mode;

/// How many triangles `vertices` make, or why they make none. Points and lines make none, soundly.
pub(super) fn triangle_count(mode: Mode, vertices: usize) -> Result<usize, String> {
    match mode {
        Mode::Triangles if !vertices.is_multiple_of(3) => Err(format!(
            "it draws triangles, but has {vertices} vertices or indices, not a multiple of three"
        )),
        Mode::Triangles => Ok(vertices / 3),
        Mode::TriangleStrip | Mode::TriangleFan if vertices == 1 || vertices == 2 => Err(format!(
            "a strip or fan needs three vertices, but it has {vertices}"
        )),
        Mode::TriangleStrip | Mode::TriangleFan => Ok(vertices.saturating_sub(2)),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Ok(0),
    }
}

/// The corners of triangle `i`, as positions in the list of indices (or vertices).
pub(super) fn corners(mode: Mode, i: usize) -> [usize; 3] {
    match mode {
        Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
        Mode::TriangleFan => [i + 1, i + 2, 0],
        _ => [3 * i, 3 * i + 1, 3 * i + 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_of_a_flat_band_winds_one_way() {
        let vertex = |i: usize| (i as i32 / 2 * 2 + (i as i32 % 2), i as i32 % 2);
        for i in 0..6 {
            let [(ax, ay), (bx, by), (cx, cy)] = corners(Mode::TriangleStrip, i).map(vertex);
            assert!(
                (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) < 0,
                "triangle {i}"
            );
        }
    }

    #[test]
    fn a_fan_of_a_circle_winds_one_way() {
        let vertex = |i: usize| [(0, 0), (4, 0), (3, 3), (0, 4), (-3, 3), (-4, 0)][i];
        for i in 0..4 {
            let [(ax, ay), (bx, by), (cx, cy)] = corners(Mode::TriangleFan, i).map(vertex);
            assert!(
                (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0,
                "triangle {i}"
            );
        }
    }

    #[test]
    fn lists_that_do_not_add_up_are_refused() {
        assert_eq!(triangle_count(Mode::Triangles, 6), Ok(2));
        assert_eq!(triangle_count(Mode::TriangleStrip, 6), Ok(4));
        assert_eq!(triangle_count(Mode::TriangleFan, 0), Ok(0));
        assert!(triangle_count(Mode::Triangles, 7).is_err());
        assert!(triangle_count(Mode::TriangleFan, 2).is_err());
    }
}
