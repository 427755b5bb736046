// The rules by which `depth_edges` marks an edge, for detectors that look beside an edge (second differences) or continue
// edges. No other stage imports it.
// `edge_state` uses floats, and decides only where their rounding cannot matter: 0 or 1. Elsewhere it returns 2, and
// `is_marked_exact` decides by integers. So marks are exact and the same on every device (docs/numerics/depth-maps.md,
// "Exact decisions"). Change both functions only together. Neither knows objects (edge_strips.wgsl). Level 0 is the
// detector's own rule. Level 1 has lower thresholds and factors, for edges that continue a dangling one.

#import depth_map/edge_code
#import depth_map/samples

// How edges are marked. Thresholds and factors in pairs have a value for each level.
struct DepthEdgeRule {
  // Words of marks in a row of samples, and rows.
  words: vec2<u32>,
  // Blocks of 256 words.
  blocks: u32,
  // Bits of the threshold above which every difference is marked, if SECOND is 1. It is the same at both levels.
  high_threshold: u32,
  // Bits of the threshold up to which no difference is marked.
  low_thresholds: vec2<u32>,
  // Bits of the factor by which a difference must be larger than the difference beside it.
  slopes: vec2<u32>,
  // A difference may be off by a constant or by a share of its larger depth, if that is more. The bits of the constant:
  noise: u32,
  // The share is this depth with its exponent lowered by so much. 0: there is only the constant.
  noise_exponents: u32,
}

@group(0) @binding(6) var<uniform> edge_rule: DepthEdgeRule;

// How the differences beside an edge count, those to the samples before and after it in its row or column. 0: not at all;
// the low threshold decides. 1: between both thresholds a difference must be larger than both beside it, times the factor
// and with the noise. 2: it must be so much larger than one of them, and there are no thresholds.
override SECOND: u32 = 0u;

// Words of a wide integer in units of 2⁻²⁹⁸, lowest first, in two's complement.
const WIDE: u32 = 14u;
// Products of a sum.
const TERMS: u32 = 5u;
// The sign bit.
const MINUS: u32 = 0x80000000u;

