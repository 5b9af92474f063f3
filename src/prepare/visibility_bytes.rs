//! A visibility grid as bytes, and back.
//!
//! ```text
//! 8 magic │ 3 × f64 first viewpoint │ f64 spacing │ 3 × u32 counts │ u32 clusters in all lists
//! (viewpoints + 1) × u32: where each list begins
//! clusters × { u32 object, u32 cluster, f32 solid angle }
//! ```
//!
//! All little-endian, nothing between or after. Whatever the bytes, reading them takes no more memory than they do.

use glam::DVec3;

use super::ClusterId;
use super::visibility_grid::{GridLayout, SampledCluster, VisibilityGrid, VisibilityGridError};

/// What the bytes begin with; the last is the version.
const MAGIC: [u8; 8] = *b"AVISGRD\x01";

const HEADER_BYTES: usize = 56;
const CLUSTER_BYTES: usize = 12;

impl VisibilityGrid {
    /// The grid as bytes, the same on any machine.
    pub fn to_bytes(&self) -> Vec<u8> {
        let length = HEADER_BYTES + 4 * self.starts.len() + CLUSTER_BYTES * self.clusters.len();
        let mut bytes = Vec::with_capacity(length);
        bytes.extend(MAGIC);
        let GridLayout {
            first,
            spacing,
            counts,
        } = self.layout;
        for number in first.to_array().into_iter().chain([spacing]) {
            bytes.extend(number.to_le_bytes());
        }
        let lengths = counts.into_iter().chain([self.clusters.len() as u32]);
        for number in lengths.chain(self.starts.iter().copied()) {
            bytes.extend(number.to_le_bytes());
        }
        for SampledCluster { id, solid_angle } in &self.clusters {
            bytes.extend(id.object.to_le_bytes());
            bytes.extend(id.cluster.to_le_bytes());
            bytes.extend(solid_angle.to_le_bytes());
        }
        bytes
    }

    /// Reads a grid. It is sound in itself then; that it is a scene's, [`VisibilityGrid::check_scene`] says.
    ///
    /// # Errors
    /// If the bytes are not those of a grid.
    pub fn from_bytes(bytes: &[u8]) -> Result<VisibilityGrid, VisibilityGridError> {
        let damaged = VisibilityGridError::Damaged;
        let mut reader = Reader(bytes);
        let too_short = || damaged("it ends early");
        let magic: [u8; 8] = reader.take().ok_or_else(too_short)?;
        if magic != MAGIC {
            return Err(damaged("it does not begin as a grid of this version"));
        }
        let mut header = || -> Option<_> {
            let first = DVec3::new(reader.f64()?, reader.f64()?, reader.f64()?);
            let spacing = reader.f64()?;
            let counts = [reader.u32()?, reader.u32()?, reader.u32()?];
            let layout = GridLayout {
                first,
                spacing,
                counts,
            };
            Some((layout, reader.u32()? as usize))
        };
        let (layout, clusters) = header().ok_or_else(too_short)?;
        // Bounds the lengths below.
        layout.check()?;
        let starts = layout.viewpoints() as usize + 1;
        let length = 4 * starts as u64 + CLUSTER_BYTES as u64 * clusters as u64;
        if reader.0.len() as u64 != length {
            return Err(damaged("it has not the length that its header says"));
        }
        let (starts, clusters) = reader.0.split_at(4 * starts);
        let (starts, _) = starts.as_chunks();
        let (clusters, _) = clusters.as_chunks::<CLUSTER_BYTES>();
        let grid = VisibilityGrid {
            layout,
            starts: starts.iter().map(|&b| u32::from_le_bytes(b)).collect(),
            clusters: clusters.iter().map(sampled_cluster).collect(),
        };
        grid.check()?;
        Ok(grid)
    }
}

