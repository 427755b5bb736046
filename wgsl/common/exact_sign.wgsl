// The sign of det[b - a, c - a, l - w a], for a face (a, b, c) and a homogeneous light (l, w), for all finite f32, in integer
// arithmetic. It is exact, the same on every device. `exact_facing`, the query's stages of exact_shadow_depth.wgsl and, through
// polygon/turn.wgsl, the stages of polygons use it where common/fixed_sign.wgsl says that numbers do not fit. Callers must leave
// out faces that are not finite before. This is rare and slow, so the code is short rather than fast. docs/numerics/facing.md,
// "Exact facing".

const DIGIT: u32 = 0xffffffu; // The bits of a digit.
// Digits of 24 bits, the lowest first, in units of 2^-596. `exact_sign` finds and leaves them zero. 48 of them hold every sum of
// products of four finite f32; four more are read.
var<private> digits: array<i32, 52>;

// The 48-bit product of two digits, as two digits.
fn multiply(a: u32, b: u32) -> vec2<u32> {
  let a_low = a & 0xfffu;
  let a_high = a >> 12u;
  let b_low = b & 0xfffu;
  let b_high = b >> 12u;
  let middle = a_low * b_high + a_high * b_low;
  let low = a_low * b_low + ((middle & 0xfffu) << 12u);
  return vec2<u32>(low & DIGIT, a_high * b_high + (middle >> 12u) + (low >> 24u));
}

// Three digits times one.
fn multiply_three(a: vec3<u32>, b: u32) -> vec4<u32> {
  let low = multiply(a.x, b);
  let middle = multiply(a.y, b);
  let high = multiply(a.z, b);
  let second = low.y + middle.x;
  let third = middle.y + high.x + (second >> 24u);
  return vec4<u32>(low.x, second & DIGIT, third & DIGIT, high.y + (third >> 24u));
}

// Adds the product of four floats, given as bits, to `digits`; subtracts it if bit 31 of `sign` is set. Returns the index of the
// lowest digit that it may change; the four after it may change, too. It has no loop, because some software GPUs end an
// invocation's loops after 2^16 turns in total (ARCHITECTURE.md, "Limits of devices").
fn add_product(bits: vec4<u32>, sign: u32) -> u32 {
  let exponents = (bits >> vec4<u32>(23u)) & vec4<u32>(0xffu);
  let implied = select(vec4<u32>(0u), vec4<u32>(0x800000u), exponents != vec4<u32>(0u));
  let mantissas = (bits & vec4<u32>(0x7fffffu)) | implied;
  let places = max(exponents, vec4<u32>(1u)) - 1u;
  let above = places.x + places.y + places.z + places.w;
  let two = multiply(mantissas.x, mantissas.y);
  let three = multiply_three(vec3<u32>(two, 0u), mantissas.z).xyz;
  let product = multiply_three(three, mantissas.w);
  let shift = above % 24u;
  let shifted = (product << vec4<u32>(shift)) & vec4<u32>(DIGIT);
  let carried = product >> vec4<u32>(24u - shift);
  // 0, or -1 if the product is negative.
  let negative = -i32((bits.x ^ bits.y ^ bits.z ^ bits.w ^ sign) >> 31u);
  let low = (vec4<i32>(shifted | vec4<u32>(0u, carried.xyz)) ^ vec4<i32>(negative)) - vec4<i32>(negative);
  let at = above / 24u;
  digits[at] += low.x;
  digits[at + 1u] += low.y;
  digits[at + 2u] += low.z;
  digits[at + 3u] += low.w;
  digits[at + 4u] += (i32(carried.w) ^ negative) - negative;
  return at;
}

// After a digit: the carry over it, and the bits of it and all lower digits, ORed.
struct Sweep {
  carry: i32,
  any_bit: i32,
}

// Carries into a digit, and clears it.

fn take_digit(sweep: Sweep, at: u32) -> Sweep {
  let sum = digits[at] + sweep.carry;
  digits[at] = 0;
  return Sweep(sum >> 24u, sweep.any_bit | (sum & i32(DIGIT)));
}

// The sign of the determinant, from bits: 1, 0 or -1.
fn exact_sign(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>, light: vec4<u32>) -> i32 {
  // det(b, c, l) + det(a, b, l) + det(c, a, l) + w det(a, c, b): 24 products of four; those without w have a factor of
  // 1. The second product of each pair is subtracted. Then the next axis comes first.
  var p = b;
  var q = c;
  var r = light.xyz;
  var factor = 0x3f800000u;
  var lowest = 48u;
  var highest = 0u;
  for (var term = 0u; term < 24u; term++) {
    let is_second = (term & 1u) != 0u;
    let at = add_product(vec4<u32>(p.x, select(q.y, q.z, is_second), select(r.z, r.y, is_second), factor), term << 31u);
    lowest = min(lowest, at);
    highest = max(highest, at + 4u);
    p = select(p, p.yzx, is_second);
    q = select(q, q.yzx, is_second);
    r = select(r, r.yzx, is_second);
    switch (term) {
      case 5u: { p = a; q = b; }
      case 11u: { p = c; q = a; }
      case 17u: { p = a; q = c; r = b; factor = light.w; }
      default: {}
    }
  }
  var sweep = Sweep(0, 0);
  // Turns: 13.
  for (var at = lowest; at <= highest; at += 4u) {
    sweep = take_digit(take_digit(take_digit(take_digit(sweep, at), at + 1u), at + 2u), at + 3u);
  }
  if (sweep.carry < 0) {
    return -1;
  }
  return select(0, 1, sweep.carry > 0 || sweep.any_bit != 0);
}
