//! The query interface for engines that have their own scene.

use std::sync::OnceLock;

use antumbra_simd::closer::{is_box_hidden, is_outline_hidden, open_sample};
use antumbra_simd::glance::{Looks, Slabs, is_seen, looks};
use antumbra_simd::projected::CornerBox;
use antumbra_simd::query::Rectangle;
use antumbra_simd::triangle::Triangle;
use antumbra_simd::{Level, PART_HEIGHT, TILE_SIZE};
use glam::{DAffine3, DVec3};

use super::holes::Holes;
use super::overlap::{mask_in_tile, tiles_of};
use super::projected_box::rectangle;
use super::{Accuracy, Footprint, OcclusionMap, ProjectedBox, SampleRect, Screen};
use crate::raster::{Assembler, BlockList, CullMode, Geometry, TileBuffer};
use crate::scene::{Aabb, OrientedBox, is_mirroring};
use crate::tasks::Tasks;
use crate::view::{Camera, MapScale, PictureSize, Slack};

/// The answer to a question: the continuum between hidden and seen (HOM §5.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Visibility {
    /// It covers no sample of the picture: it lies outside, or between samples.
    Outside,
    /// Nothing of it can reach a pixel.
    Occluded,
    /// Something of it may reach a pixel: about this share of it, more than 0 and up to 1. It is the share of eight samples at
    /// which it shows, half a sample at least; what reaches the near plane is seen as a whole. A caller may take a coarser model
    /// for what is hardly seen.
    Visible(f32),
}

impl Visibility {
    /// Whether nothing of it can reach a pixel.
    pub fn is_hidden(self) -> bool {
        self.level() == 0.0
    }

    /// About what share of it may be seen: 0 if it is hidden.
    pub fn level(self) -> f32 {
        match self {
            Visibility::Outside | Visibility::Occluded => 0.0,
            Visibility::Visible(level) => level,
        }
    }

    /// Of something that shows at so many of eight samples.
    fn seen_at(samples: u32) -> Visibility {
        Visibility::Visible((samples as f32).max(0.5) / 8.0)
    }
}

/// Something opaque to draw into an [`OcclusionBuffer`].
#[derive(Clone, Copy, Debug)]
pub struct Occluder<'a> {
    /// Positions and indices, local coordinates.
    pub geometry: Geometry<'a>,
    /// From local to world coordinates. Answers are exact as long as local coordinates, times the matrix's scale, and
    /// its translation are not a thousand times larger than the world coordinates that they cancel to.
    pub world_from_local: DAffine3,
    /// Which faces to leave out. A face's front is where its vertices run counter-clockwise in local coordinates: a
    /// matrix that mirrors does not turn a mesh inside out.
    pub cull_mode: CullMode,
}

/// A ball, world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The middle.
    pub center: DVec3,
    /// The radius.
    pub radius: f64,
}

/// A rectangle is looked at in so many eighths from left to right, and from top to bottom.
const LOOKED_AT: [[i32; 2]; 8] = [
    [4, 4],
    [2, 2],
    [6, 6],
    [2, 6],
    [6, 2],
    [4, 1],
    [1, 4],
    [7, 4],
];

