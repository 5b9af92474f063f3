//! What it takes to draw a set of triangles, summed up triangle by triangle.

use glam::DVec3;

use super::local_box::LocalBox;
use super::position_set::PositionSet;

/// A triangle as cuts see it.
pub(super) struct Piece {
    bounds: LocalBox,
    /// Unit normal; zero for a triangle without area.
    normal: DVec3,
    /// Where the triangle comes along each axis: three of its middle, three of its normal.
    pub(super) keys: [u32; 6],
    /// Its index in the mesh.
    pub(super) triangle: usize,
    /// Numbers of its corners' positions.
    pub(super) vertices: [u16; 3],
}

impl Piece {
    /// A triangle of a mesh by its index and corners; these are numbered by `positions`.
    pub(super) fn new(
        triangle: usize,
        corners: [[f32; 3]; 3],
        positions: &mut PositionSet,
    ) -> Piece {
        let bounds = LocalBox::around(corners);
        let [a, b, c] = corners.map(|c| DVec3::from(c.map(f64::from)));
        let across = (b - a).cross(c - a);
        let length = across.length();
        let normal = if length > 0.0 {
            across / length
        } else {
            DVec3::ZERO
        };
        let [x, y, z] = middle(corners);
        let keys = [x, y, z, normal.x as f32, normal.y as f32, normal.z as f32].map(ordered);
        Piece {
            bounds,
            normal,
            keys,
            triangle,
            vertices: corners.map(|c| positions.insert(c)),
        }
    }
}

/// Three times a triangle's middle.
pub(super) fn middle([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis] + b[axis] + c[axis])
}

/// An integer that orders as the number does.
pub(super) fn ordered(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 {
        bits | 1 << 31
    } else {
        !bits
    }
}

/// What the cost of a set is made of.
#[derive(Clone, Copy)]
pub(super) struct Side {
    bounds: LocalBox,
    normals: DVec3,
    triangles: usize,
    vertices: usize,
}

impl Side {
    pub(super) const EMPTY: Side = Side {
        bounds: LocalBox::EMPTY,
        normals: DVec3::ZERO,
        triangles: 0,
        vertices: 0,
    };

    pub(super) fn add(&mut self, piece: &Piece, seen: &mut Seen) {
        self.bounds = self.bounds.union(piece.bounds);
        self.normals += piece.normal;
        self.triangles += 1;
        self.vertices += seen.add(piece.vertices);
    }

    /// What the set takes to draw, on average over all places to see it from: up to a factor.
    pub(super) fn cost(&self, one_sided: bool) -> f64 {
        let triangles = self.triangles as f64;
        let drawn = (triangles + self.vertices as f64) * self.bounds.half_area();
        if !one_sided {
            return drawn;
        }
        // Unit normals spread evenly over a cap of half angle θ have a mean of length (1 + cos θ) / 2, and all of them
        // look away from a share (1 − sin θ) / 2 of all directions.
        let cosine = 2.0 * (self.normals.length() / triangles) - 1.0;
        if cosine <= 0.0 {
            drawn
        } else {
            let sine_squared = 1.0 - cosine * cosine;
            let sine = if sine_squared > 0.0 {
                sine_squared.sqrt()
            } else {
                0.0
            };
            drawn * (0.5 + 0.5 * sine)
        }
    }
}

/// Which positions have come since it was last cleared.
pub(super) struct Seen {
    /// The round in which each came last.
    rounds: Vec<u32>,
    round: u32,
}

impl Seen {
    /// Of so many positions, none yet.
    pub(super) fn of(positions: usize) -> Seen {
        Seen {
            rounds: vec![0; positions],
            round: 0,
        }
    }

    pub(super) fn clear(&mut self) {
        self.round += 1;
    }

    /// How many of a triangle's positions had not come before.
    pub(super) fn add(&mut self, vertices: [u16; 3]) -> usize {
        let mut new = 0;
        for v in vertices {
            let last = &mut self.rounds[usize::from(v)];
            new += usize::from(*last != self.round);
            *last = self.round;
        }
        new
    }
}
