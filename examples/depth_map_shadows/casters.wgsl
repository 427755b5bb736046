// Casters without a mesh: a distance field, and cards that are the crown of a tree. main.rs appends it to `stage.wgsl`.

struct Shaded {
  @location(0) color: vec4<f32>,
  @builtin(frag_depth) depth: f32,
}

// The vector from the eye through a point of the picture, from -1 to 1. Its length along the direction of view is 1.
fn direction_through(at: vec2<f32>) -> vec3<f32> {
  let m = frame.view_projection;
  let right = vec3<f32>(m[0].x, m[1].x, m[2].x);
  let up = vec3<f32>(m[0].y, m[1].y, m[2].y);
  let forward = vec3<f32>(m[0].w, m[1].w, m[2].w);
  return forward + at.x / dot(right, right) * right + at.y / dot(up, up) * up;
}

// The distance to a ball, a ring around it, and a smaller ring around it at a right angle to the first.
fn distance_at(p: vec3<f32>) -> f32 {
  let q = p - vec3<f32>(1.25, 1.0, 0.5);
  let tilted = vec3<f32>(q.x, 0.8 * q.y - 0.6 * q.z, 0.6 * q.y + 0.8 * q.z);
  let ring = length(vec2<f32>(length(tilted.xz) - 0.78, tilted.y)) - 0.11;
  let other = length(vec2<f32>(length(tilted.xy) - 0.5, tilted.z)) - 0.07;
  return min(min(ring, other), length(q) - 0.3);
}

struct Everywhere {
  @builtin(position) clip: vec4<f32>,
  @location(0) at: vec2<f32>,
}

@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> Everywhere {
  let at = vec2<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u));
  return Everywhere(vec4<f32>(at, 0.0, 1.0), at);
}

// The point of the surface that is seen, relative to the eye. Discards the fragment if there is none.
fn marched(at: vec2<f32>) -> vec3<f32> {
  let towards = direction_through(at);
  let step = 1.0 / length(towards);
  var t = 0.2;
  for (var count = 0u; count < 160u && t < 20.0; count++) {
    let distance = distance_at(frame.eye + t * towards);
    if (distance < 5e-5 * t) {
      return t * towards;
    }
    t += distance * step;
  }
  discard;
}

fn normal_at(p: vec3<f32>) -> vec3<f32> {
  let e = vec2<f32>(1e-3, 0.0);
  return normalize(vec3<f32>(
    distance_at(p + e.xyy) - distance_at(p - e.xyy),
    distance_at(p + e.yxy) - distance_at(p - e.yxy),
    distance_at(p + e.yyx) - distance_at(p - e.yyx),
  ));
}

const FIELD: vec3<f32> = vec3<f32>(0.62, 0.46, 0.36);

@fragment fn field_ambient(in: Everywhere) -> Shaded {
  let from_eye = marched(in.at);
  let clip = frame.view_projection * vec4<f32>(from_eye, 1.0);
  return Shaded(ambient_light(normal_at(from_eye + frame.eye), FIELD), clip.z / clip.w);
}

@fragment fn field_lit(in: Everywhere) -> Shaded {
  let from_eye = marched(in.at);
  let clip = frame.view_projection * vec4<f32>(from_eye, 1.0);
  let position = from_eye + frame.eye;
  return Shaded(lamp_light(position, normal_at(position), FIELD), clip.z / clip.w);
}

struct Leaf {
  @invariant @builtin(position) clip: vec4<f32>,
  @location(0) at: vec2<f32>,
  @location(1) position: vec3<f32>,
  @location(2) @interpolate(flat) normal: vec3<f32>,
}

fn random(seed: u32) -> f32 {
  var state = seed * 747796405u + 2891336453u;
  state = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return f32((state >> 22u) ^ state) / 4294967296.0;
}

fn random_direction(seed: u32) -> vec3<f32> {
  let z = 2.0 * random(seed) - 1.0;
  let turn = 6.2831853 * random(seed + 1u);
  return vec3<f32>(sqrt(1.0 - z * z) * cos(turn), z, sqrt(1.0 - z * z) * sin(turn));
}

// Cards in the crown: two triangles each, at random positions and angles.
@vertex fn card(@builtin(vertex_index) vertex: u32) -> Leaf {
  let seed = 16u * (vertex / 6u);
  let corner = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u)[vertex % 6u];
  let at = vec2<f32>(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
  let outward = random_direction(seed);
  let middle = vec3<f32>(-1.45, 2.0, -0.2) + vec3<f32>(0.95, 0.8, 0.95) * pow(random(seed + 2u), 0.4) * outward;
  let normal = normalize(outward + 0.8 * random_direction(seed + 4u));
  let along = normalize(cross(normal, random_direction(seed + 8u)));
  let position = middle + 0.3 * (at.x * along + at.y * cross(normal, along));
  return Leaf(frame.view_projection * vec4<f32>(position - frame.eye, 1.0), at, position, normal);
}

// Whether a point of a card is on one of its three leaves. The rest of the card is discarded.
fn is_leaf(at: vec2<f32>) -> bool {
  var found = false;
  for (var leaf = 0u; leaf < 3u; leaf++) {
    let turn = 2.0943951 * f32(leaf);
    let along = at.x * cos(turn) + at.y * sin(turn);
    let across = at.y * cos(turn) - at.x * sin(turn);
    found = found || (along > 0.02 && along < 0.95 && abs(across) < 0.9 * along * (1.0 - along));
  }
  return found;
}

const GREEN: vec3<f32> = vec3<f32>(0.27, 0.42, 0.20);

@fragment fn leaf_ambient(in: Leaf) -> @location(0) vec4<f32> {
  if (!is_leaf(in.at)) {
    discard;
  }
  return ambient_light(in.normal, GREEN);
}

@fragment fn leaf_lit(in: Leaf) -> @location(0) vec4<f32> {
  if (!is_leaf(in.at)) {
    discard;
  }
  return lamp_light(in.position, in.normal, GREEN);
}
