//! A scene made ready: what is found once, when a scene is given to the culler, so that frames need not find it.
//!
//! Occluders are drawn and asked about in clusters: few enough triangles that a question about them pays, enough that
//! it is worth asking. `partition` decides which triangles stand together, by what it takes to draw them (`cost`);
//! [`ClusteredMesh`] (`clusters`) lays them out for vector loops, [`NormalCone`] (`normal_cone`) tells when a whole
//! cluster looks away from the eye, and [`ClusteredScene`] (`clustered_scene`) holds the clusters of every mesh that
//! occludes, once however many objects share it. [`OccluderFitness`] (`fitness`) says which objects are worth drawing as
//! occluders at all. For a final pass that is not ours, `bridges` says what is drawn over the seams of a cluster.
//!
//! [`VisibilityGrid`] (`visibility_grid`, and `visibility_bytes`) says which clusters are seen from where, if somebody had it made.
//!
//! [`Prepared`] (`prepared`) is a scene with all of that; an `archive` keeps it in a file. What is read from one is checked by
//! `restore` and `likeness`.
//!
//! The same scene gives the same bits on any machine and for any number of threads: only + − × ÷ and square roots, and
//! every order is total.

mod archive;
mod bridges;
mod cluster_tree;
mod clustered_scene;
mod clusters;
mod cost;
mod fitness;
mod likeness;
mod local_box;
mod normal_cone;
mod partition;
mod position_set;
mod prepared;
mod quads;
mod restore;
mod visibility_bytes;
mod visibility_grid;

pub use archive::ArchiveError;
pub(crate) use bridges::Bridges;
pub use clustered_scene::{ClusteredScene, MemoryUse};
pub(crate) use clusters::CLUSTER_COST;
pub use clusters::{
    Cluster, ClusterGeometry, ClusterId, ClusteredMesh, TRIANGLES_PER_CLUSTER, VERTEX_BLOCK,
    VERTICES_PER_CLUSTER,
};
pub use fitness::{OccluderFitness, StaticCriteria};
pub use normal_cone::NormalCone;
pub use prepared::Prepared;
pub use visibility_grid::{
    GridLayout, MOST_CLUSTERS_PER_VIEWPOINT, MOST_VIEWPOINTS, SampledCluster, VisibilityGrid,
    VisibilityGridError,
};
