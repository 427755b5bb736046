// Work lists of a scene's extraction: two compute stages, dispatched for each group of casters and batch of up to 32 lights,
// whose invocations each take chunks in turn. A chunk is 64 slots (indices in the masks), all of one caster. `clusters`,
// after `reach`, lists chunks of faces for `facing`; `chunks`, after it, lists chunks of edges for `edges`. A cluster is 128
// faces of a mesh with a bound on their planes. Lists are in `work`, in no particular order. docs/numerics/clusters.md, and
// docs/numerics/scene.md, "Cached results".

#import common/casters
#import common/extraction
#import scene/many_casters
#import scene/table

// Stage `clusters`: decides whether all faces of a cluster face a light, or none does. It takes the lights in `taken`, which
// `reach` chose (many_casters.wgsl; `active_mask`, for the caster at hand), and lists the chunks with a bit that is to be
// tested or changed, with what is decided already; and it notes in `kept` what the masks will hold, for `chunks` and the
// next encode. It decides only what exact facing would decide the same way, so bounds must not shrink.

// For each group and batch four words, then the chunks, where SceneDispatch says.
@group(0) @binding(4) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> kept: array<u32>;
@group(0) @binding(7) var<storage, read_write> statistics: SceneStatistics;
// Kinds of bounds, the fourth word of one. Kind 1 decides that all faces face a light, or that none does.
const MIXED: u32 = 0u; // It decides nothing.
const AT_MOST_AVERTED: u32 = 2u; // It decides only that none does: some faces name a vertex twice.
const AVERTED: u32 = 3u; // No face ever faces a light.
// 2.5 units in the last place: the most that the rounding of w centre adds, relative to its size.
const PRODUCT: f32 = 2.5 * 0x1p-23;
const LEAST: f32 = 0x1p-118; // The most that underflow adds.

// Lights that are decided for a whole cluster, and those of them that its faces face.
struct Decision {
  decided: u32,
  facing: u32,
}

fn four_words(at: u32) -> vec4<u32> {
  return vec4<u32>(cluster_words[at], cluster_words[at + 1u], cluster_words[at + 2u], cluster_words[at + 3u]);
}

// Decides the lights that are taken for the caster at hand by the bound at word `at` of `cluster_words`: the centre and the
// kind; the middle of the planes of all faces, each as its scaled normal and the height of the centre over it; half their
// spread.
fn decide(at: u32) -> Decision {
  let first = four_words(at);
  let kind = first.w;
  if (kind == MIXED) {
    return Decision(0u, 0u);
  }
  if (kind == AVERTED) {
    return Decision(active_mask, 0u);
  }
  let centre = bitcast<vec3<f32>>(first.xyz);
  let middle = bitcast<vec4<f32>>(four_words(at + 4u));
  let half = bitcast<vec4<f32>>(four_words(at + 8u));
  let size = abs(centre.x) + abs(centre.y) + abs(centre.z);
  var decision = Decision(0u, 0u);
  var place = 0u;
  for (var rest = lights.allowed; rest != 0u; rest &= rest - 1u) {
    let bit = (rest & (~rest + 1u)) & active_mask;
    if (bit != 0u) {
      let light = scaled_light(place);
      let inexact = inexact_w(place);
      let t = light.xyz - light.w * centre;
      let height = middle.x * t.x + middle.y * t.y + middle.z * t.z + middle.w * light.w;
      let sizes = abs(t);
      let spread = half.x * sizes.x + half.y * sizes.y + half.z * sizes.z + half.w * max(abs(light.w), inexact) +
        PRODUCT * inexact * size + LEAST;
      let is_facing = height > spread && kind != AT_MOST_AVERTED;
      decision.decided |= select(0u, bit, is_facing || height < -spread);
      decision.facing |= select(0u, bit, is_facing);
    }
    place++;
  }
  return decision;
}

// Lists a chunk of the caster at hand for `facing`, with what is decided for all its faces.
fn list_faces(chunk: u32, decision: Decision) {
  let at = group.face_work + FACE_ENTRY * atomicAdd(&work[group.work_count], 1u);
  atomicStore(&work[at], chunk);
  atomicStore(&work[at + 1u], decision.decided);
  atomicStore(&work[at + 2u], decision.facing);
  atomicStore(&work[at + 3u], select(indices_of_lights(active_mask & ~decision.decided), 0xffffffffu, decision.decided == 0u));
  if ((active_mask & ~decision.decided) != 0u) {
    atomicAdd(&statistics.faces, faces_in(chunk));
  } else {
    atomicAdd(&statistics.spared_faces, faces_in(chunk));
  }
}

