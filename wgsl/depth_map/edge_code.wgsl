// Decides about cells: which of a cell's four edges between samples are marked (a border of shadow may cross them), along which
// diagonal it is split, and which of its two triangles are drawn. Also exact comparisons of a depth difference with a threshold.
// Imported by the stages that list cells (`depth_cells`; `depth_edges` and edge_rule.wgsl, which mark edges in their own way), by
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
fn differs(a: vec2<u32>, b: vec2<u32>) -> bool {
  return object_at(a) != object_at(b);
}

// Edges of objects at the top, right and bottom of a cell whose samples on the right are `at` and the one below. `before` and
// `keys` are those of its samples on the left and on the right, from the top. An edge of a far sample is marked already, or lies
// between two.
fn object_edges(at: vec2<u32>, before: vec2<u32>, keys: vec2<u32>) -> u32 {
  if (depth_map.objects == 0u) {
    return 0u;
  }
  let left = at - vec2<u32>(1u, 0u);
  let down = vec2<u32>(0u, 1u);
  let was_far = before == vec2<u32>(FAR_KEY);
  let is_far = keys == vec2<u32>(FAR_KEY);
  return select(0u, 1u, !(was_far.x || is_far.x) && differs(left, at))
    | select(0u, 2u, !(is_far.x || is_far.y) && differs(at, at + down))
    | select(0u, 4u, !(was_far.y || is_far.y) && differs(left + down, at + down));
}

// Bits: the edges of the cell at the top, right, bottom and left. `keys` are those of samples (0, 0), (1, 0), (0, 1) and (1, 1).
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

// Bits of triangles that are drawn, where `others` are those of the other triangle of each cell: with `whole_cells` either draws
// both.
fn either(triangles: u32, others: u32) -> u32 {
  return triangles | select(0u, others, depth_map.whole_cells != 0u);
}

// A triangle is drawn if one of its edges that lie on the border of the cell is marked. The bits of an entry.
fn template_bits(code: u32, split: bool) -> u32 {
  let first = select(3u, 9u, split);
  return select(0u, SPLIT, split) | select(0u, FIRST_TRIANGLE, either(code & first, code & (15u - first)) != 0u)
    | select(0u, SECOND_TRIANGLE, either(code & (15u - first), code & first) != 0u);
}

// The samples (0, 0), (1, 0), (0, 1) and (1, 1) of a cell by their numbers.
fn sample_of_cell(number: u32) -> vec2<u32> {
  return vec2<u32>(number & 1u, number >> 1u);
}

// Bits 0 to 3 are those of `edge_code`. Bits 4 to 11: the edges from each of its samples out of the cell, two each: to the left
// or right, then up or down.
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
      key = key_at(there);
    }
    var is_edge = is_marked(keys[first], key);
    if (OBJECTS && depth_map.objects != 0u && keys[first] != FAR_KEY && key != FAR_KEY) {
      is_edge = is_edge || differs(at + sample_of_cell(first), there);
    }
    code |= select(0u, 1u << edge, is_edge);
  }
  return code;
}

// `templates` with `spread`: a triangle is drawn, too, if one of its samples is not far and at the end of a marked edge.
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
  return template_bits(code, split) | select(0u, FIRST_TRIANGLE, either(first, second) != 0u)
    | select(0u, SECOND_TRIANGLE, either(second, first) != 0u);
}

// The three bits of a cell's entry, from its sample (0, 0).
fn templates(at: vec2<u32>) -> u32 {
  if (SPREADS && depth_map.spread != 0u) {
    return spread_templates(at);
  }
  let keys = keys_of_cell(at);
  return template_bits(edge_code(at, keys), is_split(keys));
}

// Sample (0, 0) of a cell.
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

// The entry of a cell, listed or not.
fn entry_of_cell(cell: u32) -> u32 {
  return cell | templates(corner_of_cell(cell));
}

// Whether two depths of a perspective map are farther from each other than a distance in world units, exactly: the sign of
// ratio · |a − b| − |a − i| · |b − i|, with the depth i at infinity. docs/numerics/depth-maps.md.

// Words of an integer in units of 2⁻²⁹⁸, lowest first, negative as two's complement.
const WIDE: u32 = 14u;
// Products of a sum.
const TERMS: u32 = 6u;
const MINUS: u32 = 0x80000000u;

