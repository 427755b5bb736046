// Whether two depths of a perspective map are farther from each other than a distance in world units, exactly: the sign of
// ratio · |a − b| − |a − i| · |b − i|, with the depth i at infinity. NUMERICS.md, "Volumes from depth maps".

const WIDE: u32 = 16u;
// An integer, lowest word first, in units of 2⁻¹⁴⁹ or their square.
alias Wide = array<u32, WIDE>;

// WIDE, which a compiler does not know, so that it leaves the loops as they are. Unrolled, they took a minute to compile.
fn words() -> u32 {
  return min(WIDE, WIDE + depth_map.cells);
}

fn wide_mantissa(bits: u32) -> u32 {
  return select((bits & 0x7fffffu) | 0x800000u, 0u, (bits & 0x7fffffffu) == 0u);
}

// A word, moved up by some places.
fn wide(word: u32, places: u32) -> Wide {
  var result = Wide();
  let at = places >> 5u;
  let shift = places & 31u;
  result[at] = word << shift;
  if (shift != 0u) {
    result[at + 1u] = word >> (32u - shift);
  }
  return result;
}

// The absolute value of a float that is 0 or normal.
fn wide_of(bits: u32) -> Wide {
  let exponent = (bits >> 23u) & 0xffu;
  return wide(wide_mantissa(bits), max(exponent, 1u) - 1u);
}

fn is_larger(a: Wide, b: Wide) -> bool {
  var x = a;
  var y = b;
  for (var at = words(); at > 0u; at--) {
    if (x[at - 1u] != y[at - 1u]) {
      return x[at - 1u] > y[at - 1u];
    }
  }
  return false;
}

fn wide_sum(a: Wide, b: Wide) -> Wide {
  var x = a;
  var y = b;
  var carry = 0u;
  for (var at = 0u; at < words(); at++) {
    let once = x[at] + y[at];
    let twice = once + carry;
    carry = select(0u, 1u, once < x[at]) | select(0u, 1u, twice < once);
    x[at] = twice;
  }
  return x;
}

fn wide_distance(a: Wide, b: Wide) -> Wide {
  var x = a;
  var y = b;
  if (is_larger(b, a)) {
    x = b;
    y = a;
  }
  var borrow = 0u;
  for (var at = 0u; at < words(); at++) {
    let once = x[at] - y[at];
    let twice = once - borrow;
    borrow = select(0u, 1u, x[at] < y[at]) | select(0u, 1u, once < borrow);
    x[at] = twice;
  }
  return x;
}

// Low and high word.
fn word_product(a: u32, b: u32) -> vec2<u32> {
  let low = (a & 0xffffu) * (b & 0xffffu);
  let middle = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
  let other = (a & 0xffffu) * (b >> 16u) + (middle & 0xffffu);
  return vec2<u32>((other << 16u) | (low & 0xffffu), (a >> 16u) * (b >> 16u) + (middle >> 16u) + (other >> 16u));
}

// Words beyond the last are 0 for what is multiplied here.
fn wide_product(a: Wide, b: Wide) -> Wide {
  var x = a;
  var y = b;
  var result = Wide();
  for (var i = 0u; i < words(); i++) {
    if (x[i] == 0u) {
      continue;
    }
    var carry = 0u;
    for (var j = 0u; i + j < words(); j++) {
      let product = word_product(x[i], y[j]);
      let once = result[i + j] + product.x;
      let twice = once + carry;
      carry = product.y + select(0u, 1u, once < product.x) + select(0u, 1u, twice < once);
      result[i + j] = twice;
    }
  }
  return result;
}

// The distance of a depth from the one at infinity.
fn from_infinity(bits: u32) -> Wide {
  let own = wide_of(bits);
  let infinity = wide_of(edge_rule.at_infinity);
  if ((edge_rule.at_infinity >> 31u) != 0u) {
    return wide_sum(own, infinity);
  }
  return wide_distance(own, infinity);
}

fn exact_world_step(a: u32, b: u32, ratio: u32) -> bool {
  return is_larger(wide_product(wide_of(ratio), wide_distance(wide_of(a), wide_of(b))), wide_product(from_infinity(a), from_infinity(b)));
}

// Whether floats tell: 0 or 1; or 2, where the terms are nearly equal, very large or very small.
fn world_step_by_floats(a: u32, b: u32, ratio: u32) -> u32 {
  let infinity = bitcast<f32>(edge_rule.at_infinity);
  let step = bitcast<f32>(ratio) * abs(bitcast<f32>(a) - bitcast<f32>(b));
  let most = abs(bitcast<f32>(a) - infinity) * abs(bitcast<f32>(b) - infinity);
  let is_plain = (min(step, most) > 1e-30) & (max(step, most) < 1e30);
  let is_told = is_plain & ((step > 1.0001 * most) | (most > 1.0001 * step));
  // Equal depths are no step, whatever the ratio is.
  return select(select(2u, select(0u, 1u, step > most), is_told), 0u, a == b);
}
