//! The clusters of occluders that wait to be drawn, nearest first.
//!
//! Objects are taken by where they begin, but a large one reaches far behind the beginnings of others. So its clusters wait
//! until all that begins before them has been asked, and are asked once more right before they are drawn.

use antumbra_simd::triangle::CullMode;
use antumbra_simd::vertex::ScreenTransform;
use glam::DAffine3;

use super::{Frame, grow, share_of};
use crate::occlusion::{Footprint, OcclusionBuffer, SampleRect, Screen};
use crate::prepare::{CLUSTER_COST, Cluster, ClusterId, NormalCone};
use crate::scene::is_mirroring;
use crate::tasks::Work;
use crate::view::{Camera, Projection};

/// Clusters of one object that are projected together; as many as a mask has bits.
const CLUSTERS_PER_GROUP: usize = 64;
/// The same where there are others to project some of them.
const CLUSTERS_PER_SHARED_GROUP: usize = 16;

/// A budget that is chosen here spends a triangle's time for so many samples at the least; in coarse maps, where a sample hides more,
/// for a half or a quarter as many. (With a sixteenth, Sponza takes 1.5 times as long at a quarter and culls 0.71 of the hidden instead
/// of 0.63; castle, Delft and clinic hardly differ.)
const SAMPLES_A_TRIANGLE: i64 = 8;

/// An occluder that is not known to be hidden.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// The object.
    pub object: u32,
    /// From its local coordinates to the screen.
    pub screen: ScreenTransform,
    /// What its single-sided surfaces leave out.
    pub single_sided: CullMode,
    /// How many of its clusters wait, or are in the round that is being drawn.
    waiting: u32,
    /// Whether there is more of it than clusters that are found hidden.
    may_be_seen: bool,
}

/// A cluster that waits.
#[derive(Clone, Copy, Debug)]
pub struct WaitingCluster {
    /// The place of its object.
    pub placed: u32,
    /// Which of the object's clusters.
    pub cluster: u32,
    /// Its triangles.
    pub triangles: u32,
    /// Its place in the memory of contribution, if it has one.
    pub known: Option<u32>,
    /// Where it may be drawn.
    pub footprint: Footprint,
    /// Before which round it was asked, together with its object.
    pub asked_before: Option<u32>,
}

/// Clusters that wait, and memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct Waiting {
    placed: Places<Placed>,
    clusters: Places<WaitingCluster>,
    /// The keys of those that wait, the nearest last: see [`key`].
    sorted: Vec<u64>,
    /// Keys that are not among them yet.
    unsorted: Vec<u64>,
    /// How many rounds were drawn.
    rounds: u32,
    groups: Vec<Group>,
    finders: Vec<Finder>,
}

/// Things in places that are used again.
#[derive(Debug)]
struct Places<T> {
    things: Vec<T>,
    free: Vec<u32>,
}

/// Some clusters of a placed object.
#[derive(Clone, Copy, Debug)]
struct Group {
    placed: u32,
    first: u32,
    count: u32,
}

/// What a task finds.
#[derive(Debug, Default)]
struct Finder {
    footprints: Vec<Footprint>,
    found: Vec<WaitingCluster>,
    /// Places of objects with clusters that may be seen but are not worth drawing.
    passed_over: Vec<u32>,
}

/// How near a shape is: the larger the nearer.
pub fn nearness(footprint: Footprint) -> u32 {
    match footprint {
        Footprint::Unbounded => u32::MAX,
        Footprint::Nowhere => 0,
        Footprint::Within(rect) => {
            // Floats sort as their bits do, but for the sign.
            let bits = rect.nearest_depth.to_bits();
            bits ^ if bits >> 31 == 0 { 1 << 31 } else { u32::MAX }
        }
    }
}

/// The nearest cluster has the largest key, and of those as near the one in the first place.
fn key(footprint: Footprint, place: u32) -> u64 {
    u64::from(nearness(footprint)) << 32 | u64::from(!place)
}

impl<T> Default for Places<T> {
    fn default() -> Places<T> {
        Places {
            things: Vec::new(),
            free: Vec::new(),
        }
    }
}

