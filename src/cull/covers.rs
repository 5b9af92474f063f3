//! What might cover a sample: clusters of objects that are not known to be hidden, which are not drawn yet.
//!
//! Objects are looked through by their boxes' rectangles, the clusters of each by the hierarchy above them, and only what the ray
//! through the sample may meet is projected.

use antumbra_simd::covering::{BLOCK, RectangleBlock, covering};
use antumbra_simd::glance::{Ray, Rays};
use antumbra_simd::pierce::{PierceMemory, pierce};
use antumbra_simd::tree::descend;
use antumbra_simd::triangle::CullMode;
use antumbra_simd::vertex::ScreenTransform;

use glam::DAffine3;

use super::Frame;
use crate::cull::Level;
use crate::occluders::DrawnCluster;
use crate::occlusion::{Footprint, SampleRect, Screen};
use crate::prepare::{Cluster, ClusterId, ClusteredMesh};
use crate::scene::{Aabb, is_mirroring};
use crate::view::{MapScale, Projection};

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
    /// The place of its object.
    place: usize,
}

/// How finely a surface is cut should not decide what a frame takes. So of objects with so many triangles, or of all where holes may be
/// ignored, a budget that is chosen by what pays draws only clusters with so many pixels a triangle to close a gap,
const MANY_TRIANGLES: u32 = 4096;
const FEWEST_PIXELS_A_TRIANGLE: u32 = 8;
/// and looks for them only where the whole object has so many.
const FEWEST_OF_OBJECT: u32 = 4;

/// How much an object or a cluster may cover for what it costs to draw: pixels of the picture a triangle.
fn worth(scale: MapScale, footprint: Footprint, triangles: u32) -> u32 {
    let area = match footprint {
        Footprint::Nowhere => 0,
        // As much as a picture can have.
        Footprint::Unbounded => u32::MAX,
        Footprint::Within(SampleRect { x, y, .. }) => {
            let samples = (x[1] - x[0] + 1) as u32 * (y[1] - y[0] + 1) as u32;
            samples * scale.pixels() * scale.pixels()
        }
    };
    area / triangles
}

/// The same for the clusters of one object, which are about as far away as each other: the surface of the box for each triangle.
fn surface_of(cluster: &Cluster) -> f32 {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|axis| cluster.max[axis] - cluster.min[axis]);
    (x * y + y * z + z * x) / f32::from(cluster.triangle_count)
}

/// Clusters that might cover something; keeps its memory from frame to frame.
#[derive(Debug, Default)]
pub struct Covers {
    objects: Vec<u32>,
    /// Where each may be drawn.
    within: Vec<Footprint>,
    of_objects: Rectangles,
    /// What is known of each object, once it is.
    placed: Vec<Option<Placed>>,
    /// The clusters that are drawn, in the order of their ids.
    drawn: Vec<ClusterId>,
    /// Keys of objects that sort them by worth.
    keys: Vec<u64>,
    /// Objects whose rectangles hold a sample,
    objects_over: Vec<usize>,
    /// and clusters of one of them that its ray may meet.
    entered: Vec<u32>,
    footprints: Vec<Footprint>,
    pending: Vec<(u32, u32)>,
    pierce: PierceMemory,
}

/// What is known of an object.
#[derive(Clone, Copy, Debug)]
struct Placed {
    /// From its local coordinates to the screen.
    screen: ScreenTransform,
    /// What its single-sided surfaces leave out.
    single_sided: CullMode,
    /// The eye in its local coordinates, and the rays from there.
    eye: [f64; 3],
    rays: Rays,
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

