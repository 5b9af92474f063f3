//! What a frame draws: a record for each surface of each object, in scene order, and a list of draws in one indirect buffer.
//!
//! Matrices are made in f64, the eye subtracted first, and become f32 at the end: how far a vertex is off then is a share of its object's
//! size and distance, which [`Slack::GPU`](crate::view::Slack::GPU) has.

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::DVec3;

use super::device::Device;
use super::geometry::Geometry;
use super::pipelines::{Look, Pipelines, Sides};
use crate::final_pass::light::{self, Light, opacity};
use crate::scene::{Material, Scene, is_mirroring};
use crate::view::{Camera, PictureSize, Projection};
use antumbra_simd::SUBPIXELS;
use antumbra_simd::vertex::ScreenTransform;

/// A camera as the device takes it.
#[derive(Clone, Debug)]
pub struct View {
    camera: Camera,
    size: PictureSize,
    from_eye: ScreenTransform,
    /// The depths where z is 0 and 1: the nearer the larger, as everywhere.
    depths: [f64; 2],
}

/// [`View`] as `draw.wgsl` has it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct ViewUniform {
    key_direction: [f32; 3],
    perspective: f32,
    forward: [f32; 3],
    lamp: f32,
    ground: [f32; 3],
    near: f32,
    sky_less_ground: [f32; 3],
    clear_distance: f32,
    key: [f32; 3],
    haze_distance: f32,
    haze: [f32; 3],
    most_haze: f32,
    depth: [f32; 2],
    half_size: [f32; 2],
}

/// `Draw` as `draw.wgsl` has it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct DrawRecord {
    clip: [[f32; 4]; 4],
    from_eye: [[f32; 4]; 3],
    color: [f32; 4],
    object: u32,
    unused: [u32; 3],
}

/// The arguments of an indirect draw.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Arguments {
    corners: u32,
    instances: u32,
    first_corner: u32,
    /// Which record.
    first_instance: u32,
}

/// Draws one after the other that need the same pipeline and buffers.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    chunk: usize,
    sides: Sides,
    first: usize,
    count: usize,
}

/// What is drawn, in order.
#[derive(Clone, Debug, Default)]
pub struct DrawList {
    records: Vec<DrawRecord>,
    arguments: Vec<Arguments>,
    runs: Vec<Run>,
}

/// The same on the device.
#[derive(Debug)]
pub struct UploadedList {
    bound: wgpu::BindGroup,
    /// None where draws are made one by one.
    indirect: Option<wgpu::Buffer>,
    list: DrawList,
}

impl View {
    /// A camera for pictures of a size.
    pub fn new(scene: &Scene, camera: &Camera, size: PictureSize) -> View {
        let from_eye = camera.screen_from_eye(size);
        let near = from_eye.near_depth;
        let farthest = match camera.projection() {
            _ if from_eye.far_depth > f64::NEG_INFINITY => from_eye.far_depth,
            Projection::Perspective { .. } => 0.0,
            // No plane ends the view: the scene does.
            Projection::Orthographic { .. } => {
                let corners = scene.bounds().iter().flat_map(|b| [b.min, b.max]);
                let reach = corners.map(|corner| (corner - camera.eye()).abs());
                let reach = reach.fold(DVec3::ZERO, DVec3::max);
                (-reach.dot(camera.forward().abs()) * 1.001).min(near - 1.0)
            }
        };
        View {
            camera: *camera,
            size,
            from_eye,
            depths: [farthest, near],
        }
    }

    /// Depth as a share of what z is: the depth at 0, and what is to be added for 1.
    pub fn depth_of_z(&self) -> [f32; 2] {
        let [farthest, nearest] = self.depths;
        [farthest as f32, (nearest - farthest) as f32]
    }

    /// What the shader has to know of a view and its light.
    pub fn uniform(&self, camera: &Camera, light: &Light<'_>) -> ViewUniform {
        let single = |v: [f64; 3]| v.map(|v| v as f32);
        let [clear_distance, haze_distance] = light.haze().map(|v| v as f32);
        let perspective = matches!(camera.projection(), Projection::Perspective { .. });
        ViewUniform {
            key_direction: light.key().as_vec3().to_array(),
            perspective: f32::from(u8::from(perspective)),
            forward: camera.forward().as_vec3().to_array(),
            lamp: light::LAMP as f32,
            ground: single(light::GROUND),
            near: camera.projection().near() as f32,
            sky_less_ground: std::array::from_fn(|i| (light::SKY[i] - light::GROUND[i]) as f32),
            clear_distance,
            key: single(light::KEY),
            haze_distance,
            haze: light::HAZE,
            most_haze: light::MOST_HAZE as f32,
            depth: self.depth_of_z(),
            half_size: [self.size.width(), self.size.height()].map(|pixels| pixels as f32 * 0.5),
        }
    }

