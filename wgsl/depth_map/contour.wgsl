// The contours of a depth map: depths as integers, marked edges, and the distances of surfaces beside them.
// docs/numerics/contours.md.

#import depth_map/samples

struct ContourShape {
  // Tiles of 16 × 16 cells across, and all of them.
  tiles: vec2<u32>,
  // Words of a row of marks.
  words: u32,
  // Walls that the list has room for.
  capacity: u32,
  // The distance that the samples of an edge must be apart, more than their slopes tell.
  threshold: i32,
  // The distance from which on they are at a jump, whatever is behind it.
  sure: i32,
  // How far a segment may be from a place of the contour.
  sideways: i32,
  // How far the ends of a wall may be from those of the surfaces there: a number, and the bits that it and distances are moved
  // down by.
  tolerance: i32,
  shift: u32,
  // The move away from the light: parts of 256 of a texel's difference, parts of 2²⁹ of the depth, a distance.
  slope_bias: i32,
  share: i32,
  constant: i32,
}

@group(0) @binding(6) var<uniform> contour: ContourShape;

const TILE: i32 = 16;
// Invocations of a tile in `contour_walls`.
const WALKERS: u32 = 64u;
// Parts of a texel that places count.
const TEXEL: i32 = 256;
// The distance of the far end of the device depths from the near end.
const RANGE: i32 = 0x20000000;
// The distance of a sample that casts nothing.
const FAR: i32 = 0x7fffffff;
// The nearest that a place may be to a sample.
const LEAST: i32 = 16;

// The corners of a cell in turn. Edge b lies between the corners b and b + 1. Walked over from within the cell, the first is on
// the left.
fn turn(corner: u32) -> vec2<i32> {
  return vec2<i32>((vec2<u32>(6u, 12u) >> vec2<u32>(corner & 3u)) & vec2<u32>(1u));
}

// The step over an edge of a cell: at the top, right, bottom and left.
fn out_of(bit: u32) -> vec2<i32> {
  let sign = select(-1, 1, bit == 1u || bit == 2u);
  return select(vec2<i32>(0, sign), vec2<i32>(sign, 0), (bit & 1u) == 1u);
}

fn step_along(axis: u32) -> vec2<i32> {
  return select(vec2<i32>(1, 0), vec2<i32>(0, 1), axis == 1u);
}

// The first sample of an edge of a cell. The edge goes on from it to the right, or down if the bit is odd.
fn edge_of_cell(cell: vec2<i32>, bit: u32) -> vec2<i32> {
  return select(cell, cell + out_of(bit), bit == 1u || bit == 2u);
}

fn smaller(a: i32, b: i32) -> i32 {
  return select(select(b, a, abs(a) < abs(b)), 0, (a ^ b) < 0);
}

// `a` times parts of 256, rounded down.
fn parts(a: i32, count: i32) -> i32 {
  return (a >> 8u) * count + (((a & 255) * count) >> 8u);
}

// The distance of a sample from the near plane.
fn distance_at(at: vec2<i32>) -> i32 {
  let key = key_at(vec2<u32>(at));
  let bits = depth_bits(key);
  let word = (bits & 0x007fffffu) | 0x00800000u;
  let exponent = bits >> 23u;
  let large = word << min(max(exponent, 121u) - 121u, 31u);
  let small = word >> min(121u - min(exponent, 121u), 31u);
  let depth = select(i32(select(small, large, exponent > 121u)), 0, exponent == 0u);
  return select(min(select(depth, RANGE - depth, depth_map.is_reversed != 0u), RANGE - 1), FAR, key == FAR_KEY);
}

// How far the surface at a sample goes away for each step in a direction, as told by the two samples on the other side.
fn slope_to_step(at: vec2<i32>, step: vec2<i32>) -> i32 {
  let own = distance_at(at);
  let first = distance_at(at - step);
  let second = distance_at(at - 2 * step);
  return select(smaller(own - first, first - second), 0, max(own, max(first, second)) == FAR);
}

// The slope to both sides that is smaller, 0 at a ridge or where a side is far.
fn slope_between(at: vec2<i32>, step: vec2<i32>) -> i32 {
  let before = distance_at(at - step);
  let own = distance_at(at);
  let after = distance_at(at + step);
  return select(abs(smaller(own - before, after - own)), 0, max(own, max(before, after)) == FAR);
}

// What the depths of the map and of the eye may be off by, at a distance.
fn precision_at(own: i32) -> i32 {
  let depth = select(own, RANGE - own, depth_map.is_reversed != 0u);
  return (((depth >> 10u) * contour.share) >> 19u) + contour.constant;
}

// The distance of a sample, moved away from the light.
fn moved_distance(at: vec2<i32>) -> i32 {
  let own = distance_at(at);
  if (own == FAR) {
    return FAR;
  }
  let slopes = slope_between(at, vec2<i32>(1, 0)) + slope_between(at, vec2<i32>(0, 1));
  // It is cut off before it overflows.
  let is_large = (slopes >> 8u) > (RANGE / 2) / max(contour.slope_bias, 1);
  let of_slopes = select(parts(slopes, contour.slope_bias), RANGE / 2, is_large);
  return own + min(of_slopes + precision_at(own), (RANGE - own) / 2);
}

// No place: the depths or the run do not tell.
const UNTOLD: i32 = -1;
// Units that the last difference before a rim has at least, and how many times what depths may be off by it is.
const LEAST_RISE: i32 = 1024;
const PRECISE: i32 = 16;

// How a smooth surface bends towards a rim. The surface along a row is taken for a conic whose tangent at the rim is a ray of the
// light: the square of the distance from the rim's depth is a quadratic polynomial.
struct Conic {
  // The last difference, in eleven bits. UNTOLD: the samples are on no such conic.
  u: i32,
  // The rim's depth less that of the last sample, in the same units.
  y: i32,
  // Differences of the squares, from the last sample on.
  first: i32,
  second: i32,
}

// The conic through a sample and the three before it, in the direction of a step. A fourth before it has to lie on it: but for a
// part of the square of the last difference.
fn conic_before(last: vec2<i32>, step: vec2<i32>, off: i32) -> Conic {
  let none = Conic(UNTOLD, 0, 0, 0);
  let z = distance_at(last);
  var gone: array<i32, 5>;
  for (var number = 1; number < 5; number++) {
    let own = distance_at(last - number * step);
    if (own == FAR || z - own <= gone[number - 1]) {
      return none;
    }
    gone[number] = z - own;
  }
  if (gone[1] < max(LEAST_RISE, PRECISE * min(precision_at(z), RANGE / PRECISE))) {
    return none;
  }
  // Eleven bits of the largest difference are enough.
  let shift = u32(max(21 - i32(countLeadingZeros(u32(gone[1]))), 0));
  let u = gone[1] >> shift;
  let v = (gone[2] >> shift) - u;
  let w = (gone[3] >> shift) - u - v;
  let x = (gone[4] >> shift) - u - v - w;
  let bend = u - 2 * v + w;
  if (max(v, max(w, x)) > u || bend <= 0) {
    return none;
  }
  let rise = 4 * u * v + 2 * v * v - u * u - w * (2 * (u + v) + w);
  if (rise < 0 || rise / bend > 16 * u) {
    return none;
  }
  let y = rise / (2 * bend);
  let first = u * (2 * y + u);
  let second = v * (2 * (y + u) + v);
  let third = w * (2 * (y + u + v) + w);
  let fourth = x * (2 * (y + u + v + w) + x);
  if (abs(fourth - 2 * third + second) > u * u / off) {
    return none;
  }
  return Conic(u, y, first, second);
}
