//! A mesh's occluding triangles in clusters, laid out for vector loops.
//!
//! ```text
//! x, y, z    | cluster 0: 21 vertices, the last repeated 11 times | cluster 1: 45, and 3 | …   blocks of 16
//! quads      | four bytes each, vertices counted within the cluster                      | …
//! ```
//!
//! Each cluster has vertices of its own: a few more are transformed than the mesh has, but a cluster is drawn without
//! reading any other, and an index takes a byte.

use antumbra_simd::assemble as simd;
use glam::DVec3;
use rayon::prelude::*;

use super::NormalCone;
use super::cluster_tree::ClusterTree;
use super::local_box::LocalBox;
use super::partition::{corners, partition};
use super::position_set::PositionSet;
use super::quads::paired;
use crate::scene::{Aabb, Array, Mesh};

/// The most triangles that a cluster has.
pub const TRIANGLES_PER_CLUSTER: usize = 64;

/// The most vertices that a cluster has, padding not counted.
pub const VERTICES_PER_CLUSTER: usize = 128;

/// A cluster's vertices start at a multiple of this and are padded to one.
pub const VERTEX_BLOCK: usize = 16;

const _: () = assert!(VERTICES_PER_CLUSTER.is_multiple_of(VERTEX_BLOCK));
const _: () = assert!(VERTICES_PER_CLUSTER <= 1 + u8::MAX as usize);

/// A cluster of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ClusterId {
    /// The object.
    pub object: u32,
    /// Which of the clusters of the object's occluder.
    pub cluster: u32,
}

/// Drawing a cluster costs as much as so many triangles, besides its own.
pub(crate) const CLUSTER_COST: u32 = 6;

/// Triangles of one mesh that lie close together and are all single-sided or all double-sided.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// Index of the first vertex, a multiple of [`VERTEX_BLOCK`].
    pub first_vertex: usize,
    /// Index of the first quadrilateral.
    pub first_quad: usize,
    /// How many vertices there are, 1 to [`VERTICES_PER_CLUSTER`], padding not counted.
    pub vertex_count: u8,
    /// How many triangles there are, 1 to [`TRIANGLES_PER_CLUSTER`].
    pub triangle_count: u8,
    /// How many quadrilaterals these are in: two triangles each, or one.
    pub quad_count: u8,
    /// Whether both sides are drawn.
    pub double_sided: bool,
    /// The least coordinates of its vertices, exactly; local units.
    pub min: [f32; 3],
    /// The largest coordinates of its vertices, exactly; local units.
    pub max: [f32; 3],
    /// What tells that no front is seen; none if nothing can, always for double-sided clusters.
    pub cone: Option<NormalCone>,
}

impl Cluster {
    /// The box around its vertices, exactly; local units.
    pub fn bounds(&self) -> Aabb {
        Aabb {
            min: DVec3::from(self.min.map(f64::from)),
            max: DVec3::from(self.max.map(f64::from)),
        }
    }

    /// How many vertices there are with the padding, a multiple of [`VERTEX_BLOCK`].
    pub fn padded_vertex_count(&self) -> usize {
        usize::from(self.vertex_count).next_multiple_of(VERTEX_BLOCK)
    }
}

/// What of a cluster is kept in an archive: the rest is found again from its geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClusterOutline {
    pub vertex_count: u8,
    pub triangle_count: u8,
    pub quad_count: u8,
    pub double_sided: bool,
    /// The axis of its cone, if it has one.
    pub axis: Option<[f32; 3]>,
}

impl Cluster {
    pub(super) fn outline(&self) -> ClusterOutline {
        ClusterOutline {
            vertex_count: self.vertex_count,
            triangle_count: self.triangle_count,
            quad_count: self.quad_count,
            double_sided: self.double_sided,
            axis: self.cone.as_ref().map(NormalCone::axis),
        }
    }
}

/// The geometry of one cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterGeometry<'a> {
    /// The vertices' x, local units; the last is repeated up to a multiple of [`VERTEX_BLOCK`].
    pub x: &'a [f32],
    /// Likewise y.
    pub y: &'a [f32],
    /// Likewise z.
    pub z: &'a [f32],
    /// How many vertices there are, padding not counted.
    pub vertex_count: usize,
    /// Four indices `a b c d` into these vertices each, never of the padding: the triangles `a b c` and `a c d`, or one
    /// where `c` and `d` are the same; counter-clockwise is the front.
    pub quads: &'a [[u8; 4]],
}

