// Uniforms of all passes of the picture. World space is right-handed with +Y up; depth is reversed, near / distance.

struct Frame {
  eye: vec3<f32>,
  near: f32,
  right: vec3<f32>,
  // Clip units per unit of view space at distance 1.
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
  // The survey's places a pixel, each way.
  places: i32,
  // 1 if boundary edges have a colour of their own.
  show_boundary: u32,
  // 1 if the model has base colours.
  is_colored: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Right, up and forward from the eye.
fn to_view(position: vec3<f32>) -> vec3<f32> {
  let from_eye = position - frame.eye;
  return vec3<f32>(dot(from_eye, frame.right), dot(from_eye, frame.up), dot(from_eye, frame.forward));
}

fn to_clip(view: vec3<f32>) -> vec4<f32> {
  return vec4<f32>(view.x * frame.scale_x, view.y * frame.scale_y, frame.near, view.z);
}

// Depth from what the survey saw; 0 where that is nothing.
fn depth_of(seen: vec4<u32>) -> f32 {
  return bitcast<f32>(seen.b | (seen.a << 16u));
}
