// The sign of det[b - a, c - a, l - w a], for a face (a, b, c) and a homogeneous light (l, w), in integers: exact, the same
// on every device, since no compiler can round, fuse or flush them. For signs that f32 leaves undecided
// (common/determinant.wgsl). First `exact_sign`, for all finite f32, rare and slow, so its code is short rather than fast.
// Then fixed point, exact for numbers that lie in a window of bits, which says so where they do not: callers try
// `fixed_face`, once for a face, and `fixed_sign`, for each light, and take `exact_sign` where that gives 2. Callers must
// leave out faces that are not finite before. `exact_facing`, the query's stages of exact_shadow_depth.wgsl and, through
// polygon/turn.wgsl, the stages of polygons use both. docs/numerics/facing.md, "Exact facing".

const DIGIT: u32 = 0xffffffu; // The bits of a digit.
// Digits of 24 bits, the lowest first, in units of 2^-596. `exact_sign` finds and leaves them zero. 48 of them hold every
// sum of products of four finite f32; four more are read.
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

// Adds the product of four floats, given as bits, to `digits`; subtracts it if bit 31 of `sign` is set. Returns the index of
// the lowest digit that it may change; the four after it may change, too. It has no loop, because some software GPUs end an
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

// Fixed point. The integers have limbs of 12 bits in i32.

// The largest number of bits from the lowest to the highest set bit of a face's nine coordinates, and of l and w a.
const FACE_BITS: i32 = 46;
const LIGHT_BITS: i32 = 48;
const FAR: i32 = 4096; // An exponent above all others.

// Three numbers, each odd or zero, times a power of two: sign * mantissa * 2^(exponent - 149).
struct Numbers {
  mantissa: vec3<u32>,
  exponent: vec3<i32>,
  length: vec3<i32>, // The largest number of bits of the mantissa.
  sign: vec3<i32>, // 0, or -1 if the number is negative.
}

// Three finite floats, given by their bits.
fn numbers(bits: vec3<u32>) -> Numbers {
  let exponent = (bits >> vec3<u32>(23u)) & vec3<u32>(0xffu);
  let implied = select(vec3<u32>(0u), vec3<u32>(0x800000u), exponent != vec3<u32>(0u));
  let mantissa = (bits & vec3<u32>(0x7fffffu)) | implied;
  // The lowest set bit is a power of two. A float holds it exactly and shows its exponent.
  let lowest = bitcast<vec3<u32>>(vec3<f32>(vec3<i32>(mantissa & (~mantissa + 1u)))) >> vec3<u32>(23u);
  let zeros = max(lowest, vec3<u32>(127u)) - 127u;
  let place = vec3<i32>(max(exponent, vec3<u32>(1u)) - 1u + zeros);
  return Numbers(mantissa >> zeros, place, 24 - vec3<i32>(zeros), -vec3<i32>(bits >> vec3<u32>(31u)));
}

// The exponent of the lowest set bit, and one more than that of the highest. Zeros do not count.
fn window(is_zero: vec3<bool>, exponent: vec3<i32>, length: vec3<i32>) -> vec2<i32> {
  let low = select(exponent, vec3<i32>(FAR), is_zero);
  let high = select(exponent + length, vec3<i32>(-FAR), is_zero);
  return vec2<i32>(min(min(low.x, low.y), low.z), max(max(high.x, high.y), high.z));
}

fn window_of(n: Numbers) -> vec2<i32> { return window(n.mantissa == vec3<u32>(0u), n.exponent, n.length); }

fn hull(a: vec2<i32>, b: vec2<i32>) -> vec2<i32> { return vec2<i32>(min(a.x, b.x), max(a.y, b.y)); }

// Three integers in two digits of 24 bits. The second digit has the sign.
struct Wide {
  low: vec3<i32>,
  high: vec3<i32>,
}

// The number in two digits, shifted up by `above` bits.
fn wide(low: vec3<u32>, high: vec3<u32>, above: vec3<i32>, sign: vec3<i32>) -> Wide {
  // A zero may have any exponent.
  let up = vec3<u32>(clamp(above, vec3<i32>(0), vec3<i32>(47)));
  let is_high = up >= vec3<u32>(24u);
  let shift = select(up, up - 24u, is_high);
  let first = (low << shift) & vec3<u32>(DIGIT);
  let second = select((low >> (24u - shift)) | (high << shift), first, is_high);
  return Wide((vec3<i32>(select(first, vec3<u32>(0u), is_high)) ^ sign) - sign, (vec3<i32>(second) ^ sign) - sign);
}

// The two limbs of a digit after those of another.
fn limbs(low: i32, high: i32) -> vec4<i32> { return vec4<i32>(low & 0xfff, low >> 12u, high & 0xfff, high >> 12u); }

// Three integers of four limbs of 12 bits, the lowest first. The last limb has the sign.
struct Limbs {
  x: vec4<i32>,
  y: vec4<i32>,
  z: vec4<i32>,
}

// p - q.
fn difference(p: Wide, q: Wide) -> Limbs {
  let low = p.low - q.low;
  let high = p.high - q.high + (low >> vec3<u32>(24u));
  let rest = low & vec3<i32>(i32(DIGIT));
  return Limbs(limbs(rest.x, high.x), limbs(rest.y, high.y), limbs(rest.z, high.z));
}

// Eight columns of limbs.
struct Columns {
  low: vec4<i32>,
  high: vec4<i32>,
}

