//! Images of a world: its depth, its masks, and the stencil that a caller would draw.

use rimline::gpu::{MaskInputs, SceneOptions, ShadowFormat, ShadowMasks, ShadowPipelines, read_back_vec};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::pipelines::{Drawing, SURFACE, depth};
use wgpu::TextureFormat;

use crate::world::{Encoded, World};

/// Copies the depth of `textureLoad`. Without samples, the last index is the level.
const COPY: &str = "
@group(0) @binding(0) var map: TEXTURE;
@vertex fn whole(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn copied(@builtin(position) at: vec4<f32>, @builtin(sample_index) sample: u32) -> @builtin(frag_depth) f32 {
  return textureLoad(map, vec2<i32>(at.xy), sample);
}
";

/// Reads the stencil of each sample of each pixel.
const STENCIL: &str = "
@group(0) @binding(0) var stencil: TEXTURE;
@group(0) @binding(1) var<storage, read_write> values: array<u32>;
@compute @workgroup_size(8, 8) fn read(@builtin(global_invocation_id) id: vec3<u32>) {
  let size = textureDimensions(stencil);
  if (id.x < size.x && id.y < size.y) {
    for (var sample = 0u; sample < SAMPLES; sample++) {
      values[SAMPLES * (id.x + size.x * id.y) + sample] = textureLoad(stencil, id.xy, sample).x;
    }
  }
}
";

/// The caller's textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Picture {
    pub(crate) size: [u32; 2],
    pub(crate) depth: TextureFormat,
    pub(crate) samples: u32,
    pub(crate) target: TextureFormat,
}

