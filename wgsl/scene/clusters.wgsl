// Work lists of a scene's extraction: the stages `clusters` and `chunks`, dispatched for each group of casters and batch of
// up to 32 lights; each invocation takes several chunks. A chunk is 64 slots (indices in the masks) of one caster. A cluster
// is 128 faces of a mesh with a bound on their planes. `clusters` runs after `cull_lights` and lists chunks of faces
// for `facing`; `chunks` runs next and lists chunks of edges for `edges`. Lists lie in `work`, in no particular order.
// docs/numerics/clusters.md, and docs/numerics/scene.md, "Cached results".

#import common/casters
#import common/extraction
#import scene/many_casters
#import scene/table

// Stage `clusters`: decides for the active lights of a caster whether all faces of a cluster face a light, or none does. It
// lists the chunks with a bit that must be tested or changed, with the decided bits. It writes to `cache` what the masks
// will hold, for `chunks` and the next encode. A decision must agree with exact facing, so bounds must not shrink.

// SceneDispatch has the offsets: four words for each group and batch, then the listed chunks.
@group(0) @binding(4) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> cache: array<u32>;
@group(0) @binding(7) var<storage, read_write> statistics: SceneStatistics;
// Kinds of bounds, the fourth word of a bound. Kind 1 decides that all faces face a light, or that none does.
const DECIDES_NOTHING: u32 = 0u; // It decides nothing.
const DECIDES_BACK_FACING: u32 = 2u; // It decides only that no face does, because some faces name a vertex twice.
const ALL_BACK_FACING: u32 = 3u; // No face ever faces a light.
// 2.5 units in the last place: the most that rounding of w centre adds, relative to its size.
const PRODUCT_ERROR: f32 = 2.5 * 0x1p-23;
const UNDERFLOW_ERROR: f32 = 0x1p-118; // The most that underflow adds.

// Lights that are decided for a whole cluster, and those of them that its faces face.
struct Decision {
  decided: u32,
  facing: u32,
}

fn four_words(offset: u32) -> vec4<u32> {
  return vec4<u32>(
    cluster_words[offset], cluster_words[offset + 1u], cluster_words[offset + 2u], cluster_words[offset + 3u]);
}

// Decides the active lights of the loaded caster by a bound at a word of `cluster_words`. A bound has three vec4s. The
// first: xyz the centre, w the kind. The second, the middle of the planes of all faces: xyz the scaled normal, w the height
// of the centre over the plane, in the same scale. The third: half the spread of the second, with room for rounding.
fn decide_cluster(bound_offset: u32) -> Decision {
  let first = four_words(bound_offset);
  let kind = first.w;
  if (kind == DECIDES_NOTHING) {
    return Decision(0u, 0u);
  }
  if (kind == ALL_BACK_FACING) {
    return Decision(active_mask, 0u);
  }
  let centre = bitcast<vec3<f32>>(first.xyz);
  let middle = bitcast<vec4<f32>>(four_words(bound_offset + 4u));
  let half_spread = bitcast<vec4<f32>>(four_words(bound_offset + 8u));
  let size = abs(centre.x) + abs(centre.y) + abs(centre.z);
  var decision = Decision(0u, 0u);
  var light_index = 0u;
  for (var remaining = lights.allowed; remaining != 0u; remaining &= remaining - 1u) {
    let bit = (remaining & (~remaining + 1u)) & active_mask;
    if (bit != 0u) {
      let light = scaled_light(light_index);
      let w_error = inexact_w(light_index);
      let to_light = light.xyz - light.w * centre;
      let middle_height = middle.x * to_light.x + middle.y * to_light.y + middle.z * to_light.z + middle.w * light.w;
      let sizes = abs(to_light);
      let spread = half_spread.x * sizes.x + half_spread.y * sizes.y + half_spread.z * sizes.z +
        half_spread.w * max(abs(light.w), w_error) + PRODUCT_ERROR * w_error * size + UNDERFLOW_ERROR;
      let is_facing = middle_height > spread && kind != DECIDES_BACK_FACING;
      decision.decided |= select(0u, bit, is_facing || middle_height < -spread);
      decision.facing |= select(0u, bit, is_facing);
    }
    light_index++;
  }
  return decision;
}

