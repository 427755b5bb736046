//! Textures that are taken as depth maps.

use super::error::DepthMapError;

/// The formats of maps.
pub(super) const MAP_FORMATS: [wgpu::TextureFormat; 6] = [
    wgpu::TextureFormat::Depth16Unorm,
    wgpu::TextureFormat::Depth24Plus,
    wgpu::TextureFormat::Depth24PlusStencil8,
    wgpu::TextureFormat::Depth32Float,
    wgpu::TextureFormat::Depth32FloatStencil8,
    wgpu::TextureFormat::R32Float,
];

/// Whether a texture can be taken as a map of `made` texels; its format.
pub(super) fn check_texture(
    map: &wgpu::Texture,
    made: [u32; 2],
    name: &str,
) -> Result<wgpu::TextureFormat, DepthMapError> {
    let taken = "Depth16Unorm, Depth24Plus, Depth32Float, or R32Float";
    check_read(map, made, name, (MAP_FORMATS.contains(&map.format()), taken))
}

/// Whether a texture can be taken as the objects of a map of `made` texels.
pub(super) fn check_objects(objects: &wgpu::Texture, made: [u32; 2], name: &str) -> Result<(), DepthMapError> {
    check_read(objects, made, name, (objects.format() == wgpu::TextureFormat::R32Uint, "R32Uint")).map(|_| ())
}

fn check_read(
    given: &wgpu::Texture,
    made: [u32; 2],
    name: &str,
    (has_format, taken): (bool, &'static str),
) -> Result<wgpu::TextureFormat, DepthMapError> {
    let (format, samples, levels) = (given.format(), given.sample_count(), given.mip_level_count());
    let size = [given.width(), given.height()];
    let map = || name.to_owned();
    if !has_format {
        return Err(DepthMapError::MapFormat { map: map(), format, taken });
    }
    if samples != 1 {
        return Err(DepthMapError::Samples { map: map(), samples });
    }
    // A view does not tell its level, and so not its size.
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

/// A texture that stages read.
pub(super) fn texture(
    device: &wgpu::Device,
    label: &'static str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    further: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | further,
        view_formats: &[],
    })
}

/// A texture that a stage writes and others read.
pub(super) fn written_texture(
    device: &wgpu::Device,
    label: &'static str,
    size: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    texture(device, label, size, format, wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC)
}
