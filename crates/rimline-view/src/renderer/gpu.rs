//! The device.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rimline::gpu::Pipelines;
use wgpu::{Features, Limits};

use super::error::RenderError;

/// A device that pictures are drawn on.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The name of the adapter.
    pub name: String,
    /// Whether the device is software, which runs on the CPU.
    pub is_software: bool,
    pub(crate) pipelines: Pipelines,
    is_lost: Arc<AtomicBool>,
}

/// Features that are used where a device has them.
const OPTIONAL: Features = Features::TIMESTAMP_QUERY.union(Features::DEPTH32FLOAT_STENCIL8);

impl Gpu {
    /// Opens an adapter's device: with default limits, and more where big models and pictures need it.
    ///
    /// # Errors
    /// [`RenderError::Adapter`] if the adapter lacks what extraction needs, or gives no device.
    pub async fn open(adapter: &wgpu::Adapter) -> Result<Self, RenderError> {
        let info = adapter.get_info();
        let name = format!("{} ({:?})", info.name, info.backend);
        let refused = |why: String| RenderError::Adapter { name: name.clone(), why };
        if !adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
            return Err(refused("it has no compute shaders".into()));
        }
        let offered = adapter.limits();
        let limits = Limits {
            max_buffer_size: offered.max_buffer_size,
            max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
            max_texture_dimension_2d: offered.max_texture_dimension_2d,
            ..Limits::default().or_worse_values_from(&offered)
        };
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("rimline view"),
                required_features: adapter.features() & OPTIONAL,
                required_limits: limits,
                ..Default::default()
            })
            .await
            .map_err(|error| refused(error.to_string()))?;
        let is_software = info.device_type == wgpu::DeviceType::Cpu;
        let gpu = Self::of(device, queue, name, is_software);
        let is_lost = Arc::clone(&gpu.is_lost);
        gpu.device.set_device_lost_callback(move |_, _| is_lost.store(true, Ordering::Relaxed));
        Ok(gpu)
    }

    /// Takes a device that is there.
    pub fn of(device: wgpu::Device, queue: wgpu::Queue, name: String, is_software: bool) -> Self {
        let pipelines = Pipelines::new(&device);
        Self { device, queue, name, is_software, pipelines, is_lost: Arc::default() }
    }

    /// Whether the device is lost: everything is to be made anew, on another one.
    pub fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Relaxed)
    }

    /// The finest format of depth with a stencil.
    pub(super) fn depth_format(&self) -> wgpu::TextureFormat {
        let finest = wgpu::TextureFormat::Depth32FloatStencil8;
        let has_it = self.device.features().contains(finest.required_features());
        if has_it { finest } else { wgpu::TextureFormat::Depth24PlusStencil8 }
    }

    pub(super) fn filled(&self, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (contents.len() as u64).next_multiple_of(4).max(16),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    pub(super) fn encoder(&self, label: &str) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) })
    }

    pub(super) fn layout(&self, visibility: wgpu::ShaderStages, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
        let entry = |(binding, &ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let entries: Vec<_> = (0..).zip(types).map(entry).collect();
        self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
    }

    pub(super) fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let resources = (0..).zip(resources.iter().cloned());
        let entries: Vec<_> = resources.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }
}

pub(super) const UNIFORM: wgpu::BindingType = buffer_type(wgpu::BufferBindingType::Uniform, false);
pub(super) const UNIFORM_AT_OFFSET: wgpu::BindingType = buffer_type(wgpu::BufferBindingType::Uniform, true);
pub(super) const READ_ONLY: wgpu::BindingType =
    buffer_type(wgpu::BufferBindingType::Storage { read_only: true }, false);
pub(super) const WRITTEN: wgpu::BindingType = buffer_type(wgpu::BufferBindingType::Storage { read_only: false }, false);
pub(super) const TEXTURE: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

const fn buffer_type(ty: wgpu::BufferBindingType, has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None }
}
