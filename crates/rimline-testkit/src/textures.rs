//! Textures of depths of each format, what a shader reads of them, and of stencils; and copies of texels.

use crate::device::Gpu;
use crate::dispatch::Dispatch;
use crate::passes::{self, Loads, depth_pass};
use crate::pipelines::{Drawing, depth, group};
use wgpu::{TextureFormat, TextureUsages};

/// The first value is the width, then there are the depths of each texel's samples.
const DEPTHS: &str = "
@group(0) @binding(0) var<storage, read> values: array<f32>;
@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.0, 1.0);
}
@fragment fn depth(@builtin(position) at: vec4<f32>, @builtin(sample_index) sample: u32) -> @builtin(frag_depth) f32 {
  return values[1u + (u32(at.y) * u32(values[0]) + u32(at.x)) * SAMPLESu + sample];
}
";

const READ: &str = "
@group(0) @binding(0) var values: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> bits: array<u32>;
@compute @workgroup_size(64) fn read(@builtin(global_invocation_id) id: vec3<u32>) {
  let size = textureDimensions(values);
  let texel = id.x + id.y * 65536u;
  if (texel < size.x * size.y) {
    bits[texel] = bitcast<u32>(textureLoad(values, vec2<u32>(texel % size.x, texel / size.x), 0).x);
  }
}
";

/// Stencils of several samples as words: texels row by row, samples in turn.
const STENCILS: &str = "
@group(0) @binding(0) var stencil: texture_multisampled_2d<u32>;
@group(0) @binding(1) var<storage, read_write> found: array<u32>;
@compute @workgroup_size(64) fn stencils(@builtin(global_invocation_id) id: vec3<u32>) {
  let width = textureDimensions(stencil).x;
  let samples = textureNumSamples(stencil);
  if (id.x < arrayLength(&found)) {
    let texel = id.x / samples;
    found[id.x] = textureLoad(stencil, vec2<u32>(texel % width, texel / width), id.x % samples).x;
  }
}
";

/// A texture of depths, which passes draw into if they can.
fn made(
    gpu: &Gpu,
    size: [u32; 2],
    (format, sample_count): (TextureFormat, u32),
    usage: TextureUsages,
) -> wgpu::Texture {
    let usage = usage | TextureUsages::TEXTURE_BINDING;
    gpu.device.create_texture(&wgpu::TextureDescriptor { sample_count, usage, ..passes::texture(size, format) })
}

/// A texture of texels of four bytes.
fn written<T: bytemuck::Pod>(gpu: &Gpu, size: [u32; 2], format: TextureFormat, texels: &[T]) -> wgpu::Texture {
    let texture = made(gpu, size, (format, 1), TextureUsages::COPY_DST);
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: Some(size[1]) };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, texture.size());
    texture
}

/// A texture of objects.
pub fn objects(gpu: &Gpu, size: [u32; 2], objects: &[u32]) -> wgpu::TextureView {
    let texture = written(gpu, size, TextureFormat::R32Uint, objects);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The view of the depth aspect, or of the only one.
pub fn depth_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    let is_float = texture.format() == TextureFormat::R32Float;
    let aspect = if is_float { wgpu::TextureAspect::All } else { wgpu::TextureAspect::DepthOnly };
    texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() })
}

/// A texture of a format with these depths, as near as the format can. Stencils are 0. Only `R32Float` takes any bits.
pub fn texture(gpu: &Gpu, size: [u32; 2], format: TextureFormat, depths: &[f32]) -> Result<wgpu::Texture, String> {
    if format == TextureFormat::R32Float {
        return Ok(written(gpu, size, format, depths));
    }
    sampled(gpu, size, (format, 1), depths)
}

/// The same with some samples a texel, whose depths follow each other.
pub fn sampled(
    gpu: &Gpu,
    size: [u32; 2],
    (format, samples): (TextureFormat, u32),
    depths: &[f32],
) -> Result<wgpu::Texture, String> {
    let copied = if samples == 1 { TextureUsages::COPY_SRC } else { TextureUsages::empty() };
    let texture = made(gpu, size, (format, samples), TextureUsages::RENDER_ATTACHMENT | copied);
    let pipeline = gpu.kept(&format!("depths {format:?} {samples}"), || {
        // Without a sample index, a texel is drawn once.
        let source = match samples {
            1 => DEPTHS.replace(", @builtin(sample_index) sample: u32", "").replace(" + sample]", "]"),
            _ => DEPTHS.to_owned(),
        };
        let source = source.replace("SAMPLES", &samples.to_string());
        let depth_stencil = Some(depth(format, wgpu::CompareFunction::Always, true));
        Ok(Drawing { source: &source, depth_stencil, samples, ..Drawing::default() }.pipeline(&gpu.device))
    })?;
    let values = gpu.storage(&[&[size[0] as f32], depths].concat());
    let group = group(&gpu.device, &pipeline.get_bind_group_layout(0), [values.as_entire_binding()]);
    let clear = format.has_stencil_aspect().then_some(wgpu::LoadOp::Clear(0));
    pass(gpu, &texture, (Some(wgpu::LoadOp::Clear(0.5)), clear), |pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    })?;
    Ok(texture)
}

