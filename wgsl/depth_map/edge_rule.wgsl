// The rule of detectors that look beside an edge (second differences), continue edges, or have a threshold in world units.
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
  // Bits of how many units of depth × distance² make the threshold in world units. 0: the threshold is one of device depth.
  ratio: vec2<u32>,
  // Bits of the factor by which a difference has to exceed one beside it.
  slopes: vec2<u32>,
  // Bits of what two differences may be off by: a constant, and the depth with so many exponents less. 0: no share of the depth.
  noise: u32,
  noise_exponents: u32,
  // Bits of the depth at infinity, which may be slightly out of range.
  at_infinity: u32,
  // 0.
  unused: u32,
}

@group(0) @binding(6) var<uniform> edge_rule: DepthEdgeRule;

// How the differences beside an edge, in its row or column, count. 0: not, all above the threshold are marked. 1: a difference is
// marked that is larger than both beside it. 2: one that is larger than one of them, with no other threshold.
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

// `bends_by_floats` for one side, exactly: bits of the ends of the edge, and of the step beside it.
fn bends(ends: vec2<u32>, beside: vec2<u32>, slopes: u32) -> bool {
  let noise = noise_at(max(ends.x, ends.y));
  return is_positive(array<vec2<u32>, TERMS>(
    vec2<u32>(ONE, max(ends.x, ends.y)), vec2<u32>(ONE, min(ends.x, ends.y) | MINUS),
    vec2<u32>(slopes, max(beside.x, beside.y) | MINUS), vec2<u32>(slopes, min(beside.x, beside.y)),
    vec2<u32>(ONE, noise | MINUS), vec2<u32>(0u)));
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
    if (WORLD) {
      let ratio = edge_rule.ratio[level];
      state = select(state, world_step_by_floats(ends.x, ends.y, ratio, edge_rule.at_infinity), ratio != 0u);
    }
  }
  return select(state, select(0u, 1u, keys.y != keys.z), max(keys.y, keys.z) == FAR_KEY || keys.y == keys.z);
}

// Whether an edge is marked for which `told` gives 2. It is never asked for far samples or equal keys.
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
