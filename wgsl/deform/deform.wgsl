// Deform: computes morph targets, skin and displacement for the vertices of one instance, from mesh space to world
// space.

@group(0) @binding(0) var<uniform> chunk: DeformChunk;
@group(0) @binding(1) var<storage, read> rest: array<f32>;
// Three words for each vertex of this chunk, target by target.
@group(0) @binding(2) var<storage, read> morph: array<f32>;
// First the offset of each vertex's influences, and one more; then joint and weight of each influence.
@group(0) @binding(3) var<storage, read> skin: array<u32>;
@group(0) @binding(4) var<storage, read> pose: array<u32>;
@group(0) @binding(5) var<storage, read> source_vertices: array<u32>;
@group(0) @binding(6) var<storage, read_write> positions: array<f32>;

fn pose_row(word: u32) -> vec4<f32> {
  return bitcast<vec4<f32>>(vec4<u32>(pose[word], pose[word + 1u], pose[word + 2u], pose[word + 3u]));
}

fn transform_row(row: vec4<f32>, p: vec3<f32>) -> f32 {
  return row.x * p.x + row.y * p.y + row.z * p.z + row.w;
}

fn transform(joint: u32, p: vec3<f32>) -> vec3<f32> {
  let word = chunk.palette + 12u * joint;
  return vec3<f32>(
    transform_row(pose_row(word), p),
    transform_row(pose_row(word + 4u), p),
    transform_row(pose_row(word + 8u), p),
  );
}

@compute @workgroup_size(256)
fn deform(@builtin(global_invocation_id) id: vec3<u32>) {
  let vertex = id.x;
  if (vertex >= chunk.count) {
    return;
  }
  var p = vec3<f32>(rest[3u * vertex], rest[3u * vertex + 1u], rest[3u * vertex + 2u]);
  for (var active_target = 0u; active_target < chunk.target_count; active_target++) {
    let word = 3u * (pose[chunk.targets + 2u * active_target] * chunk.count + vertex);
    let weight = bitcast<f32>(pose[chunk.targets + 2u * active_target + 1u]);
    p += weight * vec3<f32>(morph[word], morph[word + 1u], morph[word + 2u]);
  }
  if (chunk.skinned == 0u) {
    p = transform(0u, p);
  } else {
    let morphed = p;
    p = vec3<f32>(0.0);
    for (var at = skin[vertex]; at < skin[vertex + 1u]; at++) {
      let influence = chunk.count + 1u + 2u * at;
      p += bitcast<f32>(skin[influence + 1u]) * transform(skin[influence], morphed);
    }
  }
  if (chunk.displaced != 0u) {
    p = displace(p, source_vertices[vertex], chunk.time);
  }
  positions[chunk.first_word + 3u * vertex] = p.x;
  positions[chunk.first_word + 3u * vertex + 1u] = p.y;
  positions[chunk.first_word + 3u * vertex + 2u] = p.z;
}
