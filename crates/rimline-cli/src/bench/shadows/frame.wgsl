// Surfaces of one colour in a light of its own brightness; positions are taken relative to the eye.

struct Frame {
  view_projection: mat4x4<f32>,
  eye: vec3<f32>,
  reserved_0: u32,
  // Relative to the eye.
  light: vec3<f32>,
  reserved_1: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;

struct Surface {
  @invariant @builtin(position) clip: vec4<f32>,
  @location(0) q: vec3<f32>,
  @location(1) @interpolate(flat) normal: vec3<f32>,
}

fn position(vertex: u32) -> vec3<f32> {
  return vec3<f32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

// Same arithmetic as `rimline_clip` of the library's include, because z-fail needs equal depths.
fn to_clip(position: vec3<f32>) -> vec4<f32> {
  let q = position - frame.eye;
  return frame.view_projection[0] * q.x + frame.view_projection[1] * q.y + frame.view_projection[2] * q.z +
    frame.view_projection[3];
}

@vertex fn surface_vertex(@builtin(vertex_index) corner: u32) -> Surface {
  let face = 3u * (corner / 3u);
  let a = position(faces[face]);
  let normal = cross(position(faces[face + 1u]) - a, position(faces[face + 2u]) - a);
  let p = position(faces[corner]);
  return Surface(to_clip(p), p - frame.eye, normal);
}

@fragment fn ambient_fragment() -> @location(0) vec4<f32> {
  return vec4<f32>(0.15);
}

@fragment fn lit_fragment(in: Surface) -> @location(0) vec4<f32> {
  let towards = frame.light - in.q;
  return vec4<f32>(saturate(dot(normalize(in.normal), normalize(towards))) / (1.0 + 0.01 * dot(towards, towards)));
}
