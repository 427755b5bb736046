// Finds the exact sign of det[b - a, c - a, l - w a], for a face (a, b, c) and a homogeneous light (l, w). Callers need it
// where f32 leaves the sign undecided (common/determinant.wgsl). It is the same on every device, because no compiler can
// round, fuse or flush integers. `exact_sign` takes all finite f32. It is slow and seldom called, so its code is short, not
// fast. Fixed point (`fixed_sign`) is faster, but takes only numbers whose bits lie in a window. Callers compute `fixed_face`
// once for a face, then `fixed_sign` for each light, and call `exact_sign` if it returns 2. They must reject faces that are
// not finite. `exact_facing`, the stages of exact_shadow_depth.wgsl and, by polygon/corner_turn.wgsl, the stages of polygons
// do so; polygon/cut_edges.wgsl also uses the windows of bits. Claim: docs/numerics/facing.md, "Exact facing".

const DIGIT: u32 = 0xffffffu; // The bits of a digit.
// A sum, as digits of 24 bits, the lowest first, in units of 2^-596. All are zero before and after `exact_sign`. 48 of them
// hold the sum for any finite f32. The loop over them reads four at once, so it may read more.
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

// The product of a number of three digits and one of one digit, as four digits.
fn multiply_three(a: vec3<u32>, b: u32) -> vec4<u32> {
  let low = multiply(a.x, b);
  let middle = multiply(a.y, b);
  let high = multiply(a.z, b);
  let second = low.y + middle.x;
  let third = middle.y + high.x + (second >> 24u);
  return vec4<u32>(low.x, second & DIGIT, third & DIGIT, high.y + (third >> 24u));
}

// Adds the product of four floats, given as bits, to `digits`; subtracts it if bit 31 of `sign` is set. Returns the index of
// the lowest digit that may change; the next four may change, too. It has no loop, because llvmpipe ends all loops of an
// invocation after 65,535 turns (docs/numerics/loops.md).
fn add_product(bits: vec4<u32>, sign: u32) -> u32 {
  let exponents = (bits >> vec4<u32>(23u)) & vec4<u32>(0xffu);
  let implied = select(vec4<u32>(0u), vec4<u32>(0x800000u), exponents != vec4<u32>(0u));
  let mantissas = (bits & vec4<u32>(0x7fffffu)) | implied;
  let shifts = max(exponents, vec4<u32>(1u)) - 1u;
  let shift_sum = shifts.x + shifts.y + shifts.z + shifts.w;
  let product_2 = multiply(mantissas.x, mantissas.y);
  let product_3 = multiply_three(vec3<u32>(product_2, 0u), mantissas.z).xyz;
  let product_4 = multiply_three(product_3, mantissas.w);
  let shift = shift_sum % 24u;
  let shifted = (product_4 << vec4<u32>(shift)) & vec4<u32>(DIGIT);
  let carried = product_4 >> vec4<u32>(24u - shift);
  // 0, or -1 if the product is negative.
  let negative = -i32((bits.x ^ bits.y ^ bits.z ^ bits.w ^ sign) >> 31u);
  let low = (vec4<i32>(shifted | vec4<u32>(0u, carried.xyz)) ^ vec4<i32>(negative)) - vec4<i32>(negative);
  let lowest_digit = shift_sum / 24u;
  digits[lowest_digit] += low.x;
  digits[lowest_digit + 1u] += low.y;
  digits[lowest_digit + 2u] += low.z;
  digits[lowest_digit + 3u] += low.w;
  digits[lowest_digit + 4u] += (i32(carried.w) ^ negative) - negative;
  return lowest_digit;
}

// The carry out of a digit, and this digit and all lower ones, ORed after their carries.
struct CarryState {
  carry: i32,
  any_bit: i32,
}

// Adds the carry to a digit, and clears the digit.
fn carry_into_digit(state: CarryState, index: u32) -> CarryState {
  let sum = digits[index] + state.carry;
  digits[index] = 0;
  return CarryState(sum >> 24u, state.any_bit | (sum & i32(DIGIT)));
}

