// Edge codes of cells: which of a cell's four edges are marked, because a border of shadow may cross them. The code decides
// which triangles of the cell are drawn; with `depth_map.spread` edges around the cell count, too. Also an exact comparison
// of a depth difference with a threshold.
// Imported by `depth_cells`; by `depth_edges`, which marks edges by other rules; by `contour_marks`, for objects; and by
// surface.wgsl, for entries, near caps, and each cell if the list overflowed. `depth_cells` without `spread`, and
// `depth_edges`, have `entry_bits` and `edge_code` or a rule of their own for many cells at once: change them together.
// Importers bind what samples.wgsl has, and `object_texture`.
// A mark depends only on the two samples of the edge, so both cells at an edge agree. A triangle with a marked edge is
// always drawn: one that is missing would leave a gap in the boundary. One too many changes nothing if what it lies on is in
// the eye's depth buffer. Integers decide. docs/numerics/depth-maps.md, "Omitted triangles" and "Exact decisions".

#import depth_map/samples

// An entry of the list of cells: the index of the cell, and three bits.
const CELL_MASK: u32 = 0x1fffffffu;
// The cell is split from sample (1, 0) to (0, 1), not from (0, 0) to (1, 1).
const SPLIT: u32 = 0x20000000u;
// The first or second triangle is drawn.
const FIRST_TRIANGLE: u32 = 0x40000000u;
const SECOND_TRIANGLE: u32 = 0x80000000u;

// Whether edges between objects may be marked. A pipeline without them is smaller.
override OBJECTS: bool = true;

// Whether `depth_map.spread` may be set. A pipeline without it is smaller.
override SPREADS: bool = true;

// The index of the object that is visible in each texel. One texel if edges between objects are not marked.
@group(0) @binding(4) var object_texture: texture_2d<u32>;

// The mantissa of a float that is 0, or positive and not subnormal.
fn mantissa(bits: u32) -> u32 {
  return select((bits & 0x7fffffu) | 0x800000u, 0u, bits == 0u);
}

// A mantissa with 32 more bits after it, shifted down: high and low word. Without branches, because some devices execute
// both sides of a branch.
fn shift_down(mantissa: u32, shift: u32) -> vec2<u32> {
  let low = select(mantissa << ((32u - shift) & 31u), mantissa >> min(shift - 32u, 31u), shift >= 32u);
  return vec2<u32>(mantissa >> min(shift, 31u), select(low, 0u, shift == 0u));
}

// Whether `large` is more than `small` + `threshold`, exactly. All are bits of numbers from 0 to 1, none subnormal, and
// `small` is not above `large`. The bits that the shifts cut off do not matter: docs/numerics/depth-maps.md, "Exact
// decisions".
fn exceeds(large: u32, small: u32, threshold: u32) -> bool {
  let exponent = large >> 23u;
  let a = shift_down(mantissa(small), exponent - (small >> 23u));
  let b = shift_down(mantissa(threshold), exponent - (threshold >> 23u));
  let low = a.y + b.y;
  let high = a.x + b.x + select(0u, 1u, low < a.y);
  return (threshold < large) & (mantissa(large) > high);
}

// Whether the edge between two samples is marked, by their keys alone, without objects. An edge with one far sample always
// is, one with two never.
fn is_marked(a: u32, b: u32) -> bool {
  // The result is dropped for far samples.
  let depths = vec2<u32>(depth_bits(a), depth_bits(b));
  let is_step = exceeds(max(depths.x, depths.y), min(depths.x, depths.y), depth_map.threshold);
  return select(is_step | (depth_map.every_cell != 0u), a != b, max(a, b) == FAR_KEY);
}

fn key_difference(a: u32, b: u32) -> u32 {
  return max(a, b) - min(a, b);
}

// The object at a sample that is not far. Only a single map has a border on the lattice.
fn load_object(sample: vec2<u32>) -> u32 {
  return textureLoad(object_texture, vec2<i32>(sample) - select(1, 0, depth_map.faces > 1u), 0).x;
}

// Whether two samples, neither of them far, show different objects. Only with `has_objects`: else there is one texel.
fn is_object_edge(a: vec2<u32>, b: vec2<u32>) -> bool {
  return load_object(a) != load_object(b);
}

// The bits of an edge code for edges between objects at the top, right and bottom. `top_right`: the cell's upper sample on
// the right. The keys are of the upper and lower sample on each side. Edges of far samples have no bit: `is_marked` decides
// them.
fn object_edge_code_without_left(top_right: vec2<u32>, left_keys: vec2<u32>, right_keys: vec2<u32>) -> u32 {
  if (depth_map.has_objects == 0u) {
    return 0u;
  }
  let top_left = top_right - vec2<u32>(1u, 0u);
  let down = vec2<u32>(0u, 1u);
  let is_left_far = left_keys == vec2<u32>(FAR_KEY);
  let is_right_far = right_keys == vec2<u32>(FAR_KEY);
  return select(0u, 1u, !(is_left_far.x || is_right_far.x) && is_object_edge(top_left, top_right))
    | select(0u, 2u, !(is_right_far.x || is_right_far.y) && is_object_edge(top_right, top_right + down))
    | select(0u, 4u, !(is_left_far.y || is_right_far.y) && is_object_edge(top_left + down, top_right + down));
}

