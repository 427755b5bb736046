//! Depth that is copied is the depth that was drawn: `textureLoad` gives the same bits of both.

use rimline::internals::stages::{MASK_SAMPLES, SHADOW_MASKS};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::Dispatch;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::textures::depth_view;
use rimline_testkit::{is_long, must_fail};
use wgpu::TextureFormat::R8Uint;
use wgpu::TextureFormat::{self, Depth16Unorm, Depth24Plus, Depth24PlusStencil8, Depth32Float, Depth32FloatStencil8};

use crate::drawn::{DepthDraw, Picture, float_texture};

pub(crate) const TESTS: &[Test] = &[("depth_survives_the_copy", survives)];

const SIDE: u32 = 1024;

/// Depths by the indices of pixels.
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

/// The bits of the last sample of each pixel.
fn read(gpu: &Gpu, map: &wgpu::Texture) -> Result<Vec<u32>, String> {
    let samples = map.sample_count();
    let source = READ.replace("TEXTURE", float_texture(samples)).replace("LAST", &format!("{}", samples - 1));
    let kernel = Dispatch::new(gpu, &source, "read");
    let values = gpu.storage(&vec![0_u32; (SIDE * SIDE) as usize]);
    gpu.submit(|encoder| {
        kernel.record_over(gpu, encoder, &depth_view(map), &values, [SIDE / 8, SIDE / 8]);
        Ok(())
    })?;
    gpu.read(&values, usize::MAX)
}

/// Draws depths into a texture, copies them by the stage, and returns the bits of both.
fn copied(gpu: &Gpu, [from, to]: [TextureFormat; 2], samples: u32, first: [u32; 2]) -> Result<[Vec<u32>; 2], String> {
    let picture = Picture { size: [SIDE, SIDE], depth: from, samples, target: R8Uint };
    let [map, copy] = [from, to].map(|format| picture.texture(gpu, format, samples, 1));
    let fragment = if from == Depth32Float { "bits" } else { "parts" };
    let first = gpu.storage(&first);
    let (entry_points, bound) = ([Some("whole"), Some(fragment)], first.as_entire_binding());
    let numbered = DepthDraw { name: fragment, source: NUMBERED, entry_points, bound };
    let stage = if samples > 1 { &MASK_SAMPLES } else { &SHADOW_MASKS };
    let source = stage.composed().map_err(text)?.wgsl;
    gpu.submit(|encoder| {
        numbered.draw(gpu, encoder, &map)?;
        // The automatic layout takes depth for a texture of filterable floats.
        let (view, entry_points) = (depth_view(&map), [Some("mask_whole"), Some("mask_depth")]);
        let bound = wgpu::BindingResource::TextureView(&view);
        DepthDraw { name: "mask_depth", source: &source, entry_points, bound }.draw(gpu, encoder, &copy)
    })?;
    Ok([read(gpu, &map)?, read(gpu, &copy)?])
}

/// All values of 16 bits; values of 24 bits and of floats from 0 to 1, in a long run all of 24 bits. Pairs are the bits that
/// were drawn and those of the copy.
fn survives() -> Result<(), String> {
    let gpu = &*Gpu::shared_with_depth_features()?;
    let exact = |[map, copy]: [u32; 2]| copy == map;
    // Without the feature. llvmpipe multiplies by the reciprocal of 2²⁴ − 1 where it should divide, so that depths from 3/4
    // on come out as the next one.
    let next = |[map, copy]: [u32; 2]| copy == map || (map > 0.75_f32.to_bits() && copy == map + 1);
    // No two of 16 bits become one of 24, and the nearest of 16 bits is the one that it was.
    let of_16 = |pair: [u32; 2]| {
        let [map, copy] = pair.map(|bits| (f64::from(f32::from_bits(bits)) * 65535.0).round());
        copy == map
    };
    // With wgpu 30, OpenGL has no textures of several samples that shaders read.
    let is_opengl = gpu.device.adapter_info().backend == wgpu::Backend::Gl;
    let samples: &[u32] = if is_opengl { &[1] } else { &[1, 4] };
    for (&samples, part) in
        samples.iter().flat_map(|samples| (0..if is_long() { 16 } else { 1 }).map(move |part| (samples, part)))
    {
        type Row<'a> = ([TextureFormat; 2], [u32; 2], &'a dyn Fn([u32; 2]) -> bool);
        let rows: [Row<'_>; 5] = [
            ([Depth24Plus, Depth32FloatStencil8], [part, 16], &exact),
            ([Depth24Plus, Depth24PlusStencil8], [part, 16], &next),
            ([Depth16Unorm, Depth32FloatStencil8], [0, 16], &exact),
            ([Depth16Unorm, Depth24PlusStencil8], [0, 16], &of_16),
            // From the least normal number to 1.
            ([Depth32Float, Depth32FloatStencil8], [0x0080_0000, 1000], &exact),
        ];
        for (formats, first, is_right) in rows {
            let what = format!("{formats:?}, {samples} samples");
            let [map, mut copy] = copied(gpu, formats, samples, first)?;
            let check = |copy: &[u32]| {
                let wrong = map.iter().zip(copy).find(|(map, copy)| !is_right([**map, **copy]));
                wrong.map_or(Ok(()), |pair| Err(format!("{what}: {pair:?}")))
            };
            check(&copy)?;
            if formats[0] == Depth24Plus && map.windows(2).any(|pair| pair[0] >= pair[1]) {
                return Err("the depths are not all different".to_owned());
            }
            copy[1000] = copy[2000];
            must_fail("a depth that is changed", &check(&copy))?;
        }
    }
    Ok(())
}
