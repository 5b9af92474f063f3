//! A scene made ready: what is found once, when a scene is given to the culler, so that frames need not find it.
//!
//! Occluders are drawn and asked about in clusters: few enough triangles that a question about them pays, enough that
//! it is worth asking. `partition` decides which triangles stand together, by what it takes to draw them (`cost`);
//! [`ClusteredMesh`] (`clusters`) lays them out for vector loops, [`NormalCone`] (`normal_cone`) tells when a whole
//! cluster looks away from the eye, and [`ClusteredScene`] (`clustered_scene`) holds the clusters of every mesh that
//! occludes, once however many objects share it. [`OccluderFitness`] (`fitness`) says which objects are worth drawing as
//! occluders at all.
//!
//! The same scene gives the same bits on any machine and for any number of threads: only + − × ÷ and square roots, and
//! every order is total.

mod clustered_scene;
mod clusters;
mod cost;
mod fitness;
mod local_box;
mod normal_cone;
mod partition;
mod position_set;
mod quads;

pub use clustered_scene::{ClusteredScene, MemoryUse};
pub use clusters::{
    Cluster, ClusterGeometry, ClusteredMesh, TRIANGLES_PER_CLUSTER, VERTEX_BLOCK,
    VERTICES_PER_CLUSTER,
};
pub use fitness::{OccluderFitness, StaticCriteria};
pub use normal_cone::NormalCone;
