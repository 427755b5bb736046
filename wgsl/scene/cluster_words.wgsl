// The clusters of a page. For each mesh that has clusters: a bound for each cluster, where each chunk of edges begins to name
// the clusters of its faces, and these names. Words count from the first of the mesh.

@group(0) @binding(9) var<storage, read> cluster_words: array<u32>;

// A caster whose mesh has no clusters.
const NO_CLUSTERS: u32 = 0xffffffffu;
// Faces of a cluster, which are two chunks.
const CLUSTER_FACES: u32 = 128u;
const CLUSTER_CHUNKS: u32 = 2u;
// Words of a bound.
const BOUND_WORDS: u32 = 12u;
// Bits of the place where the names of a chunk begin. The others tell when the chunk has no silhouette.
const PLACE_BITS: u32 = 30u;

// Whether the clusters of a caster decide anything: bounds hold for the positions of the mesh.
fn has_clusters(caster: u32) -> bool {
  return caster_part(caster, 7u).w != NO_CLUSTERS && (caster_part(caster, 4u).w & RIGID) != 0u;
}

// The word of what is kept where a chunk of faces has two: lights for which all faces of its cluster have the same bit, and
// those of them that they face. They tell what is in the masks.
fn kept_cluster_at(chunk: u32) -> u32 {
  return group.clusters_at + 2u * chunk;
}
