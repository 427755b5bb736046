// Whether two depths of a perspective map are farther from each other than a distance in world units, exactly: the sign of
// ratio · |a − b| − |a − i| · |b − i|, with the depth i at infinity. NUMERICS.md, "Volumes from depth maps".

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
fn product(a: u32, b: u32) -> vec2<u32> {
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
    let mantissa = product(a.x, b.x);
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

fn exact_world_step(a: u32, b: u32, ratio: u32, infinity: u32) -> bool {
  // (a − i) (b − i) is negative if i is between them.
  let turned = select(0u, MINUS, is_below(a, infinity) != is_below(b, infinity));
  return is_positive(array<vec2<u32>, TERMS>(
    vec2<u32>(ratio, max(a, b)), vec2<u32>(ratio, min(a, b) | MINUS),
    vec2<u32>(a, b ^ MINUS ^ turned), vec2<u32>(infinity, a ^ turned), vec2<u32>(infinity, b ^ turned),
    vec2<u32>(infinity, infinity ^ MINUS ^ turned)));
}

// Whether floats tell: 0 or 1; or 2, where the terms are nearly equal, very large or very small.
fn world_step_by_floats(a: u32, b: u32, ratio: u32, infinity: u32) -> u32 {
  let depth_there = bitcast<f32>(infinity);
  let step = bitcast<f32>(ratio) * abs(bitcast<f32>(a) - bitcast<f32>(b));
  let most = abs(bitcast<f32>(a) - depth_there) * abs(bitcast<f32>(b) - depth_there);
  let is_plain = (min(step, most) > 1e-30) & (max(step, most) < 1e30);
  let is_told = is_plain & ((step > 1.0001 * most) | (most > 1.0001 * step));
  // Equal depths are no step, whatever the ratio is.
  return select(select(2u, select(0u, 1u, step > most), is_told), 0u, a == b);
}
