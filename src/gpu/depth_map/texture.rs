//! Checks of textures that are depth maps or objects, and textures that stages write.

use super::error::DepthMapError;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::memory::guarded;

/// The formats of depth maps.
pub(super) const MAP_FORMATS: [wgpu::TextureFormat; 6] = [
    wgpu::TextureFormat::Depth16Unorm,
    wgpu::TextureFormat::Depth24Plus,
    wgpu::TextureFormat::Depth24PlusStencil8,
    wgpu::TextureFormat::Depth32Float,
    wgpu::TextureFormat::Depth32FloatStencil8,
    wgpu::TextureFormat::R32Float,
];

/// Refuses a texture that is no depth map of `made` texels. Returns its format.
pub(super) fn check_texture(
    map: &wgpu::Texture,
    made: [u32; 2],
    name: &str,
) -> Result<wgpu::TextureFormat, DepthMapError> {
    let accepted = "Depth16Unorm, Depth24Plus, Depth32Float, or R32Float";
    check_read(map, made, name, (MAP_FORMATS.contains(&map.format()), accepted))
}

/// Refuses a texture that has no objects for a map of `made` texels.
pub(super) fn check_objects(objects: &wgpu::Texture, made: [u32; 2], name: &str) -> Result<(), DepthMapError> {
    check_read(objects, made, name, (objects.format() == wgpu::TextureFormat::R32Uint, "R32Uint")).map(|_| ())
}

fn check_read(
    given: &wgpu::Texture,
    made: [u32; 2],
    name: &str,
    (has_format, accepted): (bool, &'static str),
) -> Result<wgpu::TextureFormat, DepthMapError> {
    let (format, samples, levels) = (given.format(), given.sample_count(), given.mip_level_count());
    let size = [given.width(), given.height()];
    let map = || name.to_owned();
    if !has_format {
        return Err(DepthMapError::MapFormat { map: map(), format, accepted });
    }
    if samples != 1 {
        return Err(DepthMapError::Samples { map: map(), samples });
    }
    // wgpu does not say which level a view shows, and so which size it has.
    if levels != 1 {
        return Err(DepthMapError::MipLevels { map: map(), levels });
    }
    if size != made {
        return Err(DepthMapError::MapSize { map: map(), given: size, made });
    }
    if !given.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING) {
        return Err(DepthMapError::Usage(map()));
    }
    Ok(format)
}

/// A texture that stages write and read, with four bytes a texel.
pub(super) fn written_texture(
    device: &wgpu::Device,
    label: &'static str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> Result<wgpu::TextureView, DeviceError> {
    use wgpu::TextureUsages;
    let descriptor = wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC,
        view_formats: &[],
    };
    let bytes = 4 * u64::from(width) * u64::from(height);
    let texture = guarded(device, bytes, || device.create_texture(&descriptor))?;
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}