// Lists a chunk of the loaded caster for `facing`, with the bits decided for all its faces.
fn list_face_chunk(chunk: u32, decision: Decision) {
  let entry = group.face_work + FACE_ENTRY * atomicAdd(&work[group.work_count], 1u);
  atomicStore(&work[entry], chunk);
  atomicStore(&work[entry + 1u], decision.decided);
  atomicStore(&work[entry + 2u], decision.facing);
  // Most casters have no clusters. Then no light is decided, and the loop over lights would be wasted.
  var tested_lights = 0xffffffffu;
  if (decision.decided != 0u) {
    tested_lights = indices_of_lights(active_mask & ~decision.decided);
  }
  atomicStore(&work[entry + 3u], tested_lights);
  if ((active_mask & ~decision.decided) != 0u) {
    atomicAdd(&statistics.faces, face_count(chunk));
  } else {
    atomicAdd(&statistics.untested_faces, face_count(chunk));
  }
}

fn face_count(chunk: u32) -> u32 { return min(CHUNK, face_range.x + face_range.y - CHUNK * chunk); }

// Decides the cluster of the loaded caster that begins with `chunk`, and lists its chunks unless the masks have its bits.
// `index` is its index in the caster.
fn process_cluster(chunk: u32, index: u32) {
  let decision = decide_cluster(caster_part(caster, 7u).w + BOUND_WORDS * index);
  let offset = cached_cluster_offset(chunk);
  var before = Decision(0u, 0u);
  if (cache[0] == group.structure) {
    before = Decision(cache[offset], cache[offset + 1u]);
  }
  cache[offset] = (before.decided & ~active_mask) | decision.decided;
  cache[offset + 1u] = (before.facing & ~active_mask) | decision.facing;
  // True if the masks have these bits already.
  let is_known = (active_mask & ~(decision.decided & before.decided)) == 0u &&
    ((decision.facing ^ before.facing) & active_mask) == 0u;
  let end = min(chunk + CLUSTER_CHUNKS, (face_range.x + face_range.y + CHUNK - 1u) / CHUNK);
  // Turns: CLUSTER_CHUNKS.
  for (var cluster_chunk = chunk; cluster_chunk < end; cluster_chunk++) {
    if (is_known) {
      atomicAdd(&statistics.untested_faces, select(0u, face_count(cluster_chunk), active_mask != 0u));
    } else {
      list_face_chunk(cluster_chunk, decision);
    }
  }
}

// Processes the cluster that begins with a chunk, or the chunk itself if its caster has no clusters.
fn process_chunk(chunk: u32) {
  load_caster(caster_of(group.face_chunks_offset, chunk));
  if (!has_clusters(caster)) {
    if (active_mask != 0u) {
      list_face_chunk(chunk, Decision(0u, 0u));
    }
    return;
  }
  let chunk_index = chunk - face_range.x / CHUNK;
  if (chunk_index % CLUSTER_CHUNKS == 0u) {
    process_cluster(chunk, chunk_index / CLUSTER_CHUNKS);
  }
}

@compute @workgroup_size(256)
fn clusters(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // If no list is dirty, no bit is.
  let is_idle = atomicLoad(&work[group.work_count + 2u]) == 0u;
  // Turns: SCENE_ITEMS.
  for (var chunk = id.x; chunk < select(group.face_chunks, 0u, is_idle); chunk += 256u * groups.x) {
    process_chunk(chunk);
  }
}

// Stage `chunks`: lists chunks of edges of casters with a light whose list is dirty. It skips chunks that have no silhouette
// by the decisions about clusters. A chunk that may have one must be listed. It also empties the dirty lists and `record` for
// `facing` and later stages, and writes to `cache` the versions of layout, lights and lists. `cull_lights` and `clusters`
// compare those of the encode before. All their dispatches, for all groups and batches, must come before the first of
// `chunks`.

@group(0) @binding(3) var<storage, read> relevant_lights: array<u32>;
// For each light of the batch the number of its silhouette edges. Then word CACHED_ZEROS: not 0 if a light was in the
// plane of a face whose bits are cached.
@group(0) @binding(5) var<storage, read_write> list_counts: array<u32, 64>;
@group(0) @binding(8) var<storage, read_write> record: FacingRecord;
// Rules for a chunk to have no silhouette. Rule 1: all its clusters are decided, and its edges lie within clusters. Rule 2:
// all are decided with the same facing. By other rules it may always have one.
const SKIPPED_DECIDED: u32 = 1u;
const SKIPPED_SAME_FACING: u32 = 2u;

