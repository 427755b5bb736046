// Uniforms of all passes of a picture with shadows. No shader branches on them alone: for each draw Mesa's software
// Vulkan 22 compiles such a shader anew, and keeps every copy. World space is right-handed with +Y up; positions are
// relative to the eye. Depth is reversed; of a perspective camera it is near / distance. Light is linear.

struct Frame {
  // From positions less the eye, in units, to clip space. The shadow volumes' camera, whose clip space is a unit times as
  // large where it is perspective: a power of two, so that depths are the same to the bit.
  view_projection: mat4x4<f32>,
  eye: vec3<f32>,
  // The ground's height over the eye, in units; negative, since it is seen from above.
  ground: f32,
  right: vec3<f32>,
  // One over the distance from where the ground begins to fade into the backdrop to where it has; in units.
  fade_slope: f32,
  up: vec3<f32>,
  // Pixels of the picture from one pixel drawn to the next, and where in the picture the first one's centre is.
  pitch: f32,
  forward: vec3<f32>,
  exposure: f32,
  ambient: vec3<f32>,
  // One over the unit, a power of two of about the scene's size: squares of distances are floats then, and so is what
  // rasterisers divide by w.
  per_unit: f32,
  backdrop: vec3<f32>,
  // 1 for an orthographic camera.
  is_parallel: u32,
  // Width and height in pixels.
  size: vec2<f32>,
  // Below the models, (x, z), relative to the eye, in units.
  centre: vec2<f32>,
  first: vec2<f32>,
  // How far right and up of the view's middle a pixel drawn is, at distance 1 of a perspective camera: its step, and its
  // value where pixels begin.
  aside_step: vec2<f32>,
  aside: vec2<f32>,
}

// A light, or a sample of one with an area.
struct ShadedLight {
  // Homogeneous, relative to the eye, in units.
  light: vec4<f32>,
  color: vec3<f32>,
  // Where it ends, in units times the light's w; 0: nowhere.
  range: f32,
  // Where it begins to fade, in the same, and how.
  begin: f32,
  exponent: f32,
  // Its bit in the word of facing masks that is bound.
  bit: u32,
  // How dense its volume is drawn.
  density: f32,
  // The way a spot shines, and how the share of its light follows from the cosine there; else 0, 0 and 1.
  axis: vec3<f32>,
  cone_scale: f32,
  cone_offset: f32,
  // The index of its lists of silhouettes in the batch of 32 lights that is bound.
  silhouettes: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<uniform> shaded: ShadedLight;

fn from_eye(position: vec3<f32>) -> vec3<f32> {
  return frame.per_unit * (position - frame.eye);
}

// Same arithmetic as `rimline_clip` of the library's include.
fn to_clip(position: vec3<f32>) -> vec4<f32> {
  let q = from_eye(position);
  return frame.view_projection[0] * q.x + frame.view_projection[1] * q.y + frame.view_projection[2] * q.z +
    frame.view_projection[3];
}

// From a position towards the eye.
fn towards_eye(q: vec3<f32>) -> vec3<f32> {
  return select(direction_of(-q), -frame.forward, frame.is_parallel != 0u);
}

fn direction_to_clip(d: vec3<f32>) -> vec4<f32> {
  return frame.view_projection[0] * d.x + frame.view_projection[1] * d.y + frame.view_projection[2] * d.z;
}

// Light that arrives at a position, on a surface perpendicular to its rays. The position is relative to the eye, in
// units.
struct Arriving {
  // To the light.
  towards: vec3<f32>,
  color: vec3<f32>,
  // The place is within the light's range and cone.
  reached: bool,
}

// Bergeron's falloff, as `rimline::shadow::falloff`.
fn falloff(distance: f32) -> f32 {
  if (distance >= shaded.range) {
    return 0.0;
  }
  if (distance <= shaded.begin) {
    return 1.0;
  }
  let left = saturate((shaded.range - distance) / (shaded.range - shaded.begin));
  return select(0.0, pow(left, shaded.exponent), left > 0.0);
}

// In units, squares are floats.
fn arriving(q: vec3<f32>) -> Arriving {
  let l = shaded.light.xyz - shaded.light.w * q;
  let towards = normalize(l);
  let cone = saturate(shaded.cone_offset - shaded.cone_scale * dot(shaded.axis, towards));
  let has_range = shaded.range > 0.0;
  let distance = length(l);
  let share = cone * cone * select(1.0, falloff(distance), has_range);
  return Arriving(towards, shaded.color * share, (cone > 0.0) & (!has_range | (distance < shaded.range)));
}

// Where in the picture a pixel drawn is.
fn in_picture(pixel: vec2<f32>) -> vec2<f32> {
  return frame.pitch * (pixel - 0.5) + frame.first;
}

// The paper behind everything, a little lighter behind its middle.
fn backdrop(pixel: vec2<f32>) -> vec3<f32> {
  let p = (in_picture(pixel) - 0.5 * frame.size) / frame.size.y;
  let glow = exp(-1.3 * dot(p, p));
  return frame.backdrop * mix(0.8, 1.0, glow);
}
