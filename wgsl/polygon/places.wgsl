// Edges of outlines at their places.

// The bits of a position. Both zeros are one, so that equal bits are equal places.
fn place_of(vertex: u32) -> vec3<u32> {
  let bits = position_bits(vertex, position_offset(), position_stride());
  return select(bits, vec3<u32>(0u), bits == vec3<u32>(0x80000000u));
}

// The directed edge of an outline.
struct Edge {
  a: vec3<u32>,
  b: vec3<u32>,
  has_length: bool,
}

fn edge_at(index: u32) -> Edge {
  let ends = outlines[index];
  let a = place_of(ends.x);
  let b = place_of(ends.y);
  return Edge(a, b, any(a != b));
}
