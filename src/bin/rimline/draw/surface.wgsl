// The model as matte clay in a small studio: a warm key from the upper left, a cool fill from the right, a rim light
// from behind, all of which move with the eye.

@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;
// A normal a corner, folded onto an octahedron.
@group(1) @binding(2) var<storage, read> normals: array<u32>;

struct Surface {
  @builtin(position) clip: vec4<f32>,
  @location(0) normal: vec3<f32>,
  @location(1) position: vec3<f32>,
}

fn unfold(word: u32) -> vec3<f32> {
  let e = unpack2x16snorm(word);
  var n = vec3<f32>(e, 1.0 - abs(e.x) - abs(e.y));
  let t = saturate(-n.z);
  n.x += select(t, -t, n.x >= 0.0);
  n.y += select(t, -t, n.y >= 0.0);
  return normalize(n);
}

@vertex fn surface_vertex(@builtin(vertex_index) corner: u32) -> Surface {
  let first = 3u * faces[corner];
  let position = vec3<f32>(positions[first], positions[first + 1u], positions[first + 2u]);
  return Surface(to_clip(to_view(position)), unfold(normals[corner]), position);
}

fn studio(right: f32, up: f32, back: f32) -> vec3<f32> {
  return normalize(right * frame.right + up * frame.up - back * frame.forward);
}

@fragment fn surface_fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
  let to_eye = normalize(frame.eye - in.position);
  var n = normalize(in.normal);
  if (!front) {
    n = -n;
  }
  // Interpolated normals may lean away from the eye at the rim.
  n = normalize(n + max(0.0, 0.02 - dot(n, to_eye)) * to_eye);

  let key = saturate((dot(n, studio(-0.62, 0.72, 0.62)) + 0.25) / 1.25);
  let fill = saturate((dot(n, studio(0.95, 0.05, 0.45)) + 0.4) / 1.4);
  let sky = 0.5 + 0.5 * n.y;
  let facing = saturate(dot(n, to_eye));
  let rim = pow(1.0 - facing, 3.0) * saturate(dot(n, studio(0.75, 0.5, -0.6)) + 0.1);

  // The inside of an open surface is a little bluer.
  let clay = select(vec3<f32>(0.50, 0.53, 0.58), vec3<f32>(0.74, 0.66, 0.575), front);
  var light = mix(vec3<f32>(0.20, 0.165, 0.145), vec3<f32>(0.33, 0.36, 0.41), sky);
  light += 0.80 * pow(key, 1.35) * vec3<f32>(1.0, 0.955, 0.89);
  light += 0.13 * fill * vec3<f32>(0.72, 0.86, 1.0);
  let halfway = normalize(to_eye + studio(-0.62, 0.72, 0.62));
  let sheen = 0.05 * pow(saturate(dot(n, halfway)), 24.0);
  let colour = clay * light + 0.22 * rim * vec3<f32>(0.95, 0.97, 1.0) + sheen;
  return vec4<f32>(colour, 1.0);
}
