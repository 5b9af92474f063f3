//! What is drawn to, and how it is read back.
//!
//! ```text
//!   solid surfaces ─→ light, depths ─→ creases, background ─→ composed ─→ sRGB ─→ picture
//!                                      translucent surfaces ──↗
//! ```

use bytemuck::{Pod, Zeroable, cast_slice, pod_collect_to_vec};
use std::sync::mpsc::channel;

use super::GpuError;
use super::device::Device;
use super::draws::View;
use super::pipelines::{DEPTH_FORMAT, OWNER_FORMAT, PICTURE_FORMAT, Pipelines};
use crate::final_pass::creases::{self, Creases, Scale};
use crate::final_pass::image::SrgbTable;
use crate::final_pass::light;
use crate::view::{Camera, PictureSize, Projection};

/// `Picture` as `picture.wgsl` has it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct PictureUniform {
    background_top: [f32; 3],
    height: f32,
    background_bottom: [f32; 3],
    pixels: f32,
    depth: [f32; 2],
    creases: [f32; 2],
    perspective: f32,
    steps: u32,
    unused: [u32; 2],
}

impl PictureUniform {
    /// Of a camera's pictures.
    pub fn new(
        view: &View,
        camera: &Camera,
        size: PictureSize,
        creases: &Creases,
    ) -> PictureUniform {
        let (Scale::Relative(pixels) | Scale::Absolute(pixels)) = creases.scale();
        let perspective = matches!(camera.projection(), Projection::Perspective { .. });
        PictureUniform {
            background_top: light::BACKGROUND_TOP,
            height: size.height() as f32,
            background_bottom: light::BACKGROUND_BOTTOM,
            pixels,
            depth: view.depth_of_z(),
            creases: [creases::DARKEST, creases::BRIGHTEST],
            perspective: f32::from(u8::from(perspective)),
            steps: creases.steps().len() as u32,
            unused: [0; 2],
        }
    }
}

/// What a picture is drawn to.
#[derive(Debug)]
pub struct Targets {
    size: PictureSize,
    light: wgpu::TextureView,
    depths: wgpu::TextureView,
    composed: wgpu::TextureView,
    picture: ReadBack,
    steps: wgpu::Buffer,
    srgb: wgpu::Buffer,
    /// Solid light and its depths.
    from_solid: wgpu::BindGroup,
    /// All light.
    from_composed: wgpu::BindGroup,
    /// Of the frame being drawn.
    uniform: Option<wgpu::BindGroup>,
}

/// What owners of pixels are drawn to.
#[derive(Debug)]
pub struct OwnerTargets {
    depths: wgpu::TextureView,
    owners: ReadBack,
}

/// A texture of four bytes a pixel, and a buffer to read it from.
#[derive(Debug)]
struct ReadBack {
    size: PictureSize,
    view: wgpu::TextureView,
    buffer: wgpu::Buffer,
    bytes_per_row: u32,
}

const USED: wgpu::TextureUsages = wgpu::TextureUsages::RENDER_ATTACHMENT;

fn extent(size: PictureSize) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: size.width() as u32,
        height: size.height() as u32,
        depth_or_array_layers: 1,
    }
}

