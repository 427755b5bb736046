// Uniforms of all passes of the picture. World space is right-handed with +Y up; depth is reversed. Of a perspective camera
// it is near / distance.

struct Frame {
  eye: vec3<f32>,
  // The distance of the near plane. The survey divides by distances of at least this.
  near: f32,
  right: vec3<f32>,
  // Clip units per unit of view space, of a perspective camera at distance 1.
  scale_x: f32,
  up: vec3<f32>,
  scale_y: f32,
  forward: vec3<f32>,
  // Half the width of a line, in pixels.
  half_line: f32,
  // Width and height in pixels.
  size: vec2<f32>,
  // The model's largest extent, a length to scale effects with.
  extent: f32,
  // Height of the ground.
  ground: f32,
  // Centre (x, z) and half-width of the square of ground that takes the contact shadow.
  ground_centre: vec2<f32>,
  ground_half: f32,
  // Height above the ground up to which the model darkens it.
  shadow_height: f32,
  // Texels of the survey along a pixel's side.
  survey_scale: i32,
  // 1 if boundary edges have a colour of their own.
  show_boundary: u32,
  // The distance of the far plane of an orthographic camera; 0 of a perspective one.
  far: f32,
  // 1 if the model has base colours.
  is_colored: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Right, up and forward from the eye.
fn to_view(position: vec3<f32>) -> vec3<f32> {
  let from_eye = position - frame.eye;
  return vec3<f32>(dot(from_eye, frame.right), dot(from_eye, frame.up), dot(from_eye, frame.forward));
}

fn is_parallel() -> bool {
  return frame.far > 0.0;
}

// The distance that sizes in the picture shrink with.
fn shrinking(distance: f32) -> f32 {
  return select(distance, 1.0, is_parallel());
}

// The ray of the eye through what is `from_eye`, of any length.
fn ray(from_eye: vec3<f32>) -> vec3<f32> {
  return select(from_eye, frame.forward, vec3<bool>(is_parallel()));
}

fn to_clip(view: vec3<f32>) -> vec4<f32> {
  let parallel_depth = (frame.far - view.z) / (frame.far - frame.near);
  let depth = select(frame.near, parallel_depth, is_parallel());
  return vec4<f32>(view.x * frame.scale_x, view.y * frame.scale_y, depth, shrinking(view.z));
}

// Near / distance from what the survey saw; 0 where that is nothing.
fn depth_of(seen: vec4<u32>) -> f32 {
  return bitcast<f32>(seen.b | (seen.a << 16u));
}
