//! The bindings of a stage, as its WGSL declares them: the layout of its bind group, and the number of each name.

use std::ops::Range;

use naga::{AddressSpace, StorageAccess};
use wgpu::BindingResource;

/// The bindings of bind group 0, ordered by number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Bindings(Vec<(String, wgpu::BindGroupLayoutEntry)>);

impl Bindings {
    /// Reads the bindings from the source of a module: buffers, and the kinds of textures that stages have. Source that
    /// does not parse has none; making its pipeline then reports the error.
    pub(crate) fn of(wgsl: &str) -> Self {
        let Ok(module) = naga::front::wgsl::parse_str(wgsl) else { return Self::default() };
        let mut found: Vec<(String, wgpu::BindGroupLayoutEntry)> = Vec::new();
        for (_, variable) in module.global_variables.iter() {
            let (Some(binding), Some(name)) = (&variable.binding, &variable.name) else { continue };
            let ty = match module.types[variable.ty].inner {
                naga::TypeInner::Image { class: naga::ImageClass::Sampled { multi, kind }, .. } => {
                    Some(if kind == naga::ScalarKind::Uint { UINT_TEXTURE } else { float_texture(multi) })
                }
                naga::TypeInner::Image { class: naga::ImageClass::Storage { format, .. }, .. } => {
                    Some(written_type(format))
                }
                _ => buffer_type(variable.space),
            };
            let Some(ty) = ty.filter(|_| binding.group == 0) else { continue };
            let visibility = wgpu::ShaderStages::COMPUTE;
            found.push((
                name.clone(),
                wgpu::BindGroupLayoutEntry { binding: binding.binding, visibility, ty, count: None },
            ));
        }
        found.sort_by_key(|(_, entry)| entry.binding);
        Self(found)
    }

    /// The names with their entries, by number.
    pub(crate) fn named(&self) -> impl Iterator<Item = (&str, wgpu::BindGroupLayoutEntry)> {
        self.0.iter().map(|(name, entry)| (name.as_str(), *entry))
    }
}

/// A resource that a stage binds by its name.
#[derive(Clone)]
pub(crate) struct Resource<'a> {
    pub(crate) bound: BindingResource<'a>,
    /// Where the entry of a uniform begins in its table: the dynamic offset of a dispatch. 0 for all others.
    pub(crate) offset: u32,
}

impl<'a> From<BindingResource<'a>> for Resource<'a> {
    fn from(bound: BindingResource<'a>) -> Self {
        Self { bound, offset: 0 }
    }
}

/// A whole buffer.
pub(crate) fn whole(buffer: &wgpu::Buffer) -> Resource<'_> {
    buffer.as_entire_binding().into()
}

/// A part of a buffer. It has at least four bytes, because bindings must not be empty.
pub(crate) fn part(buffer: &wgpu::Buffer, range: Range<u64>) -> Resource<'_> {
    let size = std::num::NonZeroU64::new((range.end - range.start).max(4));
    BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: range.start, size }).into()
}

/// The entry of a table of uniforms that begins at `offset`.
pub(crate) fn uniform<T>(buffer: &wgpu::Buffer, offset: u32) -> Resource<'_> {
    Resource { offset, ..part(buffer, 0..size_of::<T>() as u64) }
}

/// A texture.
pub(crate) fn texture(view: &wgpu::TextureView) -> Resource<'_> {
    BindingResource::TextureView(view).into()
}

/// A texture of two dimensions.
const fn texture_type(sample_type: wgpu::TextureSampleType, multisampled: bool) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension: wgpu::TextureViewDimension::D2, multisampled }
}

/// A texture of floats that is not filtered. The depth aspect of a texture can be bound to it, too.
pub(crate) const fn float_texture(multisampled: bool) -> wgpu::BindingType {
    texture_type(wgpu::TextureSampleType::Float { filterable: false }, multisampled)
}
/// A texture of unsigned integers.
pub(crate) const UINT_TEXTURE: wgpu::BindingType = texture_type(wgpu::TextureSampleType::Uint, false);

/// A buffer whose offset is not dynamic.
const fn buffer_of(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

/// A buffer of uniforms for a draw.
pub(crate) const UNIFORM: wgpu::BindingType = buffer_of(wgpu::BufferBindingType::Uniform);
/// A storage buffer that is only read.
pub(crate) const READ: wgpu::BindingType = buffer_of(wgpu::BufferBindingType::Storage { read_only: true });

/// The entries of a layout, by number.
pub(crate) fn entries(
    visibility: wgpu::ShaderStages,
    types: impl IntoIterator<Item = (u32, wgpu::BindingType)>,
) -> Vec<wgpu::BindGroupLayoutEntry> {
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    types.into_iter().map(entry).collect()
}

/// A texture of two dimensions that a stage writes: `r32uint`, or else `r32float`, which no other format may stand for.
fn written_type(format: naga::StorageFormat) -> wgpu::BindingType {
    let is_uint = format == naga::StorageFormat::R32Uint;
    wgpu::BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format: if is_uint { wgpu::TextureFormat::R32Uint } else { wgpu::TextureFormat::R32Float },
        view_dimension: wgpu::TextureViewDimension::D2,
    }
}

/// Uniforms lie in tables. A dispatch selects an entry by a dynamic offset.
fn buffer_type(space: AddressSpace) -> Option<wgpu::BindingType> {
    let ty = match space {
        AddressSpace::Uniform => wgpu::BufferBindingType::Uniform,
        AddressSpace::Storage { access } => {
            wgpu::BufferBindingType::Storage { read_only: !access.contains(StorageAccess::STORE) }
        }
        _ => return None,
    };
    let has_dynamic_offset = ty == wgpu::BufferBindingType::Uniform;
    Some(wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    const WGSL: &str = "
        @group(0) @binding(3) var<storage, read_write> out: array<u32>;
        @group(0) @binding(1) var<uniform> word: vec4<f32>;
        @group(1) @binding(0) var<storage, read> others: array<u32>;
        @group(0) @binding(2) var<storage, read> faces: array<u32>;
        var<workgroup> sums: array<u32, 4>;
    ";

    #[test]
    fn bindings_are_those_of_the_wgsl() {
        let bindings = Bindings::of(WGSL);
        assert_eq!(bindings.named().map(|(name, _)| name).collect::<Vec<_>>(), ["word", "faces", "out"]);
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let found: Vec<_> = bindings
            .named()
            .map(|(_, entry)| match entry.ty {
                wgpu::BindingType::Buffer { ty, has_dynamic_offset, .. } => (entry.binding, ty, has_dynamic_offset),
                _ => panic!("{entry:?}"),
            })
            .collect();
        let uniform = wgpu::BufferBindingType::Uniform;
        assert_eq!(found, [(1, uniform, true), (2, storage(true), false), (3, storage(false), false)]);
        assert_eq!(Bindings::of("not WGSL"), Bindings::default());
    }

    /// naga writes no loads of depth textures for OpenGL. Floats that are not filtered take depth, too.
    #[test]
    fn depth_is_bound_as_floats() {
        for (name, wgsl) in crate::stages::FILES {
            assert!(!wgsl.contains("texture_depth"), "{name}");
        }
        for (wgsl, multisampled) in [("texture_2d<f32>", false), ("texture_multisampled_2d<f32>", true)] {
            let bindings = Bindings::of(&format!("@group(0) @binding(0) var depth: {wgsl};"));
            let found: Vec<_> = bindings.named().map(|(_, entry)| entry.ty).collect();
            assert_eq!(found, [float_texture(multisampled)], "{wgsl}");
        }
    }
}
