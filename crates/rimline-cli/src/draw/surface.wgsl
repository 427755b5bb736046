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

fn resources(right: f32, up: f32, back: f32) -> vec3<f32> {
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

  let key_from = resources(-0.52, 0.68, 0.72);
  let key = saturate((dot(n, key_from) + 0.2) / 1.2);
  let fill = saturate((dot(n, resources(0.95, 0.1, 0.5)) + 0.35) / 1.35);
  let sky = 0.5 + 0.5 * n.y;
  let rim = pow(1.0 - saturate(dot(n, to_eye)), 3.0) * saturate(dot(n, resources(0.8, 0.5, -0.5)) + 0.15);

  // Fired clay; the inside of an open surface is glazed grey.
  let clay = select(vec3<f32>(0.62, 0.44, 0.33), vec3<f32>(0.36, 0.49, 0.56), front);
  var light = mix(vec3<f32>(0.24, 0.22, 0.22), vec3<f32>(0.36, 0.38, 0.41), sky);
  light += 0.84 * pow(key, 1.3) * vec3<f32>(1.0, 0.94, 0.86);
  light += 0.22 * fill * vec3<f32>(0.90, 0.94, 1.0);
  let halfway = normalize(to_eye + key_from);
  let sheen = 0.045 * pow(saturate(dot(n, halfway)), 20.0);
  let colour = clay * light + 0.18 * rim * vec3<f32>(0.95, 0.95, 1.0) + sheen;
  return vec4<f32>(colour, 1.0);
}
