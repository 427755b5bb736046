// Contours of a depth map: depths as integers, slopes, and how smooth surfaces end. Samples are points of a lattice, a texel
// apart; a cell is the square between four of them. A contour is the line where a surface ends before another or before nothing,
// as the light sees it: it crosses the edges of cells at a jump. It is cut into straight segments; over each a wall along rays of
// the light is drawn, in place of triangles. Imported by the stages `contour_…`, `depth_walls`, `depth_near_walls`,
// contour_rim.wgsl. A distance is the device depth from the near plane on, in units of 2⁻²⁹ of its range; FAR is nothing. A place
// is where a contour crosses an edge, in 256 parts of a texel; a rim, where a smooth surface bends away from the light. Tiles
// have 16 × 16 cells. `at` is a sample, also one outside of the lattice, which is far. Importers bind what samples.wgsl has, of a
// single map. All is integer arithmetic, so lists of walls are the same on every device, to the word. docs/numerics/contours.md,
// shows that nothing overflows: keep shifts and clamps.

#import depth_map/samples

struct ContourShape {
  // Tiles of 16 × 16 cells across, and all of them.
  tiles: vec2<u32>,
  // Words of a row of marks.
  words: u32,
  // Walls that the list has room for.
  capacity: u32,
  // At a jump the distances of an edge's samples differ by more than this, and by so much more than slopes beside it. If it is
  // RANGE, only far samples and other objects make jumps.
  threshold: i32,
  // A larger difference need not be twice those beside it to be a jump.
  sure: i32,
  // How far a segment may pass from the place on an edge, in parts of 256 of a texel.
  sideways: i32,
  // How far surfaces may be from the line between a wall's ends: a distance. It, and distances that are compared with it, are
  // shifted down by `shift` bits.
  tolerance: i32,
  shift: u32,
  // The move of surfaces away from the light is the sum of these, up to a limit (`moved_distance`):
  slope_bias: i32, // times the slope for each texel, in parts of 256;
  share: i32, // times the depth, in parts of 2²⁹;
  constant: i32, // a distance.
}

@group(0) @binding(6) var<uniform> contour: ContourShape;

const TILE: i32 = 16;
// Invocations of a tile in `contour_walls`.
const WALKERS: u32 = 64u;
// Parts of a texel that places count.
const TEXEL: i32 = 256;
// The distance of the far end of the device depths from the near end. Samples that cast have smaller ones.
const RANGE: i32 = 0x20000000;
// The distance of a sample that casts nothing.
const FAR: i32 = 0x7fffffff;
// The nearest that a place may be to a sample, in parts of a texel.
const LEAST: i32 = 16;

// The offset of a corner of a cell (its number modulo 4) from the cell's first sample: from (0, 0) on, clockwise with rows
// downwards. Edge `bit` lies between the corners `bit` and `bit` + 1: 0 top, 1 right, 2 bottom, 3 left. On the way out of the
// cell over it, corner `bit` is on the left.
fn corner_offset(corner: u32) -> vec2<i32> {
  return vec2<i32>((vec2<u32>(6u, 12u) >> vec2<u32>(corner & 3u)) & vec2<u32>(1u));
}

// The step from a cell to the one beyond its edge `bit`.
fn out_of(bit: u32) -> vec2<i32> {
  let sign = select(-1, 1, bit == 1u || bit == 2u);
  return select(vec2<i32>(0, sign), vec2<i32>(sign, 0), (bit & 1u) == 1u);
}

// From a sample to the next: 0 to the right, 1 down.
fn step_along(axis: u32) -> vec2<i32> {
  return select(vec2<i32>(1, 0), vec2<i32>(0, 1), axis == 1u);
}

// The first sample of edge `bit` of a cell. The edge goes on from it to the right, or down if `bit` is odd.
fn edge_of_cell(cell: vec2<i32>, bit: u32) -> vec2<i32> {
  return select(cell, cell + out_of(bit), bit == 1u || bit == 2u);
}

// The one that is nearer to 0, or 0 if their signs differ.
fn smaller(a: i32, b: i32) -> i32 {
  return select(select(b, a, abs(a) < abs(b)), 0, (a ^ b) < 0);
}

// `a` · `count` / 256, rounded down. The result must fit.
fn parts(a: i32, count: i32) -> i32 {
  return (a >> 8u) * count + (((a & 255) * count) >> 8u);
}