/// A pass that draws into a texture of depths, and of stencils if they are loaded.
pub fn pass<T>(
    gpu: &Gpu,
    target: &wgpu::Texture,
    loads: Loads,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Result<T, String>,
) -> Result<T, String> {
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    gpu.submit(|encoder| draw(&mut encoder.begin_render_pass(&depth_pass(&view, loads))))
}

/// Values of the texels of a texture, read by a shader.
pub fn read(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<f32>, String> {
    let texels = texture.width() * texture.height();
    let bits = gpu.storage(&vec![0_u32; texels as usize]);
    let kernel = gpu.kept("read", || Ok(Dispatch::new(gpu, READ, "read")))?;
    gpu.submit(|encoder| {
        kernel.record_over(gpu, encoder, &depth_view(texture), &bits, [1024, texels.div_ceil(65_536)]);
        Ok(())
    })?;
    let bits: Vec<u32> = gpu.read(&bits, texels as usize)?;
    Ok(bits.into_iter().map(f32::from_bits).collect())
}

/// The stencils of a texture as they are when an encoder comes to it.
pub struct Stencils {
    copy: wgpu::Buffer,
    size: [u32; 2],
    samples: u32,
}

impl Stencils {
    /// A shader reads several samples a texel, which no copy can. OpenGL has no shader that reads stencils.
    pub fn of(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture) -> Result<Self, String> {
        let (size, samples) = ([texture.width(), texture.height()], texture.sample_count());
        let aspect = wgpu::TextureAspect::StencilOnly;
        if samples == 1 {
            let from = wgpu::TexelCopyTextureInfo { aspect, ..texture.as_image_copy() };
            return Ok(Self { copy: copied(gpu, encoder, from, size[0]), size, samples });
        }
        let words = size[0] * size[1] * samples;
        let kernel = gpu.kept("stencils", || Ok(Dispatch::new(gpu, STENCILS, "stencils")))?;
        let copy = gpu.storage(&vec![0_u32; words as usize]);
        let view = texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
        kernel.record_over(gpu, encoder, &view, &copy, [words.div_ceil(64), 1]);
        Ok(Self { copy, size, samples })
    }

    /// Texels row by row, samples in turn.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, String> {
        let [width, height] = self.size;
        if self.samples > 1 {
            let words: Vec<u32> = gpu.read(&self.copy, usize::MAX)?;
            return Ok(words.into_iter().map(|value| value as u8).collect());
        }
        let all: Vec<u8> = gpu.read(&self.copy, usize::MAX)?;
        Ok(all.chunks(all.len() / height as usize).flat_map(|row| &row[..width as usize]).copied().collect())
    }
}

/// A buffer with rows of so many bytes of a texture's layer, each of them padded.
fn copied(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    from: wgpu::TexelCopyTextureInfo<'_>,
    width: u32,
) -> wgpu::Buffer {
    let row = width.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.storage(&vec![0_u8; (row * from.texture.height()) as usize]);
    let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(row), ..Default::default() };
    let size = wgpu::Extent3d { depth_or_array_layers: 1, ..from.texture.size() };
    encoder.copy_texture_to_buffer(from, wgpu::TexelCopyBufferInfo { buffer: &buffer, layout }, size);
    buffer
}

/// The bytes of the texels of a layer, row by row. They can be copied.
pub fn texels(gpu: &Gpu, texture: &wgpu::Texture, layer: u32) -> Result<Vec<u8>, String> {
    let bytes = texture.format().block_copy_size(None).ok_or("a format of several aspects")?;
    let (width, height) = (texture.width() * bytes, texture.height() as usize);
    let origin = wgpu::Origin3d { z: layer, ..wgpu::Origin3d::ZERO };
    let from = wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
    let copy = gpu.submit(|encoder| Ok(copied(gpu, encoder, from, width)))?;
    let all: Vec<u8> = gpu.read(&copy, usize::MAX)?;
    Ok(all.chunks(all.len() / height).take(height).flat_map(|row| &row[..width as usize]).copied().collect())
}
