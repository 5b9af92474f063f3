//! The distinct positions of some triangles, numbered in the order they come.
//!
//! Positions are the same if their bits are: an exporter that shades flat writes a corner once for every face, and
//! culling sees none of the difference. −0 and 0 stay apart, so that nothing downstream can tell a cluster's vertices
//! from the mesh's.

const EMPTY: u16 = u16::MAX;

/// Distinct positions, fewer than 2¹⁵.
pub(super) struct PositionSet {
    /// Open addressing, a power of two of them: an index into `positions`, or `EMPTY`.
    slots: Vec<u16>,
    positions: Vec<[f32; 3]>,
}

impl PositionSet {
    /// Room for the corners of so many triangles, at most 10,000.
    pub(super) fn for_triangles(triangles: usize) -> PositionSet {
        debug_assert!(triangles <= 10_000);
        // At least twice as many as are ever full, so that probes stay short.
        let slots = (6 * triangles).next_power_of_two();
        PositionSet {
            slots: vec![EMPTY; slots],
            positions: Vec::with_capacity(3 * triangles),
        }
    }

    /// The number of a position, a new one if it has not come before.
    pub(super) fn insert(&mut self, position: [f32; 3]) -> u16 {
        let bits = position.map(f32::to_bits);
        let mut slot = self.slot_of(bits);
        loop {
            match self.slots[slot] {
                EMPTY => {
                    let number = self.positions.len() as u16;
                    self.slots[slot] = number;
                    self.positions.push(position);
                    return number;
                }
                number if self.positions[usize::from(number)].map(f32::to_bits) == bits => {
                    return number;
                }
                _ => slot = (slot + 1) % self.slots.len(),
            }
        }
    }

    /// The positions by number.
    pub(super) fn into_positions(self) -> Vec<[f32; 3]> {
        self.positions
    }

    /// Multiplicative hashing (Knuth, *The Art of Computer Programming* 3, §6.4): the upper bits of a product.
    fn slot_of(&self, [x, y, z]: [u32; 3]) -> usize {
        const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
        let mixed = ((u64::from(x) << 32 | u64::from(y)).wrapping_mul(ODD) ^ u64::from(z))
            .wrapping_mul(ODD);
        (mixed >> (64 - self.slots.len().ilog2())) as usize
    }
}