/// Draws occluders and answers whether shapes are hidden behind them.
///
/// Each frame: [`clear`](OcclusionBuffer::clear) with the camera, [`draw`](OcclusionBuffer::draw) occluders, nearest
/// first for speed, [`finish`](OcclusionBuffer::finish), and ask, from any number of threads.
///
/// ```
/// use antumbra::glam::{DAffine3, DVec3};
/// use antumbra::occlusion::{Occluder, OcclusionBuffer};
/// use antumbra::raster::{CullMode, Geometry, Positions};
/// use antumbra::scene::Aabb;
/// use antumbra::view::{Camera, PictureSize, Projection};
///
/// let size = PictureSize::new(640, 480)?;
/// let projection = Projection::Perspective { fov_y: 1.0, near: 0.1, far: None };
/// let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection)?;
///
/// let wall = [[-9.0, -9.0, -5.0], [9.0, -9.0, -5.0], [9.0, 9.0, -5.0], [-9.0, 9.0, -5.0]];
/// let mut buffer = OcclusionBuffer::new(size, camera);
/// buffer.draw(&Occluder {
///     geometry: Geometry::new(Positions::packed(&wall), &[0, 1, 2, 0, 2, 3])?,
///     world_from_local: DAffine3::IDENTITY,
///     cull_mode: CullMode::Back,
/// });
/// buffer.finish();
///
/// let cube_at = |z: f64| Aabb { min: DVec3::new(-1.0, -1.0, z - 1.0), max: DVec3::new(1.0, 1.0, z + 1.0) };
/// assert!(buffer.test_aabb(&cube_at(-9.0)).is_hidden());
/// assert!(!buffer.test_aabb(&cube_at(-3.0)).is_hidden());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct OcclusionBuffer {
    picture: PictureSize,
    screen: Screen,
    tiles: TileBuffer,
    /// As of the last [`finish`](OcclusionBuffer::finish), if it has been needed since.
    map: OnceLock<OcclusionMap>,
    accuracy: Accuracy,
    /// What is ignored, if anything may be.
    holes: Option<Box<Holes>>,
    assembler: Assembler,
    triangles: Vec<Triangle>,
}

impl OcclusionBuffer {
    /// An empty buffer for pictures of a size, seen by a camera.
    pub fn new(size: PictureSize, camera: Camera) -> OcclusionBuffer {
        OcclusionBuffer::with_map_scale(size, camera, MapScale::Full)
    }

    /// An empty buffer for pictures of a size, with a map of this scale: coarse ones take less time and memory, and hide less.
    pub fn with_map_scale(size: PictureSize, camera: Camera, scale: MapScale) -> OcclusionBuffer {
        OcclusionBuffer::with_slack(size, camera, scale, Slack::NONE)
    }

    /// The same where the final pass is not ours, and may lie this far from it.
    pub fn with_slack(
        size: PictureSize,
        camera: Camera,
        scale: MapScale,
        slack: Slack,
    ) -> OcclusionBuffer {
        let mut buffer = OcclusionBuffer {
            picture: size,
            screen: Screen::with_slack(camera, size, scale, slack),
            map: OnceLock::new(),
            tiles: TileBuffer::with_map_scale(scale.map_size(size), scale),
            accuracy: Accuracy::Exact,
            holes: None,
            assembler: Assembler::default(),
            triangles: Vec::new(),
        };
        buffer.tiles.set_inset(buffer.inset());
        buffer
    }

    /// Sub-pixels of the map by which occluders are pulled in.
    fn inset(&self) -> i32 {
        self.accuracy
            .inset(self.screen.scale(), self.screen.slack())
    }

    /// Sets what may be lost, before anything is drawn; exact at first.
    pub fn set_accuracy(&mut self, accuracy: Accuracy) {
        if accuracy == self.accuracy {
            return;
        }
        let scale = self.screen.scale();
        self.accuracy = accuracy;
        self.tiles.set_inset(self.inset());
        let is_approximate = accuracy.approximation().is_some();
        self.holes = is_approximate.then(|| Box::new(Holes::new(&self.tiles, &accuracy, scale)));
    }

    /// Chooses the instruction set; the best one at first.
    pub fn set_level(&mut self, level: Level) {
        self.tiles.set_level(level);
    }

    /// Forgets all that was drawn and begins a frame.
    pub fn clear(&mut self, camera: &Camera) {
        self.clear_by(Tasks::ALONE, camera);
    }

    /// Forgets all that was drawn and begins a frame, in tasks.
    pub(crate) fn clear_by(&mut self, tasks: Tasks<'_>, camera: &Camera) {
        let (scale, slack) = (self.screen.scale(), self.screen.slack());
        self.screen = Screen::with_slack(*camera, self.picture, scale, slack);
        self.tiles.clear_by(tasks);
        if let Some(holes) = &mut self.holes {
            holes.clear();
        }
    }

