// Invocations that take the edge records of the listed chunks. LANES invocations share a chunk. Each takes slots in
// turn, so that it finds their caster once, and ends where the caster ends. They take the lights whose lists are made
// anew.

@group(0) @binding(4) var<storage, read> work: array<u32>;

fn take_items(first: u32, step: u32) {
  let items = LANES * work[group.work_count + 1u];
  // Turns: SCENE_ITEMS.
  for (var number = first; number < items; number += step) {
    take_lane(number);
  }
}

fn take_lane(number: u32) {
  let chunk = work[group.edge_work + number / LANES];
  take_caster(caster_of(group.edge_chunks_at, chunk));
  matter &= work[group.work_count + 2u];
  let end = min(CHUNK * (chunk + 1u), of_edges.x + of_edges.y);
  // Turns: CHUNK / LANES.
  for (var slot = CHUNK * chunk + number % LANES; slot < end; slot += LANES) {
    take_item(slot, of_edges.z + slot - of_edges.x);
  }
}
