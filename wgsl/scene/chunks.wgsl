// Chunks: lists the chunks of faces and of edges of the casters that any light of the batch reaches, in no particular
// order.

@group(0) @binding(3) var<storage, read> lit: array<u32>;
// Counts of chunks, then the chunks, where SceneDispatch says.
@group(0) @binding(4) var<storage, read_write> work: array<atomic<u32>>;

fn is_lit(chunks_at: u32, chunk: u32) -> bool {
  return lit[group.batch * group.casters + caster_of(chunks_at, chunk)] != 0u;
}

@compute @workgroup_size(256)
fn chunks(@builtin(global_invocation_id) id: vec3<u32>) {
  let chunk = group.first + id.x;
  if (chunk < group.face_chunks && is_lit(group.face_chunks_at, chunk)) {
    atomicStore(&work[group.face_work + atomicAdd(&work[group.work_count], 1u)], chunk);
  }
  if (chunk < group.edge_chunks && is_lit(group.edge_chunks_at, chunk)) {
    atomicStore(&work[group.edge_work + atomicAdd(&work[group.work_count + 1u], 1u)], chunk);
  }
}