impl Picture {
    pub(crate) fn texture(&self, gpu: &Gpu, format: TextureFormat, samples: u32, layers: u32) -> wgpu::Texture {
        let [width, height] = self.size;
        let copied =
            if format.has_depth_aspect() { wgpu::TextureUsages::empty() } else { wgpu::TextureUsages::COPY_SRC };
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING | copied,
            view_formats: &[],
        })
    }

    /// The target for so many lights.
    pub(crate) fn target(&self, gpu: &Gpu, lights: usize) -> wgpu::Texture {
        self.texture(gpu, self.target, 1, lights.div_ceil(lights_a_layer(self.target)).max(1) as u32)
    }

    /// The depth of a world, in a texture of the caller.
    pub(crate) fn depth(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        world: &World,
    ) -> Result<wgpu::TextureView, String> {
        let texture = self.texture(gpu, self.depth, self.samples, 1);
        draw_depth(gpu, encoder, world, &texture)?;
        Ok(depth_view(&texture))
    }

    /// The masks of a target, a light each: the byte of a share, or 0 and 255.
    pub(crate) fn masks(&self, gpu: &Gpu, target: &wgpu::Texture, lights: usize) -> Result<Vec<Vec<u8>>, String> {
        let a_layer = lights_a_layer(self.target);
        let bytes = self.target.block_copy_size(None).ok_or("a size")? as usize;
        let layers = (0..lights.div_ceil(a_layer)).map(|layer| read_layer(gpu, target, layer as u32, bytes));
        let layers = layers.collect::<Result<Vec<_>, _>>()?;
        let mask = |light: usize| {
            let texels = layers[light / a_layer].chunks_exact(bytes);
            let value = |texel: &[u8]| match a_layer {
                1 => texel[0],
                _ => 255 * (texel[light % a_layer / 8] >> (light % 8) & 1),
            };
            texels.map(value).collect()
        };
        Ok((0..lights).map(mask).collect())
    }

    /// The stencils of volumes that the caller draws, one a light, with a word for each sample of each pixel.
    pub(crate) fn stencils(
        &self,
        gpu: &Gpu,
        world: &World,
        encoded: &Encoded,
        (options, trim): (&SceneOptions, bool),
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<Vec<wgpu::Buffer>, String> {
        let has_float = gpu.device.features().contains(wgpu::Features::DEPTH32FLOAT_STENCIL8);
        let depth_stencil =
            if has_float { TextureFormat::Depth32FloatStencil8 } else { TextureFormat::Depth24PlusStencil8 };
        let texture = self.texture(gpu, depth_stencil, self.samples, 1);
        if has_float && !matches!(self.depth, TextureFormat::Depth32Float | TextureFormat::Depth32FloatStencil8) {
            let drawn = self.depth(gpu, encoder, world)?;
            let ty = if self.samples > 1 { "texture_depth_multisampled_2d" } else { "texture_depth_2d" };
            let (source, bound) = (COPY.replace("TEXTURE", ty), wgpu::BindingResource::TextureView(&drawn));
            let copy = DepthDraw { name: "copied", source: &source, entry_points: [None; 2], bound };
            copy.draw(gpu, encoder, &texture)?;
        } else {
            draw_depth(gpu, encoder, world, &texture)?;
        }
        let format = ShadowFormat {
            depth_stencil,
            depth: world.camera.depth,
            samples: self.samples,
            has_far_plane: world.camera.has_far_plane(),
            count_bits: options.stencil.count_bits,
            trim,
            ..ShadowFormat::default()
        };
        let make = if options.stencil.count_batches > 1 { ShadowPipelines::in_batches } else { ShadowPipelines::new };
        let pipelines = make(&gpu.pipelines, &format, options.counting).map_err(text)?;
        let reader = Reader::new(gpu, &texture)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let draw = |light| {
            let mut pass = begin(encoder, &view, None);
            encoded.frame.draw(&mut pass, &pipelines, 0, light).map_err(text)?;
            drop(pass);
            Ok(reader.read(gpu, encoder))
        };
        encoded.lights.iter().copied().map(draw).collect()
    }

    /// Masks of a world, and its stencils: a light each, with as many values a pixel as there are samples.
    pub(crate) fn both(
        &self,
        gpu: &Gpu,
        world: &World,
        options: &SceneOptions,
        masks: &mut ShadowMasks,
    ) -> Result<[Vec<Vec<u8>>; 2], String> {
        let target = self.target(gpu, world.lights.len());
        let stencils = gpu.submit(|encoder| {
            let depth = &self.depth(gpu, encoder, world)?;
            let encoded = world.encode(gpu, encoder, *options)?;
            let inputs = MaskInputs { depth, view: 0, lights: &encoded.lights, target: &target };
            encoded.frame.write_masks(encoder, masks, &inputs).map_err(text)?;
            self.stencils(gpu, world, &encoded, (options, masks.trim), encoder)
        })?;
        let read = |buffer: &wgpu::Buffer| {
            let words: Vec<u32> = read_back_vec(&gpu.device, &gpu.queue, buffer).map_err(text)?;
            Ok(words.into_iter().map(|word| word as u8).collect())
        };
        let stencils = stencils.iter().map(read).collect::<Result<Vec<Vec<u8>>, String>>()?;
        Ok([self.masks(gpu, &target, world.lights.len())?, stencils])
    }
}

pub(crate) fn lights_a_layer(target: TextureFormat) -> usize {
    match target {
        TextureFormat::R8Uint => 8,
        TextureFormat::R32Uint => 32,
        _ => 1,
    }
}

/// The texels of a layer, row by row.
fn read_layer(gpu: &Gpu, target: &wgpu::Texture, layer: u32, bytes: usize) -> Result<Vec<u8>, String> {
    let (width, height) = (target.width() as usize * bytes, target.height());
    let row = width.next_multiple_of(256);
    let copy = gpu.storage(&vec![0_u8; row * height as usize]);
    gpu.submit(|encoder| {
        let origin = wgpu::Origin3d { z: layer, ..wgpu::Origin3d::ZERO };
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { origin, ..target.as_image_copy() },
            wgpu::TexelCopyBufferInfo {
                buffer: &copy,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row as u32),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { depth_or_array_layers: 1, ..target.size() },
        );
        Ok(())
    })?;
    let all: Vec<u8> = read_back_vec(&gpu.device, &gpu.queue, &copy).map_err(text)?;
    Ok(all.chunks(row).take(height as usize).flat_map(|line| &line[..width]).copied().collect())
}

