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
use crate::scene::{Aabb, Mesh};

/// The most triangles that a cluster has.
pub const TRIANGLES_PER_CLUSTER: usize = 64;

/// The most vertices that a cluster has, padding not counted.
pub const VERTICES_PER_CLUSTER: usize = 128;

/// A cluster's vertices start at a multiple of this and are padded to one.
pub const VERTEX_BLOCK: usize = 16;

const _: () = assert!(VERTICES_PER_CLUSTER.is_multiple_of(VERTEX_BLOCK));
const _: () = assert!(VERTICES_PER_CLUSTER <= 1 + u8::MAX as usize);

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
        self.quads.iter().flat_map(|&[a, b, c, d]| {
            let other = (c != d).then_some([a, c, d]);
            std::iter::once([a, b, c]).chain(other)
        })
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
///     positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [0.0, 3.0, 0.0]],
///     triangles: vec![[0, 1, 2], [0, 2, 3]],
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
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    quads: Vec<[u8; 4]>,
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
            let sets = partition(mesh, occluding(mesh, double_sided), !double_sided);
            let parts: Vec<Part> = sets
                .par_iter()
                .map(|set| Part::new(mesh, set, double_sided))
                .collect();
            parts.iter().for_each(|part| clustered.append(part));
        }
        clustered.tree = ClusterTree::over(&clustered.clusters);
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

    /// All clusters' vertices, padding included: the x, the y and the z, local units.
    pub fn vertices(&self) -> [&[f32]; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// How many triangles all clusters have.
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
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
        for &[x, y, z] in padded {
            self.x.push(x);
            self.y.push(y);
            self.z.push(z);
        }
        self.quads.extend(&part.quads);
        self.triangle_count += usize::from(part.cluster.triangle_count);
    }
}

/// The triangles to cluster, as indices into the mesh's.
fn occluding(mesh: &Mesh, double_sided: bool) -> Vec<usize> {
    let surfaces = mesh.surfaces.iter();
    surfaces
        .filter(|s| s.material.occludes() && s.material.double_sided == double_sided)
        .flat_map(|s| s.triangles.clone())
        .filter(|&t| {
            let [a, b, c] = corners(mesh, t);
            a != b && b != c && c != a
        })
        .collect()
}

/// A cluster before it has its place.
struct Part {
    cluster: Cluster,
    positions: Vec<[f32; 3]>,
    quads: Vec<[u8; 4]>,
}

impl Part {
    fn new(mesh: &Mesh, set: &[usize], double_sided: bool) -> Part {
        let all_corners = || set.iter().map(|&t| corners(mesh, t));
        let mut positions = PositionSet::for_triangles(set.len());
        let triangles: Vec<[u8; 3]> = all_corners()
            .map(|corners| corners.map(|c| positions.insert(c) as u8))
            .collect();
        let positions = positions.into_positions();
        let quads = paired(&positions, &triangles);
        let LocalBox { min, max } = LocalBox::around(positions.iter().copied());
        let cluster = Cluster {
            first_vertex: 0,
            first_quad: 0,
            vertex_count: positions.len() as u8,
            triangle_count: triangles.len() as u8,
            quad_count: quads.len() as u8,
            double_sided,
            min,
            max,
            cone: (!double_sided)
                .then(|| NormalCone::around(all_corners()))
                .flatten(),
        };
        Part {
            cluster,
            positions,
            quads,
        }
    }
}
