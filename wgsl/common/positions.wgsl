// Reads positions from a caller's buffer, at any offset and stride in words, for the stages of extraction, polygons and
// queries. (Scenes have one binding instead: scene/many_casters.wgsl.) Positions lie in up to four bindings, of equal length
// but for the last; unused ones repeat the first. They are loaded as u32, so that no load can flush a subnormal. Exact signs
// need the unchanged bits.

@group(0) @binding(2) var<storage, read> positions_0: array<u32>;
@group(0) @binding(3) var<storage, read> positions_1: array<u32>;
@group(0) @binding(4) var<storage, read> positions_2: array<u32>;
@group(0) @binding(5) var<storage, read> positions_3: array<u32>;
override WINDOW_WORDS: u32 = 0u; // Words in each binding but the last. 0: the first binding has all.

fn position_word(word: u32) -> u32 {
  if (WINDOW_WORDS == 0u) {
    return positions_0[word];
  }
  let offset = word % max(WINDOW_WORDS, 1u);
  switch (word / max(WINDOW_WORDS, 1u)) {
    case 0u: { return positions_0[offset]; }
    case 1u: { return positions_1[offset]; }
    case 2u: { return positions_2[offset]; }
    default: { return positions_3[offset]; }
  }
}

fn position_bits(vertex: u32, offset: u32, stride: u32) -> vec3<u32> {
  let word = offset + vertex * stride;
  return vec3<u32>(position_word(word), position_word(word + 1u), position_word(word + 2u));
}

// Tests the bits, because WGSL allows an implementation to assume that floats are finite.
fn is_finite(bits: vec3<u32>) -> bool {
  let exponent = bits & vec3<u32>(0x7f800000u);
  return all(exponent != vec3<u32>(0x7f800000u));
}
