// The models, as matte clay. A face's side towards a light decides whether it is lit; smooth normals only shade.

struct Clay {
  front: vec3<f32>,
  back: vec3<f32>,
}

@group(2) @binding(0) var<uniform> clay: Clay;
@group(2) @binding(1) var<storage, read> positions: array<u32>;
@group(2) @binding(2) var<storage, read> faces: array<u32>;
// The group of normals of each corner, and their normals.
@group(2) @binding(3) var<storage, read> groups: array<u32>;
@group(2) @binding(4) var<storage, read> normals: array<f32>;

struct Surface {
  @invariant @builtin(position) clip: vec4<f32>,
  @location(0) normal: vec3<f32>,
  @location(1) q: vec3<f32>,
  @location(2) @interpolate(flat) faces_light: u32,
}

fn position(vertex: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(vec3<u32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]));
}

@vertex fn surface_vertex(@builtin(vertex_index) corner: u32) -> Surface {
  let face = corner / 3u;
  let a = position(faces[3u * face]);
  let b = position(faces[3u * face + 1u]);
  let c = position(faces[3u * face + 2u]);
  if (!is_finite(a) || !is_finite(b) || !is_finite(c)) {
    return Surface(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec3<f32>(0.0), vec3<f32>(0.0), 0u);
  }
  let p = position(faces[corner]);
  let own = cross(b - a, c - a);
  let towards = lamp.light.xyz - lamp.light.w * from_eye(a);
  var n = own;
  if (frame.is_smooth != 0u) {
    let first = 3u * groups[corner];
    n = vec3<f32>(normals[first], normals[first + 1u], normals[first + 2u]);
  }
  return Surface(to_clip(p), n, from_eye(p), u32(dot(own, towards) > 0.0));
}

// Towards the eye; interpolated normals may lean away from it at the rim.
fn shading_normal(in: Surface, front: bool, to_eye: vec3<f32>) -> vec3<f32> {
  let n = normalize(select(-in.normal, in.normal, front) + 1e-30 * to_eye);
  return normalize(n + max(0.0, 0.02 - dot(n, to_eye)) * to_eye);
}

fn albedo(front: bool) -> vec3<f32> {
  return select(clay.back, clay.front, front);
}

@fragment fn ambient_fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
  let to_eye = normalize(-in.q);
  let n = shading_normal(in, front, to_eye);
  // More from above; and a little from the eye and its right, so that what is in shadow keeps its shape.
  let around = mix(0.5, 1.0, 0.5 + 0.5 * n.y) * mix(0.55, 1.05, saturate(dot(n, to_eye))) *
    (1.0 + 0.18 * dot(n, frame.right));
  return vec4<f32>(albedo(front) * frame.ambient * around, 1.0);
}

// Light and eye are on the same side of the face.
fn is_lit(in: Surface, front: bool) -> bool {
  return (in.faces_light != 0u) == front;
}

@fragment fn lit_fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
  if (!is_lit(in, front)) {
    discard;
  }
  let to_eye = normalize(-in.q);
  let n = shading_normal(in, front, to_eye);
  let light = arriving(in.q);
  // Flat faces turn from the light one at a time, smooth normals do not: the light fades before the first face turns.
  let cosine = saturate(dot(n, light.towards));
  let fade = smoothstep(0.0, 0.3, cosine);
  let sheen = 0.06 * pow(saturate(dot(n, normalize(to_eye + light.towards))), 24.0);
  return vec4<f32>((albedo(front) * cosine + sheen) * fade * light.color, 0.0);
}

// Keeps the pixels whose visible side is turned away from the light.
@fragment fn averted_fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
  if (is_lit(in, front)) {
    discard;
  }
  return vec4<f32>(0.0);
}

@fragment fn black_fragment() -> @location(0) vec4<f32> {
  return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}

// A factor for what is there.
@fragment fn dim_fragment() -> @location(0) vec4<f32> {
  return vec4<f32>(0.5, 0.5, 0.5, 1.0);
}

// Faces that cast: those whose front is turned away from the light.
@fragment fn caps_fragment(in: Surface) -> @location(0) vec4<f32> {
  if (in.faces_light != 0u) {
    discard;
  }
  let brightest = max(max(lamp.color.r, lamp.color.g), max(lamp.color.b, 1e-6));
  return vec4<f32>(lamp.color / brightest * 0.55 / frame.exposure, 0.35);
}
