// Reads the positions of the casters of a group, which are in one binding. They are read as u32, so that no load can
// flush a subnormal.

@group(0) @binding(2) var<storage, read> positions: array<u32>;

fn position_bits(vertex: u32, offset: u32, stride: u32) -> vec3<u32> {
  let word = offset + vertex * stride;
  return vec3<u32>(positions[word], positions[word + 1u], positions[word + 2u]);
}