    /// The rows that take a position relative to `middle` to clip space, from those that take a local position to the screen.
    fn clip_rows(&self, screen: &ScreenTransform, middle: DVec3) -> [[f32; 4]; 4] {
        let half = |pixels: usize| pixels as f64 * f64::from(SUBPIXELS) * 0.5;
        let (half_width, half_height) = (half(self.size.width()), half(self.size.height()));
        let [farthest, nearest] = self.depths;
        let ScreenTransform { x, y, depth, w, .. } = screen;
        let row = |value: &dyn Fn(usize) -> f64| {
            let [a, b, c, constant] = std::array::from_fn(value);
            let constant = constant + DVec3::new(a, b, c).dot(middle);
            [a, b, c, constant].map(|v| v as f32)
        };
        [
            row(&|i| x[i] / half_width - w[i]),
            row(&|i| w[i] - y[i] / half_height),
            row(&|i| (depth[i] - farthest * w[i]) / (nearest - farthest)),
            row(&|i| w[i]),
        ]
    }
}

impl DrawList {
    /// The surfaces that `wanted` says of `objects`, which are in scene order.
    pub fn new(
        scene: &Scene,
        geometry: &Geometry,
        view: &View,
        light: &Light<'_>,
        objects: &[u32],
        wanted: impl Fn(&Material) -> bool,
    ) -> DrawList {
        let mut list = DrawList::default();
        for &number in objects {
            let object = &scene.objects()[number as usize];
            let mesh = &scene.meshes()[object.mesh];
            if !mesh.surfaces.iter().any(|s| wanted(&s.material)) {
                continue;
            }
            let place = geometry.place(object.mesh);
            let local = object.world_from_local;
            let screen = view.camera.placed(&view.from_eye, &local);
            let clip = view.clip_rows(&screen, place.middle);
            let middle = local.matrix3 * place.middle + (local.translation - view.camera.eye());
            let from_eye = std::array::from_fn(|axis| {
                let row = local.matrix3.row(axis);
                [row.x, row.y, row.z, middle[axis]].map(|v| v as f32)
            });
            let mirrored = is_mirroring(&local);
            for surface in mesh.surfaces.iter().filter(|s| wanted(&s.material)) {
                let material = &surface.material;
                let [red, green, blue] = light.base_color(number, material);
                let record = DrawRecord {
                    clip,
                    from_eye,
                    color: [red, green, blue, opacity(material)],
                    object: number,
                    unused: [0; 3],
                };
                let first_corner = place.first_corner + 3 * surface.triangles.start as u32;
                let corners = 3 * surface.triangles.len() as u32;
                let sides = Sides::of(material.double_sided, mirrored);
                list.push(place.chunk, sides, record, first_corner, corners);
            }
        }
        list
    }

    fn push(
        &mut self,
        chunk: usize,
        sides: Sides,
        record: DrawRecord,
        first_corner: u32,
        corners: u32,
    ) {
        let number = self.records.len();
        self.records.push(record);
        self.arguments.push(Arguments {
            corners,
            instances: 1,
            first_corner,
            first_instance: number as u32,
        });
        match self.runs.last_mut() {
            Some(run) if run.chunk == chunk && run.sides == sides => run.count += 1,
            _ => self.runs.push(Run {
                chunk,
                sides,
                first: number,
                count: 1,
            }),
        }
    }

    /// Uploads the list.
    pub fn upload(
        self,
        device: &Device,
        pipelines: &Pipelines,
        view: &wgpu::Buffer,
    ) -> UploadedList {
        let records = device.buffer(cast_slice(&self.records), wgpu::BufferUsages::STORAGE);
        let arguments: &[u8] = cast_slice(&self.arguments);
        UploadedList {
            bound: device.bind(
                &pipelines.frame_layout,
                &[view.as_entire_binding(), records.as_entire_binding()],
            ),
            indirect: device
                .draws_indirectly
                .then(|| device.buffer(arguments, wgpu::BufferUsages::INDIRECT)),
            list: self,
        }
    }
}

impl UploadedList {
    /// Draws it all.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &Pipelines,
        look: Look,
        geometry: &Geometry,
    ) {
        pass.set_bind_group(0, &self.bound, &[]);
        for run in &self.list.runs {
            pass.set_pipeline(pipelines.of(look, run.sides));
            pass.set_bind_group(1, geometry.chunk(run.chunk), &[]);
            if let Some(indirect) = &self.indirect {
                let offset = run.first * size_of::<Arguments>();
                pass.multi_draw_indirect(indirect, offset as u64, run.count as u32);
                continue;
            }
            for a in &self.list.arguments[run.first..][..run.count] {
                let corners = a.first_corner..a.first_corner + a.corners;
                pass.draw(corners, a.first_instance..a.first_instance + 1);
            }
        }
    }
}