fn sampled_cluster(bytes: &[u8; CLUSTER_BYTES]) -> SampledCluster {
    let [o0, o1, o2, o3, c0, c1, c2, c3, a0, a1, a2, a3] = *bytes;
    SampledCluster {
        id: ClusterId {
            object: u32::from_le_bytes([o0, o1, o2, o3]),
            cluster: u32::from_le_bytes([c0, c1, c2, c3]),
        },
        solid_angle: f32::from_le_bytes([a0, a1, a2, a3]),
    }
}

/// Bytes that are still to be read.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> VisibilityGrid {
        let layout = GridLayout {
            first: DVec3::new(-1.0, 0.5, 1e6),
            spacing: 0.25,
            counts: [2, 1, 2],
        };
        let seen = |object, cluster, solid_angle| SampledCluster {
            id: ClusterId { object, cluster },
            solid_angle,
        };
        let lists = [
            vec![seen(0, 0, 0.5), seen(0, 3, 0.25), seen(7, 0, 1.0)],
            vec![],
            vec![seen(2, 1, 0.125)],
            vec![seen(0, 1, 12.5)],
        ];
        VisibilityGrid::new(layout, &lists).expect("a grid")
    }

    #[test]
    fn bytes_give_the_grid_back() {
        let grid = grid();
        assert_eq!(VisibilityGrid::from_bytes(&grid.to_bytes()), Ok(grid));
    }

    #[test]
    fn every_part_of_the_bytes_is_an_error() {
        let bytes = grid().to_bytes();
        for length in 0..bytes.len() {
            assert!(
                VisibilityGrid::from_bytes(&bytes[..length]).is_err(),
                "{length}"
            );
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(VisibilityGrid::from_bytes(&longer).is_err());
    }

    /// A damaged byte gives an error or another sound grid, and what is sound is written as it was read.
    #[test]
    fn damaged_bytes_never_panic() {
        let bytes = grid().to_bytes();
        let (mut refused, mut sound) = (0, 0);
        for place in 0..bytes.len() {
            for change in 1..=255_u8 {
                let mut damaged = bytes.clone();
                damaged[place] ^= change;
                match VisibilityGrid::from_bytes(&damaged) {
                    Err(_) => refused += 1,
                    Ok(grid) => {
                        sound += 1;
                        assert_eq!(grid.to_bytes(), damaged);
                        for eye in [DVec3::ZERO, grid.layout().first] {
                            let near = grid.viewpoint_near(eye);
                            assert!(near.is_none_or(|v| !grid.seen_from(v).is_empty()));
                        }
                    }
                }
            }
        }
        // Ids and coordinates may become others; lengths, orders and impossible numbers may not.
        assert!(refused > 4_000 && sound > 1_000, "{refused} and {sound}");
    }

    #[test]
    fn what_no_grid_holds_is_refused() {
        let refused = |place: usize, value: &[u8]| {
            let mut bytes = grid().to_bytes();
            bytes[place..place + value.len()].copy_from_slice(value);
            VisibilityGrid::from_bytes(&bytes).is_err()
        };
        assert!(refused(7, &[2]), "another version");
        assert!(refused(8, &f64::NAN.to_le_bytes()), "no place");
        assert!(refused(32, &0.0_f64.to_le_bytes()), "no spacing");
        assert!(refused(32, &f64::INFINITY.to_le_bytes()), "no end");
        assert!(refused(40, &u32::MAX.to_le_bytes()), "too many");
        assert!(refused(40, &0_u32.to_le_bytes()), "no viewpoints");
        let clusters = 56 + 4 * 5;
        assert!(refused(60, &9_u32.to_le_bytes()), "a list beyond the end");
        assert!(refused(clusters, &1_u32.to_le_bytes()), "out of order");
        assert!(refused(clusters + 8, &f32::NAN.to_le_bytes()), "no angle");
        assert!(refused(clusters + 8, &14_f32.to_le_bytes()), "too much");
        assert!(refused(clusters + 8, &(-1_f32).to_le_bytes()), "too little");
        assert!(!refused(clusters + 8, &2_f32.to_le_bytes()));
    }
}
