// The scene table and the cached results, for `cull_lights`, `clusters`, `chunks`, `facing`, `exact_facing` and
// `edges`. Each encode uploads the table (src/gpu/scene/table.rs). Stages of shadow volumes read it by
// shadow/caster.wgsl. It has, in this order: casters; for each batch (up to 32 lights) and caster its lights; the
// ranges of the lights; their versions; four words; the cones of the lights; the lights, for each rigid caster in its
// mesh space; occluders, with scaled lights in world space and corners, if there are any; the caster of each chunk,
// written once; choices of shadow volumes, copied. The four words: the number of the encode; the word of the work lists
// where a word for each deforming caster begins (1: culled, 2: needed), or 0 if there is none; the largest coordinate
// of the origins of cameras; one unused. Cached results are valid while the versions beside them are. src/layout.rs has
// the same structs.

#import common/casters

// The lights of a caster in a batch.
struct CasterLights {
  // The bits of the lights that the caster's light mask allows, without those that cannot be moved to its space.
  allowed: u32,
  first: u32, // The offset of its lights in the table: for each the bits as given, then scaled as in LightBatch.
  magnitudes: vec2<f32>, // The largest |x|, |y| or |z| of the scaled lights, and their largest |w| or inexact w.
}

// Statistics of an encode of a scene.
struct SceneStatistics {
  // Relevant pairs of caster and light, and those of them whose bits were cached.
  pairs: atomic<u32>,
  cached_pairs: atomic<u32>,
  // Pairs of caster and allowed light that are culled by range or cone. Casters that the frame does not need have none.
  pairs_culled_by_range: atomic<u32>,
  // Pairs of caster and light that are culled by an occluder between them.
  pairs_culled_by_occluders: atomic<u32>,
  // Tested faces, for each batch, and tested edge records.
  faces: atomic<u32>,
  edges: atomic<u32>,
  // Faces and edge records that were not tested, because clusters decided them.
  untested_faces: atomic<u32>,
  untested_edges: atomic<u32>,
  culled_casters: atomic<u32>, // Casters that the frame does not need.
}

// A dispatch over a group of casters for a batch of lights.
struct SceneDispatch {
  // Casters and batches of the scene.
  casters: u32,
  batches: u32,
  batch: u32,
  // The word of `cache` where 32 words of the group and batch begin: for each light the encode that made its list.
  lists_offset: u32,
  // Offsets in the table, in vec4s: lights of casters, ranges, casters of the group's face chunks and of its edge chunks.
  lights_offset: u32,
  ranges_offset: u32,
  face_chunks_offset: u32,
  edge_chunks_offset: u32,
  // Chunks of the group.
  face_chunks: u32,
  edge_chunks: u32,
  // Words of the work lists. `work_count`: the first of four words of the group and batch. These are the number of listed
  // face chunks, that of edge chunks, the lights with a dirty list, and the lights with cached bits, all 0 before
  // `cull_lights`. `face_work`, `edge_work`: the first listed chunk.
  work_count: u32,
  face_work: u32,
  edge_work: u32,
  capacity: u32, // Entries that the list of each light has room for.
  // The number of this layout of the scene. Results cached for another one are invalid.
  structure: u32,
  uses_cache: u32, // 1: bits of an earlier encode are valid if their versions are.
  clusters_offset: u32, // The word of `cache` where the clusters of the group and batch begin.
  // The offset in the table of the occluders, for each batch and occluder, and their number. Then that of the scaled lights.
  occluders_offset: u32,
  occluders: u32,
  world_lights_offset: u32,
}

@group(0) @binding(0) var<uniform> group: SceneDispatch;
@group(0) @binding(1) var<storage, read> table: array<vec4<u32>>;

// Part `part` of a caster, four words of SceneCaster. 0 to 2: rows of the matrix; 3: low, scale; 4: high, flags; 5: face
// slots, faces, position offset; 6: edge slots, edges, position stride; 7: version, group, first caster, clusters.
fn caster_part(caster: u32, part: u32) -> vec4<u32> { return table[8u * caster + part]; }

// Words of a listed chunk of faces: the chunk; the lights that are decided for all its faces; those of them that the faces
// face; the index mask of the lights to test, all bits if none is decided.
const FACE_ENTRY: u32 = 4u;

fn encode_number() -> u32 { return table[group.ranges_offset + 16u * group.batches].x; }

fn light_cone(batch: u32, light: u32) -> LightCone {
  let offset = group.ranges_offset + 16u * group.batches + 1u + 2u * (32u * batch + light);
  return LightCone(bitcast<vec4<f32>>(table[offset]), bitcast<vec4<f32>>(table[offset + 1u]));
}

fn light_version(batch: u32, light: u32) -> u32 {
  return table[group.ranges_offset + 8u * (group.batches + batch) + light / 4u][light % 4u];
}

// Words of `cache`, the cached results and the versions that they were computed from. Word 0: the number of the layout. From
// word 4 on: for each batch the versions of its lights. Then for each batch and caster: the caster's version, and the lights
// whose bits are valid for these versions. Then for all groups and batches: the encodes that made the lists of their lights.
// Then, again for all, two words for each chunk of faces.
fn cached_light_offset(batch: u32) -> u32 { return 4u + 32u * batch; }
fn cached_pair_offset(pair: u32) -> u32 { return 4u + 32u * group.batches + 2u * pair; }

fn caster_lights(caster: u32, batch: u32) -> CasterLights {
  let words = table[group.lights_offset + batch * group.casters + caster];
  return CasterLights(words.x, words.y, bitcast<vec2<f32>>(words.zw));
}

// The caster of a chunk. `chunks_offset` is where the casters of the group's chunks begin in the table.
fn caster_of(chunks_offset: u32, chunk: u32) -> u32 { return table[chunks_offset + chunk / 4u][chunk % 4u]; }

// The clusters of a page, each of up to 128 faces of a mesh. For each mesh with clusters: a bound for each cluster; for each
// chunk of edges, and for their end, an offset; and from that offset the indices of the clusters that its faces are in.
// Offsets count from the first word of the mesh.
@group(0) @binding(9) var<storage, read> cluster_words: array<u32>;
const NO_CLUSTERS: u32 = 0xffffffffu; // A caster whose mesh has no clusters.
// A cluster has two chunks of faces.
const CLUSTER_FACES: u32 = 128u;
const CLUSTER_CHUNKS: u32 = 2u;
const BOUND_WORDS: u32 = 12u; // Words of a bound.
// Low bits of a chunk's word, which are its offset. The two high bits are a rule: when the chunk has no silhouette
// (`chunks`).
const OFFSET_BITS: u32 = 30u;

// Whether clusters decide anything for a caster. Bounds hold only for the positions of the mesh.
fn has_clusters(caster: u32) -> bool {
  return caster_part(caster, 7u).w != NO_CLUSTERS && (caster_part(caster, 4u).w & RIGID) != 0u;
}

// The first of two words of `cache` for a chunk of faces. Only the first chunk of a cluster uses them. They describe the
// masks: the lights for which all faces of the cluster have the same bit and none is excluded, but by the caller; those of
// them that the faces face.
fn cached_cluster_offset(chunk: u32) -> u32 { return group.clusters_offset + 2u * chunk; }
