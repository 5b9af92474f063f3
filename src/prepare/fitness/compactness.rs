//! How well a mesh fills its box (LOD §5.1, equation 2).
//!
//! `(A₁·P₁/R₁ + A₂·P₂/R₂ + A₃·P₃/R₃) / (A₁ + A₂ + A₃)`: for each axis of the mesh's tight box ([`TightBox`]), the area A of the face
//! across it, the samples P of the face that the mesh covers in a projection along the axis, and all of its samples R. It is 1
//! for a box and little for a wire. Nothing depends on where the mesh is placed, so each mesh has one, however many objects
//! share it.
//!
//! The paper does not say how finely faces are sampled; here by 64 × 64 samples whatever their shape, which is a share of
//! the area to one part in a hundred or so. A face without area counts for nothing, as A says: a sheet's compactness is its share
//! of its rectangle.

use glam::DVec3;

use super::silhouette::Silhouette;
use super::tight_box::TightBox;
use crate::prepare::ClusteredMesh;

/// A mesh in its box.
#[derive(Clone, Debug)]
pub struct BoxedMesh {
    /// The box, local units.
    pub bounds: TightBox,
    /// What the mesh covers of the face across each axis; none if that has no area.
    pub silhouettes: [Option<Silhouette>; 3],
}

impl BoxedMesh {
    /// Of a mesh's occluding triangles; none if there are none.
    pub fn new(mesh: &ClusteredMesh) -> Option<BoxedMesh> {
        let mut triangles = Vec::with_capacity(mesh.triangle_count());
        for cluster in 0..mesh.clusters().len() {
            let geometry = mesh.geometry(cluster);
            let corners = geometry.triangles().map(|t| geometry.corners(t));
            triangles.extend(corners.map(|t| t.map(|c| DVec3::from(c.map(f64::from)))));
        }
        BoxedMesh::around(&triangles)
    }

    /// Of triangles, given by their corners; none if there are none.
    pub fn around(triangles: &[[DVec3; 3]]) -> Option<BoxedMesh> {
        let bounds = TightBox::around(triangles)?;
        Some(BoxedMesh {
            silhouettes: [0, 1, 2].map(|k| Silhouette::along(k, &bounds, triangles)),
            bounds,
        })
    }

    /// How well it fills its box, from 0 to 1.
    pub fn compactness(&self) -> f64 {
        let size = self.bounds.size();
        let (mut covered, mut all) = (0.0, 0.0);
        for (k, silhouette) in self.silhouettes.iter().enumerate() {
            if let Some(silhouette) = silhouette {
                let area = size[(k + 1) % 3] * size[(k + 2) % 3];
                covered += area * silhouette.share();
                all += area;
            }
        }
        if all > 0.0 { covered / all } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::BOX_FACES;
    use super::*;

    fn compactness(triangles: &[[DVec3; 3]]) -> f64 {
        BoxedMesh::around(triangles).expect("a box").compactness()
    }

    /// The faces of a box.
    fn block(min: [f64; 3], max: [f64; 3]) -> Vec<[DVec3; 3]> {
        let corner = |i: usize| {
            let pick = |k: usize| if i >> k & 1 == 1 { max[k] } else { min[k] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let halves = BOX_FACES
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        halves.map(|corners| corners.map(corner)).collect()
    }

    #[test]
    fn boxes_are_compact_however_they_stand() {
        let upright = block([0.0; 3], [8.0, 3.0, 0.5]);
        assert_eq!(compactness(&upright), 1.0);
        // The same in coordinates that are turned by (3, 4, 5).
        let turned: Vec<[DVec3; 3]> = upright
            .iter()
            .map(|t| t.map(|c| DVec3::new(0.6 * c.x - 0.8 * c.y, 0.8 * c.x + 0.6 * c.y, c.z)))
            .collect();
        // Samples in the middle of the box's edges may fall on either side.
        assert!(compactness(&turned) > 0.96, "{}", compactness(&turned));
    }

    #[test]
    fn wires_are_not() {
        // Along an edge, across the face, and up: a bent wire in a cube.
        let mut wire = block([0.0; 3], [10.0, 0.2, 0.2]);
        wire.extend(block([9.8, 0.0, 0.0], [10.0, 10.0, 0.2]));
        wire.extend(block([9.8, 9.8, 0.0], [10.0, 10.0, 10.0]));
        assert!(compactness(&wire) < 0.1, "{}", compactness(&wire));
    }

    #[test]
    fn faces_count_by_their_areas() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        // A triangle over half of the face of 4 × 2, upright on a full floor of 4 × 1.
        let triangles = [
            [at(0.0, 0.0, 0.0), at(4.0, 0.0, 0.0), at(0.0, 2.0, 0.0)],
            [at(0.0, 0.0, 0.0), at(4.0, 0.0, 0.0), at(4.0, 0.0, 1.0)],
            [at(0.0, 0.0, 0.0), at(4.0, 0.0, 1.0), at(0.0, 0.0, 1.0)],
        ];
        let found = compactness(&triangles);
        // Along x only edges are seen, along y the floor, along z the triangle: (2·0 + 4·1 + 8·½) / 14.
        assert!((found - 8.0 / 14.0).abs() < 0.02, "{found}");
    }
}
