// The edge code of a cell: which of its four edges are marked, how it is split, and which of its triangles are drawn. Both
// cells of an edge decide about it from the same two samples, so they agree.

// An entry is the number of the cell and these bits.
const CELL_MASK: u32 = 0x1fffffffu;
// The cell is split from sample (1, 0) to (0, 1), not from (0, 0) to (1, 1).
const SPLIT: u32 = 0x20000000u;
const FIRST_TRIANGLE: u32 = 0x40000000u;
const SECOND_TRIANGLE: u32 = 0x80000000u;

// For each texel the object that is seen there. One texel, if edges of objects do not count.
@group(0) @binding(4) var object_texture: texture_2d<u32>;

fn mantissa(bits: u32) -> u32 {
  return select((bits & 0x7fffffu) | 0x800000u, 0u, bits == 0u);
}

// A mantissa with 32 further bits, moved down by `places`: high and low word.
fn moved_down(word: u32, places: u32) -> vec2<u32> {
  if (places == 0u) {
    return vec2<u32>(word, 0u);
  }
  if (places < 32u) {
    return vec2<u32>(word >> places, word << (32u - places));
  }
  return vec2<u32>(0u, select(word >> (places & 31u), 0u, places >= 64u));
}

// Whether `large` is more than `small` + `threshold`, exactly: bits of numbers from 0 to 1, none subnormal, small <= large.
// What the sum loses by the move cannot change the result (NUMERICS.md).
fn exceeds(large: u32, small: u32, threshold: u32) -> bool {
  if (threshold >= large) {
    return false;
  }
  let exponent = large >> 23u;
  let a = moved_down(mantissa(small), exponent - (small >> 23u));
  let b = moved_down(mantissa(threshold), exponent - (threshold >> 23u));
  let low = a.y + b.y;
  let high = a.x + b.x + select(0u, 1u, low < a.y);
  let own = mantissa(large);
  return own > high;
}

fn is_marked(a: u32, b: u32) -> bool {
  if (a == FAR_KEY || b == FAR_KEY) {
    return a != b;
  }
  if (depth_map.every_cell != 0u) {
    return true;
  }
  let depths = vec2<u32>(depth_bits(a), depth_bits(b));
  if (depth_map.ratio != 0u) {
    return world_step(depths.x, depths.y);
  }
  return exceeds(max(depths.x, depths.y), min(depths.x, depths.y), depth_map.threshold);
}

fn key_distance(a: u32, b: u32) -> u32 {
  return max(a, b) - min(a, b);
}

// The object at a sample that is not far.
fn object_at(at: vec2<u32>) -> u32 {
  return textureLoad(object_texture, vec2<i32>(at) - 1, 0).x;
}

// Whether objects at two samples, neither of them far, differ.
fn differs(a: vec2<u32>, b: vec2<u32>) -> bool {
  return object_at(a) != object_at(b);
}

// The edges of the cell, and those from its samples to others: right, down, left, up in turn.
const CELL_EDGES: u32 = 4u;
const ALL_EDGES: u32 = 12u;

// The samples (0, 0), (1, 0), (0, 1) and (1, 1) by their numbers.
fn sample_of_cell(number: u32) -> vec2<u32> {
  return vec2<u32>(number & 1u, number >> 1u);
}

// Bits 0 to 3: the edges of the cell at the top, right, bottom and left. Bits 4 to 11: those from each of its samples out of the cell,
// across and down or up. `keys` are those of its samples.
fn edge_code(at: vec2<u32>, keys: vec4<u32>) -> u32 {
  // A loop that is not unrolled has one copy of what decides.
  let edges = select(CELL_EDGES, ALL_EDGES, depth_map.spread != 0u);
  var code = 0u;
  for (var edge = 0u; edge < min(edges, 12u + depth_map.cells); edge++) {
    // The ends of the edges of the cell, by two bits each.
    var first = (0x24u >> (2u * edge)) & 3u;
    let end = (0xbdu >> (2u * edge)) & 3u;
    var there = at + sample_of_cell(end);
    var key = keys[end];
    if (edge >= CELL_EDGES) {
      first = (edge - CELL_EDGES) / 2u;
      let out = sample_of_cell(first) * 2u - 1u;
      there = at + sample_of_cell(first) + select(vec2<u32>(0u, out.y), vec2<u32>(out.x, 0u), edge % 2u == 0u);
      key = key_at(there);
    }
    var is_edge = is_marked(keys[first], key);
    // An edge of a far sample is marked already, or lies between two.
    if (depth_map.objects != 0u && keys[first] != FAR_KEY && key != FAR_KEY) {
      is_edge = is_edge || differs(at + sample_of_cell(first), there);
    }
    code |= select(0u, 1u << edge, is_edge);
  }
  return code;
}

// The samples of the cell, a bit for each, that are not far and at the end of a marked edge.
fn ends_of_edges(code: u32, keys: vec4<u32>) -> u32 {
  var ends = 0u;
  for (var number = 0u; number < 4u; number++) {
    // Two edges of the cell and two out of it.
    let own = ((0x6c39u >> (4u * number)) & 15u) | (0x30u << (2u * number));
    ends |= select(0u, 1u << number, (code & own) != 0u && keys[number] != FAR_KEY);
  }
  return ends;
}

// A triangle is drawn if one of its edges that lie on the border of the cell is marked.
fn templates(at: vec2<u32>) -> u32 {
  let keys = keys_of_cell(at);
  let code = edge_code(at, keys);
  let is_split = key_distance(keys.x, keys.w) > key_distance(keys.y, keys.z);
  let first = select(3u, 9u, is_split);
  var drawn = select(0u, FIRST_TRIANGLE, (code & first) != 0u)
    | select(0u, SECOND_TRIANGLE, (code & (15u - first)) != 0u);
  if (depth_map.spread != 0u) {
    // By their three samples.
    let ends = ends_of_edges(code, keys);
    drawn |= select(0u, FIRST_TRIANGLE, (ends & select(11u, 7u, is_split)) != 0u)
      | select(0u, SECOND_TRIANGLE, (ends & select(13u, 14u, is_split)) != 0u);
  }
  return select(0u, SPLIT, is_split) | drawn;
}

fn corner_of_cell(cell: u32) -> vec2<u32> {
  if (depth_map.faces > 1u) {
    let side = depth_map.size.x - 1u;
    let face = cell / (side * side);
    let rest = cell % (side * side);
    return vec2<u32>(face % 3u, face / 3u) * depth_map.size.x + vec2<u32>(rest % side, rest / side);
  }
  let across = depth_map.size.x + 1u;
  return vec2<u32>(cell % across, cell / across);
}

fn keys_of_cell(at: vec2<u32>) -> vec4<u32> {
  return vec4<u32>(
    key_at(at), key_at(at + vec2<u32>(1u, 0u)), key_at(at + vec2<u32>(0u, 1u)), key_at(at + vec2<u32>(1u, 1u)));
}

// The entry of a cell. It is listed if it has a triangle.
fn entry_of_cell(cell: u32) -> u32 {
  return cell | templates(corner_of_cell(cell));
}
