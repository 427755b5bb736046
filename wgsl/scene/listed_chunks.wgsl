// Invocations that take the listed chunks of a scene, one after the other.

@group(0) @binding(4) var<storage, read> work: array<u32>;

// The slot of an invocation, in the list of chunks at `list`, which has `count` chunks.
fn listed_slot(invocation: u32, list: u32, count: u32) -> u32 {
  let number = group.first + invocation;
  if (number / CHUNK >= count) {
    return NO_SLOT;
  }
  return CHUNK * work[list + number / CHUNK] + number % CHUNK;
}

fn face_of_invocation(invocation: u32) -> Item {
  let slot = listed_slot(invocation, group.face_work, work[group.work_count]);
  if (slot == NO_SLOT) {
    return Item(false, 0u, 0u);
  }
  return face_in_slot(slot);
}

fn edge_of_invocation(invocation: u32) -> Item {
  let slot = listed_slot(invocation, group.edge_work, work[group.work_count + 1u]);
  if (slot == NO_SLOT) {
    return Item(false, 0u, 0u);
  }
  return edge_in_slot(slot);
}
