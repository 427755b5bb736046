// The sign of det[b - a, c - a, l - w a] for any finite f32 whatever, in pure integer arithmetic: rare and slow, so as
// short as can be. NUMERICS.md, "Exact facing".

// Digits of 24 bits; 48 of them hold every sum of products of four finite f32.
const DIGITS: u32 = 48u;
const DIGIT: u32 = 0xffffffu;
// Zeros between uses.
var<private> digits: array<i32, 48>;

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

// Adds the product of four mantissas `above` bits over the lowest digit.
fn add_product(mantissas: vec4<u32>, above: u32, negative: bool) {
  let two = multiply(mantissas.x, mantissas.y);
  let three = multiply_three(vec3<u32>(two, 0u), mantissas.z).xyz;
  var product = multiply_three(three, mantissas.w);
  let shift = above % 24u;
  let end = above / 24u + 5u;
  var below = 0u;
  for (var at = above / 24u; at < end; at++) {
    let value = i32(((product.x << shift) & DIGIT) | below);
    digits[at] += select(value, -value, negative);
    below = product.x >> (24u - shift);
    product = vec4<u32>(product.yzw, 0u);
  }
}

// The sign of the determinant, from bits: 1, 0 or -1.
fn exact_sign(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>, light: vec4<u32>) -> i32 {
  // det(b, c, l) + det(a, b, l) + det(c, a, l) + w det(a, c, b): 24 products of four, where those without w have a 1. Of
  // each pair the second is subtracted; then the next axis comes first.
  var p = b;
  var q = c;
  var r = light.xyz;
  var factor = 0x3f800000u;
  for (var term = 0u; term < 24u; term++) {
    let is_second = (term & 1u) != 0u;
    let bits = vec4<u32>(p.x, select(q.y, q.z, is_second), select(r.z, r.y, is_second), factor);
    let exponents = (bits >> vec4<u32>(23u)) & vec4<u32>(0xffu);
    let implied = select(vec4<u32>(0u), vec4<u32>(0x800000u), exponents != vec4<u32>(0u));
    let places = max(exponents, vec4<u32>(1u)) - 1u;
    let signs = bits.x ^ bits.y ^ bits.z ^ bits.w ^ (term << 31u);
    add_product((bits & vec4<u32>(0x7fffffu)) | implied, places.x + places.y + places.z + places.w, signs >> 31u != 0u);
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
  var carry = 0;
  var any_digit = 0;
  for (var at = 0u; at < DIGITS; at++) {
    let sum = digits[at] + carry;
    any_digit |= sum & i32(DIGIT);
    carry = sum >> 24u;
    digits[at] = 0;
  }
  if (carry < 0) {
    return -1;
  }
  return select(0, 1, carry > 0 || any_digit != 0);
}