impl<T: Copy> Places<T> {
    fn put(&mut self, thing: T) -> u32 {
        let Some(place) = self.free.pop() else {
            self.things.push(thing);
            return self.things.len() as u32 - 1;
        };
        self.things[place as usize] = thing;
        place
    }

    fn take(&mut self, place: u32) -> T {
        self.free.push(place);
        self.things[place as usize]
    }

    fn clear(&mut self) {
        self.things.clear();
        self.free.clear();
    }
}

impl Waiting {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.placed.clear();
        self.clusters.clear();
        self.sorted.clear();
        self.unsorted.clear();
        self.rounds = 0;
    }

    /// Lets the clusters of objects wait that may show a front and are not done, which are given in the order of their ids; the
    /// footprints are those of the objects' boxes. Hands the objects to `hide` that turn out to be hidden.
    pub fn add(
        &mut self,
        frame: &Frame<'_>,
        objects: &[(u32, Footprint)],
        done: &[ClusterId],
        buffer: &OcclusionBuffer,
        mut hide: impl FnMut(u32),
    ) {
        self.place_all(frame, objects, done, buffer.screen());
        let groups = &self.groups;
        let share = match frame.tasks.threads() {
            1 => groups.len().max(1),
            threads => groups.len().div_ceil(4 * threads).max(1),
        };
        let count = groups.len().div_ceil(share);
        grow(&mut self.finders, count);
        let placed = &self.placed.things;
        let finders = &mut self.finders[..count];
        frame
            .tasks
            .each(Work::AskClusters, finders, |task, finder| {
                finder.found.clear();
                finder.passed_over.clear();
                for group in share_of(groups, share, task) {
                    finder.find(
                        frame,
                        group,
                        &placed[group.placed as usize],
                        done,
                        buffer.screen(),
                    );
                }
            });
        for finder in 0..count {
            for found in 0..self.finders[finder].found.len() {
                self.push(self.finders[finder].found[found]);
            }
            for &placed in &self.finders[finder].passed_over {
                self.placed.things[placed as usize].may_be_seen = true;
            }
        }
        for group in 0..self.groups.len() {
            let Group { placed, first, .. } = self.groups[group];
            if first == 0 && self.placed.things[placed as usize].waiting == 0 {
                self.settle(placed, &mut hide);
            }
        }
    }

    /// Places objects, and cuts their clusters into groups. What has one cluster waits at once.
    fn place_all(
        &mut self,
        frame: &Frame<'_>,
        objects: &[(u32, Footprint)],
        done: &[ClusterId],
        screen: &Screen,
    ) {
        let per_group = if frame.tasks.threads() == 1 {
            CLUSTERS_PER_GROUP
        } else {
            CLUSTERS_PER_SHARED_GROUP
        };
        self.groups.clear();
        for &(number, footprint) in objects {
            let object = &frame.scene.objects()[number as usize];
            let Some(mesh) = frame.occluders.mesh_of(object) else {
                continue;
            };
            let clusters = mesh.clusters();
            let is_single = clusters.len() == 1;
            if is_single
                && (!is_promising(frame, &clusters[0], footprint)
                    || !done_of(done, number).is_empty()
                    || facing(clusters, screen.camera(), &object.world_from_local) == 0)
            {
                continue;
            }
            // A cluster that looks away is not asked, nor one that is drawn already.
            let may_be_seen = !frame.occluders.is_all_of(number)
                || !done_of(done, number).is_empty()
                || clusters.iter().any(|cluster| cluster.cone.is_some());
            let placed = self.place(frame, number, may_be_seen, screen);
            if is_single {
                // It is where its object is.
                self.push(WaitingCluster {
                    placed,
                    cluster: 0,
                    triangles: u32::from(clusters[0].triangle_count),
                    known: None,
                    footprint,
                    asked_before: Some(self.rounds),
                });
                continue;
            }
            let groups = (0..clusters.len()).step_by(per_group);
            self.groups.extend(groups.map(|first| Group {
                placed,
                first: first as u32,
                count: (clusters.len() - first).min(per_group) as u32,
            }));
        }
    }

    /// Places an object; `may_be_seen` if there is more of it than the clusters that will wait.
    pub(super) fn place(
        &mut self,
        frame: &Frame<'_>,
        number: u32,
        may_be_seen: bool,
        screen: &Screen,
    ) -> u32 {
        let place = &frame.scene.objects()[number as usize].world_from_local;
        let bounds = &frame.scene.bounds()[number as usize];
        self.placed.put(Placed {
            object: number,
            screen: screen.screen_from_local(place, bounds),
            single_sided: if is_mirroring(place) {
                CullMode::Front
            } else {
                CullMode::Back
            },
            waiting: 0,
            may_be_seen,
        })
    }

    /// Lets a cluster wait, by the place of its object.
    pub(super) fn push(&mut self, cluster: WaitingCluster) {
        self.placed.things[cluster.placed as usize].waiting += 1;
        let place = self.clusters.put(cluster);
        self.unsorted.push(key(cluster.footprint, place));
    }

    /// How many clusters wait.
    pub fn len(&self) -> usize {
        self.sorted.len() + self.unsorted.len()
    }

    /// Fills a round up to `most` with clusters that are at least as near as `horizon` says ([`nearness`]), nearest first,
    /// and have no more than so many triangles together. Whether the next one would have more.
    pub fn take(
        &mut self,
        horizon: u32,
        most: usize,
        mut triangles: u64,
        round: &mut Vec<WaitingCluster>,
    ) -> bool {
        self.sort();
        for left_over in &*round {
            triangles = triangles.saturating_sub(u64::from(left_over.triangles));
        }
        while round.len() < most
            && let Some(nearest) = self.sorted.last()
            && nearest >> 32 >= u64::from(horizon)
        {
            let place = !(*nearest as u32);
            let of_cluster = u64::from(self.clusters.things[place as usize].triangles);
            if of_cluster > triangles {
                return true;
            }
            triangles -= of_cluster;
            round.push(self.clusters.take(place));
            self.sorted.pop();
        }
        false
    }

    /// Puts the keys that came last in their places.
    fn sort(&mut self) {
        let Waiting {
            sorted, unsorted, ..
        } = self;
        unsorted.sort_unstable();
        let mut left = sorted.len();
        sorted.resize(left + unsorted.len(), 0);
        // From the end on, so that none is overwritten before it has moved.
        while let Some(&key) = unsorted.last() {
            let to = left + unsorted.len() - 1;
            if left > 0 && sorted[left - 1] > key {
                sorted[to] = sorted[left - 1];
                left -= 1;
            } else {
                sorted[to] = key;
                unsorted.pop();
            }
        }
    }

    /// From the local coordinates of a placed object to the screen.
    pub fn screen_of(&self, placed: u32) -> &ScreenTransform {
        &self.placed.things[placed as usize].screen
    }

    /// The object of a cluster that was taken.
    pub fn object_of(&self, cluster: &WaitingCluster) -> &Placed {
        &self.placed.things[cluster.placed as usize]
    }

    /// What a cluster that was taken is.
    pub fn id_of(&self, cluster: &WaitingCluster) -> ClusterId {
        ClusterId {
            object: self.object_of(cluster).object,
            cluster: cluster.cluster,
        }
    }

    /// Whether a cluster was asked since the last round was drawn.
    pub fn was_just_asked(&self, cluster: &WaitingCluster) -> bool {
        cluster.asked_before == Some(self.rounds)
    }

    /// Notes that a round was drawn, all but its clusters that were `hidden`: a bit for each. An object that is nothing but
    /// such clusters is handed to `hide`.
    pub fn drawn(&mut self, round: &[WaitingCluster], hidden: u128, mut hide: impl FnMut(u32)) {
        self.rounds += 1;
        for (i, cluster) in round.iter().enumerate() {
            let placed = &mut self.placed.things[cluster.placed as usize];
            placed.waiting -= 1;
            placed.may_be_seen |= hidden >> i & 1 == 0;
            if placed.waiting == 0 {
                self.settle(cluster.placed, &mut hide);
            }
        }
    }

    /// Forgets an object that has no cluster left.
    pub(super) fn settle(&mut self, placed: u32, hide: &mut impl FnMut(u32)) {
        let placed = self.placed.take(placed);
        if !placed.may_be_seen {
            hide(placed.object);
        }
    }
}

