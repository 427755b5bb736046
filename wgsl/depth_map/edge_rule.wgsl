// The rule by which an edge between two samples is marked: from first differences, or from these and those beside them. Both are
// decided exactly. docs/numerics/depth-maps.md.

#import depth_map/edge_code
#import depth_map/samples

// How edges are marked. Of two values, the second is that next to the end of a marked edge.
struct DepthEdgeRule {
  // Words of a row, and rows.
  words: vec2<u32>,
  // Blocks of 256 words.
  blocks: u32,
  // Bits of what every larger difference is marked above.
  high: u32,
  // Bits of what every smaller difference is not marked below.
  low: vec2<u32>,
  // Bits of how many units of depth × distance² make the threshold in world units. 0: the threshold is one of device depth.
  ratio: vec2<u32>,
  // Bits of how many times the difference beside it a difference is.
  slopes: vec2<u32>,
  // Bits of what two differences are off by: a constant, and the depth with so many exponents less. 0: no share of the depth.
  noise: u32,
  noise_exponents: u32,
  // Bits of the depth at infinity, which may be slightly out of range.
  at_infinity: u32,
  // 0.
  unused: u32,
}

@group(0) @binding(6) var<uniform> edge_rule: DepthEdgeRule;

// What second differences tell. 0: nothing, all above the threshold are marked. 1: a difference is marked that is larger than
// both beside it. 2: one that is larger than one of them, with no other threshold.
override SECOND: u32 = 0u;

// Whether thresholds may be steps in world units.
override WORLD: bool = false;

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

// As `bends_by_floats`, of one side, exactly: the ends of the edge, and of the step beside it.
fn bends(ends: vec2<u32>, beside: vec2<u32>, slopes: u32) -> bool {
  let noise = noise_at(max(ends.x, ends.y));
  return is_positive(array<vec2<u32>, TERMS>(
    vec2<u32>(ONE, max(ends.x, ends.y)), vec2<u32>(ONE, min(ends.x, ends.y) | MINUS),
    vec2<u32>(slopes, max(beside.x, beside.y) | MINUS), vec2<u32>(slopes, min(beside.x, beside.y)),
    vec2<u32>(ONE, noise | MINUS), vec2<u32>(0u)));
}

// Whether an edge is marked: 0 or 1; or 2, where it is left to `exactly`. `level`: 1 next to the end of a marked edge.
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
    if (WORLD) {
      let ratio = edge_rule.ratio[level];
      state = select(state, world_step_by_floats(ends.x, ends.y, ratio, edge_rule.at_infinity), ratio != 0u);
    }
  }
  return select(state, select(0u, 1u, keys.y != keys.z), max(keys.y, keys.z) == FAR_KEY || keys.y == keys.z);
}

// As `told`, where it does not tell.
fn exactly(keys: vec4<u32>, level: u32) -> bool {
  let ends = vec2<u32>(depth_bits(keys.y), depth_bits(keys.z));
  var is_step = false;
  // The ratio is the same for all invocations.
  // Turns: of one branch.
  if (WORLD && edge_rule.ratio[level] != 0u) {
    is_step = exact_world_step(ends.x, ends.y, edge_rule.ratio[level], edge_rule.at_infinity);
  } else {
    var count = 0u;
    for (var side = 0u; side < opaque(2u); side++) {
      count += select(0u, 1u, bends(ends, step_beside(keys, side == 1u), edge_rule.slopes[level]));
    }
    is_step = count >= select(1u, 2u, SECOND == 1u);
  }
  return is_step;
}