// The edge code of a cell: bits 0 to 3 are set for marked edges at the top, right, bottom and left. `keys` are of samples
// (0, 0), (1, 0), (0, 1) and (1, 1).
fn edge_code(first_sample: vec2<u32>, keys: vec4<u32>) -> u32 {
  let marked = vec4<bool>(
    is_marked(keys.x, keys.y), is_marked(keys.y, keys.w), is_marked(keys.z, keys.w), is_marked(keys.x, keys.z));
  let bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), marked);
  let code = bits.x | bits.y | bits.z | bits.w;
  if (!OBJECTS) {
    return code;
  }
  // The left edge is the right edge of the cell before.
  let left_object_edge = object_edge_code_without_left(first_sample, vec2<u32>(FAR_KEY), keys.xz) & 2u;
  return code | object_edge_code_without_left(first_sample + vec2<u32>(1u, 0u), keys.xz, keys.yw) | (left_object_edge << 2u);
}

// Whether a cell is split from sample (1, 0) to (0, 1), because the keys of the other diagonal differ more. The choice only
// shapes the border of the shadow, but entries and near caps must take the same.
fn is_split(keys: vec4<u32>) -> bool {
  return key_difference(keys.x, keys.w) > key_difference(keys.y, keys.z);
}

// The three bits of a cell's entry. A triangle is drawn if one of its two edges on the border of the cell is marked.
fn entry_bits(code: u32, split: bool) -> u32 {
  let edges_of_first = select(3u, 9u, split);
  return select(0u, SPLIT, split) | select(0u, FIRST_TRIANGLE, (code & edges_of_first) != 0u)
    | select(0u, SECOND_TRIANGLE, (code & (15u - edges_of_first)) != 0u);
}

// The offset of samples 0 to 3 of a cell: (0, 0), (1, 0), (0, 1), (1, 1).
fn sample_offset(index: u32) -> vec2<u32> {
  return vec2<u32>(index & 1u, index >> 1u);
}

// Bits 0 to 3: the edge code. Bits 4 to 11: two edges out of the cell at each of its samples, first the horizontal one. For a
// single map: in a cube these edges might lead into another map.
fn edges_in_and_around(first_sample: vec2<u32>, keys: vec4<u32>) -> u32 {
  var code = 0u;
  // `opaque` keeps the loop from being unrolled into 12 copies of `is_marked`.
  for (var edge = 0u; edge < opaque(12u); edge++) {
    // The samples at the ends of edges 0 to 3, two bits each.
    var start = (0x24u >> (2u * edge)) & 3u;
    let end = (0xbdu >> (2u * edge)) & 3u;
    var end_sample = first_sample + sample_offset(end);
    var end_key = keys[end];
    if (edge >= 4u) {
      start = (edge - 4u) / 2u;
      let outwards = sample_offset(start) * 2u - 1u;
      end_sample =
        first_sample + sample_offset(start) + select(vec2<u32>(0u, outwards.y), vec2<u32>(outwards.x, 0u), edge % 2u == 0u);
      end_key = load_key(end_sample);
    }
    var is_edge = is_marked(keys[start], end_key);
    if (OBJECTS && depth_map.has_objects != 0u && keys[start] != FAR_KEY && end_key != FAR_KEY) {
      is_edge = is_edge || is_object_edge(first_sample + sample_offset(start), end_sample);
    }
    code |= select(0u, 1u << edge, is_edge);
  }
  return code;
}

// `cell_entry_bits` with `depth_map.spread`: a triangle is also drawn if one of its samples is at the end of a marked edge
// and not far.
fn spread_entry_bits(first_sample: vec2<u32>) -> u32 {
  let keys = load_cell_keys(first_sample);
  let code = edges_in_and_around(first_sample, keys);
  // A bit for each sample that is at the end of a marked edge and not far.
  var edge_ends = 0u;
  for (var index = 0u; index < 4u; index++) {
    // Two edges of the cell and two out of it.
    let edges_at_sample = ((0x6c39u >> (4u * index)) & 15u) | (0x30u << (2u * index));
    edge_ends |= select(0u, 1u << index, (code & edges_at_sample) != 0u && keys[index] != FAR_KEY);
  }
  // The three samples of each triangle.
  let split = is_split(keys);
  let ends_of_first = edge_ends & select(11u, 7u, split);
  let ends_of_second = edge_ends & select(13u, 14u, split);
  return entry_bits(code, split) | select(0u, FIRST_TRIANGLE, ends_of_first != 0u)
    | select(0u, SECOND_TRIANGLE, ends_of_second != 0u);
}

// The three bits of a cell's entry, from its first sample.
fn cell_entry_bits(first_sample: vec2<u32>) -> u32 {
  if (SPREADS && depth_map.spread != 0u) {
    return spread_entry_bits(first_sample);
  }
  let keys = load_cell_keys(first_sample);
  return entry_bits(edge_code(first_sample, keys), is_split(keys));
}

// Sample (0, 0) of a cell.
fn first_sample_of_cell(cell: u32) -> vec2<u32> {
  if (depth_map.faces > 1u) {
    let side = depth_map.size.x - 1u;
    let face = cell / (side * side);
    let cell_in_map = cell % (side * side);
    return vec2<u32>(face % 3u, face / 3u) * depth_map.size.x + vec2<u32>(cell_in_map % side, cell_in_map / side);
  }
  let cells_per_row = depth_map.size.x + 1u;
  return vec2<u32>(cell % cells_per_row, cell / cells_per_row);
}

fn load_cell_keys(first_sample: vec2<u32>) -> vec4<u32> {
  return vec4<u32>(
    load_key(first_sample), load_key(first_sample + vec2<u32>(1u, 0u)), load_key(first_sample + vec2<u32>(0u, 1u)),
    load_key(first_sample + vec2<u32>(1u, 1u)));
}

// The entry of a cell, decided anew.
fn entry_of_cell(cell: u32) -> u32 {
  return cell | cell_entry_bits(first_sample_of_cell(cell));
}
