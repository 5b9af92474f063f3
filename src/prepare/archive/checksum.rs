//! The checksum of a section: quick, and sure to find what is likely.
//!
//! ```text
//! word   0   1   2   3   4   5   6   7    8   9  …
//! lane   0   1   2   3   4   5   6   7    0   1  …       lane ← rotated((lane ⊕ word) · odd)
//! ```
//!
//! Each step is a bijection of the lane for a given word, and of the word for a given lane, and so is each step that joins
//! the lanes. A change within one word of eight bytes therefore always changes the sum; any other does but once in 2⁶⁴
//! times, unless someone meant to. Eight lanes, since a product takes several cycles but one can be begun in each.

const LANES: usize = 8;
const WORD: usize = 8;

/// Odd, and with no pattern: 2⁶⁴ times the golden ratio's fraction.
const ODD: u64 = 0x9e37_79b9_7f4a_7c15;

fn step(lane: u64, word: u64) -> u64 {
    ((lane ^ word).wrapping_mul(ODD)).rotate_left(29)
}

/// The checksum of some bytes.
pub(super) fn checksum(bytes: &[u8]) -> u64 {
    let mut lanes: [u64; LANES] = std::array::from_fn(|i| ODD.rotate_left(8 * i as u32));
    let (blocks, rest) = bytes.as_chunks::<{ LANES * WORD }>();
    for block in blocks {
        for (lane, word) in lanes.iter_mut().zip(block.as_chunks::<WORD>().0) {
            *lane = step(*lane, u64::from_le_bytes(*word));
        }
    }
    for (lane, bytes) in lanes.iter_mut().zip(rest.chunks(WORD)) {
        let mut word = [0; WORD];
        word[..bytes.len()].copy_from_slice(bytes);
        *lane = step(*lane, u64::from_le_bytes(word));
    }
    // The length last: it tells zeros from nothing.
    let sum = lanes.iter().fold(0, |sum, &lane| step(sum, lane));
    let sum = step(sum, bytes.len() as u64);
    (sum ^ sum >> 32).wrapping_mul(ODD)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_every_change_of_a_byte_and_every_length() {
        let bytes: Vec<u8> = (0..200u8).map(|i| i.wrapping_mul(37)).collect();
        let sum = checksum(&bytes);
        for at in 0..bytes.len() {
            for change in 1..=u8::MAX {
                let mut changed = bytes.clone();
                changed[at] ^= change;
                assert_ne!(checksum(&changed), sum, "byte {at} ^ {change}");
            }
            assert_ne!(checksum(&bytes[..at]), sum);
        }
        let zeros = [0; 200];
        let mut sums: Vec<u64> = (0..=200).map(|n| checksum(&zeros[..n])).collect();
        sums.sort_unstable();
        sums.dedup();
        assert_eq!(sums.len(), 201);
    }

    #[test]
    fn the_sum_is_part_of_the_format() {
        let bytes: Vec<u8> = (0..=255).collect();
        assert_eq!(
            [checksum(b""), checksum(b"umbra"), checksum(&bytes)],
            [
                0xf67b_77dc_d69a_1d33,
                0x3b8a_3f10_fadc_778d,
                0x2e09_1e4d_0a4e_9d33
            ]
        );
    }
}