fn faces_in(chunk: u32) -> u32 { return min(CHUNK, face_range.x + face_range.y - CHUNK * chunk); }

// Takes the chunks of the cluster that begins with `chunk`. `number` is the cluster's among those of the caster.
fn take_cluster(chunk: u32, number: u32) {
  let decision = decide(caster_part(caster, 7u).w + BOUND_WORDS * number);
  let at = cached_cluster_offset(chunk);
  var before = Decision(0u, 0u);
  if (kept[0] == group.structure) {
    before = Decision(kept[at], kept[at + 1u]);
  }
  kept[at] = (before.decided & ~active_mask) | decision.decided;
  kept[at + 1u] = (before.facing & ~active_mask) | decision.facing;
  // Where the masks have these bits already, nothing is to be done.
  let is_known = (active_mask & ~(decision.decided & before.decided)) == 0u &&
    ((decision.facing ^ before.facing) & active_mask) == 0u;
  let end = min(chunk + CLUSTER_CHUNKS, (face_range.x + face_range.y + CHUNK - 1u) / CHUNK);
  // Turns: CLUSTER_CHUNKS.
  for (var each = chunk; each < end; each++) {
    if (is_known) {
      atomicAdd(&statistics.spared_faces, select(0u, faces_in(each), active_mask != 0u));
    } else {
      list_faces(each, decision);
    }
  }
}

// Takes the cluster that begins with a chunk, or the chunk itself where a caster has no clusters.
fn take_chunk(chunk: u32) {
  load_caster(caster_of(group.face_chunks_at, chunk));
  if (!has_clusters(caster)) {
    if (active_mask != 0u) {
      list_faces(chunk, Decision(0u, 0u));
    }
    return;
  }
  let number = chunk - face_range.x / CHUNK;
  if (number % CLUSTER_CHUNKS == 0u) {
    take_cluster(chunk, number / CLUSTER_CHUNKS);
  }
}

@compute @workgroup_size(256)
fn clusters(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // Where no list is made anew, no bit is.
  let is_still = atomicLoad(&work[group.work_count + 2u]) == 0u;
  // Turns: SCENE_ITEMS.
  for (var chunk = id.x; chunk < select(group.face_chunks, 0u, is_still); chunk += 256u * groups.x) {
    take_chunk(chunk);
  }
}

// Stage `chunks`: lists the chunks of edges of casters with a light whose list is made anew, but for chunks that clusters
// tell to have no silhouette. It also empties lists and statistics for `facing` and the stages after it, and notes in `kept`
// the versions that the bits are computed from. `reach` and `clusters` compare these with those of before, so all their
// dispatches, of all groups and batches, must come before the first of `chunks`. A chunk that may have a silhouette must be
// listed.

@group(0) @binding(3) var<storage, read> lit: array<u32>;
// For each light of the batch the number of its silhouette edges. Behind those: whether a light was in the plane of a face
// whose bits are kept.
@group(0) @binding(5) var<storage, read_write> list_counts: array<u32, 64>;
@group(0) @binding(8) var<storage, read_write> record: FacingRecord;
// When a chunk has no silhouette: if all its clusters are decided (its edges lie within clusters), or if all are decided the
// same way. With any other rule it may have one.
const SKIPPED_DECIDED: u32 = 1u;
const SKIPPED_ALIKE: u32 = 2u;

// Makes the lists and the record ready, for a light of the batch.
fn prepare(light: u32) {
  if (((atomicLoad(&work[group.work_count + 2u]) >> light) & 1u) != 0u) {
    list_counts[light] = 0u;
    kept[group.lists_at + light] = encode_number();
  }
  kept[cached_light_offset(group.batch) + light] = light_version(group.batch, light);
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
  let bounds_at = caster_part(caster, 7u).w;
  // Behind the bounds of all clusters.
  let at = bounds_at + BOUND_WORDS * ((faces.y + CLUSTER_FACES - 1u) / CLUSTER_FACES) + chunk - edges.x / CHUNK;
  let begin = cluster_words[at];
  let rule = begin >> OFFSET_BITS;
  if (rule != SKIPPED_DECIDED && rule != SKIPPED_ALIKE) {
    return false;
  }
  let places = (1u << OFFSET_BITS) - 1u;
  let end = bounds_at + (cluster_words[at + 1u] & places);
  var facing = 0u;
  var averted = 0u;
  // Turns: 2 * CHUNK.
  for (var name = bounds_at + (begin & places); name < end; name++) {
    let cluster = cached_cluster_offset(faces.x / CHUNK + CLUSTER_CHUNKS * cluster_words[name]);
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
