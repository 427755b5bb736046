// Stage `shadow_masks`: full-screen draws that turn depth without a stencil into masks, for scenes. `mask_whole` is the vertex
// shader of all of them; three vertices, and the instance is the number that a fragment shader takes.
// `mask_depth`: copies the depth that the caller drew. Its value is stored as it was loaded, where the format has room for it.
// `mask_bit`: adds the bit of a light to the bits of the lights, 8 a channel. The caller's pipeline adds, and tests the stencil.
// `mask_dark_bit`, `mask_dark`: write the bit or the share of the only light to the target at once, with the same test.
// `mask_byte`, `mask_word`: write 8 or 32 bits to the target, of sample 0. `mask_share`: writes the share of the samples that have
// a bit.
// Reads: the depth, or the bits.
// The variant SAMPLES takes textures with several samples a pixel. Each sample then has depth, stencil and bits of its own.

// Depth as floats: OpenGL loads no texels of depth textures.
#if SAMPLES
@group(0) @binding(0) var mask_source: texture_multisampled_2d<f32>;

fn mask_samples() -> u32 { return textureNumSamples(mask_source); }
#else
@group(0) @binding(0) var mask_source: texture_2d<f32>;

fn mask_samples() -> u32 { return 1u; }
#endif

struct MaskPoint {
  @builtin(position) clip: vec4<f32>,
  @location(0) @interpolate(flat) number: u32,
}

@vertex
fn mask_whole(@builtin(vertex_index) corner: u32, @builtin(instance_index) number: u32) -> MaskPoint {
  return MaskPoint(vec4<f32>(select(-1.0, 3.0, corner == 1u), select(-1.0, 3.0, corner == 2u), 0.5, 1.0), number);
}

#if SAMPLES
@fragment
fn mask_depth(in: MaskPoint, @builtin(sample_index) sample: u32) -> @builtin(frag_depth) f32 {
  return textureLoad(mask_source, vec2<i32>(in.clip.xy), sample).x;
}
#else
@fragment
fn mask_depth(in: MaskPoint) -> @builtin(frag_depth) f32 {
  return textureLoad(mask_source, vec2<i32>(in.clip.xy), 0).x;
}
#endif

@fragment
fn mask_bit(in: MaskPoint) -> @location(0) vec4<f32> {
  let bit = f32(1u << (in.number & 7u)) / 255.0;
  return select(vec4<f32>(), vec4<f32>(bit), vec4<u32>(0u, 1u, 2u, 3u) == vec4<u32>(in.number >> 3u));
}

@fragment
fn mask_dark_bit() -> @location(0) u32 {
  return 1u;
}

@fragment
fn mask_dark() -> @location(0) f32 {
  return 1.0;
}

// The bits of up to 32 lights at a sample of a pixel.
fn mask_bits(at: vec4<f32>, sample: u32) -> u32 {
  return pack4x8unorm(textureLoad(mask_source, vec2<i32>(at.xy), sample));
}

@fragment
fn mask_byte(in: MaskPoint) -> @location(0) u32 {
  return (mask_bits(in.clip, 0u) >> (8u * in.number)) & 255u;
}

@fragment
fn mask_word(in: MaskPoint) -> @location(0) u32 {
  return mask_bits(in.clip, 0u);
}

@fragment
fn mask_share(in: MaskPoint) -> @location(0) f32 {
  var count = 0u;
  // Turns: 64.
  for (var sample = 0u; sample < mask_samples(); sample++) {
    count += (mask_bits(in.clip, sample) >> in.number) & 1u;
  }
  return f32(count) / f32(mask_samples());
}
