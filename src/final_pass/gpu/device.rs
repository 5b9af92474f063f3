//! The device: found without a window, and asked for all that it can do.

use bytemuck::{NoUninit, bytes_of};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use super::GpuError;

/// A device with a queue.
#[derive(Debug)]
pub struct Device {
    name: String,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Whether one call draws all that a buffer lists.
    pub draws_indirectly: bool,
    /// Of pictures in linear light.
    pub light_format: wgpu::TextureFormat,
    /// The largest buffer that a shader reads, bytes.
    pub largest_buffer: u64,
}

impl Device {
    /// Opens the fastest device.
    pub fn open() -> Result<Device, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            // All that is drawn indirectly is written here, and need not be checked on the device.
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        }));
        let adapter = adapter.map_err(|e| GpuError::NoDevice(e.to_string()))?;
        let info = adapter.get_info();
        let name = format!("{} ({})", info.name, info.backend);
        let capabilities = adapter.get_downlevel_capabilities().flags;
        if !capabilities.contains(wgpu::DownlevelFlags::VERTEX_STORAGE) {
            let why = "its vertex shaders read no storage buffers".to_owned();
            return Err(GpuError::Unfit { device: name, why });
        }
        let wanted = wgpu::Features::FLOAT32_BLENDABLE | wgpu::Features::INDIRECT_FIRST_INSTANCE;
        let features = adapter.features() & wanted;
        let limits = adapter.limits();
        let opened = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            required_features: features,
            required_limits: limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        }));
        let (device, queue) = opened.map_err(|e| GpuError::Unfit {
            device: name.clone(),
            why: e.to_string(),
        })?;
        Ok(Device {
            name,
            device,
            queue,
            draws_indirectly: features.contains(wgpu::Features::INDIRECT_FIRST_INSTANCE)
                && capabilities.contains(wgpu::DownlevelFlags::INDIRECT_EXECUTION),
            light_format: if features.contains(wgpu::Features::FLOAT32_BLENDABLE) {
                wgpu::TextureFormat::Rgba32Float
            } else {
                wgpu::TextureFormat::Rgba16Float
            },
            largest_buffer: limits
                .max_buffer_size
                .min(limits.max_storage_buffer_binding_size),
        })
    }

    /// Its name, and by which interface it is used.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Does something that needs memory of the device, which may be too little.
    pub fn try_to<T>(&self, what: impl FnOnce() -> T) -> Result<T, GpuError> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let done = what();
        match pollster::block_on(scope.pop()) {
            None => Ok(done),
            Some(error) => Err(self.failed(error)),
        }
    }

    /// What the device said when it failed.
    pub fn failed(&self, why: impl ToString) -> GpuError {
        GpuError::Failed {
            device: self.name.clone(),
            why: why.to_string(),
        }
    }

    /// Begins a list of commands.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        let descriptor = wgpu::CommandEncoderDescriptor::default();
        self.device.create_command_encoder(&descriptor)
    }

    /// A buffer with contents; not an empty one.
    pub fn buffer(&self, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer_init(&BufferInitDescriptor {
            label: None,
            contents: if contents.is_empty() {
                &[0; 256]
            } else {
                contents
            },
            usage,
        })
    }

    /// A uniform buffer.
    pub fn uniform(&self, contents: &impl NoUninit) -> wgpu::Buffer {
        self.buffer(bytes_of(contents), wgpu::BufferUsages::UNIFORM)
    }

    /// Resources for a shader, numbered from 0.
    pub fn bind(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let resources = resources.iter().enumerate();
        let entries: Vec<_> = resources
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: binding as u32,
                resource: resource.clone(),
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        })
    }
}
