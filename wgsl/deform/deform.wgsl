// Deform: computes the positions of deforming instances for a frame: morph targets, skin, the caller's displacement, from
// mesh space to world space. Dispatched when the caller records a `Deformer` or a scene with models, before all stages that
// read positions. A workgroup has up to 256 vertices of one instance, an invocation each. It reads `rest`, `morph`, `skin`,
// `source_vertices` and the pose. It writes `positions`, three floats a vertex, for all later stages and the caller's draws.
// All vertices of an instance that `needs` culled become (0, 0, 0), so that nothing of it is drawn. Sums have the order of
// src/cpu/deform; rounding may differ between devices. Later stages read the positions as written, so silhouettes always
// close. docs/numerics/deform.md, "Deform".

#if DISPLACED
#else
#import deform/displace
#endif

// A dispatch of the deform stage.
struct DeformDispatch {
  // The word in `pose` from which on each workgroup of the dispatch has a word: that at which its chunk begins.
  workgroups: u32,
  // 0: do not call `displace`.
  displaced: u32,
  // The time for `displace`, in seconds.
  time: f32,
  // The number of instances of the model.
  instances: u32,
}

// A range of vertices of one instance, for whole workgroups. Words count from where the dispatch binds the arrays.
struct DeformChunk {
  // The index of its first workgroup in the dispatch.
  first_workgroup: u32,
  // The number of its vertices.
  count: u32,
  // The words at which it begins in `rest`, `morph`, `skin`, `source_vertices` and `positions`.
  rest: u32,
  morph: u32,
  skin: u32,
  sources: u32,
  positions: u32,
  // The word in `pose` where the matrices begin (12 words each, three rows of four). The word where the active morph targets,
  // those with a weight other than 0, begin (two words each, index and weight), and their number.
  palette: u32,
  targets: u32,
  target_count: u32,
  // 0: all vertices follow the first matrix of the palette.
  skinned: u32,
  // The word in `pose` that is 1 if the positions of the instance are all (0, 0, 0), because it was culled before. The word
  // `dispatch.instances` words later is 1 if it is culled now.
  before: u32,
}

@group(0) @binding(0) var<uniform> dispatch: DeformDispatch;
@group(0) @binding(1) var<storage, read> rest: array<f32>;
// For each chunk and each morph target, active or not, the displacements of the vertices, three words each. Instances of one
// geometry share `rest`, `morph`, `skin` and `source_vertices`.
@group(0) @binding(2) var<storage, read> morph: array<f32>;
// For each chunk with skin first the index of each vertex's first influence, and the number of all; then joint and weight of
// each influence.
@group(0) @binding(3) var<storage, read> skin: array<u32>;
// In this order: chunks; a word for each instance, 1 if its positions are all (0, 0, 0); another, 1 if it is culled; for each
// instance matrices and active morph targets; for each workgroup the word at which its chunk begins. Each encode uploads all
// but the last, with 0 for the words of instances. Then copies on the GPU write the first of these, and in scenes the other.
@group(0) @binding(4) var<storage, read> pose: array<u32>;
// For each vertex the index of its source vertex, before welding, for `displace`.
@group(0) @binding(5) var<storage, read> source_vertices: array<u32>;
@group(0) @binding(6) var<storage, read_write> positions: array<f32>;

// The chunk of this workgroup.
var<private> chunk: DeformChunk;

// Loads the chunk that begins at a word of the pose.
fn load_chunk(word: u32) {
  chunk = DeformChunk(
    pose[word], pose[word + 1u], pose[word + 2u], pose[word + 3u], pose[word + 4u], pose[word + 5u], pose[word + 6u],
    pose[word + 7u], pose[word + 8u], pose[word + 9u], pose[word + 10u], pose[word + 11u]);
}

// The row of a matrix that begins at a word of the pose.
fn pose_row(word: u32) -> vec4<f32> {
  return bitcast<vec4<f32>>(vec4<u32>(pose[word], pose[word + 1u], pose[word + 2u], pose[word + 3u]));
}

// A coordinate of a transformed position.
fn transform_row(row: vec4<f32>, p: vec3<f32>) -> f32 {
  return row.x * p.x + row.y * p.y + row.z * p.z + row.w;
}

// A position transformed by a matrix of the instance's palette.
fn transform(joint: u32, p: vec3<f32>) -> vec3<f32> {
  let word = chunk.palette + 12u * joint;
  return vec3<f32>(
    transform_row(pose_row(word), p),
    transform_row(pose_row(word + 4u), p),
    transform_row(pose_row(word + 8u), p),
  );
}

@compute @workgroup_size(256)
fn deform(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
  load_chunk(pose[dispatch.workgroups + workgroup.x]);
  let vertex = 256u * (workgroup.x - chunk.first_workgroup) + lane;
  if (vertex >= chunk.count) {
    return;
  }
  let word = chunk.positions + 3u * vertex;
  if (pose[chunk.before + dispatch.instances] == 1u) {
    // If the instance was culled before, its positions are (0, 0, 0) already.
    if (pose[chunk.before] != 1u) {
      positions[word] = 0.0;
      positions[word + 1u] = 0.0;
      positions[word + 2u] = 0.0;
    }
    return;
  }
  let rest_offset = chunk.rest + 3u * vertex;
  var p = vec3<f32>(rest[rest_offset], rest[rest_offset + 1u], rest[rest_offset + 2u]);
  // Turns: DEFORM_TERMS in all.
  for (var active_target = 0u; active_target < chunk.target_count; active_target++) {
    let word = chunk.morph + 3u * (pose[chunk.targets + 2u * active_target] * chunk.count + vertex);
    let weight = bitcast<f32>(pose[chunk.targets + 2u * active_target + 1u]);
    p += weight * vec3<f32>(morph[word], morph[word + 1u], morph[word + 2u]);
  }
  if (chunk.skinned == 0u) {
    p = transform(0u, p);
  } else {
    let morphed = p;
    p = vec3<f32>(0.0);
    let first = skin[chunk.skin + vertex];
    let end = skin[chunk.skin + vertex + 1u];
    // DEFORM_TERMS (src/turns.rs) bounds the turns of both loops together, so this loop adds none to those stated above.
    // Turns: 0.
    for (var index = first; index < end; index++) {
      let influence = chunk.skin + chunk.count + 1u + 2u * index;
      p += bitcast<f32>(skin[influence + 1u]) * transform(skin[influence], morphed);
    }
  }
  if (dispatch.displaced != 0u) {
    p = displace(p, source_vertices[chunk.sources + vertex], dispatch.time);
  }
  positions[word] = p.x;
  positions[word + 1u] = p.y;
  positions[word + 2u] = p.z;
}
