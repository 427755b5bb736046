// Uniforms and functions of all passes. World space is right-handed with +Y up; positions are relative to the eye. Depth is
// reversed, near / distance. Light is linear. The look is that of `rimline shadow`.

struct Frame {
  // From positions less the eye to clip space, as for shadow volumes.
  view_projection: mat4x4<f32>,
  eye: vec3<f32>,
  // The ground's height over the eye.
  ground: f32,
  right: vec3<f32>,
  // Clip units per unit of view space at distance 1.
  scale_x: f32,
  up: vec3<f32>,
  scale_y: f32,
  forward: vec3<f32>,
  exposure: f32,
  ambient: vec3<f32>,
  // From the centre, where the ground begins to fade into the backdrop, and where it has.
  fade_begin: f32,
  backdrop: vec3<f32>,
  fade_end: f32,
  // Width and height in pixels.
  size: vec2<f32>,
  // Below the models, (x, z), relative to the eye.
  centre: vec2<f32>,
  // Whether faces smooth into each other.
  is_smooth: u32,
}

struct Lamp {
  // Homogeneous, relative to the eye.
  light: vec4<f32>,
  color: vec3<f32>,
  // The distance where it ends; 0: nowhere.
  range: f32,
  // The way a spot shines, and how the share of its light follows from the cosine there; else 0, 0 and 1.
  axis: vec3<f32>,
  cone_scale: f32,
  cone_offset: f32,
  // The number of the light in extractions.
  number: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<uniform> lamp: Lamp;

fn from_eye(position: vec3<f32>) -> vec3<f32> {
  return position - frame.eye;
}

// Same arithmetic as `rimline_clip` of the library's include.
fn to_clip(position: vec3<f32>) -> vec4<f32> {
  let q = from_eye(position);
  return frame.view_projection[0] * q.x + frame.view_projection[1] * q.y + frame.view_projection[2] * q.z +
    frame.view_projection[3];
}

fn direction_to_clip(d: vec3<f32>) -> vec4<f32> {
  return frame.view_projection[0] * d.x + frame.view_projection[1] * d.y + frame.view_projection[2] * d.z;
}

// Decided on the bits: WGSL lets an implementation assume that floats are finite.
fn is_finite(p: vec3<f32>) -> bool {
  let exponents = bitcast<vec3<u32>>(p) & vec3<u32>(0x7f800000u);
  return all(exponents != vec3<u32>(0x7f800000u));
}

// A triangle that covers the target.
@vertex fn cover_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(vertex & 1u) * 4.0 - 1.0, f32(vertex >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Noise with little energy in low frequencies, from 0 to 1.
fn dither(pixel: vec2<f32>) -> f32 {
  return fract(52.9829189 * fract(dot(pixel, vec2<f32>(0.06711056, 0.00583715))));
}

// Light that arrives at a position relative to the eye, on a surface perpendicular to its rays.
struct Arriving {
  towards: vec3<f32>,
  color: vec3<f32>,
}

fn arriving(q: vec3<f32>) -> Arriving {
  let l = lamp.light.xyz - lamp.light.w * q;
  let towards = normalize(l);
  let cone = saturate(lamp.cone_offset - lamp.cone_scale * dot(lamp.axis, towards));
  var share = cone * cone;
  if (lamp.range > 0.0) {
    share *= saturate(1.0 - length(l) / lamp.range);
  }
  return Arriving(towards, lamp.color * share);
}

// The paper behind everything, a little lighter behind its middle.
fn backdrop(pixel: vec2<f32>) -> vec3<f32> {
  let p = (pixel - 0.5 * frame.size) / frame.size.y;
  return frame.backdrop * mix(0.8, 1.0, exp(-1.3 * dot(p, p)));
}
