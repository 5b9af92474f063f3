//! Axis-aligned boxes in f64.
//!
//! World coordinates stay in f64 until the eye has been subtracted, so a box far from the origin is as tight as one
//! at it.

use glam::DVec3;

/// An axis-aligned box; `min` and `max` are world coordinates in scene units.
///
/// [`Aabb::EMPTY`] holds nothing: its `min` is above its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// The box that holds nothing, and that [`Aabb::union`] leaves out.
    pub const EMPTY: Aabb = Aabb {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The smallest box around some points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Aabb {
        points.into_iter().fold(Aabb::EMPTY, |b, p| Aabb {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// The smallest box around two boxes.
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The box with every face moved outwards by `distance`.
    pub fn grown(self, distance: f64) -> Aabb {
        Aabb {
            min: self.min - DVec3::splat(distance),
            max: self.max + DVec3::splat(distance),
        }
    }

    /// The middle of the box.
    pub fn center(self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Edge lengths.
    pub fn size(self) -> DVec3 {
        self.max - self.min
    }

    /// The eight corners; bit 0 of the index chooses `max.x`, bit 1 `max.y`, bit 2 `max.z`.
    pub fn corners(self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f64, hi: f64| if i >> bit & 1 == 0 { lo } else { hi };
            DVec3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            )
        })
    }

    /// Whether the box is finite and holds at least a point.
    pub fn is_valid(self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }
}
