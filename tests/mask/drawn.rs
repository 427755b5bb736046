//! Images of a world: its depth, its masks, and the stencil that a caller would draw.

use rimline::gpu::{MaskInputs, SceneOptions, ShadowFormat, ShadowMasks, ShadowPipelines};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::{self, depth_pass, draw_surfaces};
use rimline_testkit::pipelines::{Drawing, depth, group};
use rimline_testkit::textures::{Stencils, depth_view, texels};
use wgpu::TextureFormat;

use crate::world::{Encoded, World};

/// Copies the depth of `textureLoad`. Without samples, the last index is the level.
const COPY: &str = "
@group(0) @binding(0) var map: TEXTURE;
@vertex fn whole(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn copied(@builtin(position) at: vec4<f32>, @builtin(sample_index) sample: u32) -> @builtin(frag_depth) f32 {
  return textureLoad(map, vec2<i32>(at.xy), sample).x;
}
";

/// The type of a texture of depths that a shader loads, as floats: naga writes no loads of depth textures for OpenGL.
pub(crate) fn float_texture(samples: u32) -> &'static str {
    if samples > 1 { "texture_multisampled_2d<f32>" } else { "texture_2d<f32>" }
}

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
        let plain = passes::texture(self.size, format);
        let size = wgpu::Extent3d { depth_or_array_layers: layers, ..plain.size };
        let is_copied = samples == 1 && (format.has_stencil_aspect() || !format.has_depth_aspect());
        let copied = if is_copied { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() };
        let usage = plain.usage | copied;
        gpu.device.create_texture(&wgpu::TextureDescriptor { size, sample_count: samples, usage, ..plain })
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
        let layers = (0..lights.div_ceil(a_layer)).map(|layer| texels(gpu, target, layer as u32));
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

    /// The stencils of volumes that the caller draws, one a light.
    pub(crate) fn stencils(
        &self,
        gpu: &Gpu,
        world: &World,
        encoded: &Encoded,
        (options, trim): (&SceneOptions, bool),
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<Vec<Stencils>, String> {
        let has_float = gpu.device.features().contains(wgpu::Features::DEPTH32FLOAT_STENCIL8);
        let depth_stencil =
            if has_float { TextureFormat::Depth32FloatStencil8 } else { TextureFormat::Depth24PlusStencil8 };
        let texture = self.texture(gpu, depth_stencil, self.samples, 1);
        if has_float && !matches!(self.depth, TextureFormat::Depth32Float | TextureFormat::Depth32FloatStencil8) {
            let drawn = self.depth(gpu, encoder, world)?;
            let source = COPY.replace("TEXTURE", float_texture(self.samples));
            let bound = wgpu::BindingResource::TextureView(&drawn);
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
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let draw = |light| {
            let pass = &depth_pass(&view, (Some(wgpu::LoadOp::Load), Some(wgpu::LoadOp::Clear(0))));
            encoded.frame.draw(&mut encoder.begin_render_pass(pass), &pipelines, 0, light).map_err(text)?;
            Stencils::of(gpu, encoder, &texture)
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
        let stencils = stencils.iter().map(|stencils| stencils.read(gpu)).collect::<Result<Vec<_>, _>>()?;
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

/// Draws all surfaces.
fn draw_depth(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    world: &World,
    texture: &wgpu::Texture,
) -> Result<(), String> {
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    draw_surfaces(gpu, encoder, &view, &world.camera, &world.corners())
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
        let group = group(&gpu.device, &pipeline.get_bind_group_layout(0), [bound]);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let stencils = format.has_stencil_aspect().then_some(wgpu::LoadOp::Clear(0));
        let mut pass = encoder.begin_render_pass(&depth_pass(&view, (Some(wgpu::LoadOp::Clear(0.0)), stencils)));
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }
}
