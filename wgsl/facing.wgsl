// Facing: for each face one bit a light, set where the light lies strictly on the face's counter-clockwise side.
// Sign of det[b - a, c - a, l - w a] in its local form n . (l - w a), with a bound on its error; NUMERICS.md, "Facing"
// and "Filter". What the bound does not decide is left 0 and listed for exact_facing.wgsl.

@group(0) @binding(0) var<uniform> word: LightWord;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(6) var<storage, read> faces: array<u32>;
@group(0) @binding(7) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> statistics: Statistics;
@group(0) @binding(9) var<storage, read_write> undecided: Undecided;

// Without it the sign is taken as f32 gives it.
override EXACT: bool = true;

// Ten units of the last place, 10 * 2^-23, and what underflow may add, 2^-115.
const RELATIVE: f32 = 0x1.4p-20;
const UNDERFLOW: f32 = 0x1p-115;
// Exponent bits of 2^40: a coordinate from there on could overflow the determinant, so its face is undecided.
const LARGE: u32 = 0x53800000u;

// A face as the filter sees it.
struct Side {
  a: vec3<f32>,
  n: vec3<f32>,
  // The normal's components with absolute values throughout.
  n_abs: vec3<f32>,
  // Error of the determinant a unit of |l| and of |w|, and by itself: the cheap bound.
  per_l: f32,
  per_w: f32,
  least: f32,
}

// Bits of facing lights and of undecided ones.
struct Decision {
  facing: u32,
  doubt: u32,
}

fn side_of(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> Side {
  let u = b - a;
  let v = c - a;
  let u_abs = abs(u);
  let v_abs = abs(v);
  let n = vec3<f32>(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
  let n_abs = vec3<f32>(
    u_abs.y * v_abs.z + u_abs.z * v_abs.y,
    u_abs.z * v_abs.x + u_abs.x * v_abs.z,
    u_abs.x * v_abs.y + u_abs.y * v_abs.x,
  );
  let reach = max(max(largest(u_abs), largest(v_abs)), 1.0);
  let least = UNDERFLOW * reach * reach;
  let per_l = RELATIVE * (n_abs.x + n_abs.y + n_abs.z) + least;
  return Side(a, n, n_abs, per_l, per_l * largest(abs(a)), least);
}

fn largest(v: vec3<f32>) -> f32 {
  return max(max(v.x, v.y), v.z);
}

fn determinant(side: Side, light: vec4<f32>) -> f32 {
  let to_light = light.xyz - light.w * side.a;
  return side.n.x * to_light.x + side.n.y * to_light.y + side.n.z * to_light.z;
}

// Bit 0: facing; bit 16: in doubt.
fn test(side: Side, light: u32) -> u32 {
  let d = determinant(side, word.lights[light]);
  if (!EXACT) {
    return select(0u, 1u, d > 0.0);
  }
  let bounds = word.bounds[light];
  let bound = side.per_l * bounds.x + (side.per_w * bounds.y + side.least);
  return select(0u, 1u, d > bound) | select(0x10000u, 0u, abs(d) > bound);
}

// All lights by the cheap bound. Four at a time: the loop's own cost counts beside a test of a dozen operations. Lights
// past `count` are zeros and decide nothing.
fn decide(side: Side) -> Decision {
  var decision = Decision(0u, 0u);
  for (var light = 0u; light < word.count; light += 4u) {
    let found = test(side, light) | (test(side, light + 1u) << 1u) | (test(side, light + 2u) << 2u) |
      (test(side, light + 3u) << 3u);
    decision.facing |= (found & 0xfu) << light;
    decision.doubt |= (found >> 16u) << light;
  }
  if (EXACT) {
    decision.facing &= ~word.doubtful;
    decision.doubt = (decision.doubt | word.doubtful) & word.live;
  }
  return decision;
}

// Lights in doubt by the full bound, whose terms are the light's own.
fn decide_again(side: Side, before: Decision) -> Decision {
  var decision = before;
  for (var rest = before.doubt & ~word.doubtful; rest != 0u; rest &= rest - 1u) {
    let at = firstTrailingBit(rest);
    let light = word.lights[at];
    let bounds = word.bounds[at];
    let to_light = abs(light.xyz - light.w * side.a);
    let a_abs = bounds.z * abs(side.a);
    let size = side.n_abs.x * (to_light.x + a_abs.x) + side.n_abs.y * (to_light.y + a_abs.y) +
      side.n_abs.z * (to_light.z + a_abs.z);
    let d = determinant(side, light);
    let bound = RELATIVE * size + side.least * (1.0 + largest(to_light) + largest(a_abs));
    if (abs(d) > bound) {
      decision.doubt &= ~(1u << at);
      decision.facing |= select(0u, 1u, d > 0.0) << at;
    }
  }
  return decision;
}

// The bits of 1.0.
const ONE: u32 = 0x3f800000u;

// A point light in the plane of a face that lies along two axes is on neither side, nor is any of a face that is a line.
fn leave_out_coplanar(doubt: u32, a: vec3<u32>, b: vec3<u32>, c: vec3<u32>) -> u32 {
  let flat = (a == b) & (a == c);
  if (all(a == b) || all(a == c) || all(b == c)) {
    return 0u;
  }
  if (!any(flat)) {
    return doubt;
  }
  var left = doubt;
  for (var rest = doubt; rest != 0u; rest &= rest - 1u) {
    let at = firstTrailingBit(rest);
    let light = word.light_bits[at];
    if (light.w == ONE && any(flat & (light.xyz == a))) {
      left &= ~(1u << at);
    }
  }
  return left;
}

@compute @workgroup_size(256)
fn facing(@builtin(global_invocation_id) id: vec3<u32>) {
  let face = id.x;
  if (face >= chunk.count) {
    return;
  }
  let corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
  let a = position_bits(corners.x, word.position_offset, word.position_stride);
  let b = position_bits(corners.y, word.position_offset, word.position_stride);
  let c = position_bits(corners.z, word.position_offset, word.position_stride);
  var decision = Decision(0u, 0u);
  if (!(is_finite(a) && is_finite(b) && is_finite(c))) {
    if (chunk.first_light == 0u) {
      atomicAdd(&statistics.non_finite_faces, 1u);
    }
  } else if (corners.x != corners.y && corners.y != corners.z && corners.z != corners.x) {
    let side = side_of(bitcast<vec3<f32>>(a), bitcast<vec3<f32>>(b), bitcast<vec3<f32>>(c));
    decision = decide(side);
    if (EXACT) {
      let magnitudes = max(max(a & vec3<u32>(0x7fffffffu), b & vec3<u32>(0x7fffffffu)), c & vec3<u32>(0x7fffffffu));
      if (any(magnitudes >= vec3<u32>(LARGE))) {
        decision = Decision(0u, word.live);
      } else if (decision.doubt != 0u) {
        decision = decide_again(side, decision);
      }
      if (decision.doubt != 0u) {
        decision.doubt = leave_out_coplanar(decision.doubt, a, b, c);
      }
      if (decision.doubt != 0u) {
        let place = atomicAdd(&undecided.count, 1u);
        if (place < arrayLength(&undecided.entries)) {
          undecided.entries[place] = vec2<u32>(face, decision.doubt);
        }
      }
    }
  }
  facing_masks[face] = decision.facing;
}