// The mantissa of a float that is 0 or normal (x), and its shift up in units of 2⁻¹⁴⁹ (y).
fn mantissa_and_shift(bits: u32) -> vec2<u32> {
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

// Whether a sum of products of two floats is above 0, exactly. Products must be below 2^146, so that the sum fits WIDE words.
fn is_positive(terms: array<vec2<u32>, TERMS>) -> bool {
  var factors = terms;
  var sum = array<u32, WIDE>();
  for (var term = 0u; term < opaque(TERMS); term++) {
    let pair = factors[term];
    let a = mantissa_and_shift(pair.x);
    let b = mantissa_and_shift(pair.y);
    let mantissa = wide_product(a.x, b.x);
    let first_word = (a.y + b.y) >> 5u;
    let shift = (a.y + b.y) & 31u;
    let shift_of_carried = vec2<u32>(32u - shift) & vec2<u32>(31u);
    let carried = select(mantissa >> shift_of_carried, vec2<u32>(0u), shift == 0u);
    let digits = vec3<u32>(mantissa.x << shift, (mantissa.y << shift) | carried.x, carried.y);
    // A negative product is added as its complement and 1.
    let sign = (pair.x ^ pair.y) >> 31u;
    var carry = sign;
    for (var word = 0u; word < opaque(WIDE); word++) {
      let index = word - first_word;
      let digit =
        select(select(select(0u, digits.z, index == 2u), digits.y, index == 1u), digits.x, index == 0u) ^ (0u - sign);
      let with_digit = sum[word] + digit;
      let with_carry = with_digit + carry;
      carry = select(0u, 1u, with_digit < digit) | select(0u, 1u, with_carry < with_digit);
      sum[word] = with_carry;
    }
  }
  var any = 0u;
  for (var word = 0u; word < opaque(WIDE); word++) {
    any |= sum[word];
  }
  return any != 0u && sum[WIDE - 1u] < MINUS;
}

// Whether one or more steps to the right or down lead out of a map of a cube.
fn leaves_map(sample: vec2<u32>, step: vec2<u32>) -> bool {
  return depth_map.faces > 1u && any(sample % depth_map.size + step >= depth_map.size);
}

// Keys of the samples before an edge, at its two ends and after it. Beside a map of a cube nothing casts.
fn keys_along(sample: vec2<u32>, step: vec2<u32>) -> vec4<u32> {
  let before = select(load_key(sample - step), FAR_KEY, depth_map.faces > 1u && any(sample % depth_map.size < step));
  let after = select(load_key(sample + 2u * step), FAR_KEY, leaves_map(sample, 2u * step));
  return vec4<u32>(before, load_key(sample), load_key(sample + step), after);
}

// Bits of the error that the difference of two depths may have. `large`: bits of the larger depth.
fn noise_bits(large: u32) -> u32 {
  let exponents = edge_rule.noise_exponents << 23u;
  let share = select(0u, large - exponents, exponents != 0u && large >= exponents + 0x00800000u);
  return max(edge_rule.noise, share);
}

// Bits of the depths at both ends of the step before an edge, or after it, by `keys_along`. (0, 0) if the step rises the
// other way than the edge, or one of its ends is far.
fn adjacent_step(keys: vec4<u32>, is_after: bool) -> vec2<u32> {
  let beside = select(keys.xy, keys.zw, is_after);
  let same_way = (beside.x < beside.y) == (keys.y < keys.z);
  return select(
    vec2<u32>(0u), vec2<u32>(depth_bits(beside.x), depth_bits(beside.y)), same_way && max(beside.x, beside.y) != FAR_KEY);
}

fn float_difference(bits: vec2<u32>) -> f32 {
  return abs(bitcast<f32>(bits.x) - bitcast<f32>(bits.y));
}

// Whether the difference at an edge exceeds both differences beside it, or one of them, times a factor, and the noise. 0 no,
// 1 yes, 2 if float rounding might matter. `ends`: bits of the depths at the edge. `factor`: bits, too.
fn exceeds_slopes_by_floats(keys: vec4<u32>, ends: vec2<u32>, factor: u32) -> u32 {
  let before = float_difference(adjacent_step(keys, false));
  let after = float_difference(adjacent_step(keys, true));
  let difference = float_difference(ends);
  let beside = select(max(before, after), min(before, after), SECOND == 2u);
  let limit = bitcast<f32>(factor) * beside + bitcast<f32>(noise_bits(max(ends.x, ends.y)));
  let is_certain = (difference + limit > 1e-30) & (abs(difference - limit) > 1e-5 * (difference + limit));
  return select(2u, select(0u, 1u, difference > limit), is_certain);
}

// The same for the difference on one side, exactly. `beside`: bits of the depths at the ends of the step there.
fn exceeds_slope_exact(ends: vec2<u32>, beside: vec2<u32>, factor: u32) -> bool {
  let noise = noise_bits(max(ends.x, ends.y));
  return is_positive(array<vec2<u32>, TERMS>(
    vec2<u32>(ONE, max(ends.x, ends.y)), vec2<u32>(ONE, min(ends.x, ends.y) | MINUS),
    vec2<u32>(factor, max(beside.x, beside.y) | MINUS), vec2<u32>(factor, min(beside.x, beside.y)),
    vec2<u32>(ONE, noise | MINUS)));
}

// Whether an edge is marked, by `keys_along`: 0 no, 1 yes, 2 if only `is_marked_exact` can decide.
fn edge_state(keys: vec4<u32>, level: u32) -> u32 {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  let large = max(ends.x, ends.y);
  let small = min(ends.x, ends.y);
  var state = 2u;
  if (SECOND == 2u) {
    state = exceeds_slopes_by_floats(keys, ends, edge_rule.slopes[level]);
  } else {
    let is_step = exceeds(large, small, edge_rule.low_thresholds[level]);
    state = select(0u, 1u, is_step);
    if (SECOND == 1u) {
      let is_decided = !is_step || exceeds(large, small, edge_rule.high_threshold);
      state = select(exceeds_slopes_by_floats(keys, ends, edge_rule.slopes[level]), state, is_decided);
    }
  }
  return select(state, select(0u, 1u, keys.y != keys.z), max(keys.y, keys.z) == FAR_KEY || keys.y == keys.z);
}

// Whether an edge is marked for which `edge_state` is 2. So neither sample is far, their keys differ, and if SECOND is 1 the
// difference is between both thresholds: these are not tested again.
fn is_marked_exact(keys: vec4<u32>, level: u32) -> bool {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  var exceeded_sides = 0u;
  for (var side = 0u; side < opaque(2u); side++) {
    exceeded_sides += select(0u, 1u, exceeds_slope_exact(ends, adjacent_step(keys, side == 1u), edge_rule.slopes[level]));
  }
  return exceeded_sides >= select(1u, 2u, SECOND == 1u);
}
