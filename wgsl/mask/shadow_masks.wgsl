// Stage `shadow_masks`: full-screen draws that turn the stencil counts of a scene's volumes into masks, for renderers
// without a stencil. `SceneFrame::write_masks` records them. `mask_whole` is the vertex shader of all.
// * `mask_depth` copies the caller's depth before the volumes are drawn. The copy is exact where the format has room.
// * `mask_bit` adds the bit of a light where the stencil is not 0, after its volumes. The pipeline blends by addition.
// * `mask_byte`, `mask_word` write 8 or 32 of the bits to the target, from sample 0.
// * `mask_share` writes the share of the samples that have the bit of a light.
// * `mask_dark_bit`, `mask_dark` write bit or share of a single light directly to the target, with the same stencil test.
// The variant SAMPLES is for multisampled textures, where each sample has depth, stencil and bits of its own.
// docs/numerics/rasterisers.md, "Copied depth".

// The depth for `mask_depth`, else the bits, 8 lights a channel. Depth is read as floats, because OpenGL loads no texels of
// depth textures.
#if SAMPLES
@group(0) @binding(0) var mask_source: texture_multisampled_2d<f32>;

fn mask_samples() -> u32 { return textureNumSamples(mask_source); }
#else
@group(0) @binding(0) var mask_source: texture_2d<f32>;

fn mask_samples() -> u32 { return 1u; }
#endif

struct MaskVertex {
  @builtin(position) clip: vec4<f32>,
  // The instance index. For `mask_bit` and `mask_share` it is the bit of a light, for `mask_byte` the index of 8 lights.
  @location(0) @interpolate(flat) index: u32,
}

@vertex
fn mask_whole(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> MaskVertex {
  return MaskVertex(vec4<f32>(select(-1.0, 3.0, corner == 1u), select(-1.0, 3.0, corner == 2u), 0.5, 1.0), index);
}

#if SAMPLES
@fragment
fn mask_depth(in: MaskVertex, @builtin(sample_index) sample: u32) -> @builtin(frag_depth) f32 {
  return textureLoad(mask_source, vec2<i32>(in.clip.xy), sample).x;
}
#else
@fragment
fn mask_depth(in: MaskVertex) -> @builtin(frag_depth) f32 {
  return textureLoad(mask_source, vec2<i32>(in.clip.xy), 0).x;
}
#endif

@fragment
fn mask_bit(in: MaskVertex) -> @location(0) vec4<f32> {
  let value = f32(1u << (in.index & 7u)) / 255.0;
  return select(vec4<f32>(), vec4<f32>(value), vec4<u32>(0u, 1u, 2u, 3u) == vec4<u32>(in.index >> 3u));
}

@fragment
fn mask_dark_bit() -> @location(0) u32 {
  return 1u;
}

@fragment
fn mask_dark() -> @location(0) f32 {
  return 1.0;
}

// The bits of up to 32 lights at a sample of a pixel. If the texture has one channel, only the low 8 bits have a meaning:
// its alpha reads as 1. Without SAMPLES, `sample` is the mip level and must be 0.
fn mask_bits(pixel: vec4<f32>, sample: u32) -> u32 {
  return pack4x8unorm(textureLoad(mask_source, vec2<i32>(pixel.xy), sample));
}

@fragment
fn mask_byte(in: MaskVertex) -> @location(0) u32 {
  return (mask_bits(in.clip, 0u) >> (8u * in.index)) & 255u;
}

@fragment
fn mask_word(in: MaskVertex) -> @location(0) u32 {
  return mask_bits(in.clip, 0u);
}

@fragment
fn mask_share(in: MaskVertex) -> @location(0) f32 {
  var count = 0u;
  // Turns: 64.
  for (var sample = 0u; sample < mask_samples(); sample++) {
    count += (mask_bits(in.clip, sample) >> in.index) & 1u;
  }
  return f32(count) / f32(mask_samples());
}