impl<'a> ClusterGeometry<'a> {
    /// The triangles, three indices each.
    pub fn triangles(&self) -> impl Iterator<Item = [u8; 3]> {
        triangles_of(self.quads)
    }

    /// The same for the hot loops.
    pub(crate) fn for_loops(&self) -> simd::Cluster<'a> {
        simd::Cluster {
            x: self.x,
            y: self.y,
            z: self.z,
            vertices: self.vertex_count,
            quads: self.quads,
        }
    }

    /// The corners of a triangle, local units.
    pub fn corners(&self, triangle: [u8; 3]) -> [[f32; 3]; 3] {
        triangle.map(|i| [self.x, self.y, self.z].map(|axis| axis[usize::from(i)]))
    }
}

/// The triangles of quadrilaterals.
fn triangles_of(quads: &[[u8; 4]]) -> impl Iterator<Item = [u8; 3]> {
    quads.iter().flat_map(|&[a, b, c, d]| {
        let other = (c != d).then_some([a, c, d]);
        std::iter::once([a, b, c]).chain(other)
    })
}

/// The occluding triangles of a mesh, in clusters.
///
/// Triangles with two corners in one place are left out: nothing of them is ever drawn.
///
/// ```
/// use antumbra::prepare::ClusteredMesh;
/// use antumbra::scene::{Material, Mesh, Surface};
///
/// let wall = Mesh {
///     name: "wall".to_owned(),
///     positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [0.0, 3.0, 0.0]].into(),
///     triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
///     surfaces: vec![Surface { triangles: 0..2, material: Material::default() }],
/// };
/// let clustered = ClusteredMesh::new(&wall);
/// let cluster = &clustered.clusters()[0];
/// assert_eq!((cluster.triangle_count, cluster.vertex_count), (2, 4));
/// assert_eq!(clustered.geometry(0).x.len(), 16);
///
/// // Its front looks along +z.
/// let cone = cluster.cone.expect("a wall has a back");
/// assert!(cone.is_back_facing([1.0, 1.0, -5.0].into()));
/// assert!(!cone.is_back_facing([1.0, 1.0, 5.0].into()));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClusteredMesh {
    clusters: Vec<Cluster>,
    x: Array<f32>,
    y: Array<f32>,
    z: Array<f32>,
    quads: Array<[u8; 4]>,
    triangle_count: usize,
    tree: ClusterTree,
}

impl ClusteredMesh {
    /// Clusters a mesh. There is no cluster if none of its surfaces occludes.
    ///
    /// The mesh must be valid as [`Scene::new`](crate::scene::Scene::new) demands: indices in range, coordinates
    /// finite.
    pub fn new(mesh: &Mesh) -> ClusteredMesh {
        let mut clustered = ClusteredMesh::default();
        for double_sided in [false, true] {
            let sets = partition(mesh, occluding(mesh, double_sided).collect(), !double_sided);
            let parts: Vec<Part> = sets
                .par_iter()
                .map(|set| Part::new(mesh, set, double_sided))
                .collect();
            parts.iter().for_each(|part| clustered.append(part));
        }
        clustered.shrink();
        clustered.grow_tree();
        clustered
    }