// The sign of the determinant, 1, 0 or -1, of numbers given by their bits.
fn exact_sign(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>, light: vec4<u32>) -> i32 {
  // det(b, c, l) + det(a, b, l) + det(c, a, l) + w det(a, c, b): 24 products of four. Products without w have a factor of 1.
  // The second product of each pair is subtracted. After each pair the axes rotate.
  var p = b;
  var q = c;
  var r = light.xyz;
  var factor = 0x3f800000u;
  var lowest = 48u;
  var highest = 0u;
  for (var term = 0u; term < 24u; term++) {
    let is_second = (term & 1u) != 0u;
    let lowest_digit = add_product(
      vec4<u32>(p.x, select(q.y, q.z, is_second), select(r.z, r.y, is_second), factor), term << 31u);
    lowest = min(lowest, lowest_digit);
    highest = max(highest, lowest_digit + 4u);
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
  var state = CarryState(0, 0);
  // Turns: 13.
  for (var index = lowest; index <= highest; index += 4u) {
    state = carry_into_digit(
      carry_into_digit(carry_into_digit(carry_into_digit(state, index), index + 1u), index + 2u), index + 3u);
  }
  if (state.carry < 0) {
    return -1;
  }
  return select(0, 1, state.carry > 0 || state.any_bit != 0);
}

// Fixed point. Products are of integers in limbs of 12 bits, each in an i32.

// The most bits from the lowest to the highest set bit that fixed point takes: of a face's nine coordinates, and of l and
// w a.
const FACE_BITS: i32 = 46;
const LIGHT_BITS: i32 = 48;
const EXPONENT_LIMIT: i32 = 4096; // An exponent above all others.

// Three numbers, each zero or an odd mantissa times a power of two: +-mantissa * 2^(exponent - 149).
struct FloatParts {
  mantissa: vec3<u32>,
  exponent: vec3<i32>,
  length: vec3<i32>, // Bits of the mantissa; of a subnormal number, or 0, there may be fewer.
  sign: vec3<i32>, // 0, or -1 if the number is negative.
}

// Splits three finite floats, given by their bits.
fn float_parts(bits: vec3<u32>) -> FloatParts {
  let exponent = (bits >> vec3<u32>(23u)) & vec3<u32>(0xffu);
  let implied = select(vec3<u32>(0u), vec3<u32>(0x800000u), exponent != vec3<u32>(0u));
  let mantissa = (bits & vec3<u32>(0x7fffffu)) | implied;
  // The lowest set bit of a mantissa, as a float, is exact, and its exponent is the number of zeros below it.
  let lowest = bitcast<vec3<u32>>(vec3<f32>(vec3<i32>(mantissa & (~mantissa + 1u)))) >> vec3<u32>(23u);
  let zeros = max(lowest, vec3<u32>(127u)) - 127u;
  let lowest_exponent = vec3<i32>(max(exponent, vec3<u32>(1u)) - 1u + zeros);
  return FloatParts(mantissa >> zeros, lowest_exponent, 24 - vec3<i32>(zeros), -vec3<i32>(bits >> vec3<u32>(31u)));
}

// The range of bits of three numbers: the exponent of the lowest set bit, and at least one more than that of the highest
// (more for subnormal numbers). Zeros have none.
fn bit_window(is_zero: vec3<bool>, exponent: vec3<i32>, length: vec3<i32>) -> vec2<i32> {
  let low = select(exponent, vec3<i32>(EXPONENT_LIMIT), is_zero);
  let high = select(exponent + length, vec3<i32>(-EXPONENT_LIMIT), is_zero);
  return vec2<i32>(min(min(low.x, low.y), low.z), max(max(high.x, high.y), high.z));
}

fn bit_window_of(n: FloatParts) -> vec2<i32> { return bit_window(n.mantissa == vec3<u32>(0u), n.exponent, n.length); }

fn hull(a: vec2<i32>, b: vec2<i32>) -> vec2<i32> { return vec2<i32>(min(a.x, b.x), max(a.y, b.y)); }

// Three integers, each of two digits of 24 bits. Both digits of a negative integer are negative, or 0.
struct TwoDigits {
  low: vec3<i32>,
  high: vec3<i32>,
}

// Three integers given as digits, shifted up by `shift_up` bits. `sign` is -1 to negate them, else 0. The result, without
// sign, must be below 2^48.
fn shifted_digits(low: vec3<u32>, high: vec3<u32>, shift_up: vec3<i32>, sign: vec3<i32>) -> TwoDigits {
  // Zeros may have any exponent, and callers ignore the result if numbers do not fit, so the shift is clamped.
  let up = vec3<u32>(clamp(shift_up, vec3<i32>(0), vec3<i32>(47)));
  let is_high = up >= vec3<u32>(24u);
  let shift = select(up, up - 24u, is_high);
  let first = (low << shift) & vec3<u32>(DIGIT);
  let second = select((low >> (24u - shift)) | (high << shift), first, is_high);
  return TwoDigits((vec3<i32>(select(first, vec3<u32>(0u), is_high)) ^ sign) - sign, (vec3<i32>(second) ^ sign) - sign);
}

// The limbs of a low digit without sign, then those of a high digit with the sign.
fn limbs(low: i32, high: i32) -> vec4<i32> { return vec4<i32>(low & 0xfff, low >> 12u, high & 0xfff, high >> 12u); }

// Three integers of four limbs of 12 bits, the lowest first. The last limb has the sign.
struct Limbs {
  x: vec4<i32>,
  y: vec4<i32>,
  z: vec4<i32>,
}

// p - q.
fn difference(p: TwoDigits, q: TwoDigits) -> Limbs {
  let low = p.low - q.low;
  let high = p.high - q.high + (low >> vec3<u32>(24u));
  let digit = low & vec3<i32>(i32(DIGIT));
  return Limbs(limbs(digit.x, high.x), limbs(digit.y, high.y), limbs(digit.z, high.z));
}

// Eight columns, the lowest first. A column has the weight of a limb, but may be larger until it is carried.
struct Columns {
  low: vec4<i32>,
  high: vec4<i32>,
}

// The columns of a product, without carries.
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

// The difference of two products, carried: a component of the normal. The last limb has the sign and may have more bits.
fn normal_limbs(first: Columns, second: Columns) -> Columns {
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

// A face's values for all lights. If `fits` is false, the other members have no meaning.
struct FixedFace {
  fits: bool,
  // u = b - a and v = c - a are in units of 2^(lowest - 149).
  lowest: i32,
  a: FloatParts,
  // The cross product of u and v.
  x: Columns,
  y: Columns,
  z: Columns,
}

// The vector between two corners, in units of 2^(lowest - 149). `lowest` is the lowest exponent of the face.
fn edge_vector(from_corner: FloatParts, to_corner: FloatParts, lowest: i32) -> Limbs {
  let none = vec3<u32>(0u);
  let p = shifted_digits(from_corner.mantissa, none, from_corner.exponent - lowest, from_corner.sign);
  let q = shifted_digits(to_corner.mantissa, none, to_corner.exponent - lowest, to_corner.sign);
  return difference(q, p);
}

// The corners must be finite; they are given by their bits.
fn fixed_face(a_bits: vec3<u32>, b_bits: vec3<u32>, c_bits: vec3<u32>) -> FixedFace {
  let a = float_parts(a_bits);
  let b = float_parts(b_bits);
  let c = float_parts(c_bits);
  let span = hull(hull(bit_window_of(a), bit_window_of(b)), bit_window_of(c));
  let u = edge_vector(a, b, span.x);
  let v = edge_vector(a, c, span.x);
  return FixedFace(
    span.y - span.x <= FACE_BITS,
    span.x,
    a,
    normal_limbs(multiply_limbs(u.y, v.z), multiply_limbs(u.z, v.y)),
    normal_limbs(multiply_limbs(u.z, v.x), multiply_limbs(u.x, v.z)),
    normal_limbs(multiply_limbs(u.x, v.y), multiply_limbs(u.y, v.x)),
  );
}

// Carries four columns. x: the carry out of them. y: not 0 if any of them is not 0 after the carries.
fn carry_columns(columns: vec4<i32>, carry: i32) -> vec2<i32> {
  let x = columns.x + carry;
  let y = columns.y + (x >> 12u);
  let z = columns.z + (y >> 12u);
  let w = columns.w + (z >> 12u);
  return vec2<i32>(w >> 12u, (x | y | z | w) & 0xfff);
}

// A determinant: twelve columns that are not carried, the lowest first, in units of 2^(exponent - 447).
struct FixedSum {
  fits: bool,
  first: vec4<i32>,
  second: vec4<i32>,
  third: vec4<i32>,
  exponent: i32,
}

// The determinant of a face for a light, given by its bits. If `fits` is false, the other members have no meaning.
fn fixed_sum(face: FixedFace, light: vec4<u32>) -> FixedSum {
  let l = float_parts(light.xyz);
  let w = float_parts(light.www);
  // w a, as two digits.
  var low: vec3<u32>;
  var high: vec3<u32>;
  let x = multiply(face.a.mantissa.x, w.mantissa.x);
  let y = multiply(face.a.mantissa.y, w.mantissa.x);
  let z = multiply(face.a.mantissa.z, w.mantissa.x);
  low = vec3<u32>(x.x, y.x, z.x);
  high = vec3<u32>(x.y, y.y, z.y);
  let exponent = face.a.exponent + w.exponent - 149;
  let span = hull(bit_window_of(l), bit_window((low | high) == vec3<u32>(0u), exponent, face.a.length + w.length));
  let fits = face.fits && span.y - span.x <= LIGHT_BITS;
  let light_digits = shifted_digits(l.mantissa, vec3<u32>(0u), l.exponent - span.x, l.sign);
  let t = difference(light_digits, shifted_digits(low, high, exponent - span.x, face.a.sign ^ w.sign));
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

// The sign of the determinant: 1, 0 or -1, or 2 if the numbers do not fit.
fn fixed_sign(face: FixedFace, light: vec4<u32>) -> i32 {
  let sum = fixed_sum(face, light);
  if (!sum.fits) {
    return 2;
  }
  let first = carry_columns(sum.first, 0);
  let second = carry_columns(sum.second, first.x);
  let third = carry_columns(sum.third, second.x);
  let carry = third.x;
  let any_bit = first.y | second.y | third.y;
  if (carry < 0) {
    return -1;
  }
  return select(0, 1, (carry | any_bit) != 0);
}