    /// Calls `visit` with the number of each that holds a sample and reaches nearer.
    fn over(&mut self, level: Level, sample: Sample, mut visit: impl FnMut(usize)) {
        let at = [sample.column, sample.row];
        self.masks.clear();
        covering(level, &self.blocks, at, sample.depth, &mut self.masks);
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

/// The eye in an object's local coordinates, and the rays from there in these coordinates. Without perspective there is no eye, and
/// rays begin anywhere.
fn local_rays(screen: &Screen, place: &DAffine3, from_local: &ScreenTransform) -> ([f64; 3], Rays) {
    let camera = screen.camera();
    if !matches!(camera.projection(), Projection::Perspective { .. }) {
        return ([0.0; 3], Rays::new(from_local));
    }
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
    (eye.to_array(), rays)
}

impl Placed {
    fn new(screen: &Screen, place: &DAffine3, bounds: &Aabb) -> Placed {
        let from_local = screen.screen_from_local(place, bounds);
        let (eye, rays) = local_rays(screen, place, &from_local);
        Placed {
            screen: from_local,
            single_sided: if is_mirroring(place) {
                CullMode::Front
            } else {
                CullMode::Back
            },
            eye,
            rays,
        }
    }
}

impl Covers {
    /// Forgets all, and begins with some objects within these footprints, and the clusters that are drawn already.
    pub fn begin(
        &mut self,
        frame: &Frame<'_>,
        objects: &[(u32, Footprint)],
        drawn: &[DrawnCluster],
    ) {
        self.objects.clear();
        self.within.clear();
        self.of_objects.clear();
        self.placed.clear();
        self.keys.clear();
        let pays = frame.settings.budget.is_for_what_pays();
        let is_approximate = !frame.settings.accuracy.is_exact();
        for (place, &(object, footprint)) in (0..).zip(objects) {
            let triangles = frame.occluders.triangles_of(object);
            let worth = worth(frame.settings.map_scale, footprint, triangles.max(1));
            let is_fine = pays && (is_approximate || triangles >= MANY_TRIANGLES);
            if triangles > 0 && (!is_fine || worth >= FEWEST_OF_OBJECT) {
                self.keys.push(u64::from(!worth) << 32 | place);
            }
        }
        self.keys.sort_unstable();
        for key in &self.keys {
            let (object, footprint) = objects[*key as u32 as usize];
            self.objects.push(object);
            self.within.push(footprint);
            self.of_objects.push(footprint);
        }
        self.placed.resize(self.objects.len(), None);
        self.drawn.clear();
        self.drawn.extend(drawn.iter().map(|cluster| cluster.id));
        self.drawn.sort_unstable();
    }

    /// Finds a cluster of another object than `of` that covers a sample: of the object that is largest on screen for its triangles.
    pub fn find(
        &mut self,
        frame: &Frame<'_>,
        screen: &Screen,
        sample: Sample,
        of: u32,
    ) -> Option<Cover> {
        let mut objects = std::mem::take(&mut self.objects_over);
        objects.clear();
        let level = frame.settings.level;
        self.of_objects
            .over(level, sample, |object| objects.push(object));
        let at = [sample.column, sample.row];
        let ray = Ray::through(screen.rays(), screen.camera().eye().to_array(), at);
        let mut found = None;
        for &object in &objects {
            let number = self.objects[object];
            let bounds = &frame.scene.bounds()[number as usize];
            // Most rays that pass through the rectangle miss the box, or enter it behind what is to be hidden.
            let (low, high) = (bounds.min.to_array(), bounds.max.to_array());
            if number != of && ray.may_be_before(low, high, f64::from(sample.depth)) {
                found = self.find_in(frame, screen, sample, object);
                if found.is_some() {
                    break;
                }
            }
        }
        self.objects_over = objects;
        found
    }

    /// Finds a cluster of an object that covers a sample: the largest for its triangles.
    fn find_in(
        &mut self,
        frame: &Frame<'_>,
        screen: &Screen,
        sample: Sample,
        place: usize,
    ) -> Option<Cover> {
        let number = self.objects[place];
        let object = &frame.scene.objects()[number as usize];
        let mesh = frame.occluders.mesh_of(object)?;
        let bounds = &frame.scene.bounds()[number as usize];
        // A proxy hides nothing while its object reaches the near plane.
        if object.occluder_proxy.is_some()
            && screen.footprint_of_aabb(bounds) == Footprint::Unbounded
        {
            return None;
        }
        let placed = self.placed[place]
            .get_or_insert_with(|| Placed::new(screen, &object.world_from_local, bounds));
        let (level, scale) = (frame.settings.level, frame.settings.map_scale);
        let clusters = mesh.clusters();
        let is_fine = frame.settings.budget.is_for_what_pays()
            && (!frame.settings.accuracy.is_exact()
                || mesh.triangle_count() >= MANY_TRIANGLES as usize);
        self.entered.clear();
        if clusters.len() == 1 {
            self.entered.push(0);
        } else {
            let ray = Ray::through(&placed.rays, placed.eye, [sample.column, sample.row]);
            let tree = mesh.tree().for_loops();
            let (depth, pending) = (f64::from(sample.depth), &mut self.pending);
            descend(level, tree, &ray, depth, pending, &mut self.entered);
            let value = |&cluster: &u32| surface_of(&clusters[cluster as usize]);
            self.entered
                .sort_unstable_by(|a, b| value(b).total_cmp(&value(a)).then(a.cmp(b)));
        }
        for i in 0..self.entered.len() {
            let cluster = self.entered[i];
            let id = ClusterId {
                object: number,
                cluster,
            };
            if self.drawn.binary_search(&id).is_ok()
                || !self.pierces(level, mesh, place, cluster, sample)
            {
                continue;
            }
            let footprint = if clusters.len() == 1 {
                self.within[place]
            } else {
                let placed = self.placed[place].as_ref()?;
                let bounds_of_it = std::iter::once(clusters[cluster as usize].bounds());
                self.footprints.clear();
                let (footprints, place) = (&mut self.footprints, &placed.screen);
                screen.footprints_of_local_boxes(level, place, bounds, bounds_of_it, footprints);
                self.footprints[0]
            };
            let triangles = u32::from(clusters[cluster as usize].triangle_count);
            if may_cover(footprint, sample)
                && (!is_fine || worth(scale, footprint, triangles) >= FEWEST_PIXELS_A_TRIANGLE)
            {
                return Some(Cover {
                    id,
                    triangles,
                    footprint,
                    place,
                });
            }
        }
        None
    }

    /// Whether what is to be drawn of a cluster that was found covers a sample.
    pub fn covers(&mut self, frame: &Frame<'_>, cover: &Cover, sample: Sample) -> bool {
        let object = &frame.scene.objects()[cover.id.object as usize];
        let level = frame.settings.level;
        may_cover(cover.footprint, sample)
            && frame.occluders.mesh_of(object).is_some_and(|mesh| {
                self.pierces(level, mesh, cover.place, cover.id.cluster, sample)
            })
    }

    /// Whether the ray through a sample meets a cluster of the object in a place nearer than the sample's depth.
    fn pierces(
        &mut self,
        level: Level,
        mesh: &ClusteredMesh,
        place: usize,
        cluster: u32,
        sample: Sample,
    ) -> bool {
        let Some(placed) = &self.placed[place] else {
            return false;
        };
        let cluster = cluster as usize;
        let cull = if mesh.clusters()[cluster].double_sided {
            CullMode::None
        } else {
            placed.single_sided
        };
        let at = [sample.column, sample.row];
        let geometry = mesh.geometry(cluster).for_loops();
        let depth = pierce(level, geometry, &placed.screen, cull, at, &mut self.pierce);
        depth.is_some_and(|depth| depth > f64::from(sample.depth))
    }

    /// Notes that a cluster is drawn.
    pub fn take(&mut self, id: ClusterId) {
        if let Err(place) = self.drawn.binary_search(&id) {
            self.drawn.insert(place, id);
        }
    }
}
