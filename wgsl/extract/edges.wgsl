// Edges: computes the silhouette and winding mask of each edge record from the facing masks of its faces. It writes the
// masks, appends silhouette edges to the lists of the lights in no particular order, or does both.

@group(0) @binding(0) var<uniform> batch: LightBatch;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> facing_0: array<u32>;
@group(0) @binding(3) var<storage, read> facing_1: array<u32>;
@group(0) @binding(4) var<storage, read> facing_2: array<u32>;
@group(0) @binding(5) var<storage, read> facing_3: array<u32>;
@group(0) @binding(6) var<storage, read> edge_faces: array<vec2<u32>>;

// The number of faces in each binding except the last. 0: all are in the first.
override WINDOW_WORDS: u32 = 0u;

fn facing_mask(face: u32) -> u32 {
  if (WINDOW_WORDS == 0u) {
    return facing_0[face];
  }
  let at = face % max(WINDOW_WORDS, 1u);
  switch (face / max(WINDOW_WORDS, 1u)) {
    case 0u: { return facing_0[at]; }
    case 1u: { return facing_1[at]; }
    case 2u: { return facing_2[at]; }
    default: { return facing_3[at]; }
  }
}

@compute @workgroup_size(256)
fn edges(@builtin(global_invocation_id) id: vec3<u32>) {
  let edge = id.x;
  if (edge >= chunk.count) {
    return;
  }
  let faces = edge_faces[edge];
  let winding = facing_mask(faces.x & ~INCONSISTENT);
  var silhouette = batch.live;
  if (faces.y != NO_FACE) {
    silhouette = winding ^ facing_mask(faces.y);
    if ((faces.x & INCONSISTENT) != 0u) {
      silhouette = ~silhouette & batch.live;
    }
  }
  emit(edge, silhouette, winding);
}
