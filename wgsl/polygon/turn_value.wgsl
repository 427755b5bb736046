// How large the determinant of a turn is, and not only its sign: rounded once, where fixed point holds it. So ratios of nearly equal
// turns are exact but for the last places, however flat the light sees them.

struct TurnValue {
  // False: fixed point does not hold it.
  fits: bool,
  // The determinant over 2^exponent.
  value: f32,
  exponent: i32,
}

// Four limbs after a carry, and the carry over them.
struct Limbs4 {
  limbs: vec4<i32>,
  carry: i32,
}

fn carried(columns: vec4<i32>, carry: i32) -> Limbs4 {
  let x = columns.x + carry;
  let y = columns.y + (x >> 12u);
  let z = columns.z + (y >> 12u);
  let w = columns.w + (z >> 12u);
  return Limbs4(vec4<i32>(x, y, z, w) & vec4<i32>(0xfff), w >> 12u);
}

fn turn_value(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>, light: vec4<u32>) -> TurnValue {
  let face = fixed_face(a, b, c);
  let sum = fixed_sum(face, light);
  // The magnitude: that of a negative sum ends in a run of ones.
  let negative = carried(sum.third, carried(sum.second, carried(sum.first, 0).carry).carry).carry < 0;
  let sign = select(1, -1, negative);
  let first = carried(sign * sum.first, 0);
  let second = carried(sign * sum.second, first.carry);
  let third = carried(sign * sum.third, second.carry);
  // From the highest limb down: the sum is rounded where it has 24 bits. Limb 6 has the unit 1.
  let places = vec4<f32>(0x1p0, 0x1p12, 0x1p24, 0x1p36);
  let high = vec4<f32>(third.limbs) * places;
  let middle = vec4<f32>(second.limbs) * places;
  let low = vec4<f32>(first.limbs) * places;
  let top = f32(third.carry) * 0x1p48 + high.w + high.z + high.y + high.x;
  let value = top * 0x1p24 + (middle.w + middle.z + middle.y + middle.x) * 0x1p-24
    + (low.w + low.z + low.y + low.x) * 0x1p-72;
  return TurnValue(sum.fits, f32(sign) * value, sum.exponent + 72);
}

// A product with a power of two. Far smaller numbers are 0.
fn times_power(value: f32, exponent: i32) -> f32 {
  return select(0.0, value * bitcast<f32>(u32(127 + max(exponent, -126)) << 23u), exponent > -64);
}

// The share of the first of two turns of contrary sense. 0.5 if both are 0.
fn share_of_turns(first: TurnValue, second: TurnValue) -> f32 {
  if (first.value == 0.0 || second.value == 0.0) {
    return select(select(1.0, 0.0, second.value != 0.0), 0.5, first.value == second.value);
  }
  let exponent = max(first.exponent, second.exponent);
  let part = times_power(first.value, first.exponent - exponent);
  return part / (part - times_power(second.value, second.exponent - exponent));
}
