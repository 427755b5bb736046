// Stage `shadow_masks`: full-screen draws that turn the stencil counts of a scene's volumes into masks, for renderers
// without a stencil. `SceneFrame::write_masks` records them, for 32 lights at a time. `mask_whole` is the vertex shader
// of all.
// * `mask_depth` copies the caller's depth before the volumes are drawn. The copy is exact in `Depth32FloatStencil8`, but
//   for subnormal depths. In 24 bits it may be off by a unit, even if the caller's depth has 24 bits.
// * `mask_bit` adds the bit of a light where the stencil is not 0, once, after its volumes. The pipeline blends by
//   addition and sets the stencil to 0.
// * `mask_byte`, `mask_word` write 8 or 32 of the bits to the target, from sample 0. `mask_word` needs four channels.
// * `mask_share` writes the share of the samples that have the bit of a light.
// * `mask_dark_bit`, `mask_dark` write bit or share of a single light directly to the target, with the same stencil test,
//   if the depth has one sample.
// The variant SAMPLES is for multisampled textures, where each sample has depth, stencil and bits of its own.
// docs/numerics/rasterisers.md, "Copied depth".

// The depth for `mask_depth`; for `mask_bits` the bits, 8 lights a channel. Other draws do not read it. Depth is bound as
// floats, because naga writes no loads of depth textures for OpenGL.
#if SAMPLES
@group(0) @binding(0) var mask_source: texture_multisampled_2d<f32>;

fn mask_samples() -> u32 { return textureNumSamples(mask_source); }
#else
@group(0) @binding(0) var mask_source: texture_2d<f32>;

fn mask_samples() -> u32 { return 1u; }
#endif

struct MaskVertex {
  @builtin(position) clip: vec4<f32>,
  // The instance index, within 32 lights. For `mask_bit` and `mask_share` it is the bit of a light, for `mask_byte` the
  // index of 8 lights.
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
