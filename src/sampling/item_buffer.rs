//! An item buffer: which cluster each pixel of a cube's face shows (HOM §7.5; the hemicube of radiosity, with all six faces).
//!
//! A pixel near a corner of the face is seen at a smaller angle than one in its middle. The solid angle of a pixel of area A on a face
//! at distance 1, whose centre is (u, v, 1), is `A / (1 + u² + v²)^(3/2)`, but for a share that shrinks with A.

use antumbra_simd::triangle::CullMode;

use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::prepare::{Cluster, ClusterGeometry, ClusterId, ClusteredScene};
use crate::raster::{Assembler, Geometry, Positions, for_each_sample};
use crate::scene::{Scene, is_mirroring};
use crate::view::PictureSize;

/// What no cluster owns.
const NOTHING: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Pixel {
    depth: f32,
    /// The place of a cluster among those that were drawn.
    item: u32,
}

/// A face of a cube, drawn with the names of clusters.
#[derive(Debug)]
pub struct ItemBuffer {
    size: PictureSize,
    /// Row by row.
    pixels: Vec<Pixel>,
    /// The solid angle of each pixel, steradians.
    solid_angles: Vec<f64>,
    /// The clusters that were drawn.
    items: Vec<ClusterId>,
    /// What each of them owns.
    sums: Vec<f64>,
    footprints: Vec<Footprint>,
    assembler: Assembler,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl ItemBuffer {
    /// A face of such a size, which shows 90° across and down.
    pub fn new(size: PictureSize) -> ItemBuffer {
        let (width, height) = (size.width(), size.height());
        let middle = |i: usize, count: usize| (2 * i + 1) as f64 / count as f64 - 1.0;
        let area = 4.0 / (width * height) as f64;
        let solid_angle = |i: usize| {
            let (u, v) = (middle(i % width, width), middle(i / width, height));
            let square = 1.0 + u * u + v * v;
            area / (square * square.sqrt())
        };
        ItemBuffer {
            size,
            pixels: Vec::new(),
            solid_angles: (0..width * height).map(solid_angle).collect(),
            items: Vec::new(),
            sums: Vec::new(),
            footprints: Vec::new(),
            assembler: Assembler::default(),
            positions: Vec::new(),
            indices: Vec::new(),
        }
    }

    /// Draws the occluding clusters of `objects`, in scene order, as they are seen through the screen of `culled`. Those that it hides are
    /// left out: they own no pixel.
    pub fn draw(
        &mut self,
        scene: &Scene,
        clusters: &ClusteredScene,
        objects: &[u32],
        culled: &OcclusionBuffer,
    ) {
        let empty = Pixel {
            depth: f32::NEG_INFINITY,
            item: NOTHING,
        };
        self.pixels.clear();
        self.pixels.resize(self.solid_angles.len(), empty);
        self.items.clear();
        let screen = culled.screen();
        for &number in objects {
            let object = &scene.objects()[number as usize];
            let bounds = &scene.bounds()[number as usize];
            let Some(mesh) = clusters.occluder(object) else {
                continue;
            };
            // A proxy hides nothing while its object reaches the near plane.
            let is_proxy = object.occluder_proxy.is_some();
            if is_proxy && screen.footprint_of_aabb(bounds) == Footprint::Unbounded {
                continue;
            }
            let place = &object.world_from_local;
            let from_local = screen.screen_from_local(place, bounds);
            let single_sided = if is_mirroring(place) {
                CullMode::Front
            } else {
                CullMode::Back
            };
            let mut footprints = std::mem::take(&mut self.footprints);
            footprints.clear();
            let boxes = mesh.clusters().iter().map(Cluster::bounds);
            let level = culled.tiles().level();
            screen.footprints_of_local_boxes(level, &from_local, bounds, boxes, &mut footprints);
            for (i, (cluster, &footprint)) in mesh.clusters().iter().zip(&footprints).enumerate() {
                if culled.hides(footprint) {
                    continue;
                }
                let cull = if cluster.double_sided {
                    CullMode::None
                } else {
                    single_sided
                };
                self.set_geometry(mesh.geometry(i));
                self.items.push(ClusterId {
                    object: number,
                    cluster: i as u32,
                });
                self.draw_geometry(&from_local, cull);
            }
            self.footprints = footprints;
        }
    }

    /// Takes a cluster's triangles.
    fn set_geometry(&mut self, geometry: ClusterGeometry<'_>) {
        let ClusterGeometry { x, y, z, .. } = geometry;
        let axes = x.iter().zip(y).zip(z);
        self.positions.clear();
        self.positions.extend(axes.map(|((&x, &y), &z)| [x, y, z]));
        self.indices.clear();
        self.indices
            .extend(geometry.triangles().flatten().map(u32::from));
    }

    /// Draws them in the name of the last item.
    fn draw_geometry(
        &mut self,
        from_local: &antumbra_simd::vertex::ScreenTransform,
        cull: CullMode,
    ) {
        let item = self.items.len() as u32 - 1;
        let positions = Positions::packed(&self.positions);
        // A cluster's indices are whole triangles and in range.
        let Ok(geometry) = Geometry::new(positions, &self.indices) else {
            return;
        };
        let (pixels, size) = (&mut self.pixels, self.size);
        let rows = 0..size.height() as i32;
        let emit = |triangle, _| {
            for_each_sample(&triangle, rows.clone(), |x, y, depth| {
                let pixel = &mut pixels[y as usize * size.width() + x as usize];
                if depth > pixel.depth {
                    *pixel = Pixel { depth, item };
                }
            });
        };
        self.assembler
            .assemble(geometry, from_local, size, cull, emit);
    }

    /// Appends the clusters that own a pixel, in the order they were drawn, each with the solid angle that it owns.
    pub fn add_up(&mut self, seen: &mut Vec<(ClusterId, f64)>) {
        self.sums.clear();
        self.sums.resize(self.items.len(), 0.0);
        for (pixel, solid_angle) in self.pixels.iter().zip(&self.solid_angles) {
            if pixel.item != NOTHING {
                self.sums[pixel.item as usize] += solid_angle;
            }
        }
        let owners = self.items.iter().zip(&self.sums);
        let owners = owners.filter(|&(_, &sum)| sum > 0.0);
        seen.extend(owners.map(|(&id, &sum)| (id, sum)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_faces_are_the_whole_sphere() {
        for side in [16, 128, 256] {
            let face = ItemBuffer::new(PictureSize::new(side, side).expect("a size"));
            let sphere: f64 = 6.0 * face.solid_angles.iter().sum::<f64>();
            let off = (sphere / (4.0 * std::f64::consts::PI) - 1.0).abs();
            assert!(off < 0.5 / f64::from(side * side), "{side}: {off}");
        }
    }

    #[test]
    fn a_pixel_in_a_corner_is_seen_at_a_fifth_of_the_angle() {
        let face = ItemBuffer::new(PictureSize::new(256, 256).expect("a size"));
        let ratio = face.solid_angles[128 * 256 + 128] / face.solid_angles[0];
        // 3 to the power of 3/2.
        assert!((ratio - 5.196).abs() < 0.1, "{ratio}");
    }
}
