// Chunks: a compute stage of a scene that lists in `work`, for a batch of up to 32 lights, the chunks of edges that `edges` goes
// over, in no particular order: those of casters with a light whose list is made anew, but for chunks that clusters tell to have
// no silhouette. A chunk is 64 slots, indices in the masks, all of one caster; a cluster is 128 faces with a bound. Dispatched
// after `clusters` for each group of casters and batch; invocations share the chunks. It also empties lists and statistics for
// `facing` and the stages after it, and notes in `kept` the versions that the bits are computed from: it is the last of the
// stages that read those of before. A chunk that may have a silhouette must be listed. docs/numerics/clusters.md, and
// docs/numerics/scene.md, "Cached results".

#import common/casters
#import common/extraction
#import scene/table

@group(0) @binding(3) var<storage, read> lit: array<u32>;
// For each group and batch four words, then the chunks, where SceneDispatch says.
@group(0) @binding(4) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> kept: array<u32>;
@group(0) @binding(6) var<storage, read_write> statistics: SceneStatistics;
// For each light of the batch the number of its silhouette edges. Behind those: whether a light was in the plane of a face
// whose bits are kept.
@group(0) @binding(7) var<storage, read_write> list_counts: array<u32, 64>;
@group(0) @binding(8) var<storage, read_write> record: FacingRecord;
// When a chunk has no silhouette: if all its clusters are decided (its edges lie within clusters), or if all are decided the same
// way. With any other rule it may have one.
const SKIPPED_DECIDED: u32 = 1u;
const SKIPPED_ALIKE: u32 = 2u;

// Makes the lists and the record ready, for a light of the batch.
fn prepare(light: u32) {
  if (((atomicLoad(&work[group.work_count + 2u]) >> light) & 1u) != 0u) {
    list_counts[light] = 0u;
    kept[group.lists_at + light] = encode_number();
  }
  kept[kept_lights_at(group.batch) + light] = light_version(group.batch, light);
  if (light == 0u) {
    kept[0] = group.structure;
    let zeros = list_counts[KEPT_ZEROS] | atomicLoad(&record.statistics.exact_zeros);
    list_counts[KEPT_ZEROS] = select(0u, zeros, atomicLoad(&work[group.work_count + 3u]) != 0u);
    atomicStore(&record.statistics.non_finite_faces, 0u);
    atomicStore(&record.statistics.overflowed_lists, 0u);
    atomicStore(&record.statistics.undecided_pairs, 0u);
    atomicStore(&record.statistics.exact_zeros, 0u);
    atomicStore(&record.undecided_count, 0u);
  }
}

// Whether the clusters tell that no edge of a chunk is a silhouette for any of the lights in `wanted`.
fn is_spared(caster: u32, chunk: u32, wanted: u32) -> bool {
  let faces = caster_part(caster, 5u);
  let edges = caster_part(caster, 6u);
  let clusters = caster_part(caster, 7u).w;
  // Behind the bounds of all clusters.
  let at = clusters + BOUND_WORDS * ((faces.y + CLUSTER_FACES - 1u) / CLUSTER_FACES) + chunk - edges.x / CHUNK;
  let begin = cluster_words[at];
  let rule = begin >> PLACE_BITS;
  if (rule != SKIPPED_DECIDED && rule != SKIPPED_ALIKE) {
    return false;
  }
  let places = (1u << PLACE_BITS) - 1u;
  let end = clusters + (cluster_words[at + 1u] & places);
  var facing = 0u;
  var averted = 0u;
  // Turns: 2 * CHUNK.
  for (var name = clusters + (begin & places); name < end; name++) {
    let cluster = kept_cluster_at(faces.x / CHUNK + CLUSTER_CHUNKS * cluster_words[name]);
    if ((wanted & ~kept[cluster]) != 0u) {
      return false;
    }
    facing |= kept[cluster + 1u];
    averted |= ~kept[cluster + 1u];
  }
  return rule == SKIPPED_DECIDED || (wanted & facing & averted) == 0u;
}

// Lists a chunk of edges, if it may have a silhouette in a list that is made anew.
fn take_edges(chunk: u32) {
  let caster = caster_of(group.edge_chunks_at, chunk);
  let wanted = lit[group.batch * group.casters + caster] & atomicLoad(&work[group.work_count + 2u]);
  if (wanted == 0u) {
    return;
  }
  let edges = caster_part(caster, 6u);
  let count = min(CHUNK, edges.x + edges.y - CHUNK * chunk);
  if (has_clusters(caster) && is_spared(caster, chunk, wanted)) {
    atomicAdd(&statistics.spared_edges, count);
    return;
  }
  atomicStore(&work[group.edge_work + atomicAdd(&work[group.work_count + 1u], 1u)], chunk);
  atomicAdd(&statistics.edges, count);
}

@compute @workgroup_size(256)
fn chunks(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  if (id.x < 32u) {
    prepare(id.x);
  }
  let is_still = atomicLoad(&work[group.work_count + 2u]) == 0u;
  // Turns: SCENE_ITEMS.
  for (var chunk = id.x; chunk < select(group.edge_chunks, 0u, is_still); chunk += 256u * groups.x) {
    take_edges(chunk);
  }
}