// The mantissa of a float that is 0 or normal, and how many places it is moved up, in units of 2⁻¹⁴⁹.
fn mantissa_and_places(bits: u32) -> vec2<u32> {
  let exponent = (bits >> 23u) & 0xffu;
  return vec2<u32>(select((bits & 0x7fffffu) | 0x800000u, 0u, exponent == 0u), max(exponent, 1u) - 1u);
}

// The product of two numbers below 2²⁴: low and high word.
fn wide_product(a: u32, b: u32) -> vec2<u32> {
  let low = (a & 0xffffu) * (b & 0xffffu);
  let middle = (a & 0xffffu) * (b >> 16u) + (a >> 16u) * (b & 0xffffu);
  let sum = low + (middle << 16u);
  return vec2<u32>(sum, (a >> 16u) * (b >> 16u) + (middle >> 16u) + select(0u, 1u, sum < low));
}

// Whether a sum of products of two floats is above 0.
fn is_positive(terms: array<vec2<u32>, TERMS>) -> bool {
  var factors = terms;
  var sum = array<u32, WIDE>();
  for (var term = 0u; term < opaque(TERMS); term++) {
    let own = factors[term];
    let a = mantissa_and_places(own.x);
    let b = mantissa_and_places(own.y);
    let mantissa = wide_product(a.x, b.x);
    let first = (a.y + b.y) >> 5u;
    let shift = (a.y + b.y) & 31u;
    let carried = vec2<u32>(32u - shift) & vec2<u32>(31u);
    let over = select(mantissa >> carried, vec2<u32>(0u), shift == 0u);
    let digits = vec3<u32>(mantissa.x << shift, (mantissa.y << shift) | over.x, over.y);
    // A negative product is added as the complement, and one.
    let sign = (own.x ^ own.y) >> 31u;
    var carry = sign;
    for (var word = 0u; word < opaque(WIDE); word++) {
      let at = word - first;
      let digit = select(select(select(0u, digits.z, at == 2u), digits.y, at == 1u), digits.x, at == 0u) ^ (0u - sign);
      let once = sum[word] + digit;
      let twice = once + carry;
      carry = select(0u, 1u, once < digit) | select(0u, 1u, twice < once);
      sum[word] = twice;
    }
  }
  var any = 0u;
  for (var word = 0u; word < opaque(WIDE); word++) {
    any |= sum[word];
  }
  return any != 0u && sum[WIDE - 1u] < MINUS;
}

// Whether a is below b: floats that are 0 or normal, and b may be negative.
fn is_below(a: u32, b: u32) -> bool {
  return b < MINUS && a < b;
}

// Whether the sign above is positive. Bits of the depths a and b, the ratio, and the depth at infinity.
fn exact_world_step(a: u32, b: u32, ratio: u32, infinity: u32) -> bool {
  // (a − i) (b − i) is negative if i is between them.
  let turned = select(0u, MINUS, is_below(a, infinity) != is_below(b, infinity));
  return is_positive(array<vec2<u32>, TERMS>(
    vec2<u32>(ratio, max(a, b)), vec2<u32>(ratio, min(a, b) | MINUS),
    vec2<u32>(a, b ^ MINUS ^ turned), vec2<u32>(infinity, a ^ turned), vec2<u32>(infinity, b ^ turned),
    vec2<u32>(infinity, infinity ^ MINUS ^ turned)));
}

// `exact_world_step` by floats: 0 or 1; or 2, where the terms are nearly equal, very large or very small.
fn world_step_by_floats(a: u32, b: u32, ratio: u32, infinity: u32) -> u32 {
  let depth_there = bitcast<f32>(infinity);
  let step = bitcast<f32>(ratio) * abs(bitcast<f32>(a) - bitcast<f32>(b));
  let most = abs(bitcast<f32>(a) - depth_there) * abs(bitcast<f32>(b) - depth_there);
  let is_plain = (min(step, most) > 1e-30) & (max(step, most) < 1e30);
  let is_told = is_plain & ((step > 1.0001 * most) | (most > 1.0001 * step));
  // Equal depths are no step, whatever the ratio is.
  return select(select(2u, select(0u, 1u, step > most), is_told), 0u, a == b);
}
