// A host's renderer: bodies and a floor in ambient light, then one light at a time.

struct Frame {
  // From positions less the eye to clip space.
  view_projection: mat4x4<f32>,
  eye: vec3<f32>,
  ambient: f32,
}

struct Lamp {
  // Homogeneous.
  light: vec4<f32>,
  color: vec3<f32>,
  // 1 / range², which is 0 without a range.
  reach: f32,
}

// An instance of a body.
struct Placed {
  // Rows of the matrix from its positions to world space.
  rows: array<vec4<f32>, 3>,
  albedo: vec3<f32>,
  // Its vertex 0 in the positions.
  first_vertex: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> lamp: Lamp;
@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;
@group(1) @binding(2) var<storage, read> instances: array<Placed>;

struct Point {
  @invariant @builtin(position) clip: vec4<f32>,
  @location(0) position: vec3<f32>,
  @location(1) @interpolate(flat) normal: vec3<f32>,
  @location(2) albedo: vec3<f32>,
}

fn along(row: vec4<f32>, at: vec3<f32>) -> f32 {
  return row.x * at.x + row.y * at.y + row.z * at.z;
}

// A corner of an instance, less the eye. Shadow volumes place their vertices by the same products and sums.
fn corner(number: u32, placed: Placed) -> vec3<f32> {
  let first = 3u * (placed.first_vertex + faces[number]);
  let at = vec3<f32>(positions[first], positions[first + 1u], positions[first + 2u]);
  let rows = placed.rows;
  let shift = vec3<f32>(rows[0].w, rows[1].w, rows[2].w) - frame.eye;
  return vec3<f32>(along(rows[0], at), along(rows[1], at), along(rows[2], at)) + shift;
}

fn point(from_eye: vec3<f32>, normal: vec3<f32>, albedo: vec3<f32>) -> Point {
  return Point(frame.view_projection * vec4<f32>(from_eye, 1.0), from_eye + frame.eye, normal, albedo);
}

@vertex fn body(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Point {
  let placed = instances[instance];
  let first = vertex / 3u * 3u;
  let a = corner(first, placed);
  let normal = normalize(cross(corner(first + 1u, placed) - a, corner(first + 2u, placed) - a));
  return point(corner(vertex, placed), normal, placed.albedo);
}

// A strip of four vertices.
@vertex fn floor_quad(@builtin(vertex_index) vertex: u32) -> Point {
  let at = 400.0 * (vec2<f32>(f32(vertex & 1u), f32(vertex >> 1u)) - 0.5);
  return point(vec3<f32>(at.x, 0.0, at.y) - frame.eye, vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(0.80, 0.79, 0.77));
}

fn ambient_light(normal: vec3<f32>, albedo: vec3<f32>) -> vec4<f32> {
  return vec4<f32>(frame.ambient * albedo * vec3<f32>(0.88, 0.95, 1.06) * (0.75 + 0.25 * normal.y), 1.0);
}

// Light counts where it is on the eye's side of the face.
fn lamp_light(position: vec3<f32>, normal: vec3<f32>, albedo: vec3<f32>) -> vec4<f32> {
  let side = sign(dot(normal, frame.eye - position));
  let towards = lamp.light.xyz - lamp.light.w * position;
  let facing = max(0.0, side * dot(normal, normalize(towards)));
  let falloff = max(0.0, 1.0 - lamp.light.w * lamp.reach * dot(towards, towards));
  return vec4<f32>(albedo * lamp.color * facing * falloff * falloff, 0.0);
}

@fragment fn ambient(in: Point) -> @location(0) vec4<f32> {
  return ambient_light(in.normal, in.albedo);
}

@fragment fn lit(in: Point) -> @location(0) vec4<f32> {
  return lamp_light(in.position, in.normal, in.albedo);
}
