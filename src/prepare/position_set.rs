//! The distinct positions of one cluster, numbered in the order they come.
//!
//! Positions are the same if their bits are: an exporter that shades flat writes a corner once for every face, and
//! culling sees none of the difference. −0 and 0 stay apart, so that nothing downstream can tell a cluster's vertices
//! from the mesh's.

use super::TRIANGLES_PER_CLUSTER;

/// A power of two well above the 192 corners of a cluster, so that probes stay short.
const SLOTS: usize = 512;
const EMPTY: u8 = u8::MAX;
const _: () = assert!(3 * TRIANGLES_PER_CLUSTER < EMPTY as usize);

/// At most 3 × [`TRIANGLES_PER_CLUSTER`] distinct positions.
pub(super) struct PositionSet {
    /// Open addressing: an index into `positions`, or `EMPTY`.
    slots: [u8; SLOTS],
    positions: Vec<[f32; 3]>,
}

impl PositionSet {
    pub(super) fn new() -> PositionSet {
        PositionSet {
            slots: [EMPTY; SLOTS],
            positions: Vec::with_capacity(3 * TRIANGLES_PER_CLUSTER),
        }
    }

    pub(super) fn clear(&mut self) {
        self.slots = [EMPTY; SLOTS];
        self.positions.clear();
    }

    /// The number of a position, a new one if it has not come before.
    pub(super) fn insert(&mut self, position: [f32; 3]) -> u8 {
        let bits = position.map(f32::to_bits);
        let mut slot = Self::slot_of(bits);
        loop {
            match self.slots[slot] {
                EMPTY => {
                    let number = self.positions.len() as u8;
                    self.slots[slot] = number;
                    self.positions.push(position);
                    return number;
                }
                number if self.positions[usize::from(number)].map(f32::to_bits) == bits => {
                    return number;
                }
                _ => slot = (slot + 1) % SLOTS,
            }
        }
    }

    /// The positions by number.
    pub(super) fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Multiplicative hashing (Knuth, *The Art of Computer Programming* 3, §6.4): the upper bits of a product.
    fn slot_of([x, y, z]: [u32; 3]) -> usize {
        const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
        let mixed = ((u64::from(x) << 32 | u64::from(y)).wrapping_mul(ODD) ^ u64::from(z))
            .wrapping_mul(ODD);
        (mixed >> (64 - SLOTS.ilog2())) as usize
    }
}
