// Marks of edges, many at once: a word has 16 samples that follow each other in a row of the lattice. It has a bit for the edge
// from each sample to the next one on the right, and 16 bits higher one for the edge to the sample below.

// What an earlier pass marked.
@group(0) @binding(7) var<storage, read> edges_before: array<u32>;

// A triangle is drawn if one of its samples is so many edges, less one, from the end of a marked edge.
override RINGS: u32 = 2u;

// Marks of 16 samples in a row that does not exist are 0. `axis`: 1 for edges down.
fn half_word(word: i32, row: i32, axis: u32) -> u32 {
  let inside = all(vec2<i32>(word, row) >= vec2<i32>(0)) && all(vec2<i32>(word, row) < vec2<i32>(edge_rule.words));
  let index = select(0, row * i32(edge_rule.words.x) + word, inside);
  return select(0u, (edges_before[index] >> (16u * axis)) & 0xffffu, inside);
}

// Marks of 17 samples or more from a place on.
fn marks_from(at: vec2<i32>, axis: u32) -> u32 {
  let word = at.x >> 4u;
  return (half_word(word, at.y, axis) | (half_word(word + 1, at.y, axis) << 16u)) >> u32(at.x & 15);
}

// For 17 cells from a place on, whether exactly one of their edges is marked.
fn dangling_from(at: vec2<i32>) -> u32 {
  let top = marks_from(at, 0u);
  let bottom = marks_from(at + vec2<i32>(0, 1), 0u);
  let left = marks_from(at, 1u);
  let right = marks_from(at + vec2<i32>(1, 0), 1u);
  let two = (top & bottom) | (left & right) | ((top | bottom) & (left | right));
  var single = (top | bottom | left | right) & ~two;
  if (depth_map.faces > 1u) {
    // There are none between two maps.
    let side = i32(depth_map.size.x);
    for (var cell = 0; cell < 17; cell++) {
      let is_between = any((at + vec2<i32>(cell, 0) + side) % side == vec2<i32>(side - 1));
      single &= ~select(0u, 1u << u32(cell), is_between);
    }
  }
  return single;
}

// For 17 samples from a place on, whether they are at the end of a marked edge, or on the border of a map of a cube, whose other
// maps may have one there.
fn ends_from(at: vec2<i32>) -> u32 {
  let across = marks_from(at - vec2<i32>(1, 0), 0u);
  var ends = across | (across >> 1u) | marks_from(at, 1u) | marks_from(at - vec2<i32>(0, 1), 1u);
  if (depth_map.faces > 1u) {
    let side = i32(depth_map.size.x);
    for (var sample = 0; sample < 13; sample++) {
      let local = (at + vec2<i32>(sample, 0) + side) % side;
      let is_border = any(local == vec2<i32>(0)) || any(local == vec2<i32>(side - 1));
      ends |= select(0u, 1u << u32(sample), is_border);
    }
  }
  return ends;
}

// For 11 samples from a place on, whether triangles at them are drawn for the marked edges near them.
fn rings_from(at: vec2<i32>) -> u32 {
  if (RINGS == 0u) {
    return 0u;
  }
  let own = ends_from(at - vec2<i32>(1, 0));
  if (RINGS == 1u) {
    return own >> 1u;
  }
  let beside = ends_from(at - vec2<i32>(0, 1)) | ends_from(at + vec2<i32>(0, 1));
  return own | (own >> 1u) | (own >> 2u) | beside;
}
