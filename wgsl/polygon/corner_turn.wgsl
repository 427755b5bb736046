// The exact turn of three points as seen from a light: the sign of det[b - a, c - a, l - w a]. It is 1 if the light sees a,
// b, c counter-clockwise, -1 if clockwise. `polygon_pairs` and the passes of `cut_edges` call `turn`. A bound on rounding
// decides if it can, then fixed point, then `exact_sign`, so all devices have the same sign. If the determinant is 0, the
// light moves by (e, e^2, e^3) for an infinitely small e. Then the sign is the first that is not 0 with the axes x, y, z for
// the light. All callers must share this rule, or their results for one boundary contradict each other. Also the rounded
// value of the determinant, for the order of cuts. Points are the bits of positions, finite and without -0 (`position_of`).
// `Turns:` above a loop is its most iterations. Claims: docs/numerics/polygons.md.

#import common/determinant
#import common/exact_sign
#import common/order_keys
#import extract/one_caster

struct Turn {
  // 0 only if the points are in line.
  sign: i32,
  // The light that decides `sign`: 0 the given one, 1 to 3 an axis, or `IN_LINE`.
  tie: u32,
}

const IN_LINE: u32 = 4u;

// The light's bits, or for tie 1 to 3 those of the axis along which it moves, as a light at infinity.
fn light_or_axis(light_index: u32, tie: u32) -> vec4<u32> {
  switch (tie) {
    case 0u: { return given_light(light_index); }
    case 1u: { return vec4<u32>(0x3f800000u, 0u, 0u, 0u); }
    case 2u: { return vec4<u32>(0u, 0x3f800000u, 0u, 0u); }
    default: { return vec4<u32>(0u, 0u, 0x3f800000u, 0u); }
  }
}

// The sign for the given light if a bound makes it certain, otherwise 0.
fn certain_turn(a_bits: vec3<u32>, b_bits: vec3<u32>, c_bits: vec3<u32>, light_index: u32) -> i32 {
  let magnitude = largest_magnitude(a_bits, b_bits, c_bits);
  if (magnitude >= LARGE) {
    return 0;
  }
  let a = bitcast<vec3<f32>>(a_bits);
  let u = bitcast<vec3<f32>>(b_bits) - a;
  let v = bitcast<vec3<f32>>(c_bits) - a;
  let size = (abs(u.x) + abs(u.y) + abs(u.z)) * (abs(v.x) + abs(v.y) + abs(v.z));
  let bound = face_bound(size, bitcast<f32>(magnitude), light_magnitudes());
  let d = local_form(cross_product(u, v), a, scaled_light(light_index));
  return select(0, 1, d > bound) - select(0, 1, d < -bound);
}

// The turn of three finite positions, given by their bits.
fn turn(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>, light_index: u32) -> Turn {
  if (all(a == b) || all(b == c) || all(c == a)) {
    return Turn(0, IN_LINE);
  }
  let certain = certain_turn(a, b, c, light_index);
  if (certain != 0) {
    return Turn(certain, 0u);
  }
  var result = Turn(0, IN_LINE);
  let fixed = fixed_face(a, b, c);
  // Turns: 4.
  for (var tie = 0u; tie < 4u && result.sign == 0; tie++) {
    let light = light_or_axis(light_index, tie);
    var sign = fixed_sign(fixed, light);
    if (sign == 2) {
      sign = exact_sign(a, b, c, light);
    }
    result = Turn(sign, select(IN_LINE, tie, sign != 0));
  }
  return result;
}

// Whether `middle`, which must be on the line through `p` and `q`, is strictly between them.
fn is_between(p: vec3<u32>, middle: vec3<u32>, q: vec3<u32>) -> bool {
  let before = order_keys(p) < order_keys(middle);
  return any((before != (order_keys(q) < order_keys(middle))) & (p != middle) & (q != middle));
}

// The value of a determinant, from fixed point, rounded once. Ratios of nearly equal turns are exact but for the last bits,
// however flat the light sees them.

struct TurnValue {
  // False: fixed point does not hold it.
  fits: bool,
  // The determinant is value * 2^(exponent - 447). In ratios, all that callers take, the 447 cancels.
  value: f32,
  exponent: i32,
}

// Four limbs after a carry, and the carry over them.
struct Limbs4 {
  limbs: vec4<i32>,
  carry: i32,
}

// Carries the bits above 12 of each column into the next.
fn carried(columns: vec4<i32>, carry: i32) -> Limbs4 {
  let x = columns.x + carry;
  let y = columns.y + (x >> 12u);
  let z = columns.z + (y >> 12u);
  let w = columns.w + (z >> 12u);
  return Limbs4(vec4<i32>(x, y, z, w) & vec4<i32>(0xfff), w >> 12u);
}

// The determinant for a light, without ties. If `fits` is false, the other members have no meaning.
fn turn_value(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>, light: vec4<u32>) -> TurnValue {
  let face = fixed_face(a, b, c);
  let sum = fixed_sum(face, light);
  // Computes the magnitude, because the digits of a negative sum do not end.
  let negative = carried(sum.third, carried(sum.second, carried(sum.first, 0).carry).carry).carry < 0;
  let sign = select(1, -1, negative);
  let first = carried(sign * sum.first, 0);
  let second = carried(sign * sum.second, first.carry);
  let third = carried(sign * sum.third, second.carry);
  // Adds limbs from the highest down: the sum is rounded only after 24 bits. Limb 6 has the unit 1.
  let limb_units = vec4<f32>(0x1p0, 0x1p12, 0x1p24, 0x1p36);
  let high = vec4<f32>(third.limbs) * limb_units;
  let middle = vec4<f32>(second.limbs) * limb_units;
  let low = vec4<f32>(first.limbs) * limb_units;
  let top = f32(third.carry) * 0x1p48 + high.w + high.z + high.y + high.x;
  let value = top * 0x1p24 + (middle.w + middle.z + middle.y + middle.x) * 0x1p-24
    + (low.w + low.z + low.y + low.x) * 0x1p-72;
  return TurnValue(sum.fits, f32(sign) * value, sum.exponent + 72);
}

// Whether fixed point holds the turns of all points whose bits lie in a window, for a light and for the axes.
fn holds_turns(span: vec2<i32>, light: vec4<u32>) -> bool {
  let moved_window = span + bit_window_of(float_parts(light.www)) - 149;
  let light_window = hull(bit_window_of(float_parts(light.xyz)), moved_window);
  return span.y - span.x <= FACE_BITS && light_window.y - light_window.x <= LIGHT_BITS;
}

// value * 2^exponent for an exponent up to 0, or 0 if the exponent is -64 or less.
fn times_power(value: f32, exponent: i32) -> f32 {
  return select(0.0, value * bitcast<f32>(u32(127 + max(exponent, -126)) << 23u), exponent > -64);
}

// |first| / (|first| + |second|) for turns of opposite signs. It is the fraction of an edge, from the end with turn `first`,
// at which it crosses another edge's plane. 0.5 if both are 0. If one does not fit, it has no meaning.
fn fraction_from_turns(first: TurnValue, second: TurnValue) -> f32 {
  if (first.value == 0.0 || second.value == 0.0) {
    return select(select(1.0, 0.0, second.value != 0.0), 0.5, first.value == second.value);
  }
  let exponent = max(first.exponent, second.exponent);
  let first_part = times_power(first.value, first.exponent - exponent);
  return first_part / (first_part - times_power(second.value, second.exponent - exponent));
}
