//! Quadrilaterals over the seams of a cluster, for a final pass that is not ours.
//!
//! With a slack, each polygon is pulled in on its own, which opens a seam along every edge that two share. But what two triangles cover
//! together is pulled in by its outline alone, as the slack asks, and their common edge lies inside:
//!
//! ```text
//!   +--------+--------+        +--------+--------+
//!   | +----+ | +----+ |        | +----+ | +----+ |
//!   | |    | | |    | |        | |   ====== |   | |
//!   | |    | | |    | |   →    | |   =    = |   | |    what is left open are the corners
//!   | +----+ | +----+ |        | +----+ | +----+ |
//!   +--------+--------+        +--------+--------+
//! ```
//!
//! So every pair of triangles with a common edge is drawn as well that is not one quadrilateral already and may be one. Seams between
//! clusters stay.

use rayon::prelude::*;

use super::quads::pairs_beside;
use super::{ClusteredMesh, ClusteredScene};

/// The bridges of a mesh's clusters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bridges {
    quads: Vec<[u8; 4]>,
    /// Where those of each cluster end.
    ends: Vec<usize>,
}

impl Bridges {
    /// Those of a mesh.
    pub fn new(mesh: &ClusteredMesh) -> Bridges {
        let mut bridges = Bridges::default();
        for cluster in 0..mesh.clusters().len() {
            let geometry = mesh.geometry(cluster);
            let vertices = 0..geometry.vertex_count;
            let positions: Vec<[f32; 3]> = vertices
                .map(|i| [geometry.x[i], geometry.y[i], geometry.z[i]])
                .collect();
            bridges
                .quads
                .extend(pairs_beside(&positions, geometry.quads));
            bridges.ends.push(bridges.quads.len());
        }
        bridges
    }

    /// Those of each of a scene's meshes; empty where it does not occlude.
    pub fn of_scene(scene: &ClusteredScene, meshes: usize) -> Vec<Bridges> {
        let of_mesh = |mesh| scene.mesh(mesh).map(Bridges::new).unwrap_or_default();
        (0..meshes).into_par_iter().map(of_mesh).collect()
    }

    /// Those of a cluster.
    ///
    /// # Panics
    /// If there is no such cluster.
    pub fn of(&self, cluster: usize) -> &[[u8; 4]] {
        let first = cluster.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.quads[first..self.ends[cluster]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Mesh, Surface};

    /// Three squares in a row: three quadrilaterals, with two seams between.
    #[test]
    fn every_seam_that_is_no_diagonal_has_a_bridge() {
        let positions: Vec<[f32; 3]> = (0..8)
            .map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0])
            .collect();
        let squares = (0..3).map(|i| 2 * i);
        let triangles: Vec<[u32; 3]> = squares
            .flat_map(|a| [[a, a + 2, a + 3], [a, a + 3, a + 1]])
            .collect();
        let mesh = Mesh {
            name: String::new(),
            surfaces: vec![Surface {
                triangles: 0..triangles.len(),
                material: Material::default(),
            }],
            positions: positions.into(),
            triangles: triangles.into(),
        };
        let clustered = ClusteredMesh::new(&mesh);
        assert_eq!(
            (clustered.clusters().len(), clustered.quads().len()),
            (1, 3)
        );
        let bridges = Bridges::new(&clustered);
        assert_eq!(bridges.of(0).len(), 2);
        let geometry = clustered.geometry(0);
        for &quad in bridges.of(0) {
            // The seam is the diagonal: both its ends have the same x.
            let x = quad.map(|i| geometry.x[usize::from(i)]);
            assert_eq!(x[0], x[2], "{quad:?}");
        }
    }
}
