//! Depth maps as textures of each format, and what a shader reads of them.

use rimline_testkit::device::Gpu;
use rimline_testkit::pipelines::TexelKernel;
use wgpu::TextureFormat;

const DEPTHS: &str = "
@group(0) @binding(0) var values: texture_2d<f32>;
@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.0, 1.0);
}
@fragment fn depth(@builtin(position) at: vec4<f32>) -> @builtin(frag_depth) f32 {
  let sample = 0;
  let samples = 1;
  return textureLoad(values, vec2<i32>(samples * i32(at.x) + sample, i32(at.y)), 0).x;
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

fn made(gpu: &Gpu, size: [u32; 2], format: TextureFormat, usage: wgpu::TextureUsages) -> wgpu::Texture {
    made_with(gpu, size, (format, 1), usage)
}

fn made_with(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    (format, sample_count): (TextureFormat, u32),
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("depths"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// A texture of `R32Float` with any bits.
fn floats(gpu: &Gpu, size: [u32; 2], depths: &[f32]) -> wgpu::Texture {
    let texture = made(gpu, size, TextureFormat::R32Float, wgpu::TextureUsages::COPY_DST);
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: Some(size[1]) };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(depths), layout, texture.size());
    texture
}

/// A texture of objects.
pub(crate) fn objects(gpu: &Gpu, size: [u32; 2], objects: &[u32]) -> wgpu::Texture {
    let texture = made(gpu, size, TextureFormat::R32Uint, wgpu::TextureUsages::COPY_DST);
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: Some(size[1]) };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(objects), layout, texture.size());
    texture
}

/// The view of the depth aspect, or of the only one.
pub(crate) fn depth_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    let is_float = texture.format() == TextureFormat::R32Float;
    let aspect = if is_float { wgpu::TextureAspect::All } else { wgpu::TextureAspect::DepthOnly };
    texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() })
}

/// A texture of a format with these depths, as near as the format can. Stencils are 0.
pub(crate) fn texture(
    gpu: &Gpu,
    size: [u32; 2],
    format: TextureFormat,
    depths: &[f32],
) -> Result<wgpu::Texture, String> {
    if format == TextureFormat::R32Float {
        return Ok(floats(gpu, size, depths));
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
    let values = floats(gpu, [samples * size[0], size[1]], depths);
    let device = &gpu.device;
    let copied = if samples == 1 { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() };
    let usages = wgpu::TextureUsages::RENDER_ATTACHMENT | copied;
    let texture = made_with(gpu, size, (format, samples), usages);
    let source = if samples == 1 {
        DEPTHS.to_owned()
    } else {
        DEPTHS
            .replace("at: vec4<f32>)", "at: vec4<f32>, @builtin(sample_index) number: u32)")
            .replace("let sample = 0", "let sample = i32(number)")
            .replace("let samples = 1", &format!("let samples = {samples}"))
    };
    let entry = wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    };
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &[entry] });
    let pipeline = gpu.kept(&format!("depths {format:?} {samples}"), || {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("depths"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        Ok(device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("depths"),
            layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            })),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[],
            }),
            multiview_mask: None,
            cache: None,
        }))
    })?;
    let view = values.create_view(&wgpu::TextureViewDescriptor::default());
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) }],
    });
    let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let stencil_ops = wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store };
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.5), store: wgpu::StoreOp::Store }),
                stencil_ops: format.has_stencil_aspect().then_some(stencil_ops),
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        Ok::<_, String>(())
    })?;
    Ok(texture)
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
