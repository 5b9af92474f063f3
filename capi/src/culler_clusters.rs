//! The clusters of a culler's objects: which of them may be seen, which were drawn, and their triangles.

use std::mem::MaybeUninit;

use antumbra::prepare::{ClusterId, TRIANGLES_PER_CLUSTER};

use crate::arguments::{ListPlace, required};
use crate::borrow::{handle, room};
use crate::culler::AntumbraCuller;
use crate::status::{AntumbraStatus, Error, guard};

/// The most triangles that a cluster has.
pub const ANTUMBRA_TRIANGLES_PER_CLUSTER: u32 = 64;

const _: () = assert!(ANTUMBRA_TRIANGLES_PER_CLUSTER as usize == TRIANGLES_PER_CLUSTER);

/// A cluster of an object: up to ANTUMBRA_TRIANGLES_PER_CLUSTER of its triangles that lie close together.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraCluster {
    /// The object.
    pub object: u32,
    /// Which of the object's clusters, counted from 0.
    pub cluster: u32,
}

/// A cluster that was drawn as an occluder.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraDrawnCluster {
    /// Which.
    pub cluster: AntumbraCluster,
    /// Its triangles, before clipping and culling by facing.
    pub triangles: u32,
    /// How many samples it took over from what was drawn before it.
    pub gain: u32,
}

/// Lists that C reads.
#[derive(Default)]
pub(crate) struct Clusters {
    visible: Vec<AntumbraCluster>,
    whole: Vec<u32>,
    drawn: Vec<AntumbraDrawnCluster>,
}

impl From<ClusterId> for AntumbraCluster {
    fn from(id: ClusterId) -> AntumbraCluster {
        AntumbraCluster {
            object: id.object,
            cluster: id.cluster,
        }
    }
}

/// Finds which clusters of the last frame's visible objects may be seen: an object that reaches everywhere may be visible while
/// most of its clusters are not.
///
/// @param clusters Is given them, in the order of their objects.
/// @param whole_objects Is given the objects that are to be drawn as a whole, since there is more to them than clusters: they are
///     translucent or cut out, hide nothing, or have a proxy in their place. Exact if culling is: every cluster that owns a pixel
///     is named.
///
/// A frame that leaves occlusion out names all clusters: who draws by clusters sets AntumbraSettings.skip to 0.
///
/// Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_visible_clusters(
    culler: *mut AntumbraCuller,
    clusters: Option<&mut MaybeUninit<*const AntumbraCluster>>,
    cluster_count: Option<&mut MaybeUninit<usize>>,
    whole_objects: Option<&mut MaybeUninit<*const u32>>,
    whole_object_count: Option<&mut MaybeUninit<usize>>,
) -> AntumbraStatus {
    guard(|| {
        let clusters_place = ListPlace::empty(clusters, cluster_count)?;
        let whole_place = ListPlace::empty(whole_objects, whole_object_count)?;
        let mut frames = handle(culler, "culler")?.0.write()?;
        frames.camera()?;
        let frames = &mut *frames;
        let Clusters { visible, whole, .. } = &mut frames.clusters;
        whole.clear();
        let found = frames.culler.visible_clusters(&frames.found, whole);
        visible.clear();
        visible.extend(found.into_iter().map(AntumbraCluster::from));
        clusters_place.put(visible);
        whole_place.put(whole);
        Ok(())
    })
}

/// The clusters that the last frame drew as occluders, in that order. Some may be of objects that were found hidden after.
///
/// Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_drawn_clusters(
    culler: *mut AntumbraCuller,
    clusters: Option<&mut MaybeUninit<*const AntumbraDrawnCluster>>,
    count: Option<&mut MaybeUninit<usize>>,
) -> AntumbraStatus {
    guard(|| {
        let place = ListPlace::empty(clusters, count)?;
        let mut frames = handle(culler, "culler")?.0.write()?;
        frames.camera()?;
        let frames = &mut *frames;
        let drawn = &mut frames.clusters.drawn;
        drawn.clear();
        let occluders = frames.found.occluders.iter();
        drawn.extend(occluders.map(|occluder| AntumbraDrawnCluster {
            cluster: occluder.id.into(),
            triangles: occluder.triangles,
            gain: occluder.gain,
        }));
        place.put(drawn);
        Ok(())
    })
}

/// Copies the triangles of a cluster, those of the proxy if its object has one.
///
/// @param corners Room for capacity triangles of three corners each, nine numbers: x, y and z of each corner, local units of the
///     object's mesh, counter-clockwise at the front. ANTUMBRA_TRIANGLES_PER_CLUSTER are always enough.
/// @param triangle_count Is given how many triangles the cluster has; no more than capacity are copied.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such object or cluster, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_cluster_triangles(
    culler: Option<&AntumbraCuller>,
    cluster: AntumbraCluster,
    corners: *mut f32,
    capacity: usize,
    triangle_count: Option<&mut MaybeUninit<usize>>,
) -> AntumbraStatus {
    guard(|| {
        let count = required(triangle_count, "triangle_count")?.write(0);
        let frames = required(culler, "culler")?.0.read()?;
        let objects = frames.culler.scene().objects().len();
        let AntumbraCluster { object, cluster } = cluster;
        if object as usize >= objects {
            return Err(Error::out_of_range("object", object, objects));
        }
        let mesh = frames.culler.occluder_of(object);
        let clusters = mesh.map_or(0, |mesh| mesh.clusters().len());
        let (Some(mesh), true) = (mesh, (cluster as usize) < clusters) else {
            let what = format!("cluster of object {object}");
            return Err(Error::out_of_range(&what, cluster, clusters));
        };
        let geometry = mesh.geometry(cluster as usize);
        let floats = room(corners, capacity.saturating_mul(9), "corners")?;
        let triangles = geometry.triangles().map(|t| geometry.corners(t));
        let mut places = floats.chunks_exact_mut(9);
        for triangle in triangles {
            *count += 1;
            let numbers = triangle.as_flattened().iter();
            for (place, number) in places.next().into_iter().flatten().zip(numbers) {
                place.write(*number);
            }
        }
        Ok(())
    })
}
