// The loops over listed chunks: `process_item` is called once for each slot of the chunks that `clusters` and `chunks`
// listed, in any order. `facing` and `edges` import it through interface/caster.wgsl. A chunk is 64 slots of one caster.
// LANES invocations share a chunk, so that each loads its caster once. They stop at the last slot of the caster.
//
// Expects: `process_item(slot, index)`, which decides a face or an edge record.

#import common/casters
#import scene/many_casters
#import scene/table

@group(0) @binding(4) var<storage, read> work: array<u32>;

fn process_faces(first: u32, step: u32) {
  let item_count = LANES * work[group.work_count];
  // Turns: SCENE_ITEMS.
  for (var item = first; item < item_count; item += step) {
    process_face_chunk(item);
  }
}

// Processes every LANES-th face of a listed chunk. `item` is LANES times the chunk's rank in the list, plus the lane.
fn process_face_chunk(item: u32) {
  let entry_offset = group.face_work + FACE_ENTRY * (item / LANES);
  let chunk = work[entry_offset];
  load_caster(caster_of(group.face_chunks_offset, chunk));
  decided = work[entry_offset + 1u];
  decided_facing = work[entry_offset + 2u];
  tested = work[entry_offset + 3u];
  first_lights = load_four_lights(0u);
  let end = min(CHUNK * (chunk + 1u), face_range.x + face_range.y);
  // Turns: CHUNK / LANES.
  for (var slot = CHUNK * chunk + item % LANES; slot < end; slot += LANES) {
    process_item(slot, face_range.z + slot - face_range.x);
  }
}

fn process_edges(first: u32, step: u32) {
  let item_count = LANES * work[group.work_count + 1u];
  // Turns: SCENE_ITEMS.
  for (var item = first; item < item_count; item += step) {
    process_edge_chunk(item);
  }
}

// Processes every LANES-th edge record of a listed chunk, only for lights with a dirty list.
fn process_edge_chunk(item: u32) {
  let chunk = work[group.edge_work + item / LANES];
  load_caster(caster_of(group.edge_chunks_offset, chunk));
  active_mask &= work[group.work_count + 2u];
  let end = min(CHUNK * (chunk + 1u), edge_range.x + edge_range.y);
  // Turns: CHUNK / LANES.
  for (var slot = CHUNK * chunk + item % LANES; slot < end; slot += LANES) {
    process_item(slot, edge_range.z + slot - edge_range.x);
  }
}
