//! Short ways to buffers and bind groups.

use wgpu::BufferBindingType;

/// A uniform buffer.
pub const UNIFORM: wgpu::BindingType = buffer_type(BufferBindingType::Uniform, false);
/// A uniform buffer at a dynamic offset.
pub(crate) const UNIFORM_AT_OFFSET: wgpu::BindingType = buffer_type(BufferBindingType::Uniform, true);
/// A storage buffer that shaders read.
pub const READ_ONLY: wgpu::BindingType = buffer_type(BufferBindingType::Storage { read_only: true }, false);
/// A storage buffer that shaders write.
pub(crate) const WRITTEN: wgpu::BindingType = buffer_type(BufferBindingType::Storage { read_only: false }, false);

const fn buffer_type(ty: BufferBindingType, has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None }
}

/// A texture of floats with one sample.
pub fn read_texture(view_dimension: wgpu::TextureViewDimension, filterable: bool) -> wgpu::BindingType {
    let sample_type = wgpu::TextureSampleType::Float { filterable };
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// A buffer of at least 16 bytes with these contents, whose size is a multiple of 4. Copies may overwrite them.
pub fn filled(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    label: &str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let (label, size) = (Some(label), (contents.len() as u64).next_multiple_of(4).max(16));
    let usage = usage | wgpu::BufferUsages::COPY_DST;
    let buffer = device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false });
    queue.write_buffer(&buffer, 0, contents);
    buffer
}

/// A layout whose bindings these stages see.
pub fn layout(
    device: &wgpu::Device,
    visibility: wgpu::ShaderStages,
    types: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, &ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let entries: Vec<_> = (0..).zip(types).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

/// Binds resources in the order of a layout.
pub fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = (0..).zip(resources.iter().cloned()).map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// The finest format of depth with a stencil: floating point where the device has it. With reversed depth it has about the
/// same relative precision at all distances, however near the near plane is (docs/numerics/rasterisers.md, "Depth").
pub fn depth_format(device: &wgpu::Device) -> wgpu::TextureFormat {
    let finest = wgpu::TextureFormat::Depth32FloatStencil8;
    let has_it = device.features().contains(finest.required_features());
    if has_it { finest } else { wgpu::TextureFormat::Depth24PlusStencil8 }
}
