//! What might cover a sample: clusters of objects that are not known to be hidden, which are not drawn yet.
//!
//! Objects are looked through by their boxes' rectangles. The clusters of one are only projected when its rectangle holds a
//! sample that somebody asks about.

use std::ops::Range;

use antumbra_simd::covering::{BLOCK, RectangleBlock, covering};
use antumbra_simd::glance::{Ray, Rays};
use antumbra_simd::pierce::{PierceMemory, pierce};
use antumbra_simd::triangle::CullMode;
use antumbra_simd::vertex::ScreenTransform;

use glam::{DAffine3, DVec3};

use super::Frame;
use crate::cull::Level;
use crate::occluders::{ClusterId, DrawnCluster};
use crate::occlusion::{Footprint, SampleRect, Screen};
use crate::prepare::Cluster;
use crate::scene::{Aabb, is_mirroring};
use crate::view::Projection;

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
    /// The place of its object.
    object: usize,
    /// Its triangles.
    pub triangles: u32,
    /// Where it may be drawn.
    pub footprint: Footprint,
    /// The larger, the more it may cover for what it costs to draw.
    worth: u32,
    /// Whether it is drawn by now.
    is_taken: bool,
}

/// How much a cluster may cover for what it costs to draw: samples a triangle.
fn worth(footprint: Footprint, triangles: u32) -> u32 {
    let area = match footprint {
        Footprint::Nowhere => 0,
        // As much as a picture can have.
        Footprint::Unbounded => u32::MAX,
        Footprint::Within(SampleRect { x, y, .. }) => {
            (x[1] - x[0] + 1) as u32 * (y[1] - y[0] + 1) as u32
        }
    };
    area / triangles
}

/// Clusters that might cover something; keeps its memory from frame to frame.
#[derive(Debug, Default)]
pub struct Covers {
    objects: Vec<u32>,
    /// The clusters that were drawn to begin with, in the order of their ids.
    drawn: Vec<ClusterId>,
    /// Where each may be drawn.
    within: Vec<Footprint>,
    of_objects: Rectangles,
    /// What is known of each object, once it is.
    expanded: Vec<Option<Expanded>>,
    clusters: Vec<Cover>,
    /// The rectangles of the clusters of objects that have several; those of each object begin with a block.
    of_clusters: Rectangles,
    /// The eyes in the local coordinates of these objects, and rays from there; none where rays begin elsewhere.
    eyes: Vec<(DVec3, Rays)>,
    footprints: Vec<Footprint>,
    /// Objects and clusters whose rectangles hold a sample.
    objects_over: Vec<usize>,
    clusters_over: Vec<usize>,
    pierce: PierceMemory,
}

/// What is known of an object.
#[derive(Clone, Debug)]
struct Expanded {
    /// The places of its clusters.
    clusters: Range<usize>,
    /// Where the rectangles of several begin.
    first_block: usize,
    /// From its local coordinates to the screen.
    screen: ScreenTransform,
    /// What its single-sided surfaces leave out.
    single_sided: CullMode,
    /// The place of its eye, if it has one.
    eye: Option<u32>,
}

/// Footprints in places, structure of arrays.
#[derive(Debug, Default)]
struct Rectangles {
    blocks: Vec<RectangleBlock>,
    count: usize,
    masks: Vec<u16>,
}

impl Rectangles {
    fn clear(&mut self) {
        self.blocks.clear();
        self.count = 0;
    }

    /// Goes on with a new block.
    fn end_block(&mut self) {
        self.count = self.blocks.len() * BLOCK;
    }

    fn push(&mut self, footprint: Footprint) {
        let (x, y, nearest) = match footprint {
            Footprint::Nowhere => ([0, -1], [0, -1], f32::NEG_INFINITY),
            Footprint::Unbounded => ([0, i32::MAX], [0, i32::MAX], f32::INFINITY),
            Footprint::Within(rect) => (rect.x, rect.y, rect.nearest_depth),
        };
        let (block, i) = (self.count / BLOCK, self.count % BLOCK);
        if block == self.blocks.len() {
            self.blocks.push(RectangleBlock::EMPTY);
        }
        let block = &mut self.blocks[block];
        for end in 0..2 {
            block.x[end][i] = x[end];
            block.y[end][i] = y[end];
        }
        block.nearest[i] = nearest;
        self.count += 1;
    }

