// The work of an invocation: an edge of an outline and a light, from an entry.

// The edge that an invocation decides, for a light. The invocations of a large outline share one.
struct Work {
  exists: bool,
  is_large: bool,
  edge: Edge,
  index: u32,
  place: u32,
}

fn work_of(outline: OutlineRange, part: u32, lights: u32, lane: u32) -> Work {
  var work: Work;
  work.is_large = is_large(outline);
  work.index = part & 0xffffu;
  work.place = part >> 16u;
  if (!work.is_large) {
    work.index += lane % ENTRY_EDGES;
    work.place = ENTRY_LIGHTS * work.place + lane / ENTRY_EDGES;
  }
  work.exists = work.index < outline.count && ((lights >> (work.place % 32u)) & 1u) != 0u;
  if (work.exists) {
    work.edge = edge_at(outline.first + work.index);
    work.exists = work.edge.has_length;
  }
  return work;
}