// Resets the list of a light of the batch if it is dirty, and updates versions. For light 0 it also resets the record, but
// not `twisted_lights`, which only polygons set.
fn reset_light(light: u32) {
  if (((atomicLoad(&work[group.work_count + 2u]) >> light) & 1u) != 0u) {
    list_counts[light] = 0u;
    cache[group.lists_offset + light] = encode_number();
  }
  cache[cached_light_offset(group.batch) + light] = light_version(group.batch, light);
  if (light == 0u) {
    cache[0] = group.structure;
    let zeros = list_counts[CACHED_ZEROS] | atomicLoad(&record.statistics.exact_zeros);
    list_counts[CACHED_ZEROS] = select(0u, zeros, atomicLoad(&work[group.work_count + 3u]) != 0u);
    atomicStore(&record.statistics.non_finite_faces, 0u);
    atomicStore(&record.statistics.overflowed_lists, 0u);
    atomicStore(&record.statistics.undecided_pairs, 0u);
    atomicStore(&record.statistics.exact_zeros, 0u);
    atomicStore(&record.undecided_count, 0u);
  }
}

// Whether, by the decisions about clusters, no edge of a chunk is a silhouette for any of `lights_to_list`.
fn is_without_silhouette(caster: u32, chunk: u32, lights_to_list: u32) -> bool {
  let faces = caster_part(caster, 5u);
  let edges = caster_part(caster, 6u);
  let bounds_offset = caster_part(caster, 7u).w;
  // The offsets of chunks lie behind the bounds of all clusters.
  let word = bounds_offset + BOUND_WORDS * ((faces.y + CLUSTER_FACES - 1u) / CLUSTER_FACES) + chunk - edges.x / CHUNK;
  let begin = cluster_words[word];
  let skip_rule = begin >> OFFSET_BITS;
  if (skip_rule != SKIPPED_DECIDED && skip_rule != SKIPPED_SAME_FACING) {
    return false;
  }
  let offset_mask = (1u << OFFSET_BITS) - 1u;
  let end = bounds_offset + (cluster_words[word + 1u] & offset_mask);
  var facing = 0u;
  var back_facing = 0u;
  // Turns: 2 * CHUNK.
  for (var member = bounds_offset + (begin & offset_mask); member < end; member++) {
    let cluster_offset = cached_cluster_offset(faces.x / CHUNK + CLUSTER_CHUNKS * cluster_words[member]);
    if ((lights_to_list & ~cache[cluster_offset]) != 0u) {
      return false;
    }
    facing |= cache[cluster_offset + 1u];
    back_facing |= ~cache[cluster_offset + 1u];
  }
  return skip_rule == SKIPPED_DECIDED || (lights_to_list & facing & back_facing) == 0u;
}

// Lists a chunk of edges if it may have a silhouette in a dirty list.
fn list_edge_chunk(chunk: u32) {
  let caster = caster_of(group.edge_chunks_offset, chunk);
  let lights_to_list = relevant_lights[group.batch * group.casters + caster] & atomicLoad(&work[group.work_count + 2u]);
  if (lights_to_list == 0u) {
    return;
  }
  let edges = caster_part(caster, 6u);
  let count = min(CHUNK, edges.x + edges.y - CHUNK * chunk);
  if (has_clusters(caster) && is_without_silhouette(caster, chunk, lights_to_list)) {
    atomicAdd(&statistics.untested_edges, count);
    return;
  }
  atomicStore(&work[group.edge_work + atomicAdd(&work[group.work_count + 1u], 1u)], chunk);
  atomicAdd(&statistics.edges, count);
}

@compute @workgroup_size(256)
fn chunks(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  if (id.x < 32u) {
    reset_light(id.x);
  }
  let is_idle = atomicLoad(&work[group.work_count + 2u]) == 0u;
  // Turns: SCENE_ITEMS.
  for (var chunk = id.x; chunk < select(group.edge_chunks, 0u, is_idle); chunk += 256u * groups.x) {
    list_edge_chunk(chunk);
  }
}
