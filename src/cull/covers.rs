//! What might cover a sample: clusters of objects that are not known to be hidden, which are not drawn yet.
//!
//! Objects are looked through by their boxes' rectangles. The clusters of one are only projected when its rectangle holds a
//! sample that somebody asks about.

use std::ops::Range;

use super::Frame;
use super::waiting::facing;
use crate::occluders::{ClusterId, Contributions};
use crate::occlusion::{Footprint, Screen};
use crate::prepare::Cluster;

/// A sample, and a depth there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Its column.
    pub column: i32,
    /// Its row.
    pub row: i32,
    /// What is nearer than this hides what is asked about.
    pub depth: f32,
}

/// A cluster that is not drawn yet.
#[derive(Clone, Copy, Debug)]
pub struct Cover {
    /// Which.
    pub id: ClusterId,
    /// Its triangles.
    pub triangles: u32,
    /// Where it may be drawn.
    pub footprint: Footprint,
}

/// Clusters that might cover something; keeps its memory from frame to frame.
#[derive(Debug, Default)]
pub struct Covers {
    objects: Vec<u32>,
    of_objects: Rectangles,
    /// The clusters of each object, once they are known.
    expanded: Vec<Option<Range<usize>>>,
    clusters: Vec<Cover>,
    of_clusters: Rectangles,
    footprints: Vec<Footprint>,
    /// Objects over a sample.
    over: Vec<usize>,
}

/// Footprints, structure of arrays.
#[derive(Debug, Default)]
struct Rectangles {
    x: [Vec<i32>; 2],
    y: [Vec<i32>; 2],
    nearest: Vec<f32>,
}

impl Rectangles {
    fn clear(&mut self) {
        for ends in self.x.iter_mut().chain(&mut self.y) {
            ends.clear();
        }
        self.nearest.clear();
    }

    fn push(&mut self, footprint: Footprint) {
        let (x, y, nearest) = match footprint {
            Footprint::Nowhere => ([1, 0], [1, 0], f32::NEG_INFINITY),
            Footprint::Unbounded => ([0, i32::MAX], [0, i32::MAX], f32::INFINITY),
            Footprint::Within(rect) => (rect.x, rect.y, rect.nearest_depth),
        };
        for end in 0..2 {
            self.x[end].push(x[end]);
            self.y[end].push(y[end]);
        }
        self.nearest.push(nearest);
    }

    /// Calls `visit` with each of a range that holds a sample and reaches nearer than it.
    #[inline]
    fn each_over(&self, range: Range<usize>, sample: Sample, mut visit: impl FnMut(usize)) {
        const LANES: usize = 16;
        let Sample { column, row, depth } = sample;
        let (x0, x1) = (&self.x[0][range.clone()], &self.x[1][range.clone()]);
        let (y0, y1) = (&self.y[0][range.clone()], &self.y[1][range.clone()]);
        let nearest = &self.nearest[range.clone()];
        let holds = |i: usize| {
            (x0[i] <= column)
                & (x1[i] >= column)
                & (y0[i] <= row)
                & (y1[i] >= row)
                & (nearest[i] > depth)
        };
        let count = nearest.len();
        let mut at = 0;
        while at < count {
            let end = count.min(at + LANES);
            let any = (at..end).fold(false, |any, i| any | holds(i));
            if any {
                (at..end).filter(|&i| holds(i)).for_each(|i| visit(range.start + i));
            }
            at = end;
        }
    }
}

impl Covers {
    /// Forgets all, and begins with some objects within these footprints.
    pub fn begin(&mut self, objects: &[(u32, Footprint)]) {
        self.objects.clear();
        self.of_objects.clear();
        self.expanded.clear();
        self.clusters.clear();
        self.of_clusters.clear();
        for &(object, footprint) in objects {
            self.objects.push(object);
            self.of_objects.push(footprint);
        }
        self.expanded.resize(objects.len(), None);
    }

    /// A cluster that was found.
    pub fn cluster(&self, index: usize) -> &Cover {
        &self.clusters[index]
    }

    /// Finds the clusters that may cover a sample, of other objects than `of`.
    pub fn find(
        &mut self,
        frame: &Frame<'_>,
        screen: &Screen,
        contributions: &Contributions,
        sample: Sample,
        of: u32,
        found: &mut Vec<usize>,
    ) {
        found.clear();
        let mut objects = std::mem::take(&mut self.over);
        objects.clear();
        self.of_objects
            .each_over(0..self.objects.len(), sample, |i| objects.push(i));
        for &i in &objects {
            if self.objects[i] == of {
                continue;
            }
            let clusters = match &self.expanded[i] {
                Some(clusters) => clusters.clone(),
                None => self.expand(frame, screen, contributions, i),
            };
            self.of_clusters
                .each_over(clusters, sample, |cluster| found.push(cluster));
        }
        self.over = objects;
    }

    /// Takes a cluster away, which is drawn.
    pub fn take(&mut self, index: usize) {
        self.of_clusters.nearest[index] = f32::NEG_INFINITY;
    }

    fn expand(
        &mut self,
        frame: &Frame<'_>,
        screen: &Screen,
        contributions: &Contributions,
        index: usize,
    ) -> Range<usize> {
        let first = self.clusters.len();
        self.find_clusters(frame, screen, contributions, index);
        for cluster in &self.clusters[first..] {
            self.of_clusters.push(cluster.footprint);
        }
        let clusters = first..self.clusters.len();
        if clusters.is_empty() {
            self.of_objects.nearest[index] = f32::NEG_INFINITY;
        }
        self.expanded[index] = Some(clusters.clone());
        clusters
    }

    fn find_clusters(
        &mut self,
        frame: &Frame<'_>,
        screen: &Screen,
        contributions: &Contributions,
        index: usize,
    ) {
        let number = self.objects[index];
        let object = &frame.scene.objects()[number as usize];
        let Some(mesh) = frame.occluders.mesh_of(object) else {
            return;
        };
        let bounds = &frame.scene.bounds()[number as usize];
        // A proxy hides nothing while its object reaches the near plane.
        if object.occluder_proxy.is_some()
            && screen.footprint_of_aabb(bounds) == Footprint::Unbounded
        {
            return;
        }
        let place = &object.world_from_local;
        let from_local = screen.screen_from_local(place);
        let mut done = contributions.done_of(number).peekable();
        for (group, clusters) in mesh.clusters().chunks(u64::BITS as usize).enumerate() {
            let facing = facing(clusters, screen.camera(), place);
            self.footprints.clear();
            let boxes = clusters.iter().map(Cluster::bounds);
            let level = frame.settings.level;
            screen.footprints_of_local_boxes(level, &from_local, bounds, boxes, &mut self.footprints);
            for (i, (cluster, &footprint)) in clusters.iter().zip(&self.footprints).enumerate() {
                let number_of_cluster = (group * u64::BITS as usize + i) as u32;
                let is_done = done.next_if_eq(&number_of_cluster).is_some();
                if facing >> i & 1 == 1 && footprint != Footprint::Nowhere && !is_done {
                    self.clusters.push(Cover {
                        id: ClusterId {
                            object: number,
                            cluster: number_of_cluster,
                        },
                        triangles: u32::from(cluster.triangle_count),
                        footprint,
                    });
                }
            }
        }
    }
}
