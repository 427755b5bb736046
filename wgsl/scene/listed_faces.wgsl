// Invocations that take the faces of the listed chunks. LANES invocations share a chunk. Each takes slots in turn, so
// that it finds their caster once, and ends where the caster ends.

@group(0) @binding(4) var<storage, read> work: array<u32>;

fn take_items(first: u32, step: u32) {
  let items = LANES * work[group.work_count];
  // Turns: SCENE_ITEMS.
  for (var number = first; number < items; number += step) {
    take_lane(number);
  }
}

fn take_lane(number: u32) {
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
