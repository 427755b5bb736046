// The normal of each group of corners: the sum over its faces by area, at the positions of now.

@group(0) @binding(0) var<storage, read> positions: array<f32>;
@group(0) @binding(1) var<storage, read> faces: array<u32>;
// Where the faces and the corners of each group begin, and at last where they end.
@group(0) @binding(2) var<storage, read> starts: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> members: array<u32>;
@group(0) @binding(4) var<storage, read> corners: array<u32>;
// One a corner, folded onto an octahedron.
@group(0) @binding(5) var<storage, read_write> normals: array<u32>;

fn position(vertex: u32) -> vec3<f32> {
  return vec3<f32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

// The inverse of `unfold`.
fn fold(n: vec3<f32>) -> u32 {
  let flat = n / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-37);
  let over = (1.0 - abs(flat.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), flat.xy >= vec2<f32>(0.0));
  return pack2x16snorm(select(flat.xy, over, flat.z < 0.0));
}

@compute @workgroup_size(64) fn normals_of_groups(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(num_workgroups) workgroups: vec3<u32>,
) {
  let group = id.x + id.y * 64u * workgroups.x;
  if (group + 1u >= arrayLength(&starts)) {
    return;
  }
  let first = starts[group];
  let end = starts[group + 1u];
  var sum = vec3<f32>(0.0);
  for (var i = first.x; i < end.x; i++) {
    let face = 3u * members[i];
    let a = position(faces[face]);
    sum += cross(position(faces[face + 1u]) - a, position(faces[face + 2u]) - a);
  }
  let normal = fold(sum);
  for (var i = first.y; i < end.y; i++) {
    normals[corners[i]] = normal;
  }
}
