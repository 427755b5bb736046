// Decides about cells: which of a cell's four edges between samples are marked (a border of shadow may cross them), along
// which diagonal it is split, and which of its two triangles are drawn. Also exact comparisons of a depth difference with a
// threshold. Imported by the stages that list cells (`depth_cells`; `depth_edges`, which marks edges in its own way), by
// `contour_marks` for objects, and by the draws (`depth_surface`, surface.wgsl), which decide anew where the list overflowed.
// Importers bind what samples.wgsl has, and `object_texture`.
// A mark depends on the two samples of its edge alone, so both cells of an edge agree. A triangle with a marked edge is always
// drawn; drawing more is right, drawing less leaves gaps in the shadow. Integers decide wherever float rounding might matter.

#import depth_map/samples

// An entry of the list of cells: the index of the cell, and these bits.
const CELL_MASK: u32 = 0x1fffffffu;
// The cell is split from sample (1, 0) to (0, 1), not from (0, 0) to (1, 1).
const SPLIT: u32 = 0x20000000u;
const FIRST_TRIANGLE: u32 = 0x40000000u;
const SECOND_TRIANGLE: u32 = 0x80000000u;

// Whether edges of objects may count. A pipeline without them is smaller.
override OBJECTS: bool = true;

// Whether triangles at the ends of marked edges may be drawn, too.
override SPREADS: bool = true;

// For each texel the object that is seen there. One texel, if edges of objects do not count.
@group(0) @binding(4) var object_texture: texture_2d<u32>;

// The mantissa of a float that is 0, or positive and not subnormal.
fn mantissa(bits: u32) -> u32 {
  return select((bits & 0x7fffffu) | 0x800000u, 0u, bits == 0u);
}

// A mantissa with 32 further bits, moved down by `places`: high and low word. Without branches, which some devices take all.
fn moved_down(word: u32, places: u32) -> vec2<u32> {
  let low = select(word << ((32u - places) & 31u), word >> min(places - 32u, 31u), places >= 32u);
  return vec2<u32>(word >> min(places, 31u), select(low, 0u, places == 0u));
}

// Whether `large` is more than `small` + `threshold`, exactly: bits of numbers from 0 to 1, none subnormal, small <= large.
// The bits that the moves cut off cannot change the result (?).
fn exceeds(large: u32, small: u32, threshold: u32) -> bool {
  let exponent = large >> 23u;
  let a = moved_down(mantissa(small), exponent - (small >> 23u));
  let b = moved_down(mantissa(threshold), exponent - (threshold >> 23u));
  let low = a.y + b.y;
  let high = a.x + b.x + select(0u, 1u, low < a.y);
  return (threshold < large) & (mantissa(large) > high);
}

// Whether the edge between two samples is marked, by their keys. `every_cell` marks all but those between two far samples.
fn is_marked(a: u32, b: u32) -> bool {
  // Not used for far samples.
  let depths = vec2<u32>(depth_bits(a), depth_bits(b));
  let is_step = exceeds(max(depths.x, depths.y), min(depths.x, depths.y), depth_map.threshold);
  return select(is_step | (depth_map.every_cell != 0u), a != b, max(a, b) == FAR_KEY);
}

// Bits: the edges at the top, right and bottom of a cell, whose samples on the left are `before` and on the right `keys`, from
// the top.
fn edges_on_the_right(before: vec2<u32>, keys: vec2<u32>) -> u32 {
  let marked = vec3<bool>(is_marked(before.x, keys.x), is_marked(keys.x, keys.y), is_marked(before.y, keys.y));
  let bits = select(vec3<u32>(0u), vec3<u32>(1u, 2u, 4u), marked);
  return bits.x | bits.y | bits.z;
}

fn key_distance(a: u32, b: u32) -> u32 {
  return max(a, b) - min(a, b);
}

// The object at a sample that is not far. In a cube, maps have no border.
fn object_at(at: vec2<u32>) -> u32 {
  return textureLoad(object_texture, vec2<i32>(at) - select(1, 0, depth_map.faces > 1u), 0).x;
}

// Whether objects at two samples, neither of them far, differ.
fn is_object_edge(a: vec2<u32>, b: vec2<u32>) -> bool {
  return object_at(a) != object_at(b);
}

// Edges of objects at the top, right and bottom of a cell whose samples on the right are `at` and the one below. `before` and
// `keys` are those of its samples on the left and on the right, from the top. An edge of a far sample is marked already, or
// lies between two.
fn object_edges(at: vec2<u32>, before: vec2<u32>, keys: vec2<u32>) -> u32 {
  if (depth_map.objects == 0u) {
    return 0u;
  }
  let left = at - vec2<u32>(1u, 0u);
  let down = vec2<u32>(0u, 1u);
  let was_far = before == vec2<u32>(FAR_KEY);
  let is_far = keys == vec2<u32>(FAR_KEY);
  return select(0u, 1u, !(was_far.x || is_far.x) && is_object_edge(left, at))
    | select(0u, 2u, !(is_far.x || is_far.y) && is_object_edge(at, at + down))
    | select(0u, 4u, !(was_far.y || is_far.y) && is_object_edge(left + down, at + down));
}

