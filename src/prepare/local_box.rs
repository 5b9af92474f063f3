//! Boxes in a mesh's own coordinates: exact, since they only choose among the vertices' own f32 coordinates.

/// The box around some points; holds nothing to begin with.
#[derive(Clone, Copy)]
pub(super) struct LocalBox {
    pub(super) min: [f32; 3],
    pub(super) max: [f32; 3],
}

impl LocalBox {
    pub(super) const EMPTY: LocalBox = LocalBox {
        min: [f32::INFINITY; 3],
        max: [f32::NEG_INFINITY; 3],
    };

    pub(super) fn around(points: impl IntoIterator<Item = [f32; 3]>) -> LocalBox {
        points
            .into_iter()
            .fold(LocalBox::EMPTY, |b, p| b.union(LocalBox { min: p, max: p }))
    }

    pub(super) fn union(self, other: LocalBox) -> LocalBox {
        // Not `f32::min` and `max`: of −0 and 0 they may answer either.
        let less = |a: f32, b: f32| if b < a { b } else { a };
        let more = |a: f32, b: f32| if b > a { b } else { a };
        LocalBox {
            min: std::array::from_fn(|axis| less(self.min[axis], other.min[axis])),
            max: std::array::from_fn(|axis| more(self.max[axis], other.max[axis])),
        }
    }

    pub(super) fn size(self) -> [f64; 3] {
        std::array::from_fn(|axis| f64::from(self.max[axis]) - f64::from(self.min[axis]))
    }

    pub(super) fn half_area(self) -> f64 {
        let [x, y, z] = self.size();
        x * y + y * z + z * x
    }
}