// The distance of a sample from the near plane, of its depth truncated to units; or FAR. It is below RANGE: else a reversed depth
// next to 0 would be at the far end. Keys (samples.wgsl) have depths from 0 to 1: a negative one counts as 0, more than 1 as 1,
// and NaN as far.
fn distance_at(at: vec2<i32>) -> i32 {
  let key = load_key(vec2<u32>(at));
  let bits = depth_bits(key);
  let word = (bits & 0x007fffffu) | 0x00800000u;
  let exponent = bits >> 23u;
  let large = word << min(max(exponent, 121u) - 121u, 31u);
  let small = word >> min(121u - min(exponent, 121u), 31u);
  let depth = select(i32(select(small, large, exponent > 121u)), 0, exponent == 0u);
  return select(min(select(depth, RANGE - depth, depth_map.is_reversed != 0u), RANGE - 1), FAR, key == FAR_KEY);
}

// How far the surface at a sample goes away for each step in a direction, as told by the two samples on the other side: the
// smaller difference. 0 if signs differ or one is far.
fn slope_to_step(at: vec2<i32>, step: vec2<i32>) -> i32 {
  let own = distance_at(at);
  let first = distance_at(at - step);
  let second = distance_at(at - 2 * step);
  return select(smaller(own - first, first - second), 0, max(own, max(first, second)) == FAR);
}

// The smaller size of the two differences to the samples before and after. 0 at a ridge or where one is far.
fn slope_between(at: vec2<i32>, step: vec2<i32>) -> i32 {
  let before = distance_at(at - step);
  let own = distance_at(at);
  let after = distance_at(at + step);
  return select(abs(smaller(own - before, after - own)), 0, max(own, max(before, after)) == FAR);
}

// How far depths of the map and of the eye may be off together, at a distance: `share` of the depth, and `constant`. It is part
// of the move of surfaces, and `conic_before` asks for a difference PRECISE times as large.
fn precision_at(own: i32) -> i32 {
  let depth = select(own, RANGE - own, depth_map.is_reversed != 0u);
  return (((depth >> 10u) * contour.share) >> 19u) + contour.constant;
}

// The distance of a sample, moved away from the light, by at most half of what is left to the far end.
fn moved_distance(at: vec2<i32>) -> i32 {
  let own = distance_at(at);
  if (own == FAR) {
    return FAR;
  }
  let slopes = slope_between(at, vec2<i32>(1, 0)) + slope_between(at, vec2<i32>(0, 1));
  // The product is replaced by RANGE / 2 where it would be larger and might overflow.
  let is_large = (slopes >> 8u) > (RANGE / 2) / max(contour.slope_bias, 1);
  let of_slopes = select(parts(slopes, contour.slope_bias), RANGE / 2, is_large);
  return own + min(of_slopes + precision_at(own), (RANGE - own) / 2);
}

// In place of a place, if neither depths nor the course of the contour over other edges tell one; and of `Conic.u`.
const UNTOLD: i32 = -1;
// The last difference of distances before a rim is at least LEAST_RISE, and at least PRECISE times what depths may be off by.
const LEAST_RISE: i32 = 1024;
const PRECISE: i32 = 16;

// How a smooth surface bends towards a rim. The surface along a row is taken for a conic whose tangent at the rim is a ray of the
// light: the square of the distance from the rim's depth is a quadratic polynomial of the place.
struct Conic {
  // The difference of the last sample and the one before it, shifted down to at most eleven bits. UNTOLD: there is no such conic.
  u: i32,
  // The rim's distance less that of the last sample, in the same units.
  y: i32,
  // Differences of these squares: that of the sample before the last less that of the last, and the same one sample further in.
  first: i32,
  second: i32,
}

// The conic through a sample, which must not be FAR, and the three before it, in the direction of a step. A fourth before it has
// to lie on it, but for the part u² / `off` of the square: a larger `off` is stricter.
fn conic_before(last: vec2<i32>, step: vec2<i32>, off: i32) -> Conic {
  let none = Conic(UNTOLD, 0, 0, 0);
  let z = distance_at(last);
  var gone: array<i32, 5>;
  // Four turns. Loops between constants need no `Turns:` comment.
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
  // Eleven bits of `u` are enough. It must be the largest difference of neighbouring samples, as is tested below.
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