// Bits: the edges of the cell at the top, right, bottom and left. `keys` are those of samples (0, 0), (1, 0), (0, 1) and (1,
// 1).
fn edge_code(at: vec2<u32>, keys: vec4<u32>) -> u32 {
  let code = edges_on_the_right(keys.xz, keys.yw) | select(0u, 8u, is_marked(keys.x, keys.z));
  if (!OBJECTS) {
    return code;
  }
  let of_objects = object_edges(at, vec2<u32>(FAR_KEY), keys.xz) & 2u;
  return code | object_edges(at + vec2<u32>(1u, 0u), keys.xz, keys.yw) | (of_objects << 2u);
}

// Whether a cell is split from sample (1, 0) to (0, 1): the keys of the other diagonal differ more. It only shapes the border.
fn is_split(keys: vec4<u32>) -> bool {
  return key_distance(keys.x, keys.w) > key_distance(keys.y, keys.z);
}

// A triangle is drawn if one of its edges that lie on the border of the cell is marked. The bits of an entry.
fn template_bits(code: u32, split: bool) -> u32 {
  let first = select(3u, 9u, split);
  return select(0u, SPLIT, split) | select(0u, FIRST_TRIANGLE, (code & first) != 0u)
    | select(0u, SECOND_TRIANGLE, (code & (15u - first)) != 0u);
}

// The samples (0, 0), (1, 0), (0, 1) and (1, 1) of a cell by their numbers.
fn sample_of_cell(number: u32) -> vec2<u32> {
  return vec2<u32>(number & 1u, number >> 1u);
}

// Bits 0 to 3 are those of `edge_code`. Bits 4 to 11: the edges from each of its samples out of the cell, two each: to the
// left or right, then up or down.
fn edges_around(at: vec2<u32>, keys: vec4<u32>) -> u32 {
  var code = 0u;
  // A loop that is not unrolled has one copy of what decides.
  for (var edge = 0u; edge < opaque(12u); edge++) {
    // The ends of the edges of the cell, by two bits each.
    var first = (0x24u >> (2u * edge)) & 3u;
    let end = (0xbdu >> (2u * edge)) & 3u;
    var there = at + sample_of_cell(end);
    var key = keys[end];
    if (edge >= 4u) {
      first = (edge - 4u) / 2u;
      let out = sample_of_cell(first) * 2u - 1u;
      there = at + sample_of_cell(first) + select(vec2<u32>(0u, out.y), vec2<u32>(out.x, 0u), edge % 2u == 0u);
      key = load_key(there);
    }
    var is_edge = is_marked(keys[first], key);
    if (OBJECTS && depth_map.objects != 0u && keys[first] != FAR_KEY && key != FAR_KEY) {
      is_edge = is_edge || is_object_edge(at + sample_of_cell(first), there);
    }
    code |= select(0u, 1u << edge, is_edge);
  }
  return code;
}

// `cell_entry_bits` with `spread`: a triangle is drawn, too, if one of its samples is not far and at the end of a marked edge.
fn spread_templates(at: vec2<u32>) -> u32 {
  let keys = keys_of_cell(at);
  let code = edges_around(at, keys);
  var ends = 0u;
  for (var number = 0u; number < 4u; number++) {
    // Two edges of the cell and two out of it.
    let own = ((0x6c39u >> (4u * number)) & 15u) | (0x30u << (2u * number));
    ends |= select(0u, 1u << number, (code & own) != 0u && keys[number] != FAR_KEY);
  }
  // By the three samples of each.
  let split = is_split(keys);
  let first = ends & select(11u, 7u, split);
  let second = ends & select(13u, 14u, split);
  return template_bits(code, split) | select(0u, FIRST_TRIANGLE, first != 0u)
    | select(0u, SECOND_TRIANGLE, second != 0u);
}

// The three bits of a cell's entry, from its sample (0, 0).
fn cell_entry_bits(at: vec2<u32>) -> u32 {
  if (SPREADS && depth_map.spread != 0u) {
    return spread_templates(at);
  }
  let keys = keys_of_cell(at);
  return template_bits(edge_code(at, keys), is_split(keys));
}

// Sample (0, 0) of a cell.
fn first_sample_of_cell(cell: u32) -> vec2<u32> {
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
    load_key(at), load_key(at + vec2<u32>(1u, 0u)), load_key(at + vec2<u32>(0u, 1u)), load_key(at + vec2<u32>(1u, 1u)));
}

// The entry of a cell, listed or not.
fn entry_of_cell(cell: u32) -> u32 {
  return cell | cell_entry_bits(first_sample_of_cell(cell));
}
