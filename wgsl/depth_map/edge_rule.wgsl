// The rule of detectors that look beside an edge (second differences) or continue edges.
// Imported by `depth_edges` alone, which gives it keys: samples as integers that grow with the distance from the light.
// `told` decides by floats, only where rounding cannot matter: 0 or 1. Where it may, it gives 2, and the caller asks `exactly`,
// which decides by integers. So marks are exact and the same on every device. Only the two together may be changed.
// Level 0 is the detector's own rule. Level 1 has lower thresholds, for edges that continue one that dangles: one that ends in a
// cell without another marked edge. ?.

#import depth_map/edge_code
#import depth_map/samples

// How edges are marked. Pairs have a value for each level.
struct DepthEdgeRule {
  // Words of marks in a row of samples, and rows.
  words: vec2<u32>,
  // Blocks of 256 words.
  blocks: u32,
  // Bits of the threshold above which every difference is marked.
  high: u32,
  // Bits of the threshold up to which no difference is marked.
  low: vec2<u32>,
  // Bits of how many times the difference beside it a difference is.
  slopes: vec2<u32>,
  // Bits of what two differences may be off by: a constant, and the depth with so many exponents less. 0: no share of the depth.
  noise: u32,
  noise_exponents: u32,
}

@group(0) @binding(6) var<uniform> edge_rule: DepthEdgeRule;

// How the differences beside an edge, in its row or column, count. 0: not, all above the threshold are marked. 1: a difference is
// marked that is larger than both beside it. 2: one that is larger than one of them, with no other threshold.
override SECOND: u32 = 0u;

// Words of an integer in units of 2⁻²⁹⁸, lowest first, negative as two's complement.
const WIDE: u32 = 14u;
// Products of a sum.
const TERMS: u32 = 5u;
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

// Samples of the lattice across, and down.
fn lattice() -> vec2<u32> {
  return select(depth_map.size + 2u, vec2<u32>(3u, 2u) * depth_map.size, depth_map.faces > 1u);
}

// Whether a step to the right or down leads to another map of a cube.
fn leaves_map(at: vec2<u32>, by: vec2<u32>) -> bool {
  return depth_map.faces > 1u && any(at % depth_map.size + by >= depth_map.size);
}

// The samples before an edge, at its ends and after it, from left to right or from the top. Beside a map nothing casts.
fn keys_along(at: vec2<u32>, step: vec2<u32>) -> vec4<u32> {
  let before = select(key_at(at - step), FAR_KEY, depth_map.faces > 1u && any(at % depth_map.size < step));
  let after = select(key_at(at + 2u * step), FAR_KEY, leaves_map(at, 2u * step));
  return vec4<u32>(before, key_at(at), key_at(at + step), after);
}

// Bits of what the difference of two depths may be off by. `large`: bits of the larger.
fn noise_at(large: u32) -> u32 {
  let exponents = edge_rule.noise_exponents << 23u;
  let share = select(0u, large - exponents, exponents != 0u && large >= exponents + 0x00800000u);
  return max(edge_rule.noise, share);
}

// The two ends of the step before an edge, or after it. They are equal if it goes the other way than the edge, or a side is far.
fn step_beside(keys: vec4<u32>, is_after: bool) -> vec2<u32> {
  let beside = select(keys.xy, keys.zw, is_after);
  let same_way = (beside.x < beside.y) == (keys.y < keys.z);
  return select(vec2<u32>(0u), vec2<u32>(depth_bits(beside.x), depth_bits(beside.y)), same_way && max(beside.x, beside.y) != FAR_KEY);
}

fn float_distance(bits: vec2<u32>) -> f32 {
  return abs(bitcast<f32>(bits.x) - bitcast<f32>(bits.y));
}

// Whether the difference at an edge is larger than multiples of both beside it, or of one, and noise: 0 or 1; or 2, where floats
// do not tell.
fn bends_by_floats(keys: vec4<u32>, ends: vec2<u32>, slopes: u32) -> u32 {
  let before = float_distance(step_beside(keys, false));
  let after = float_distance(step_beside(keys, true));
  let step = float_distance(ends);
  let beside = select(max(before, after), min(before, after), SECOND == 2u);
  let most = bitcast<f32>(slopes) * beside + bitcast<f32>(noise_at(max(ends.x, ends.y)));
  let is_told = (step + most > 1e-30) & (abs(step - most) > 1e-5 * (step + most));
  return select(2u, select(0u, 1u, step > most), is_told);
}

// `bends_by_floats` for one side, exactly: bits of the ends of the edge, and of the step beside it.
fn bends(ends: vec2<u32>, beside: vec2<u32>, slopes: u32) -> bool {
  let noise = noise_at(max(ends.x, ends.y));
  return is_positive(array<vec2<u32>, TERMS>(
    vec2<u32>(ONE, max(ends.x, ends.y)), vec2<u32>(ONE, min(ends.x, ends.y) | MINUS),
    vec2<u32>(slopes, max(beside.x, beside.y) | MINUS), vec2<u32>(slopes, min(beside.x, beside.y)),
    vec2<u32>(ONE, noise | MINUS)));
}

// Whether an edge is marked, by the keys of `keys_along`: 0 or 1; or 2, where it is left to `exactly`.
fn told(keys: vec4<u32>, level: u32) -> u32 {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  let large = max(ends.x, ends.y);
  let small = min(ends.x, ends.y);
  var state = 2u;
  if (SECOND == 2u) {
    state = bends_by_floats(keys, ends, edge_rule.slopes[level]);
  } else {
    let is_step = exceeds(large, small, edge_rule.low[level]);
    state = select(0u, 1u, is_step);
    if (SECOND == 1u) {
      let is_sure = !is_step || exceeds(large, small, edge_rule.high);
      state = select(bends_by_floats(keys, ends, edge_rule.slopes[level]), state, is_sure);
    }
  }
  return select(state, select(0u, 1u, keys.y != keys.z), max(keys.y, keys.z) == FAR_KEY || keys.y == keys.z);
}

// Whether an edge is marked for which `told` gives 2. It is never asked for far samples or equal keys.
fn exactly(keys: vec4<u32>, level: u32) -> bool {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  var count = 0u;
  for (var side = 0u; side < opaque(2u); side++) {
    count += select(0u, 1u, bends(ends, step_beside(keys, side == 1u), edge_rule.slopes[level]));
  }
  return count >= select(1u, 2u, SECOND == 1u);
}