// A product, without carries.
fn multiply_limbs(p: vec4<i32>, q: vec4<i32>) -> Columns {
  return Columns(
    vec4<i32>(
      p.x * q.x,
      p.x * q.y + p.y * q.x,
      p.x * q.z + p.y * q.y + p.z * q.x,
      p.x * q.w + p.y * q.z + p.z * q.y + p.w * q.x,
    ),
    vec4<i32>(
      p.y * q.w + p.z * q.z + p.w * q.y,
      p.z * q.w + p.w * q.z,
      p.w * q.w,
      0,
    ),
  );
}

// A component of the normal, in limbs of 12 bits. The last limb has the sign and may have more bits.
fn normal_limbs(p: vec4<i32>, q: vec4<i32>, r: vec4<i32>, s: vec4<i32>) -> Columns {
  let first = multiply_limbs(p, q);
  let second = multiply_limbs(r, s);
  var low = first.low - second.low;
  var high = first.high - second.high;
  low.y += low.x >> 12u;
  low.z += low.y >> 12u;
  low.w += low.z >> 12u;
  high.x += low.w >> 12u;
  high.y += high.x >> 12u;
  high.z += high.y >> 12u;
  high.w = high.z >> 12u;
  return Columns(low & vec4<i32>(0xfff), vec4<i32>(high.xyz & vec3<i32>(0xfff), high.w));
}

// The values that all lights of a face share.
struct FixedFace {
  fits: bool,
  // The exponent of the unit of its vectors.
  lowest: i32,
  a: Numbers,
  x: Columns,
  y: Columns,
  z: Columns,
}

// The vector from one corner to another, in units of 2^(lowest - 149): `lowest` is the lowest exponent of the face.
fn side(from_corner: Numbers, to_corner: Numbers, lowest: i32) -> Limbs {
  let none = vec3<u32>(0u);
  let p = wide(from_corner.mantissa, none, from_corner.exponent - lowest, from_corner.sign);
  let q = wide(to_corner.mantissa, none, to_corner.exponent - lowest, to_corner.sign);
  return difference(q, p);
}

// Corners are finite, given by their bits. If the numbers do not fit, only `fits` means something.
fn fixed_face(a_bits: vec3<u32>, b_bits: vec3<u32>, c_bits: vec3<u32>) -> FixedFace {
  let a = numbers(a_bits);
  let b = numbers(b_bits);
  let c = numbers(c_bits);
  let span = hull(hull(window_of(a), window_of(b)), window_of(c));
  let u = side(a, b, span.x);
  let v = side(a, c, span.x);
  return FixedFace(
    span.y - span.x <= FACE_BITS,
    span.x,
    a,
    normal_limbs(u.y, v.z, u.z, v.y),
    normal_limbs(u.z, v.x, u.x, v.z),
    normal_limbs(u.x, v.y, u.y, v.x),
  );
}

// The carry of the lowest four columns, as one limb, and whether any of their bits is set.
fn sweep(columns: vec4<i32>, carry: i32) -> vec2<i32> {
  let x = columns.x + carry;
  let y = columns.y + (x >> 12u);
  let z = columns.z + (y >> 12u);
  let w = columns.w + (z >> 12u);
  return vec2<i32>(w >> 12u, (x | y | z | w) & 0xfff);
}

// A determinant: twelve limbs of 12 bits that carry yet, the lowest first, in units of 2^(exponent - 447).
struct FixedSum {
  fits: bool,
  first: vec4<i32>,
  second: vec4<i32>,
  third: vec4<i32>,
  exponent: i32,
}

// The determinant of a face for a light, given by its bits. If `fits` is false, nothing else means something.
fn fixed_sum(face: FixedFace, light: vec4<u32>) -> FixedSum {
  let l = numbers(light.xyz);
  let w = numbers(light.www);
  // w a, as two parts of 24 bits.
  var low: vec3<u32>;
  var high: vec3<u32>;
  let x = multiply(face.a.mantissa.x, w.mantissa.x);
  let y = multiply(face.a.mantissa.y, w.mantissa.x);
  let z = multiply(face.a.mantissa.z, w.mantissa.x);
  low = vec3<u32>(x.x, y.x, z.x);
  high = vec3<u32>(x.y, y.y, z.y);
  let exponent = face.a.exponent + w.exponent - 149;
  let span = hull(window_of(l), window((low | high) == vec3<u32>(0u), exponent, face.a.length + w.length));
  let fits = face.fits && span.y - span.x <= LIGHT_BITS;
  let from_l = wide(l.mantissa, vec3<u32>(0u), l.exponent - span.x, l.sign);
  let t = difference(from_l, wide(low, high, exponent - span.x, face.a.sign ^ w.sign));
  let xs = multiply_limbs(face.x.low, t.x);
  let ys = multiply_limbs(face.y.low, t.y);
  let zs = multiply_limbs(face.z.low, t.z);
  let xs_high = multiply_limbs(face.x.high, t.x);
  let ys_high = multiply_limbs(face.y.high, t.y);
  let zs_high = multiply_limbs(face.z.high, t.z);
  return FixedSum(
    fits,
    xs.low + ys.low + zs.low,
    xs.high + ys.high + zs.high + xs_high.low + ys_high.low + zs_high.low,
    xs_high.high + ys_high.high + zs_high.high,
    2 * face.lowest + span.x,
  );
}

// Returns 1, 0 or -1, or 2 if the numbers do not fit.
fn fixed_sign(face: FixedFace, light: vec4<u32>) -> i32 {
  let sum = fixed_sum(face, light);
  if (!sum.fits) {
    return 2;
  }
  let first = sweep(sum.first, 0);
  let second = sweep(sum.second, first.x);
  let third = sweep(sum.third, second.x);
  let carry = third.x;
  let any_bit = first.y | second.y | third.y;
  if (carry < 0) {
    return -1;
  }
  return select(0, 1, (carry | any_bit) != 0);
}