fn texture(
    device: &Device,
    size: PictureSize,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureView {
    let texture = device.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

impl Targets {
    /// For pictures of a size.
    pub fn new(
        device: &Device,
        pipelines: &Pipelines,
        size: PictureSize,
        creases: &Creases,
    ) -> Targets {
        let read = USED | wgpu::TextureUsages::TEXTURE_BINDING;
        let light = texture(device, size, device.light_format, read);
        let composed = texture(device, size, device.light_format, read);
        let depths = texture(device, size, DEPTH_FORMAT, read);
        let step = |&([x, y], per_length): &([i32; 2], f32)| [x as f32, y as f32, per_length, 0.0];
        let steps: Vec<[f32; 4]> = creases.steps().iter().map(step).collect();
        let storage = |bytes: &[u8]| device.buffer(bytes, wgpu::BufferUsages::STORAGE);
        let source = |light: &wgpu::TextureView| {
            let resources = [light, &depths].map(wgpu::BindingResource::TextureView);
            device.bind(&pipelines.source_layout, &resources)
        };
        Targets {
            size,
            picture: ReadBack::new(device, size, PICTURE_FORMAT),
            steps: storage(cast_slice(&steps)),
            srgb: storage(SrgbTable::new().bytes()),
            from_solid: source(&light),
            from_composed: source(&composed),
            uniform: None,
            light,
            depths,
            composed,
        }
    }

    /// The pictures' size.
    pub fn size(&self) -> PictureSize {
        self.size
    }

    /// Begins a picture with its solid surfaces.
    pub fn begin_solid<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        begin(
            encoder,
            &self.light,
            CLEARED,
            Some((&self.depths, NO_DEPTH)),
        )
    }

    /// Draws what is made of them: creases, and the background.
    pub fn crease(
        &mut self,
        device: &Device,
        pipelines: &Pipelines,
        uniform: &PictureUniform,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        let uniform = device.uniform(uniform);
        let resources = [&uniform, &self.steps, &self.srgb].map(wgpu::Buffer::as_entire_binding);
        let uniform = device.bind(&pipelines.picture_layout, &resources);
        let uniform = self.uniform.insert(uniform);
        let mut pass = begin(encoder, &self.composed, CLEARED, None);
        pass.set_pipeline(&pipelines.crease);
        pass.set_bind_group(0, &*uniform, &[]);
        pass.set_bind_group(1, &self.from_solid, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Goes on with translucent surfaces.
    pub fn begin_translucent<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
    ) -> wgpu::RenderPass<'e> {
        let depths = Some((&self.depths, wgpu::LoadOp::Load));
        begin(encoder, &self.composed, wgpu::LoadOp::Load, depths)
    }

    /// Ends a picture: encodes it.
    pub fn encode(&self, pipelines: &Pipelines, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = begin(encoder, &self.picture.view, CLEARED, None);
        pass.set_pipeline(&pipelines.encode);
        pass.set_bind_group(0, &self.uniform, &[]);
        pass.set_bind_group(1, &self.from_composed, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Has the commands carried out, and reads the picture.
    pub fn read_picture(
        &self,
        device: &Device,
        encoder: wgpu::CommandEncoder,
    ) -> Result<Vec<[u8; 3]>, GpuError> {
        let pixels: Vec<[u8; 4]> = self.picture.read(device, encoder)?;
        Ok(pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect())
    }
}

impl OwnerTargets {
    /// For pictures of a size.
    pub fn new(device: &Device, size: PictureSize) -> OwnerTargets {
        OwnerTargets {
            depths: texture(device, size, DEPTH_FORMAT, USED),
            owners: ReadBack::new(device, size, OWNER_FORMAT),
        }
    }

    /// Begins to draw.
    pub fn begin<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        let nobody = wgpu::LoadOp::Clear(wgpu::Color {
            r: f64::from(super::NOBODY),
            ..wgpu::Color::TRANSPARENT
        });
        begin(
            encoder,
            &self.owners.view,
            nobody,
            Some((&self.depths, NO_DEPTH)),
        )
    }

    /// Has the commands carried out, and reads the owners.
    pub fn read(
        &self,
        device: &Device,
        encoder: wgpu::CommandEncoder,
    ) -> Result<Vec<u32>, GpuError> {
        self.owners.read(device, encoder)
    }
}

const CLEARED: wgpu::LoadOp<wgpu::Color> = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
/// Infinitely far.
const NO_DEPTH: wgpu::LoadOp<f32> = wgpu::LoadOp::Clear(0.0);

/// Begins to draw to a texture, perhaps with depths.
fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    color: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
    depths: Option<(&wgpu::TextureView, wgpu::LoadOp<f32>)>,
) -> wgpu::RenderPass<'e> {
    let depths = depths.map(|(view, load)| wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load,
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    });
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: color,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load,
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: depths,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}

impl ReadBack {
    fn new(device: &Device, size: PictureSize, format: wgpu::TextureFormat) -> ReadBack {
        let bytes_per_row = 4 * size.width() as u32;
        let bytes_per_row = bytes_per_row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(bytes_per_row) * size.height() as u64,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        ReadBack {
            size,
            view: texture(device, size, format, USED | wgpu::TextureUsages::COPY_SRC),
            buffer,
            bytes_per_row,
        }
    }

    /// Has the commands carried out, and reads the pixels, row by row.
    fn read<T: Pod>(
        &self,
        device: &Device,
        mut encoder: wgpu::CommandEncoder,
    ) -> Result<Vec<T>, GpuError> {
        encoder.copy_texture_to_buffer(
            self.view.texture().as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.bytes_per_row),
                    rows_per_image: None,
                },
            },
            extent(self.size),
        );
        device.queue.submit([encoder.finish()]);
        let (sender, mapped) = channel();
        self.buffer
            .map_async(wgpu::MapMode::Read, .., move |result| {
                // Nobody waits any more if waiting failed.
                let _ = sender.send(result);
            });
        let waited = device.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|e| device.failed(e))?;
        let mapped = mapped.recv().map_err(|e| device.failed(e))?;
        mapped.map_err(|e| device.failed(e))?;
        let range = self.buffer.get_mapped_range(..);
        let bytes = range.map_err(|e| device.failed(e))?;
        let rows = bytes.chunks_exact(self.bytes_per_row as usize);
        let pixels = rows.flat_map(|row| pod_collect_to_vec(&row[..4 * self.size.width()]));
        let pixels = pixels.collect();
        drop(bytes);
        self.buffer.unmap();
        Ok(pixels)
    }
}
