//! Whether clusters hold a mesh's occluding triangles: all of them, and no others.
//!
//! Culling rests on it. A cluster that is not there hides what nobody would draw; a triangle that is missing makes an
//! object hidden that still shows. To look each triangle up would take a table as large as the mesh. Two sets are as good
//! as equal if the sums of their members' hashes are, provided that whoever made the sets did not know the hash (Carter
//! and Wegman, *New Hash Functions and Their Use in Authentication and Set Equality*, 1981, §4). So its keys are drawn
//! when it is needed: no file can be made to fit, and one that does not passes once in 2⁶⁰ times.
//!
//! A triangle may begin at any corner, so its hash is made of a sum over its edges, which does not tell where they begin.

use std::hash::{BuildHasher, RandomState};

use super::clusters::occluding;
use super::{ClusterGeometry, ClusteredMesh};
use crate::scene::Mesh;

/// A hash of triangles that nobody knows beforehand.
#[derive(Clone, Copy)]
pub(super) struct TriangleHash([u64; 6]);

/// The two halves of a product, folded.
fn folded(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    product as u64 ^ (product >> 64) as u64
}

impl TriangleHash {
    /// With keys that are drawn now.
    pub(super) fn drawn() -> TriangleHash {
        let random = RandomState::new();
        TriangleHash(std::array::from_fn(|i| random.hash_one(i)))
    }

    fn of_position(&self, position: [f32; 3]) -> u64 {
        let [x, y, z] = position.map(|c| u64::from(c.to_bits()));
        folded((x << 32 | y) ^ self.0[0], z ^ self.0[1])
    }

    fn of_triangle(&self, [a, b, c]: [u64; 3]) -> u64 {
        let edge = |from: u64, to: u64| folded(from ^ self.0[2], to ^ self.0[3]);
        let edges = edge(a, b).wrapping_add(edge(b, c)).wrapping_add(edge(c, a));
        folded(edges ^ self.0[4], self.0[5] | 1)
    }

    /// The sum over a mesh's occluding triangles, single- or double-sided.
    fn of_mesh(&self, mesh: &Mesh, positions: &[u64], double_sided: bool) -> u64 {
        let triangles = occluding(mesh, double_sided).map(|t| mesh.triangles[t]);
        triangles.fold(0, |sum: u64, triangle| {
            sum.wrapping_add(self.of_triangle(triangle.map(|i| positions[i as usize])))
        })
    }

    /// The sum over a cluster's triangles.
    fn of_cluster(&self, geometry: &ClusterGeometry<'_>) -> u64 {
        let mut positions = [0; 1 + u8::MAX as usize];
        let (xy, z) = (geometry.x.iter().zip(geometry.y), geometry.z);
        for (place, ((&x, &y), &z)) in positions.iter_mut().zip(xy.zip(z)) {
            *place = self.of_position([x, y, z]);
        }
        geometry.triangles().fold(0, |sum: u64, triangle| {
            sum.wrapping_add(self.of_triangle(triangle.map(|i| positions[usize::from(i)])))
        })
    }

    /// Whether clusters hold a mesh's occluding triangles, single-sided ones as such.
    pub(super) fn is_alike(&self, mesh: &Mesh, clustered: &ClusteredMesh) -> bool {
        let positions: Vec<u64> = mesh
            .positions
            .iter()
            .map(|&p| self.of_position(p))
            .collect();
        let mut sums = [0u64; 2];
        for (index, cluster) in clustered.clusters().iter().enumerate() {
            let sum = &mut sums[usize::from(cluster.double_sided)];
            *sum = sum.wrapping_add(self.of_cluster(&clustered.geometry(index)));
        }
        sums == [false, true].map(|double_sided| self.of_mesh(mesh, &positions, double_sided))
    }
}