    /// The clusters: single-sided before double-sided ones, and neighbours near each other.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// The geometry of a cluster, by its index in [`ClusteredMesh::clusters`].
    ///
    /// # Panics
    /// If there is no such cluster.
    pub fn geometry(&self, cluster: usize) -> ClusterGeometry<'_> {
        let cluster = &self.clusters[cluster];
        let vertices = cluster.first_vertex..cluster.first_vertex + cluster.padded_vertex_count();
        let end = cluster.first_quad + usize::from(cluster.quad_count);
        ClusterGeometry {
            x: &self.x[vertices.clone()],
            y: &self.y[vertices.clone()],
            z: &self.z[vertices],
            vertex_count: usize::from(cluster.vertex_count),
            quads: &self.quads[cluster.first_quad..end],
        }
    }

    /// The geometry of a cluster that may have no place here.
    pub(super) fn geometry_of(
        &self,
        cluster: &Cluster,
    ) -> Result<ClusterGeometry<'_>, &'static str> {
        let vertices = cluster.first_vertex..cluster.first_vertex + cluster.padded_vertex_count();
        let quads = cluster.first_quad..cluster.first_quad + usize::from(cluster.quad_count);
        let geometry = || {
            Some(ClusterGeometry {
                x: self.x.get(vertices.clone())?,
                y: self.y.get(vertices.clone())?,
                z: self.z.get(vertices)?,
                vertex_count: usize::from(cluster.vertex_count),
                quads: self.quads.get(quads)?,
            })
        };
        geometry().ok_or("its geometry is missing")
    }

    /// Geometry without clusters yet.
    pub(super) fn of_geometry([x, y, z]: [Array<f32>; 3], quads: Array<[u8; 4]>) -> ClusteredMesh {
        ClusteredMesh {
            x,
            y,
            z,
            quads,
            ..ClusteredMesh::default()
        }
    }

    /// Adds a cluster whose geometry is here already.
    pub(super) fn push_restored(&mut self, cluster: Cluster) {
        self.triangle_count += usize::from(cluster.triangle_count);
        self.clusters.push(cluster);
    }

    /// All clusters' vertices, padding included: the x, the y and the z, local units.
    pub fn vertices(&self) -> [&[f32]; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// All clusters' quadrilaterals.
    pub fn quads(&self) -> &[[u8; 4]] {
        &self.quads
    }

    /// How many triangles all clusters have.
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// Gives back what vectors have grown too far.
    fn shrink(&mut self) {
        self.clusters.shrink_to_fit();
        for axis in [&mut self.x, &mut self.y, &mut self.z] {
            axis.to_mut().shrink_to_fit();
        }
        self.quads.to_mut().shrink_to_fit();
    }

    /// Builds the hierarchy over the clusters, when all are there.
    pub(super) fn grow_tree(&mut self) {
        self.tree = ClusterTree::over(&self.clusters);
    }

    /// The hierarchy over the clusters; empty if there is only one.
    pub(crate) fn tree(&self) -> &ClusterTree {
        &self.tree
    }

    /// What the clusters and their geometry take, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self)
            + size_of_val(&self.clusters[..])
            + 3 * size_of_val(&self.x[..])
            + size_of_val(&self.quads[..])
            + self.tree.memory_bytes()
    }

    fn append(&mut self, part: &Part) {
        self.clusters.push(Cluster {
            first_vertex: self.x.len(),
            first_quad: self.quads.len(),
            ..part.cluster.clone()
        });
        let last = part.positions.last();
        let padding = part.cluster.padded_vertex_count() - part.positions.len();
        let padded = part
            .positions
            .iter()
            .chain(last.into_iter().cycle().take(padding));
        let (xs, ys, zs) = (self.x.to_mut(), self.y.to_mut(), self.z.to_mut());
        for &[x, y, z] in padded {
            xs.push(x);
            ys.push(y);
            zs.push(z);
        }
        self.quads.to_mut().extend(&part.quads);
        self.triangle_count += usize::from(part.cluster.triangle_count);
    }
}

/// The triangles to cluster, as indices into the mesh's.
pub(super) fn occluding(mesh: &Mesh, double_sided: bool) -> impl Iterator<Item = usize> {
    let surfaces = mesh.surfaces.iter();
    surfaces
        .filter(move |s| s.material.occludes() && s.material.double_sided == double_sided)
        .flat_map(|s| s.triangles.clone())
        .filter(|&t| {
            let [a, b, c] = corners(mesh, t);
            a != b && b != c && c != a
        })
}

/// A cluster before it has its place.
struct Part {
    cluster: Cluster,
    positions: Vec<[f32; 3]>,
    quads: Vec<[u8; 4]>,
}

impl Part {
    fn new(mesh: &Mesh, set: &[usize], double_sided: bool) -> Part {
        let mut positions = PositionSet::for_triangles(set.len());
        let triangles: Vec<[u8; 3]> = set
            .iter()
            .map(|&t| corners(mesh, t).map(|c| positions.insert(c) as u8))
            .collect();
        let positions = positions.into_positions();
        let quads = paired(&positions, &triangles);
        let LocalBox { min, max } = LocalBox::around(positions.iter().copied());
        // Of the triangles as they are kept, not as the mesh has them: from these the cone can be found again.
        let kept = triangles_of(&quads).map(|t| t.map(|i| positions[usize::from(i)]));
        let cluster = Cluster {
            first_vertex: 0,
            first_quad: 0,
            vertex_count: positions.len() as u8,
            triangle_count: triangles.len() as u8,
            quad_count: quads.len() as u8,
            double_sided,
            min,
            max,
            cone: (!double_sided).then(|| NormalCone::around(kept)).flatten(),
        };
        Part {
            cluster,
            positions,
            quads,
        }
    }
}
