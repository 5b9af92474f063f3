//! A mesh's clusters from what an archive keeps of them, checked so that nothing behind this border can fail.
//!
//! What a cluster claims is not read but found again: its place from the sizes of those before it, its box and its cone
//! from its geometry (of the cone only the axis is kept, which takes long to find, and any would do). Whether the
//! triangles are the mesh's own is another question, see [`likeness`](super::likeness).

use super::clusters::ClusterOutline;
use super::local_box::LocalBox;
use super::{
    Cluster, ClusterGeometry, ClusteredMesh, NormalCone, TRIANGLES_PER_CLUSTER,
    VERTICES_PER_CLUSTER,
};
use crate::scene::Array;

impl ClusteredMesh {
    /// Clusters with their vertices (x, y and z) and quadrilaterals, in their order.
    ///
    /// # Errors
    /// The first broken rule: a size out of range, single-sided clusters after double-sided ones, an index that is no
    /// vertex of its cluster, a coordinate that is not finite, padding that is not the last vertex, an axis around which
    /// there is no cone, or geometry that belongs to no cluster.
    pub(super) fn restored(
        outlines: impl IntoIterator<Item = ClusterOutline>,
        vertices: [Array<f32>; 3],
        quads: Array<[u8; 4]>,
    ) -> Result<ClusteredMesh, String> {
        let mut mesh = ClusteredMesh::of_geometry(vertices, quads);
        let (mut first_vertex, mut first_quad) = (0, 0);
        let mut after_double_sided = false;
        for (index, outline) in outlines.into_iter().enumerate() {
            let mut cluster = Cluster {
                first_vertex,
                first_quad,
                vertex_count: outline.vertex_count,
                triangle_count: outline.triangle_count,
                quad_count: outline.quad_count,
                double_sided: outline.double_sided,
                min: [0.0; 3],
                max: [0.0; 3],
                cone: None,
            };
            let broken = |cause: &str| format!("cluster {index}: {cause}");
            if after_double_sided && !cluster.double_sided {
                return Err(broken(
                    "it is single-sided, and comes after double-sided ones",
                ));
            }
            after_double_sided = cluster.double_sided;
            let geometry = mesh.geometry_of(&cluster).map_err(broken)?;
            check(&cluster, &geometry).map_err(broken)?;
            LocalBox {
                min: cluster.min,
                max: cluster.max,
            } = LocalBox::around((0..geometry.vertex_count).map(|i| vertex(&geometry, i)));
            if let Some(axis) = outline.axis {
                let triangles = geometry.triangles().map(|t| geometry.corners(t));
                let cone = (!cluster.double_sided)
                    .then(|| NormalCone::along(axis, triangles))
                    .flatten();
                cluster.cone = Some(cone.ok_or_else(|| broken("its axis is none of a cone"))?);
            }
            first_vertex += cluster.padded_vertex_count();
            first_quad += usize::from(cluster.quad_count);
            mesh.push_restored(cluster);
        }
        if mesh
            .vertices()
            .iter()
            .any(|axis| axis.len() != first_vertex)
        {
            return Err("there are vertices of no cluster".to_owned());
        }
        if mesh.quads().len() != first_quad {
            return Err("there are quadrilaterals of no cluster".to_owned());
        }
        mesh.grow_tree();
        Ok(mesh)
    }
}

fn vertex(geometry: &ClusterGeometry<'_>, index: usize) -> [f32; 3] {
    [geometry.x[index], geometry.y[index], geometry.z[index]]
}

/// Checks a cluster's own numbers.
fn check(cluster: &Cluster, geometry: &ClusterGeometry<'_>) -> Result<(), &'static str> {
    let [vertices, triangles] = [cluster.vertex_count, cluster.triangle_count].map(usize::from);
    if !(1..=VERTICES_PER_CLUSTER).contains(&vertices) {
        return Err("its number of vertices is out of range");
    }
    if !(1..=TRIANGLES_PER_CLUSTER).contains(&triangles)
        || geometry.triangles().count() != triangles
    {
        return Err("its number of triangles is not that of its quadrilaterals, or out of range");
    }
    let highest = geometry.quads.as_flattened().iter().copied().max();
    if highest.is_none_or(|highest| usize::from(highest) >= vertices) {
        return Err("an index is none of its vertices");
    }
    for axis in [geometry.x, geometry.y, geometry.z] {
        if !axis.iter().all(|c| c.is_finite()) {
            return Err("a coordinate is not finite");
        }
        let last = axis[vertices - 1].to_bits();
        if axis[vertices..].iter().any(|c| c.to_bits() != last) {
            return Err("its padding is not its last vertex");
        }
    }
    Ok(())
}
