// Exact facing: the masks of the faces that the facing stage left undecided. A bound of each light's own decides most
// signs of det[b - a, c - a, l - w a] (NUMERICS.md, "Filter"); the rest is settled in pure integer arithmetic that no
// compiler can round, fuse or flush, exact for every finite f32 ("Exact facing").

@group(0) @binding(0) var<uniform> word: LightWord;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(6) var<storage, read> faces: array<u32>;
@group(0) @binding(7) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> statistics: Statistics;
// How many faces are undecided, then the faces, counted from the chunk's first.
@group(0) @binding(9) var<storage, read> undecided: array<u32>;

// Digits of 24 bits; 48 of them hold every sum of products of four finite f32.
const DIGITS: u32 = 48u;
const DIGIT: u32 = 0xffffffu;
var<private> digits: array<i32, 48>;

// a, b, c, l, w and 1 as integers: mantissas, exponents (the value is mantissa * 2^(exponent - 149)) and signs.
var<private> mantissas: array<u32, 14>;
var<private> exponents: array<u32, 14>;
var<private> negatives: array<u32, 14>;

fn decode(at: u32, bits: u32) {
  let exponent = (bits >> 23u) & 0xffu;
  mantissas[at] = (bits & 0x7fffffu) | select(0u, 0x800000u, exponent != 0u);
  exponents[at] = max(exponent, 1u) - 1u;
  negatives[at] = bits >> 31u;
}

fn decode_vertex(at: u32, bits: vec3<u32>) {
  decode(at, bits.x);
  decode(at + 1u, bits.y);
  decode(at + 2u, bits.z);
}

// The determinant is det(b, c, l) + det(a, b, l) + det(c, a, l) + w det(a, c, b): 24 products of four, where those
// without w have a 1. Operands of the products, six of each determinant; the second of a pair is subtracted.
fn operands(term: u32) -> vec4<u32> {
  let determinant = term / 6u;
  let axis = term % 6u / 2u;
  let turned = (term & 1u) != 0u;
  let second = (axis + select(1u, 2u, turned)) % 3u;
  let third = (axis + select(2u, 1u, turned)) % 3u;
  // First operands of the determinants' three vectors, a nibble each, and the factor.
  var at = vec4<u32>(3u, 6u, 9u, 13u);
  switch (determinant) {
    case 0u: {}
    case 1u: { at = vec4<u32>(0u, 3u, 9u, 13u); }
    case 2u: { at = vec4<u32>(6u, 0u, 9u, 13u); }
    default: { at = vec4<u32>(0u, 6u, 3u, 12u); }
  }
  return at + vec4<u32>(axis, second, third, 0u);
}

fn exponent_of(at: vec4<u32>) -> u32 {
  return exponents[at.x] + exponents[at.y] + exponents[at.z] + exponents[at.w];
}

fn is_zero(at: vec4<u32>) -> bool {
  return mantissas[at.x] == 0u || mantissas[at.y] == 0u || mantissas[at.z] == 0u || mantissas[at.w] == 0u;
}

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

fn add(at: u32, value: u32, negative: bool) {
  digits[at] += select(i32(value), -i32(value), negative);
}

// Adds a term at its place over `least`, the exponent of the lowest digit.
fn add_term(at: vec4<u32>, turned: bool, least: u32) {
  let two = multiply(mantissas[at.x], mantissas[at.y]);
  let three = multiply_three(vec3<u32>(two, 0u), mantissas[at.z]).xyz;
  let product = multiply_three(three, mantissas[at.w]);
  let above = exponent_of(at) - least;
  let digit = above / 24u;
  let shift = above % 24u;
  let negative = ((negatives[at.x] + negatives[at.y] + negatives[at.z] + negatives[at.w]) & 1u) != u32(turned);
  for (var part = 0u; part < 4u; part++) {
    let value = product[part];
    add(digit + part, (value & (DIGIT >> shift)) << shift, negative);
    add(digit + part + 1u, value >> (24u - shift), negative);
  }
}

// The sign of the determinant: 1, 0 or -1.
fn determinant_sign() -> i32 {
  var least = 0xffffffffu;
  var most = 0u;
  for (var term = 0u; term < 24u; term++) {
    let at = operands(term);
    if (!is_zero(at)) {
      least = min(least, exponent_of(at));
      most = max(most, exponent_of(at));
    }
  }
  if (least > most) {
    return 0;
  }
  // Each product has four digits and its shift one more; sums of 24 of them carry into a last.
  let used = min((most - least) / 24u + 6u, DIGITS);
  for (var at = 0u; at < used; at++) {
    digits[at] = 0;
  }
  for (var term = 0u; term < 24u; term++) {
    let at = operands(term);
    if (!is_zero(at)) {
      add_term(at, (term & 1u) != 0u, least);
    }
  }
  var carry = 0;
  var any_digit = 0;
  for (var at = 0u; at < used; at++) {
    let sum = digits[at] + carry;
    any_digit |= sum & i32(DIGIT);
    carry = sum >> 24u;
  }
  if (carry < 0) {
    return -1;
  }
  return select(0, 1, carry > 0 || any_digit != 0);
}