impl Finder {
    fn find(
        &mut self,
        frame: &Frame<'_>,
        group: &Group,
        placed: &Placed,
        done: &[ClusterId],
        screen: &Screen,
    ) {
        let object = &frame.scene.objects()[placed.object as usize];
        let Some(mesh) = frame.occluders.mesh_of(object) else {
            return;
        };
        let clusters = &mesh.clusters()[group.first as usize..][..group.count as usize];
        let facing = facing(clusters, screen.camera(), &object.world_from_local);
        if facing == 0 {
            return;
        }
        self.footprints.clear();
        screen.footprints_of_local_boxes(
            frame.settings.level,
            &placed.screen,
            &frame.scene.bounds()[placed.object as usize],
            clusters.iter().map(Cluster::bounds),
            &mut self.footprints,
        );
        for (i, (cluster, &footprint)) in clusters.iter().zip(&self.footprints).enumerate() {
            let number = group.first + i as u32;
            let id = ClusterId {
                object: placed.object,
                cluster: number,
            };
            let is_out = facing >> i & 1 == 0 || footprint == Footprint::Nowhere;
            if is_out || done.binary_search(&id).is_ok() {
                continue;
            }
            if !is_promising(frame, cluster, footprint) {
                self.passed_over.push(group.placed);
            } else {
                self.found.push(WaitingCluster {
                    placed: group.placed,
                    cluster: number,
                    triangles: u32::from(cluster.triangle_count),
                    known: None,
                    footprint,
                    asked_before: None,
                });
            }
        }
    }
}

