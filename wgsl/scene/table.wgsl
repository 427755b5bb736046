// The scene table, which each encode of a scene uploads (src/gpu/scene/table.rs) but for the casters of chunks, written once,
// and what is kept from one frame to the next: where things are, for the stages `reach`, `clusters`, `chunks`, `facing`,
// `exact_facing` and `edges`. (Stages of shadow volumes read the table by shadow/caster.wgsl.) The table has the casters, then
// for each batch (up to 32 lights) and caster its lights, then the ranges of the lights and their versions, four words, the
// cones of the lights, the lights themselves, for each rigid caster in its space, then occluders with the scaled lights in
// world space and the corners, if there are any, and the casters of all chunks (64 slots of faces or edges of one caster).
// Choices of shadow volumes are copied behind them. The first of the four words is the number of the encode. The second is the
// word of the work lists from which on there is a word for each figure (a caster that may be deformed), 1 if it is not needed, 2 if it is;
// it is 0 where all are needed. The third is the largest coordinate of the origins of cameras, for `reach`. A page has the
// topology and clusters of several meshes. The layout is that of the Rust; bits are kept only as long as all versions beside
// them are right.

#import common/casters

// The lights of a caster in a batch.
struct CasterLights {
  // The bits of the lights that the caster's mask of lights allows, but for those that cannot be moved to its space.
  allowed: u32,
  first: u32, // Where its lights begin in the table: for each the bits as given, and scaled as in LightBatch.
  reach: vec2<f32>, // The largest |x|, |y| or |z| of the scaled lights, and their largest |w| or inexact w.
}

// Statistics of an encode of a scene.
struct SceneStatistics {
  // Pairs of caster and light that matter, and those of them whose bits were kept.
  pairs: atomic<u32>,
  kept_pairs: atomic<u32>,
  // Pairs of caster and allowed light that range or cone keep apart. Casters that the frame does not need have none.
  unreached_pairs: atomic<u32>,
  // Pairs of caster and light that do not matter, because an occluder hides the caster from the light.
  occluded_pairs: atomic<u32>,
  // Faces that were tested, for each batch, and edge records.
  faces: atomic<u32>,
  edges: atomic<u32>,
  // Faces and edge records that clusters spared.
  spared_faces: atomic<u32>,
  spared_edges: atomic<u32>,
  unneeded: atomic<u32>, // Casters that the frame does not need.
}

// A dispatch over a group of casters for a batch of lights.
struct SceneDispatch {
  // Casters and batches of the scene.
  casters: u32,
  batches: u32,
  batch: u32,
  // The word of what is kept where the group and batch have 32 words: for each light the encode that made its list.
  lists_at: u32,
  // Where these begin in the table, in vec4s: lights of casters, ranges, casters of the group's face chunks and edge chunks.
  lights_at: u32,
  ranges_at: u32,
  face_chunks_at: u32,
  edge_chunks_at: u32,
  // Chunks of the group.
  face_chunks: u32,
  edge_chunks: u32,
  // The words of the work lists where the group and batch have four words, the face chunks and the edge chunks. The words are
  // the number of face chunks, that of edge chunks, the lights whose lists are made anew, and those of which bits are kept.
  work_count: u32,
  face_work: u32,
  edge_work: u32,
  capacity: u32, // Entries that the list of each light has room for.
  // The number of this layout, which tells what was computed for another, and whether bits are kept at all.
  structure: u32,
  keeps: u32, // 1: bits of an earlier encode are kept.
  clusters_at: u32, // The word of what is kept where the clusters of the group and batch begin.
  // Where occluders begin in the table, for each batch and occluder, and their number. Then where the scaled lights are.
  occluders_at: u32,
  occluders: u32,
  world_lights_at: u32,
}

@group(0) @binding(0) var<uniform> group: SceneDispatch;
@group(0) @binding(1) var<storage, read> table: array<vec4<u32>>;

// Part `part` of a caster, four words, in the order of SceneCaster.
fn caster_part(caster: u32, part: u32) -> vec4<u32> { return table[8u * caster + part]; }

// Words of a listed chunk of faces: the chunk, the lights that are decided for all of its faces, those of them that the
// faces face, and the places of the lights that are tested.
const FACE_ENTRY: u32 = 4u;

fn encode_number() -> u32 { return table[group.ranges_at + 16u * group.batches].x; }

fn light_cone(batch: u32, light: u32) -> LightCone {
  let at = group.ranges_at + 16u * group.batches + 1u + 2u * (32u * batch + light);
  return LightCone(bitcast<vec4<f32>>(table[at]), bitcast<vec4<f32>>(table[at + 1u]));
}

fn light_version(batch: u32, light: u32) -> u32 {
  return table[group.ranges_at + 8u * (group.batches + batch) + light / 4u][light % 4u];
}

// Words beside the bits that are kept tell what these were computed from. Word 0: the number of the layout. From word 4 on,
// for each batch the versions of its lights. For each batch and caster follow the caster's version and the lights whose bits
// are right for these versions. Then for all groups and batches the encodes that made the lists of their lights; then, again
// for all, two words for each chunk of faces.
fn kept_lights_at(batch: u32) -> u32 { return 4u + 32u * batch; }
fn kept_pair_at(pair: u32) -> u32 { return 4u + 32u * group.batches + 2u * pair; }

fn caster_lights(caster: u32, batch: u32) -> CasterLights {
  let words = table[group.lights_at + batch * group.casters + caster];
  return CasterLights(words.x, words.y, bitcast<vec2<f32>>(words.zw));
}

// The caster of a chunk. `chunks_at` is where the casters of the group's chunks begin.
fn caster_of(chunks_at: u32, chunk: u32) -> u32 { return table[chunks_at + chunk / 4u][chunk % 4u]; }

// The clusters of a page, runs of 128 faces of a mesh. For each mesh that has clusters: a bound for each cluster, where each
// chunk of edges begins to name the clusters of its faces, and these names. Words count from the first of the mesh.
@group(0) @binding(9) var<storage, read> cluster_words: array<u32>;
const NO_CLUSTERS: u32 = 0xffffffffu; // A caster whose mesh has no clusters.
// Faces of a cluster, which are two chunks.
const CLUSTER_FACES: u32 = 128u;
const CLUSTER_CHUNKS: u32 = 2u;
const BOUND_WORDS: u32 = 12u; // Words of a bound.
// Low bits of a chunk's word, which tell where its names begin. The other two tell when the chunk has no silhouette
// (`chunks`).
const PLACE_BITS: u32 = 30u;

// Whether the clusters of a caster decide anything: bounds hold for the positions of the mesh.
fn has_clusters(caster: u32) -> bool {
  return caster_part(caster, 7u).w != NO_CLUSTERS && (caster_part(caster, 4u).w & RIGID) != 0u;
}

// The word of what is kept where a chunk of faces has two; only those of the first chunk of a cluster are used: lights for which
// all faces of the cluster have the same bit, and those of them that they face. They tell what is in the masks.
fn kept_cluster_at(chunk: u32) -> u32 { return group.clusters_at + 2u * chunk; }