    /// Forgets what was drawn in the tiles that a rectangle of samples touches, for the same camera, and confines what is drawn from
    /// now on to their rows, until [`OcclusionBuffer::end_part`].
    pub(crate) fn begin_part(&mut self, x: [i32; 2], y: [i32; 2]) {
        let tiles =
            |[first, last]: [i32; 2]| (first / TILE_SIZE) as usize..(last / TILE_SIZE) as usize + 1;
        self.tiles.clear_within(tiles(x), tiles(y));
    }

    /// Lets be drawn to everywhere again.
    pub(crate) fn end_part(&mut self) {
        self.tiles.draw_everywhere();
    }

    /// Draws an occluder. Triangles with a vertex that is not finite hide nothing.
    pub fn draw(&mut self, occluder: &Occluder<'_>) {
        self.assemble(occluder);
        self.tiles.fill(&self.triangles);
    }

    /// Draws an occluder that lets light through: of opacity 0 all of it, of 1 none. Several of them combine (HOM §4.4), and where what they
    /// let through may be ignored, what is behind the farthest of them is hidden. Where nothing may be ignored, this does
    /// nothing.
    pub fn draw_translucent(&mut self, occluder: &Occluder<'_>, opacity: f32) {
        if self.accuracy.is_exact() {
            return;
        }
        self.assemble(occluder);
        if let Some(holes) = &mut self.holes {
            let opacity = (opacity.clamp(0.0, 1.0) * 255.0) as u8;
            holes.draw_translucent(&self.triangles, opacity, &self.tiles);
        }
    }

    /// Sets an occluder's triangles up.
    fn assemble(&mut self, occluder: &Occluder<'_>) {
        let size = self.tiles.size();
        let bounds = if self.screen.slack().is_none() {
            Aabb::EMPTY
        } else {
            let place = &occluder.world_from_local;
            let corners = occluder.geometry.positions().iter();
            Aabb::around(corners.map(|p| place.transform_point3(DVec3::from(p.map(f64::from)))))
        };
        let screen = self
            .screen
            .screen_from_local(&occluder.world_from_local, &bounds);
        let mirrored = is_mirroring(&occluder.world_from_local);
        let cull = if mirrored {
            occluder.cull_mode.mirrored()
        } else {
            occluder.cull_mode
        };
        self.triangles.clear();
        self.assembler
            .assemble(occluder.geometry, &screen, size, cull, |t, _| {
                self.triangles.push(t);
            });
    }

