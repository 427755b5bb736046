// Parts that passes of all pictures share.

// A triangle that covers the target, at depth 0, as where nothing was drawn: a backdrop may test for equal depths.
@vertex fn cover_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(vertex & 1u) * 4.0 - 1.0, f32(vertex >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Noise with little energy in low frequencies, from 0 to 1.
fn dither(pixel: vec2<f32>) -> f32 {
  return fract(52.9829189 * fract(dot(pixel, vec2<f32>(0.06711056, 0.00583715))));
}

// Decided on the bits: WGSL lets an implementation assume that floats are finite.
fn is_finite(p: vec3<f32>) -> bool {
  let exponents = bitcast<vec3<u32>>(p) & vec3<u32>(0x7f800000u);
  return all(exponents != vec3<u32>(0x7f800000u));
}

// A normal that was folded onto an octahedron.
fn unfold(word: u32) -> vec3<f32> {
  let e = unpack2x16snorm(word);
  var n = vec3<f32>(e, 1.0 - abs(e.x) - abs(e.y));
  let t = saturate(-n.z);
  n.x += select(t, -t, n.x >= 0.0);
  n.y += select(t, -t, n.y >= 0.0);
  return normalize(n);
}

// A linear colour, from channels that are roots in ten bits each.
fn unpack_color(word: u32) -> vec3<f32> {
  let root = vec3<f32>((vec3<u32>(word) >> vec3<u32>(0u, 10u, 20u)) & vec3<u32>(1023u)) / 1023.0;
  return root * root;
}

// Like `normalize`, whose squares leave the range of floats sooner.
fn direction_of(v: vec3<f32>) -> vec3<f32> {
  return normalize(v / max(max(abs(v.x), abs(v.y)), max(abs(v.z), 1e-37)));
}
