// A host's renderer: bodies and a floor in ambient light, then one light at a time.

struct Frame {
  // From positions less the eye to clip space.
  view_projection: mat4x4<f32>,
  eye: vec3<f32>,
  exposure: f32,
}

struct Lamp {
  // Homogeneous.
  light: vec4<f32>,
  color: vec3<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> lamp: Lamp;
@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;

struct Point {
  @invariant @builtin(position) clip: vec4<f32>,
  @location(0) position: vec3<f32>,
  @location(1) @interpolate(flat) normal: vec3<f32>,
  @location(2) albedo: vec3<f32>,
}

fn corner(number: u32) -> vec3<f32> {
  let first = 3u * faces[number];
  return vec3<f32>(positions[first], positions[first + 1u], positions[first + 2u]);
}

fn point(position: vec3<f32>, normal: vec3<f32>, albedo: vec3<f32>) -> Point {
  return Point(frame.view_projection * vec4<f32>(position - frame.eye, 1.0), position, normal, albedo);
}

@vertex fn body(@builtin(vertex_index) vertex: u32) -> Point {
  let first = vertex / 3u * 3u;
  let a = corner(first);
  let normal = normalize(cross(corner(first + 1u) - a, corner(first + 2u) - a));
  return point(corner(vertex), normal, vec3<f32>(0.66, 0.64, 0.60));
}

// A strip of four vertices.
@vertex fn floor_quad(@builtin(vertex_index) vertex: u32) -> Point {
  let at = 400.0 * (vec2<f32>(f32(vertex & 1u), f32(vertex >> 1u)) - 0.5);
  return point(vec3<f32>(at.x, 0.0, at.y), vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(0.80, 0.79, 0.77));
}

@fragment fn ambient(in: Point) -> @location(0) vec4<f32> {
  return vec4<f32>(0.22 * in.albedo * vec3<f32>(0.88, 0.95, 1.06) * (0.75 + 0.25 * in.normal.y), 1.0);
}

// Light counts where it is on the eye's side of the face.
@fragment fn lit(in: Point) -> @location(0) vec4<f32> {
  let side = sign(dot(in.normal, frame.eye - in.position));
  let towards = normalize(lamp.light.xyz - lamp.light.w * in.position);
  return vec4<f32>(in.albedo * lamp.color * max(0.0, side * dot(in.normal, towards)), 0.0);
}
