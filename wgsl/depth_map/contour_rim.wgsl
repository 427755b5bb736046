// Contour rim: where a smooth surface ends, from the depths of its last samples.

// No place: the depths or the run do not tell.
const UNTOLD: i32 = -1;
// Parts of a texel up to which a rim may lie beyond the other sample: rounding brings it there.
const BEYOND: i32 = 24;
// Units that the last difference before a rim has at least, and how many times what depths may be off by it is.
const LEAST_RISE: i32 = 1024;
const PRECISE: i32 = 16;

// The rim of a smooth surface beyond its last sample, in the direction of a step. x: its place, in parts of a texel from the
// sample on. y: how much farther away it is.
//
// The surface along a row is taken for a conic whose tangent at the rim is a ray of the light: the square of the distance from
// the rim's depth is a quadratic polynomial. Four samples tell it, and a fifth has to lie on it.
fn rim_beyond(last: vec2<i32>, step: vec2<i32>) -> vec2<i32> {
  let z = distance_at(last);
  var gone: array<i32, 5>;
  for (var number = 1; number < 5; number++) {
    let at = last - number * step;
    let own = distance_at(at);
    if (own == FAR || is_marked_before(at + step, step) || z - own <= gone[number - 1]) {
      return vec2<i32>(UNTOLD);
    }
    gone[number] = z - own;
  }
  if (gone[1] < max(LEAST_RISE, PRECISE * min(precision_at(z), RANGE / PRECISE))) {
    return vec2<i32>(UNTOLD);
  }
  // Eleven bits of the largest difference are enough.
  let shift = u32(max(21 - i32(countLeadingZeros(u32(gone[1]))), 0));
  let u = gone[1] >> shift;
  let v = (gone[2] >> shift) - u;
  let w = (gone[3] >> shift) - u - v;
  let x = (gone[4] >> shift) - u - v - w;
  let bend = u - 2 * v + w;
  if (max(v, max(w, x)) > u || bend <= 0) {
    return vec2<i32>(UNTOLD);
  }
  // The rim's depth less that of the last sample.
  let rise = 4 * u * v + 2 * v * v - u * u - w * (2 * (u + v) + w);
  if (rise < 0 || rise / bend > 6 * u) {
    return vec2<i32>(UNTOLD);
  }
  let y = rise / (2 * bend);
  // Differences of the squares.
  let first = u * (2 * y + u);
  let second = v * (2 * (y + u) + v);
  let third = w * (2 * (y + u + v) + w);
  let fourth = x * (2 * (y + u + v + w) + x);
  if (abs(fourth - 2 * third + second) > u * u / 5) {
    return vec2<i32>(UNTOLD);
  }
  // y² = slope · place + curve · place²
  let square = (y * y) >> 12u;
  let curve = (first - second) >> 13u;
  let slope = (first + (first - second) / 2) >> 12u;
  if (curve * 4 < -slope) {
    return vec2<i32>(UNTOLD);
  }
  var place = 0;
  for (var part = 256; part > 0; part /= 2) {
    let next = place + part;
    if ((slope * next + (curve * next * next) / TEXEL) <= square * TEXEL) {
      place = next;
    }
  }
  if (place > TEXEL + BEYOND) {
    return vec2<i32>(UNTOLD);
  }
  return vec2<i32>(min(place, TEXEL), min(y, (RANGE / 2) >> shift) << shift);
}

// How far the surface at a sample goes away on the way to a place beside it, in parts of a texel in the direction of a step. It
// goes on to the rim, if depths tell of one. Else it goes on as between the last samples. Where it bends away from the light, as towards a rim, it goes on bending: the slope grows
// twice as it did last, to four times at most.
fn way_on(at: vec2<i32>, step: vec2<i32>, place: i32) -> i32 {
  if (is_marked_before(at, step)) {
    return 0;
  }
  let rim = rim_beyond(at, step);
  if (rim.x != UNTOLD) {
    return parts(rim.y, min(place * TEXEL / max(rim.x, LEAST), 2 * TEXEL));
  }
  let first = distance_at(at - step);
  let last = distance_at(at) - first;
  if (is_marked_before(at - step, step)) {
    return parts(last, place);
  }
  let before = first - distance_at(at - 2 * step);
  // Jumps are not marked without a threshold.
  if (contour.threshold >= RANGE) {
    return parts(smaller(last, before), place);
  }
  if (last <= max(before, 0)) {
    return parts(last, place);
  }
  let growth = clamp(last / max(max(before, last / 2) >> 8u, 1), TEXEL, 2 * TEXEL);
  return parts(parts(parts(min(last, RANGE / 8), place), growth), growth);
}

// The distance of the surface of a sample at a place beside it, in parts of a texel in the direction of a step.
fn surface_distance(at: vec2<i32>, step: vec2<i32>, place: i32) -> i32 {
  let own = distance_at(at);
  if (own == FAR) {
    return FAR;
  }
  return clamp(moved_distance(at) + way_on(at, step, place), 0, own + (RANGE - own) / 2);
}
