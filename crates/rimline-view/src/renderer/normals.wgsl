// The normal of each group of corners: the sum over its faces by area, at the positions of now.

@group(0) @binding(0) var<storage, read> positions: array<f32>;
@group(0) @binding(1) var<storage, read> faces: array<u32>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> members: array<u32>;
@group(0) @binding(4) var<storage, read_write> normals: array<f32>;

fn position(vertex: u32) -> vec3<f32> {
  return vec3<f32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

@compute @workgroup_size(64) fn normals_of_groups(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(num_workgroups) workgroups: vec3<u32>,
) {
  let group = id.x + id.y * 64u * workgroups.x;
  if (group + 1u >= arrayLength(&starts)) {
    return;
  }
  var sum = vec3<f32>(0.0);
  let end = starts[group + 1u];
  for (var i = starts[group]; i < end; i++) {
    let face = 3u * members[i];
    let a = position(faces[face]);
    sum += cross(position(faces[face + 1u]) - a, position(faces[face + 2u]) - a);
  }
  let size = length(sum);
  let n = select(vec3<f32>(0.0), sum / size, size > 0.0);
  normals[3u * group] = n.x;
  normals[3u * group + 1u] = n.y;
  normals[3u * group + 2u] = n.z;
}