    /// Calls `visit` with the number, counted from the first block, of each in some blocks that holds a sample and reaches nearer.
    fn over(
        &mut self,
        level: Level,
        blocks: Range<usize>,
        sample: Sample,
        mut visit: impl FnMut(usize),
    ) {
        let at = [sample.column, sample.row];
        self.masks.clear();
        covering(
            level,
            &self.blocks[blocks],
            at,
            sample.depth,
            &mut self.masks,
        );
        for (block, &mask) in self.masks.iter().enumerate() {
            let mut left = mask;
            while left != 0 {
                visit(block * BLOCK + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
    }
}

/// Whether something within a footprint may cover a sample.
fn may_cover(footprint: Footprint, sample: Sample) -> bool {
    let holds = |[first, last]: [i32; 2], v: i32| first <= v && v <= last;
    match footprint {
        Footprint::Nowhere => false,
        Footprint::Unbounded => true,
        Footprint::Within(rect) => {
            holds(rect.x, sample.column)
                && holds(rect.y, sample.row)
                && rect.nearest_depth > sample.depth
        }
    }
}

fn is_perspective(screen: &Screen) -> bool {
    matches!(screen.camera().projection(), Projection::Perspective { .. })
}

/// Whether a ray may meet something in a box that hides what is asked about; both in the coordinates of the box.
fn may_be_in(ray: &Ray, eye: DVec3, bounds: &Aabb, sample: Sample) -> bool {
    let (low, high) = (bounds.min - eye, bounds.max - eye);
    ray.may_be_before(low.to_array(), high.to_array(), f64::from(sample.depth))
}

/// The eye in an object's local coordinates, and the rays from there in these coordinates.
fn rays_from_eye(screen: &Screen, place: &DAffine3, from_local: &ScreenTransform) -> (DVec3, Rays) {
    let camera = screen.camera();
    let eye = place.inverse().transform_point3(camera.eye());
    let from_eye = |row: [f64; 4]| [row[0], row[1], row[2], 0.0];
    let rays = Rays::new(&ScreenTransform {
        x: from_eye(from_local.x),
        y: from_eye(from_local.y),
        w: from_eye(from_local.w),
        depth: {
            let [x, y, z, constant] = from_local.depth;
            let at_eye = (x * eye.x + y * eye.y) + z * eye.z;
            [x, y, z, at_eye + constant]
        },
        ..*from_local
    });
    (eye, rays)
}

impl Covers {
    /// Forgets all, and begins with some objects within these footprints, and the clusters that are drawn already.
    pub fn begin(&mut self, objects: &[(u32, Footprint)], drawn: &[DrawnCluster]) {
        self.objects.clear();
        self.within.clear();
        self.of_objects.clear();
        self.expanded.clear();
        self.clusters.clear();
        self.of_clusters.clear();
        self.eyes.clear();
        for &(object, footprint) in objects {
            self.objects.push(object);
            self.within.push(footprint);
            self.of_objects.push(footprint);
        }
        self.expanded.resize(objects.len(), None);
        self.drawn.clear();
        self.drawn.extend(drawn.iter().map(|cluster| cluster.id));
        self.drawn.sort_unstable();
    }

    /// The cluster at a place.
    pub fn cluster(&self, place: usize) -> &Cover {
        &self.clusters[place]
    }

    /// Finds the place of a cluster of another object than `of` that covers a sample; of several, the largest on screen for what
    /// it costs to draw.
    pub fn find(
        &mut self,
        frame: &Frame<'_>,
        screen: &Screen,
        sample: Sample,
        of: u32,
    ) -> Option<usize> {
        let level = frame.settings.level;
        let mut objects = std::mem::take(&mut self.objects_over);
        let mut clusters = std::mem::take(&mut self.clusters_over);
        objects.clear();
        clusters.clear();
        let all = 0..self.of_objects.blocks.len();
        self.of_objects
            .over(level, all, sample, |object| objects.push(object));
        let at = [sample.column, sample.row];
        let eye = screen.camera().eye();
        let ray = is_perspective(screen).then(|| Ray::through(screen.rays(), at));
        for &object in &objects {
            let number = self.objects[object];
            let bounds = &frame.scene.bounds()[number as usize];
            // Most rays that pass through the rectangle miss the box, or enter it behind what is to be hidden.
            let may_cover = number != of
                && ray
                    .as_ref()
                    .is_none_or(|ray| may_be_in(ray, eye, bounds, sample));
            if !may_cover {
                continue;
            }
            if self.expanded[object].is_none() {
                self.expand(frame, screen, object);
            }
            let Some(expanded) = &self.expanded[object] else {
                continue;
            };
            let (first, count) = (expanded.clusters.start, expanded.clusters.len());
            if count == 1 {
                clusters.push(first);
            } else {
                let blocks = expanded.first_block..expanded.first_block + count.div_ceil(BLOCK);
                let mesh = frame
                    .occluders
                    .mesh_of(&frame.scene.objects()[number as usize]);
                let eye = expanded.eye.map(|eye| {
                    let (eye, rays) = &self.eyes[eye as usize];
                    (*eye, Ray::through(rays, at))
                });
                self.of_clusters.over(level, blocks, sample, |i| {
                    let place = first + i;
                    let may_cover = match (mesh, &eye) {
                        (Some(mesh), Some((eye, ray))) => {
                            let cluster = self.clusters[place].id.cluster as usize;
                            may_be_in(ray, *eye, &mesh.clusters()[cluster].bounds(), sample)
                        }
                        _ => true,
                    };
                    if may_cover {
                        clusters.push(place);
                    }
                });
            }
        }
        let mut best = None;
        let mut most = 0;
        for &place in &clusters {
            // What is not worth more need not be asked.
            let worth = self.clusters[place].worth;
            if (best.is_none() || worth > most) && self.covers(frame, place, sample) {
                best = Some(place);
                most = worth;
            }
        }
        self.objects_over = objects;
        self.clusters_over = clusters;
        best
    }

    /// Whether what is to be drawn of a cluster covers a sample.
    pub fn covers(&mut self, frame: &Frame<'_>, place: usize, sample: Sample) -> bool {
        let &Cover {
            id,
            object,
            footprint,
            is_taken,
            ..
        } = self.cluster(place);
        if is_taken || !may_cover(footprint, sample) {
            return false;
        }
        let mesh = frame
            .occluders
            .mesh_of(&frame.scene.objects()[id.object as usize]);
        let Some((mesh, expanded)) = mesh.zip(self.expanded[object].as_ref()) else {
            return false;
        };
        let cluster = id.cluster as usize;
        let cull = if mesh.clusters()[cluster].double_sided {
            CullMode::None
        } else {
            expanded.single_sided
        };
        let at = [sample.column, sample.row];
        let geometry = mesh.geometry(cluster).for_loops();
        let (level, screen) = (frame.settings.level, &expanded.screen);
        let depth = pierce(level, geometry, screen, cull, at, &mut self.pierce);
        depth.is_some_and(|depth| depth > f64::from(sample.depth))
    }

    /// Takes the cluster at a place away, which is drawn.
    pub fn take(&mut self, place: usize) {
        self.clusters[place].is_taken = true;
    }

    fn expand(&mut self, frame: &Frame<'_>, screen: &Screen, object: usize) {
        let place = &frame.scene.objects()[self.objects[object] as usize].world_from_local;
        let from_local = screen.screen_from_local(place);
        let first = self.clusters.len();
        self.find_clusters(frame, screen, object, &from_local);
        let clusters = first..self.clusters.len();
        let first_block = self.of_clusters.blocks.len();
        let mut eye = None;
        if clusters.len() > 1 {
            for cluster in &self.clusters[clusters.clone()] {
                self.of_clusters.push(cluster.footprint);
            }
            self.of_clusters.end_block();
            if is_perspective(screen) {
                eye = Some(self.eyes.len() as u32);
                self.eyes.push(rays_from_eye(screen, place, &from_local));
            }
        }
        self.expanded[object] = Some(Expanded {
            clusters,
            first_block,
            screen: from_local,
            single_sided: if is_mirroring(place) {
                CullMode::Front
            } else {
                CullMode::Back
            },
            eye,
        });
    }

    fn find_clusters(
        &mut self,
        frame: &Frame<'_>,
        screen: &Screen,
        index: usize,
        from_local: &ScreenTransform,
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
        let clusters = mesh.clusters();
        self.footprints.clear();
        if clusters.len() == 1 {
            self.footprints.push(self.within[index]);
        } else {
            let boxes = clusters.iter().map(Cluster::bounds);
            let level = frame.settings.level;
            screen.footprints_of_local_boxes(
                level,
                from_local,
                bounds,
                boxes,
                &mut self.footprints,
            );
        }
        let first = self.drawn.partition_point(|id| id.object < number);
        let mut drawn = self.drawn[first..].iter().peekable();
        for (place, (cluster, &footprint)) in (0..).zip(clusters.iter().zip(&self.footprints)) {
            let id = ClusterId {
                object: number,
                cluster: place,
            };
            let is_drawn = drawn.next_if_eq(&&id).is_some();
            if footprint != Footprint::Nowhere && !is_drawn {
                self.clusters.push(Cover {
                    id,
                    object: index,
                    triangles: u32::from(cluster.triangle_count),
                    footprint,
                    worth: worth(footprint, u32::from(cluster.triangle_count)),
                    is_taken: false,
                });
            }
        }
    }
}
