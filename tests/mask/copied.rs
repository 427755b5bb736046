//! Depth that is copied is the depth that was drawn: `textureLoad` gives the same bits of both.

use rimline::internals::stages::{MASK_SAMPLES, SHADOW_MASKS};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::pipelines::{Drawing, TexelKernel, depth};
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat::{self, Depth16Unorm, Depth24Plus, Depth24PlusStencil8, Depth32Float, Depth32FloatStencil8};

pub(crate) const TESTS: &[Test] = &[("depth_survives_the_copy", survives)];

const SIDE: u32 = 1024;

/// Depths by the numbers of pixels, and the bits that `textureLoad` gives.
const NUMBERED: &str = "
@group(0) @binding(0) var<storage, read> first: array<u32>;
@vertex fn whole(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, at == 1u), select(-1.0, 3.0, at == 2u), 0.5, 1.0);
}
fn number(at: vec4<f32>) -> u32 { return first[0] + first[1] * (u32(at.x) + 1024u * u32(at.y)); }
@fragment fn parts(@builtin(position) at: vec4<f32>) -> @builtin(frag_depth) f32 { return f32(number(at)) / 16777215.0; }
@fragment fn bits(@builtin(position) at: vec4<f32>) -> @builtin(frag_depth) f32 { return bitcast<f32>(number(at)); }
";

const READ: &str = "
@group(0) @binding(0) var map: TEXTURE;
@group(0) @binding(1) var<storage, read_write> values: array<u32>;
@compute @workgroup_size(8, 8) fn read(@builtin(global_invocation_id) id: vec3<u32>) {
  values[id.x + 1024u * id.y] = bitcast<u32>(textureLoad(map, id.xy, LAST).x);
}
";

struct Map {
    texture: wgpu::Texture,
}

impl Map {
    fn new(gpu: &Gpu, format: TextureFormat, samples: u32) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("map"),
            size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Self { texture }
    }

    fn view(&self) -> wgpu::TextureView {
        let aspect = wgpu::TextureAspect::DepthOnly;
        self.texture.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() })
    }

    /// Draws depth over all of it, by a source with its fragment shader and a resource.
    fn draw(
        &self,
        gpu: &Gpu,
        [source, vertex, fragment]: [&str; 3],
        bound: wgpu::BindingResource<'_>,
    ) -> Result<(), String> {
        let (format, samples) = (self.texture.format(), self.texture.sample_count());
        let pipeline = gpu.kept(&format!("{fragment} {format:?} {samples}"), || {
            let depth_stencil = Some(depth(format, wgpu::CompareFunction::Always, true));
            let entry_points = [Some(vertex), Some(fragment)];
            Ok(Drawing { source, entry_points, depth_stencil, samples, ..Drawing::default() }.pipeline(&gpu.device))
        })?;
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: bound }],
        });
        let operations = |load| wgpu::Operations { load, store: wgpu::StoreOp::Store };
        gpu.submit(|encoder| {
            let view = self.texture.create_view(&wgpu::TextureViewDescriptor::default());
            let stencil = format
                .has_stencil_aspect()
                .then_some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store });
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &view,
                    depth_ops: Some(operations(wgpu::LoadOp::Clear(0.5))),
                    stencil_ops: stencil,
                }),
                ..Default::default()
            });
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, 0..1);
            Ok(())
        })
    }

    /// The bits of the last sample of each pixel.
    fn read(&self, gpu: &Gpu) -> Result<Vec<u32>, String> {
        let samples = self.texture.sample_count();
        let ty = if samples > 1 { "texture_multisampled_2d<f32>" } else { "texture_2d<f32>" };
        let source = READ.replace("TEXTURE", ty).replace("LAST", &format!("{}", samples - 1));
        let kernel = TexelKernel::new(&gpu.device, ("read", &source), samples > 1);
        let values = gpu.storage(&vec![0_u32; (SIDE * SIDE) as usize]);
        let group = kernel.group(&gpu.device, &self.view(), &values);
        gpu.submit(|encoder| {
            kernel.run(encoder, &group, [SIDE / 8, SIDE / 8]);
            Ok(())
        })?;
        gpu.read(&values, usize::MAX)
    }
}

/// Draws depths into a map of a format, copies them by the stage, and returns the bits of both.
fn copied(
    gpu: &Gpu,
    from: TextureFormat,
    to: TextureFormat,
    samples: u32,
    first: [u32; 2],
) -> Result<[Vec<u32>; 2], String> {
    let [map, copy] = [from, to].map(|format| Map::new(gpu, format, samples));
    let fragment = if from == Depth32Float { "bits" } else { "parts" };
    map.draw(gpu, [NUMBERED, "whole", fragment], gpu.storage(&first).as_entire_binding())?;
    let stage = if samples > 1 { &MASK_SAMPLES } else { &SHADOW_MASKS };
    let source = stage.composed().map_err(text)?.wgsl;
    // The layout that a pipeline finds by itself takes depth for a texture of floats that is filtered.
    copy.draw(gpu, [&source, "mask_whole", "mask_depth"], wgpu::BindingResource::TextureView(&map.view()))?;
    Ok([map.read(gpu)?, copy.read(gpu)?])
}

/// All values of 16 bits; values of 24 bits and of floats from 0 to 1, in a long run all of 24 bits.
fn survives() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let parts = if is_long() { 16 } else { 1 };
    for samples in [1, 4] {
        for part in 0..parts {
            let [map, copy] = copied(gpu, Depth24Plus, Depth32FloatStencil8, samples, [part, 16])?;
            same(&format!("24 bits, {samples} samples"), &copy, &map)?;
            if map.windows(2).any(|pair| pair[0] >= pair[1]) {
                return Err("the depths are not all different".to_owned());
            }
            let mut other = copy;
            other[1000] += 1;
            must_fail("a depth that is changed", &same("24 bits", &other, &map))?;
            // Without the feature. llvmpipe multiplies by the reciprocal of 2²⁴ − 1 where it should divide, so that depths from 3/4 on
            // come out as the next one.
            let [map, copy] = copied(gpu, Depth24Plus, Depth24PlusStencil8, samples, [part, 16])?;
            let next = |(map, copy): (&u32, &u32)| copy == map || (*map > 0.75_f32.to_bits() && *copy == map + 1);
            if !map.iter().zip(&copy).all(next) {
                return Err("24 bits that are stored again are more than one step off".to_owned());
            }
        }
        let [map, copy] = copied(gpu, Depth16Unorm, Depth32FloatStencil8, samples, [0, 16])?;
        same(&format!("16 bits, {samples} samples"), &copy, &map)?;
        // To the nearest of 24 bits: no two of 16 bits become one, and the nearest of 16 bits is the one that it was.
        let [map, copy] = copied(gpu, Depth16Unorm, Depth24PlusStencil8, samples, [0, 16])?;
        let of_16 = |bits: &u32| (f64::from(f32::from_bits(*bits)) * 65535.0).round() as u32;
        let [map, copy] = [map, copy].map(|all| all.iter().map(of_16).collect::<Vec<_>>());
        same("16 bits in 24", &copy, &map)?;
        // From the least normal number to 1.
        let [map, copy] = copied(gpu, Depth32Float, Depth32FloatStencil8, samples, [0x0080_0000, 1000])?;
        same(&format!("floats, {samples} samples"), &copy, &map)?;
    }
    Ok(())
}
