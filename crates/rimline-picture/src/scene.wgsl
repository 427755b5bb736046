// Uniforms of all passes of a picture with shadows, and functions of them. No shader branches on them alone: for each draw
// Mesa's software Vulkan 22 compiles such a shader anew, and keeps every copy. World space is right-handed with +Y up.
// Light is computed at points q relative to the eye, in units (`from_eye`). A unit is a power of two of about the scene's
// size, so that squares of distances neither overflow nor underflow. Depth is reversed; of a perspective camera it is near /
// distance. Colours of light are linear.

struct Frame {
  // From q to clip space, for the pixels that are drawn. It is the camera of the shadow volumes, whose clip coordinates are
  // those from here, times the unit for a perspective camera. The unit is a power of two, so depths have the same bits.
  view_projection: mat4x4<f32>,
  eye: vec3<f32>,
  // The ground's height over the eye, in units. It is negative where the ground is drawn.
  ground: f32,
  right: vec3<f32>,
  // 1 / the length over which the ground fades into the backdrop, in units.
  fade_slope: f32,
  up: vec3<f32>,
  // The distance of neighbouring pixels that are drawn, in pixels of the picture: more than 1 if parts are drawn in turn.
  pitch: f32,
  forward: vec3<f32>,
  // The factor from light to the picture.
  exposure: f32,
  ambient: vec3<f32>,
  // 1 / the unit.
  per_unit: f32,
  backdrop: vec3<f32>,
  // 1 for an orthographic camera.
  is_parallel: u32,
  // Width and height of the picture in pixels.
  size: vec2<f32>,
  // x and z of the point below the middle of the models, relative to the eye, in units.
  centre: vec2<f32>,
  // The centre of the first pixel that is drawn, in the picture.
  first: vec2<f32>,
  // How far right and up of the view's middle a pixel that is drawn is, in world space, at distance 1 of a perspective camera:
  // the change from a pixel to the next, and the value at pixel coordinates 0.
  aside_step: vec2<f32>,
  aside: vec2<f32>,
}

// A light, or a sample of one with an area.
struct ShadedLight {
  // Homogeneous, relative to the eye, in units, scaled so that the largest component is about 1: w need not be 0 or 1.
  light: vec4<f32>,
  color: vec3<f32>,
  // The distance at which it ends, in units times the light's w. 0: it does not end, as at infinity.
  range: f32,
  // The distance at which it begins to fade, likewise, and the exponent of `falloff`.
  begin: f32,
  exponent: f32,
  // The index of its bit in the bound facing masks.
  bit: u32,
  // A factor of the opacity of its volume in sketches (overlay.wgsl).
  density: f32,
  // A spot shines along `axis`. Its share of light at an angle is the square of scale * cosine + offset. Other lights have 0,
  // 0 and 1.
  axis: vec3<f32>,
  cone_scale: f32,
  cone_offset: f32,
  // The index of its lists of silhouettes in the batch of 32 lights that is bound.
  silhouettes: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<uniform> shaded: ShadedLight;

// A position in world space, relative to the eye and in units.
fn from_eye(position: vec3<f32>) -> vec3<f32> {
  return frame.per_unit * (position - frame.eye);
}

// A position of world space in clip space. The operations have the order of `rimline_clip` of the library's include, so that
// depths have the bits of the shadow volumes.
fn to_clip(position: vec3<f32>) -> vec4<f32> {
  let q = from_eye(position);
  return frame.view_projection[0] * q.x + frame.view_projection[1] * q.y + frame.view_projection[2] * q.z +
    frame.view_projection[3];
}

// The direction from a point towards the eye.
fn towards_eye(q: vec3<f32>) -> vec3<f32> {
  return select(direction_of(-q), -frame.forward, frame.is_parallel != 0u);
}

// A direction, or a point at infinity, in clip space.
fn direction_to_clip(d: vec3<f32>) -> vec4<f32> {
  return frame.view_projection[0] * d.x + frame.view_projection[1] * d.y + frame.view_projection[2] * d.z;
}

// Light that arrives at a point, on a surface perpendicular to its rays.
struct Arriving {
  // The direction towards the light.
  towards: vec3<f32>,
  color: vec3<f32>,
  // Whether the point is within the light's range and cone.
  reached: bool,
}

// The share of light at a distance, in units times the light's w, for a light that ends: Bergeron's falloff, as
// `rimline::falloff`.
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

// The light that arrives at a point q, as if no face were between.
fn arriving(q: vec3<f32>) -> Arriving {
  let l = shaded.light.xyz - shaded.light.w * q;
  let towards = normalize(l);
  let cone = saturate(shaded.cone_offset - shaded.cone_scale * dot(shaded.axis, towards));
  let has_range = shaded.range > 0.0;
  let distance = length(l);
  let share = cone * cone * select(1.0, falloff(distance), has_range);
  return Arriving(towards, shaded.color * share, (cone > 0.0) & (!has_range | (distance < shaded.range)));
}

// The position in the picture of the pixel at these coordinates of the target.
fn in_picture(pixel: vec2<f32>) -> vec2<f32> {
  return frame.pitch * (pixel - 0.5) + frame.first;
}

// The colour behind everything: a little lighter in the middle of the picture.
fn backdrop(pixel: vec2<f32>) -> vec3<f32> {
  let p = (in_picture(pixel) - 0.5 * frame.size) / frame.size.y;
  let glow = exp(-1.3 * dot(p, p));
  return frame.backdrop * mix(0.8, 1.0, glow);
}