/// A pass with depth that is cleared to a value or loaded, and the stencil at 0.
fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    clear: Option<f32>,
) -> wgpu::RenderPass<'e> {
    let load = clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear);
    let store = wgpu::StoreOp::Store;
    let has_stencil = view.texture().format().has_stencil_aspect();
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("own"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load, store }),
            stencil_ops: has_stencil.then_some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store }),
        }),
        ..Default::default()
    })
}

/// Draws all surfaces.
fn draw_depth(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    world: &World,
    texture: &wgpu::Texture,
) -> Result<(), String> {
    let ShadowCamera { view_projection, origin: [x, y, z], depth: direction } = world.camera;
    let is_reversed = direction == DepthDirection::Reversed;
    let (nearer, far) =
        if is_reversed { (wgpu::CompareFunction::Greater, 0.0) } else { (wgpu::CompareFunction::Less, 1.0) };
    let (format, samples) = (texture.format(), texture.sample_count());
    let pipeline = gpu.kept(&format!("surface {format:?} {samples} {is_reversed}"), || {
        let depth_stencil = Some(depth(format, nearer, true));
        Ok(Drawing { source: SURFACE, depth_stencil, samples, ..Drawing::default() }.pipeline(&gpu.device))
    })?;
    let corners = world.corners();
    let camera = [view_projection.concat(), vec![x, y, z, 0.0]].concat();
    let buffers = [gpu.storage(&camera), gpu.storage(&corners)];
    let entries = [0, 1].map(|binding| wgpu::BindGroupEntry {
        binding: binding as u32,
        resource: buffers[binding].as_entire_binding(),
    });
    let layout = &pipeline.get_bind_group_layout(0);
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let mut pass = begin(encoder, &view, Some(far));
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..corners.len() as u32, 0..1);
    Ok(())
}

/// A full-screen draw that writes depth, by a shader that reads one resource.
pub(crate) struct DepthDraw<'a> {
    /// A name for the pipeline: equal names have equal sources and entry points.
    pub(crate) name: &'a str,
    pub(crate) source: &'a str,
    pub(crate) entry_points: [Option<&'a str>; 2],
    pub(crate) bound: wgpu::BindingResource<'a>,
}

impl DepthDraw<'_> {
    pub(crate) fn draw(
        self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
    ) -> Result<(), String> {
        let Self { name, source, entry_points, bound } = self;
        let (format, samples) = (texture.format(), texture.sample_count());
        let pipeline = gpu.kept(&format!("{name} {format:?} {samples}"), || {
            let depth_stencil = Some(depth(format, wgpu::CompareFunction::Always, true));
            Ok(Drawing { source, entry_points, depth_stencil, samples, ..Drawing::default() }.pipeline(&gpu.device))
        })?;
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: bound }],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = begin(encoder, &view, Some(0.0));
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }
}

/// A view of the depth aspect.
pub(crate) fn depth_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    let aspect = wgpu::TextureAspect::DepthOnly;
    texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() })
}

/// Reads stencils of a texture.
struct Reader {
    pipeline: std::sync::Arc<wgpu::ComputePipeline>,
    view: wgpu::TextureView,
}

impl Reader {
    fn new(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Self, String> {
        let samples = texture.sample_count();
        let pipeline = gpu.kept(&format!("stencil of {samples}"), || {
            let ty = if samples > 1 { "texture_multisampled_2d<u32>" } else { "texture_2d<u32>" };
            let source = STENCIL.replace("TEXTURE", ty).replace("SAMPLES", &format!("{samples}u"));
            let source = wgpu::ShaderSource::Wgsl(source.into());
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
            Ok(gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("stencil"),
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            }))
        })?;
        let aspect = wgpu::TextureAspect::StencilOnly;
        let view = texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
        Ok(Self { pipeline, view })
    }

    /// A word for each sample of each pixel.
    fn read(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) -> wgpu::Buffer {
        let texture = self.view.texture();
        let (width, height) = (texture.width(), texture.height());
        let values = gpu.storage(&vec![0_u32; (width * height * texture.sample_count()) as usize]);
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&self.view) },
                wgpu::BindGroupEntry { binding: 1, resource: values.as_entire_binding() },
            ],
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        values
    }
}
