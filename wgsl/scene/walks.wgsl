// Walks over a scene: calls `take_item` for each face or edge record in the chunks that `clusters` and `chunks` listed, for the
// stages `facing` and `edges`, through interface/caster.wgsl. A chunk is 64 slots of one caster, and LANES invocations share it:
// each takes slots in turn, so that it finds their caster once, and ends where the caster ends. Each listed slot is taken once,
// in any order.
//
// Expects: `take_item(slot, index)`, which decides a face or an edge record.

#import common/casters
#import scene/many_casters
#import scene/table

@group(0) @binding(4) var<storage, read> work: array<u32>;

fn take_faces(first: u32, step: u32) {
  let items = LANES * work[group.work_count];
  // Turns: SCENE_ITEMS.
  for (var number = first; number < items; number += step) {
    take_faces_of_chunk(number);
  }
}

fn take_faces_of_chunk(number: u32) {
  let entry = group.face_work + FACE_ENTRY * (number / LANES);
  let chunk = work[entry];
  take_caster(caster_of(group.face_chunks_at, chunk));
  decided = work[entry + 1u];
  decided_facing = work[entry + 2u];
  tested = work[entry + 3u];
  let end = min(CHUNK * (chunk + 1u), of_faces.x + of_faces.y);
  // Turns: CHUNK / LANES.
  for (var slot = CHUNK * chunk + number % LANES; slot < end; slot += LANES) {
    take_item(slot, of_faces.z + slot - of_faces.x);
  }
}

// Takes edge records only for the lights whose lists are made anew.
fn take_edges(first: u32, step: u32) {
  let items = LANES * work[group.work_count + 1u];
  // Turns: SCENE_ITEMS.
  for (var number = first; number < items; number += step) {
    take_edges_of_chunk(number);
  }
}

fn take_edges_of_chunk(number: u32) {
  let chunk = work[group.edge_work + number / LANES];
  take_caster(caster_of(group.edge_chunks_at, chunk));
  matter &= work[group.work_count + 2u];
  let end = min(CHUNK * (chunk + 1u), of_edges.x + of_edges.y);
  // Turns: CHUNK / LANES.
  for (var slot = CHUNK * chunk + number % LANES; slot < end; slot += LANES) {
    take_item(slot, of_edges.z + slot - of_edges.x);
  }
}
