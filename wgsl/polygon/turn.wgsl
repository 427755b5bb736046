// The turn of three points as seen from a light, exactly: the sign of det[b - a, c - a, l - w a], which bounds on rounding, fixed
// point or integers decide. Where it is 0, the light is moved by (e, e^2, e^3). NUMERICS.md, "Outlines".

struct Turn {
  // For the light as given, and for the light moved. The latter is 0 only if the points are in line.
  given: i32,
  moved: i32,
}

// The light, or the axis along which it moves in a tie.
fn light_or_axis(place: u32, tie: u32) -> vec4<u32> {
  switch (tie) {
    case 0u: { return given_light(place); }
    case 1u: { return vec4<u32>(0x3f800000u, 0u, 0u, 0u); }
    case 2u: { return vec4<u32>(0u, 0x3f800000u, 0u, 0u); }
    default: { return vec4<u32>(0u, 0u, 0x3f800000u, 0u); }
  }
}

// The sign for the light as given, as far as a bound makes it certain, otherwise 0.
fn certain_turn(a_bits: vec3<u32>, b_bits: vec3<u32>, c_bits: vec3<u32>, place: u32) -> i32 {
  let magnitude = largest_magnitude(a_bits, b_bits, c_bits);
  if (magnitude >= LARGE) {
    return 0;
  }
  let a = bitcast<vec3<f32>>(a_bits);
  let u = bitcast<vec3<f32>>(b_bits) - a;
  let v = bitcast<vec3<f32>>(c_bits) - a;
  let size = (abs(u.x) + abs(u.y) + abs(u.z)) * (abs(v.x) + abs(v.y) + abs(v.z));
  let bound = face_bound(size, bitcast<f32>(magnitude), lights_reach());
  let d = local_form(cross_product(u, v), a, scaled_light(place));
  return select(0, 1, d > bound) - select(0, 1, d < -bound);
}

fn turn(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>, place: u32) -> Turn {
  if (all(a == b) || all(b == c) || all(c == a)) {
    return Turn(0, 0);
  }
  let certain = certain_turn(a, b, c, place);
  var found = Turn(certain, certain);
  if (certain != 0) {
    return found;
  }
  let fixed = fixed_face(a, b, c);
  // Turns: 4.
  for (var tie = 0u; tie < 4u && found.moved == 0; tie++) {
    let light = light_or_axis(place, tie);
    var sign = fixed_sign(fixed, light);
    if (sign == 2) {
      sign = exact_sign(a, b, c, light);
    }
    found.given = select(found.given, sign, tie == 0u);
    found.moved = sign;
  }
  return found;
}

// Whether `middle`, which is on the line through the others, is strictly between them.
fn is_between(p: vec3<u32>, middle: vec3<u32>, q: vec3<u32>) -> bool {
  let before = ordered(p) < ordered(middle);
  return any((before != (ordered(q) < ordered(middle))) & (p != middle) & (q != middle));
}

// Integers in the order of the floats.
fn ordered(bits: vec3<u32>) -> vec3<u32> {
  return select(bits | vec3<u32>(0x80000000u), ~bits, bits >= vec3<u32>(0x80000000u));
}