/// Those of an object among clusters in the order of their ids.
fn done_of(done: &[ClusterId], object: u32) -> &[ClusterId] {
    let first = done.partition_point(|id| id.object < object);
    let count = done[first..].partition_point(|id| id.object == object);
    &done[first..first + count]
}

/// Whether a cluster may hide enough for what drawing it costs, if the budget is chosen by that.
fn is_promising(frame: &Frame<'_>, cluster: &Cluster, footprint: Footprint) -> bool {
    if !frame.settings.budget.is_for_what_pays() {
        return true;
    }
    match footprint {
        Footprint::Unbounded => true,
        Footprint::Nowhere => false,
        Footprint::Within(SampleRect { x, y, .. }) => {
            let area = (i64::from(x[1] - x[0]) + 1) * (i64::from(y[1] - y[0]) + 1);
            let pixels = i64::from(frame.settings.map_scale.pixels());
            area * pixels
                >= SAMPLES_A_TRIANGLE * i64::from(u32::from(cluster.triangle_count) + CLUSTER_COST)
        }
    }
}

/// Which clusters of a placed mesh may show a front: those whose cones do not say that all of it looks away.
pub fn facing(clusters: &[Cluster], camera: &Camera, world_from_local: &DAffine3) -> u64 {
    let all = u64::MAX >> (u64::BITS as usize - clusters.len());
    if clusters.iter().all(|cluster| cluster.cone.is_none()) {
        return all;
    }
    let local_from_world = world_from_local.inverse();
    let eye = local_from_world.transform_point3(camera.eye());
    let view = local_from_world.transform_vector3(camera.forward());
    let is_perspective = matches!(camera.projection(), Projection::Perspective { .. });
    let looks_away = |cone: &NormalCone| {
        if is_perspective {
            cone.is_back_facing(eye)
        } else {
            cone.is_back_facing_along(view)
        }
    };
    let cones = clusters.iter().map(|cluster| cluster.cone.as_ref());
    cones.enumerate().fold(all, |facing, (i, cone)| {
        facing & !(u64::from(cone.is_some_and(looks_away)) << i)
    })
}
