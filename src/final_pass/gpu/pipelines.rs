//! How things are drawn: a pipeline for each look of a surface and each choice of its sides, and two for whole pictures.

use super::device::Device;

/// Of surfaces in the depth buffer: the larger the nearer.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Of pictures of objects' numbers.
pub const OWNER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Of finished pictures: sRGB, which the shader has encoded.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// What a surface is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Its light; it hides what is farther.
    Solid,
    /// Its light over what is there, if it is nearer; it hides nothing.
    Translucent,
    /// The number of its object; it hides what is farther.
    Owner,
}

/// Which sides of a surface are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Both.
    Both,
    /// What winds counter-clockwise on screen.
    CounterClockwise,
    /// What winds clockwise on screen: fronts that a matrix mirrors.
    Clockwise,
}

impl Sides {
    /// Of a surface.
    pub fn of(double_sided: bool, mirrored: bool) -> Sides {
        match (double_sided, mirrored) {
            (true, _) => Sides::Both,
            (false, false) => Sides::CounterClockwise,
            (false, true) => Sides::Clockwise,
        }
    }

    fn culled(self) -> Option<wgpu::Face> {
        match self {
            Sides::Both => None,
            Sides::CounterClockwise => Some(wgpu::Face::Back),
            Sides::Clockwise => Some(wgpu::Face::Front),
        }
    }
}

/// All of them, and what they are bound to.
#[derive(Debug)]
pub struct Pipelines {
    /// The view, and the records of what is drawn.
    pub frame_layout: wgpu::BindGroupLayout,
    /// Positions and corners.
    pub geometry_layout: wgpu::BindGroupLayout,
    /// What a picture's pixels are made by.
    pub picture_layout: wgpu::BindGroupLayout,
    /// What they are made from: light and depths.
    pub source_layout: wgpu::BindGroupLayout,
    /// By look, and then by sides.
    surfaces: [[wgpu::RenderPipeline; 3]; 3],
    pub crease: wgpu::RenderPipeline,
    pub encode: wgpu::RenderPipeline,
}

impl Pipelines {
    /// Makes them.
    pub fn new(device: &Device) -> Pipelines {
        let gpu = &device.device;
        let (vertex, fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
        let frame_layout = layout(gpu, &[(vertex | fragment, UNIFORM), (vertex, STORAGE)]);
        let geometry_layout = layout(gpu, &[(vertex, STORAGE), (vertex, STORAGE)]);
        let resources = [
            (fragment, UNIFORM),
            (fragment, STORAGE),
            (fragment, STORAGE),
        ];
        let picture_layout = layout(gpu, &resources);
        let source_layout = layout(gpu, &[(fragment, LIGHT), (fragment, DEPTHS)]);

        let draw = gpu.create_shader_module(wgpu::include_wgsl!("draw.wgsl"));
        let bound = [Some(&frame_layout), Some(&geometry_layout)];
        let bound = pipeline_layout(gpu, &bound);
        let surfaces = [Look::Solid, Look::Translucent, Look::Owner].map(|look| {
            [Sides::Both, Sides::CounterClockwise, Sides::Clockwise]
                .map(|sides| surface_pipeline(device, &draw, &bound, look, sides))
        });

        let picture = gpu.create_shader_module(wgpu::include_wgsl!("picture.wgsl"));
        let bound = pipeline_layout(gpu, &[Some(&picture_layout), Some(&source_layout)]);
        let picture_pipeline = |entry: &str, format| {
            gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entry),
                layout: Some(&bound),
                vertex: vertex_state(&picture, "everywhere"),
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &picture,
                    entry_point: Some(entry),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(wgpu::ColorTargetState::from(format))],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let crease = picture_pipeline("crease", device.light_format);
        let encode = picture_pipeline("encode", PICTURE_FORMAT);
        Pipelines {
            frame_layout,
            geometry_layout,
            picture_layout,
            source_layout,
            surfaces,
            crease,
            encode,
        }
    }

    /// The pipeline for a look of a surface and its sides.
    pub fn of(&self, look: Look, sides: Sides) -> &wgpu::RenderPipeline {
        &self.surfaces[look as usize][sides as usize]
    }
}

fn surface_pipeline(
    device: &Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    look: Look,
    sides: Sides,
) -> wgpu::RenderPipeline {
    let (entry, format, blend) = match look {
        Look::Solid => ("light", device.light_format, None),
        Look::Translucent => {
            let over = Some(wgpu::BlendState::ALPHA_BLENDING);
            ("light", device.light_format, over)
        }
        Look::Owner => ("owner", OWNER_FORMAT, None),
    };
    let pipeline = wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: Some(layout),
        vertex: vertex_state(module, "vertex"),
        primitive: wgpu::PrimitiveState {
            cull_mode: sides.culled(),
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(look != Look::Translucent),
            // Strictly nearer: of equals the first drawn stays.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format,
                blend,
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    };
    device.device.create_render_pipeline(&pipeline)
}

fn vertex_state<'a>(module: &'a wgpu::ShaderModule, entry: &'a str) -> wgpu::VertexState<'a> {
    wgpu::VertexState {
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        buffers: &[],
    }
}

const fn buffer_of(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

const fn texture_of(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

const UNIFORM: wgpu::BindingType = buffer_of(wgpu::BufferBindingType::Uniform);
const STORAGE: wgpu::BindingType = buffer_of(wgpu::BufferBindingType::Storage { read_only: true });
const LIGHT: wgpu::BindingType = texture_of(wgpu::TextureSampleType::Float { filterable: false });
const DEPTHS: wgpu::BindingType = texture_of(wgpu::TextureSampleType::Depth);

/// What is bound, numbered from 0, and which stages see it.
fn layout(
    device: &wgpu::Device,
    resources: &[(wgpu::ShaderStages, wgpu::BindingType)],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, &(visibility, ty)): (usize, &_)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility,
        ty,
        count: None,
    };
    let entries: Vec<_> = resources.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}

fn pipeline_layout(
    device: &wgpu::Device,
    bound: &[Option<&wgpu::BindGroupLayout>],
) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: bound,
        immediate_size: 0,
    })
}