struct Face {
  corners: vec3<u32>,
  a: vec3<u32>,
  b: vec3<u32>,
  c: vec3<u32>,
}

// Bits of facing lights and of those in doubt.
struct Decision {
  facing: u32,
  doubt: u32,
}

// By f32 where the light's own bound allows it.
fn filter_lights(face: Face) -> Decision {
  let largest = largest_magnitude(face.a, face.b, face.c);
  var decision = Decision(0u, word.live);
  if (largest >= LARGE) {
    return decision;
  }
  let a = bitcast<vec3<f32>>(face.a);
  let u = bitcast<vec3<f32>>(face.b) - a;
  let v = bitcast<vec3<f32>>(face.c) - a;
  let n = cross_product(u, v);
  // The normal's components with absolute values throughout.
  let n_abs = vec3<f32>(
    abs(u.y) * abs(v.z) + abs(u.z) * abs(v.y),
    abs(u.z) * abs(v.x) + abs(u.x) * abs(v.z),
    abs(u.x) * abs(v.y) + abs(u.y) * abs(v.x),
  );
  let underflow = underflow_bound(bitcast<f32>(largest));
  for (var rest = word.live & ~word.doubtful; rest != 0u; rest &= rest - 1u) {
    let light = firstTrailingBit(rest);
    let l = word.lights[light];
    let to_light = l.xyz - l.w * a;
    let d = local_form(n, a, l);
    // The rounding of w a counts only where w is no power of two.
    let sizes = abs(to_light) + word.inexact_w[light / 4u][light % 4u] * abs(a);
    let bound = RELATIVE * (n_abs.x * sizes.x + n_abs.y * sizes.y + n_abs.z * sizes.z) +
      underflow * (1.0 + sizes.x + sizes.y + sizes.z);
    if (abs(d) > bound) {
      decision.doubt &= ~(1u << light);
      decision.facing |= select(0u, 1u, d > 0.0) << light;
    }
  }
  return decision;
}

// The bits of 1.0.
const ONE: u32 = 0x3f800000u;

// A point light in the plane of a face that lies along two axes is on neither side; of a face that is a line none is.
fn leave_out_coplanar(doubt: u32, face: Face) -> u32 {
  if (all(face.a == face.b) || all(face.a == face.c) || all(face.b == face.c)) {
    return 0u;
  }
  let flat = (face.a == face.b) & (face.a == face.c);
  var left = doubt;
  for (var rest = select(0u, doubt, any(flat)); rest != 0u; rest &= rest - 1u) {
    let at = firstTrailingBit(rest);
    let light = word.light_bits[at];
    if (light.w == ONE && any(flat & (light.xyz == face.a))) {
      left &= ~(1u << at);
    }
  }
  return left;
}

// The bits of the lights in doubt, by integers.
fn settle(doubt: u32, face: Face) -> u32 {
  decode_vertex(0u, face.a);
  decode_vertex(3u, face.b);
  decode_vertex(6u, face.c);
  mantissas[13] = 1u;
  exponents[13] = 149u;
  negatives[13] = 0u;
  var facing = 0u;
  var zeros = 0u;
  for (var rest = doubt; rest != 0u; rest &= rest - 1u) {
    let light = firstTrailingBit(rest);
    let bits = word.light_bits[light];
    decode_vertex(9u, bits.xyz);
    decode(12u, bits.w);
    let sign = determinant_sign();
    facing |= select(0u, 1u, sign > 0) << light;
    zeros += select(0u, 1u, sign == 0);
  }
  atomicAdd(&statistics.undecided_pairs, countOneBits(doubt));
  if (zeros != 0u) {
    atomicAdd(&statistics.exact_zeros, zeros);
  }
  return facing;
}

// The mask of one face.
fn decide(index: u32) -> u32 {
  var face: Face;
  face.corners = vec3<u32>(faces[3u * index], faces[3u * index + 1u], faces[3u * index + 2u]);
  face.a = position_bits(face.corners.x, word.position_offset, word.position_stride);
  face.b = position_bits(face.corners.y, word.position_offset, word.position_stride);
  face.c = position_bits(face.corners.z, word.position_offset, word.position_stride);
  if (largest_magnitude(face.a, face.b, face.c) >= INFINITE) {
    if (chunk.first_light == 0u) {
      atomicAdd(&statistics.non_finite_faces, 1u);
    }
    return 0u;
  }
  if (face.corners.x == face.corners.y || face.corners.y == face.corners.z || face.corners.z == face.corners.x) {
    return 0u;
  }
  var decision = filter_lights(face);
  decision.doubt = leave_out_coplanar(decision.doubt, face);
  if (decision.doubt != 0u) {
    decision.facing |= settle(decision.doubt, face);
  }
  return decision.facing;
}

@compute @workgroup_size(64)
fn exact_facing(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let index = ((group.z * groups.y + group.y) * groups.x + group.x) * 64u + local;
  if (undecided[0] >= arrayLength(&undecided)) {
    // The list overflowed: every face is taken.
    if (index < chunk.count) {
      facing_masks[index] = decide(index);
    }
  } else if (index < undecided[0]) {
    let face = undecided[index + 1u];
    facing_masks[face] = decide(face);
  }
}
