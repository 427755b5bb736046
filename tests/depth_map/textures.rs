//! Depth maps as textures of each format, what a shader reads of them, and of stencils.

use rimline_testkit::device::Gpu;
use rimline_testkit::pipelines::{Drawing, TexelKernel, depth};
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

/// Stencils of a picture as words: texels row by row, samples in turn.
const STENCILS: &str = "
@group(0) @binding(0) var stencil: texture_2d<u32>;
@group(0) @binding(1) var<storage, read_write> found: array<u32>;
@compute @workgroup_size(64) fn stencils(@builtin(global_invocation_id) id: vec3<u32>) {
  let size = textureDimensions(stencil);
  if (id.x < size.x * size.y * SAMPLESu) {
    let texel = id.x / SAMPLESu;
    found[id.x] = textureLoad(stencil, vec2<u32>(texel % size.x, texel / size.x), id.x % SAMPLESu).x;
  }
}
";

fn made(gpu: &Gpu, size: [u32; 2], (format, samples): (TextureFormat, u32), usage: TextureUsages) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("depths"),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
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
pub(crate) fn objects(gpu: &Gpu, size: [u32; 2], objects: &[u32]) -> wgpu::TextureView {
    let texture = written(gpu, size, TextureFormat::R32Uint, objects);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The view of the depth aspect, or of the only one.
pub(crate) fn depth_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    let is_float = texture.format() == TextureFormat::R32Float;
    let aspect = if is_float { wgpu::TextureAspect::All } else { wgpu::TextureAspect::DepthOnly };
    texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() })
}

/// A texture of a format with these depths, as near as the format can. Stencils are 0. Only `R32Float` takes any bits.
pub(crate) fn texture(
    gpu: &Gpu,
    size: [u32; 2],
    format: TextureFormat,
    depths: &[f32],
) -> Result<wgpu::Texture, String> {
    if format == TextureFormat::R32Float {
        return Ok(written(gpu, size, format, depths));
    }
    sampled(gpu, size, (format, 1), depths)
}

/// The same with some samples a texel, whose depths follow each other.
pub(crate) fn sampled(
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
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: values.as_entire_binding() }],
    });
    let clear = format.has_stencil_aspect().then_some(wgpu::LoadOp::Clear(0));
    pass(gpu, &texture, (Some(wgpu::LoadOp::Clear(0.5)), clear), |pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    })?;
    Ok(texture)
}

/// How a pass begins: with depths and stencils that are loaded or cleared, or read only.
pub(crate) type Loads = (Option<wgpu::LoadOp<f32>>, Option<wgpu::LoadOp<u32>>);

/// A pass that draws into a texture of depths, and of stencils if they are loaded.
pub(crate) fn pass<T>(
    gpu: &Gpu,
    target: &wgpu::Texture,
    loads: Loads,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Result<T, String>,
) -> Result<T, String> {
    gpu.submit(|encoder| draw(&mut begin(encoder, &target.create_view(&wgpu::TextureViewDescriptor::default()), loads)))
}

pub(crate) fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    (depths, stencils): Loads,
) -> wgpu::RenderPass<'a> {
    let store = wgpu::StoreOp::Store;
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("test"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: depths.map(|load| wgpu::Operations { load, store }),
            stencil_ops: stencils.map(|load| wgpu::Operations { load, store }),
        }),
        ..Default::default()
    })
}

/// Values of the texels of a texture, read by a shader.
pub(crate) fn read(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<f32>, String> {
    let texels = texture.width() * texture.height();
    let bits = gpu.storage(&vec![0_u32; texels as usize]);
    let kernel = gpu.kept("read", || Ok(TexelKernel::new(&gpu.device, ("read", READ), false)))?;
    let group = kernel.group(&gpu.device, &depth_view(texture), &bits);
    gpu.submit(|encoder| {
        kernel.run(encoder, &group, [1024, texels.div_ceil(65_536)]);
        Ok::<_, String>(())
    })?;
    let bits: Vec<u32> = gpu.read(&bits, texels as usize)?;
    Ok(bits.into_iter().map(f32::from_bits).collect())
}

/// The stencils of a texture.
pub(crate) fn stencils(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<u8>, String> {
    let samples = texture.sample_count();
    let pipeline = gpu.kept(&format!("stencils {samples}"), || {
        let kind = if samples == 1 { "texture_2d" } else { "texture_multisampled_2d" };
        let source = STENCILS.replace("SAMPLES", &samples.to_string()).replace("texture_2d", kind);
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("stencils"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        Ok(gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("stencils"),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        }))
    })?;
    let aspect = wgpu::TextureAspect::StencilOnly;
    let view = texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
    let count = texture.width() * texture.height() * samples;
    let found = gpu.storage(&vec![0_u32; count as usize]);
    let resources = [wgpu::BindingResource::TextureView(&view), found.as_entire_binding()];
    let entries = (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
    let (layout, entries) = (&pipeline.get_bind_group_layout(0), &entries.collect::<Vec<_>>()[..]);
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries });
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(count.div_ceil(64), 1, 1);
        Ok(())
    })?;
    Ok(gpu.read::<u32>(&found, count as usize)?.into_iter().map(|value| value as u8).collect())
}