    /// Draws triangles that were assembled for this buffer's camera and size, list after list, and adds to `gains` what the
    /// owners of the blocks gain.
    pub(crate) fn draw_blocks<'a>(
        &mut self,
        lists: impl Iterator<Item = &'a BlockList> + Clone + Sync,
        gains: &mut [u32],
        tasks: Tasks<'_>,
    ) {
        self.tiles.fill_blocks(lists, gains, tasks);
    }

    /// Prepares for many questions before anything else is drawn: covers the holes that may be ignored, and finds out what large
    /// shapes are hidden by.
    pub(crate) fn find_blocks(&mut self) {
        self.close_holes();
        self.tiles.find_blocks();
    }

    /// Whether a shape is hidden, by its rectangle and its nearest depth alone, from the tiles as they are. "No" may
    /// become "yes".
    pub(crate) fn hides(&self, footprint: Footprint) -> bool {
        match footprint {
            Footprint::Unbounded => false,
            Footprint::Nowhere => true,
            Footprint::Within(SampleRect {
                x,
                y,
                nearest_depth: nearest,
            }) => self.tiles.hides(Rectangle { x, y, nearest }),
        }
    }

    /// Covers the holes that may be ignored, of what is drawn so far.
    pub(crate) fn close_holes(&mut self) {
        if let Some(holes) = &mut self.holes {
            holes.close(&mut self.tiles);
        }
    }

    /// How many pixels of the picture are ignored: samples that nothing covers, but that were covered because
    /// approximate accuracy lets them pass. No other pixel of the picture can be wrong, if the map is as large as the picture or
    /// the distribution factor is 1. Pixels of a coarse map's samples are counted beyond the picture's edge, too.
    pub fn ignored_pixels(&self) -> u64 {
        let per_sample = u64::from(self.screen.scale().pixels()).pow(2);
        self.holes
            .as_ref()
            .map_or(0, |holes| holes.samples() * per_sample)
    }

    /// Ends drawing: covers the holes that may be ignored. Questions asked before this are answered too, from what is drawn.
    pub fn finish(&mut self) {
        self.map.take();
        self.close_holes();
    }

    /// Whether an axis-aligned world box is hidden. A box that reaches the near plane, or is not finite, is visible.
    pub fn test_aabb(&self, bounds: &Aabb) -> Visibility {
        self.test_box(&self.screen.project_aabb(bounds))
    }

    /// Whether a box with any orientation is hidden.
    pub fn test_oriented_box(&self, bounds: &OrientedBox) -> Visibility {
        self.test_box(&self.screen.project_oriented_box(bounds, 0.0))
    }

    /// Whether a box on this buffer's screen is hidden: first by its rectangle and nearest corner, and if those do not
    /// do, by its outline and faces.
    pub fn test_box(&self, projected: &ProjectedBox) -> Visibility {
        let footprint = projected.footprint();
        let Footprint::Within(rect) = footprint else {
            return self.test(footprint);
        };
        if self.hides(footprint) {
            return Visibility::Occluded;
        }
        let (level, tiles) = (self.tiles.level(), self.tiles.layered());
        let (rays, slabs) = (self.screen.rays(), projected.slabs());
        let seen = looks(level, rays, slabs, tiles, rectangle(&rect))
            .seen
            .count_ones();
        let (outline, faces) = (projected.outline(&rect), projected.faces(&rect));
        if seen == 0 && is_outline_hidden(level, tiles, &outline, &faces) {
            return Visibility::Occluded;
        }
        Visibility::seen_at(seen)
    }

    /// Whether a world box is hidden that [`test`](OcclusionBuffer::test) of its footprint does not find hidden.
    pub(crate) fn hides_aabb_closely(&self, bounds: &Aabb, footprint: Footprint) -> bool {
        let Footprint::Within(rect) = footprint else {
            return false;
        };
        self.hides_closely(&self.screen.slabs_of_aabb(bounds), rect, || {
            self.screen.corners_of_aabb(bounds)
        })
    }

    /// Whether what is inside a box with any orientation, off by no more than `error`, is hidden. `around` is the footprint
    /// of something else that it is inside of.
    pub(crate) fn hides_own_box(&self, own: &OrientedBox, error: f64, around: Footprint) -> bool {
        match around {
            Footprint::Within(rect) => {
                self.hides_closely(&self.screen.slabs_of_oriented_box(own), rect, || {
                    self.screen.corners_of_oriented_box(own, error)
                })
            }
            _ => self
                .test_box(&self.screen.project_oriented_box(own, error))
                .is_hidden(),
        }
    }

    /// Whether a box is hidden that its rectangle and nearest corner do not hide.
    fn hides_closely(
        &self,
        slabs: &Slabs,
        rect: SampleRect,
        corners: impl FnOnce() -> CornerBox,
    ) -> bool {
        let (tiles, rectangle) = (self.tiles.layered(), rectangle(&rect));
        !is_seen(
            self.tiles.level(),
            self.screen.rays(),
            slabs,
            tiles,
            rectangle,
        ) && is_box_hidden(
            self.tiles.level(),
            self.screen.view(),
            tiles,
            &corners(),
            rectangle,
        )
    }

    /// At which of a few samples a world box shows itself, whose rectangle this is.
    pub(crate) fn looks_at(&self, bounds: &Aabb, rect: SampleRect) -> Looks {
        let slabs = self.screen.slabs_of_aabb(bounds);
        looks(
            self.tiles.level(),
            self.screen.rays(),
            &slabs,
            self.tiles.layered(),
            rectangle(&rect),
        )
    }

    /// A sample at which a world box shows itself, whose rectangle this is, and its depth there. See [`open_sample`].
    pub(crate) fn open_sample(&self, bounds: &Aabb, rect: SampleRect) -> Option<([i32; 2], f32)> {
        let corners = self.screen.corners_of_aabb(bounds);
        let tiles = self.tiles.layered();
        open_sample(self.screen.view(), tiles, &corners, rectangle(&rect))
    }

    /// Whether a ball is hidden.
    pub fn test_sphere(&self, sphere: &Sphere) -> Visibility {
        self.test(
            self.screen
                .footprint_of_sphere(sphere.center, sphere.radius),
        )
    }

    /// Whether something is hidden of which only a rectangle on screen is known: columns and rows in pixels, fractions
    /// allowed, and the distance of its nearest point along the view direction in scene units.
    pub fn test_rectangle(&self, x: [f64; 2], y: [f64; 2], nearest_distance: f64) -> Visibility {
        self.test(self.screen.footprint_of_rectangle(x, y, nearest_distance))
    }

    /// Whether a shape with this footprint is hidden, by its rectangle and its nearest depth alone.
    pub fn test(&self, footprint: Footprint) -> Visibility {
        match footprint {
            Footprint::Unbounded => Visibility::Visible(1.0),
            Footprint::Nowhere => Visibility::Outside,
            Footprint::Within(_) if self.hides(footprint) => Visibility::Occluded,
            Footprint::Within(rect) => {
                let tiles = self.tiles.layered();
                let at =
                    |[first, last]: [i32; 2], eighths: i32| first + (last - first) * eighths / 8;
                let seen = LOOKED_AT.iter().filter(|&&[x, y]| {
                    !tiles.is_nearer(at(rect.x, x), at(rect.y, y), rect.nearest_depth)
                });
                Visibility::seen_at(seen.count() as u32)
            }
        }
    }

    /// Whether so little is covered around a rectangle that what is in it is visible without a closer look: see
    /// [`Approximation::transparency`](super::Approximation).
    pub(crate) fn is_hardly_covered(&self, rect: &SampleRect) -> bool {
        let holes = self.holes.as_ref();
        holes.is_some_and(|holes| holes.is_hardly_covered(rect))
    }

    /// Whether of the holes that are ignored a rectangle meets a larger part, in a tile, than a share of what may be ignored there.
    pub(crate) fn ignores_more_than(&self, share: f32, rect: &SampleRect) -> bool {
        let Some(holes) = &self.holes else {
            return false;
        };
        let across = self.tiles.size().tiles_across();
        let allowed = share * holes.ignored_in_tile() as f32;
        tiles_of(rect).any(|(x, y)| {
            let ignored = holes.ignored()[y * across + x] & mask_in_tile(rect, x, y);
            ignored.count_ones() as f32 > allowed
        })
    }

    /// The camera and picture size, ready to project shapes.
    pub fn screen(&self) -> &Screen {
        &self.screen
    }

    /// Coverage masks and depths as drawn so far.
    pub fn tiles(&self) -> &TileBuffer {
        &self.tiles
    }

    /// The pyramid of occlusion maps as of the last [`finish`](OcclusionBuffer::finish), holes and all. Answers do without it: it
    /// is built by whoever asks for it first.
    pub fn map(&self) -> &OcclusionMap {
        self.map.get_or_init(|| {
            let mut map = OcclusionMap::new(&self.tiles);
            if let Some(holes) = &self.holes {
                let covered = self.tiles.coverage().iter();
                let solid: Vec<u64> = covered.zip(holes.ignored()).map(|(c, i)| c & !i).collect();
                map.count(self.tiles.level(), &solid);
            }
            map
        })
    }

    /// Whether the pixel at column `x`, row `y` is covered, and if so the conservative depth of its tile part.
    ///
    /// # Panics
    /// If the pixel is outside the picture.
    pub fn pixel(&self, x: usize, y: usize) -> Option<f32> {
        assert!(
            x < self.picture.width() && y < self.picture.height(),
            "pixel ({x}, {y}) is outside the picture"
        );
        let size = self.tiles.size();
        let [x, y] = [x, y].map(|v| v / self.screen.scale().pixels() as usize);
        let tile = y / 8 * size.tiles_across() + x / 8;
        let (column, row) = (x % 8, y % 8);
        let part = row / PART_HEIGHT as usize;
        (self.tiles.coverage()[tile] >> (row * 8 + column) & 1 == 1)
            .then(|| self.tiles.depths()[tile][part])
    }
}
