// Chunks: lists the chunks of faces of the casters with bits that are to be computed, and the chunks of edges of those with a
// light whose list is made anew, in no particular order. And notes beside the bits what they are computed from.

@group(0) @binding(3) var<storage, read> lit: array<u32>;
// For each group and batch four words, then the chunks, where SceneDispatch says.
@group(0) @binding(4) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read> taken: array<u32>;
@group(0) @binding(6) var<storage, read_write> kept: array<u32>;
@group(0) @binding(7) var<storage, read_write> statistics: SceneStatistics;
// For each light of the batch the number of its silhouette edges. Behind those: whether a light was in the plane of a face
// whose bits are kept.
@group(0) @binding(8) var<storage, read_write> list_counts: array<u32, 64>;
@group(0) @binding(9) var<storage, read_write> record: FacingRecord;

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

fn lists_faces(chunk: u32) -> bool {
  return taken[group.batch * group.casters + caster_of(group.face_chunks_at, chunk)] != 0u;
}

fn lists_edges(chunk: u32) -> bool {
  let matter = lit[group.batch * group.casters + caster_of(group.edge_chunks_at, chunk)];
  return (matter & atomicLoad(&work[group.work_count + 2u])) != 0u;
}

// Slots of a chunk that hold something: `run` has the first slot of a caster and their number.
fn held(run: vec4<u32>, chunk: u32) -> u32 {
  return min(CHUNK, run.x + run.y - CHUNK * chunk);
}

@compute @workgroup_size(256)
fn chunks(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  if (id.x < 32u) {
    prepare(id.x);
  }
  // Where no list is made anew, no bit is.
  let is_still = atomicLoad(&work[group.work_count + 2u]) == 0u;
  let count = select(max(group.face_chunks, group.edge_chunks), 0u, is_still);
  for (var chunk = id.x; chunk < count; chunk += 256u * groups.x) {
    if (chunk < group.face_chunks && lists_faces(chunk)) {
      atomicStore(&work[group.face_work + atomicAdd(&work[group.work_count], 1u)], chunk);
      atomicAdd(&statistics.faces, held(caster_part(caster_of(group.face_chunks_at, chunk), 5u), chunk));
    }
    if (chunk < group.edge_chunks && lists_edges(chunk)) {
      atomicStore(&work[group.edge_work + atomicAdd(&work[group.work_count + 1u], 1u)], chunk);
      atomicAdd(&statistics.edges, held(caster_part(caster_of(group.edge_chunks_at, chunk), 6u), chunk));
    }
  }
}
