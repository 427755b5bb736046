// Contours of a depth map: parameters, distances as integers, slopes, and conics through samples of round surfaces. Imported
// by the stages `contour_…`, `depth_walls` and `depth_near_walls`, which bind what samples.wgsl has, of a single map.
// A contour is the line where a surface ends before another or before nothing, as the light sees it. It crosses marked
// edges: those between two samples of different surfaces. A rim is where a smooth surface bends away from the light.
// A cell is the square between four samples; a tile has 16 × 16 cells. A crossing is a position on an edge, in 1/256 texel;
// the buffer `crossings` has it in 1/65,536.
// A distance is the device depth from the near plane on, in units of 2⁻²⁹ of its range. `sample`: a position on the lattice.
// Integers decide everything, so lists of walls are the same on every device, to the word. Keep shifts and clamps: without
// them products would overflow. Claims: docs/numerics/contours.md.

#import depth_map/samples

struct ContourShape {
  // Tiles of 16 × 16 cells: in a row, and in all.
  tiles: vec2<u32>,
  // Words of marks in a row of samples.
  words: u32,
  // Walls and flaps that the list has room for.
  capacity: u32,
  // At a jump, distances differ by more than this, and by so much more than the slopes beside it. RANGE: no difference of
  // distances makes a jump, only far samples and other objects do.
  threshold: i32,
  // A difference above this may be a jump even if it is less than twice those beside it. Other conditions stay (`is_jump`).
  certain_threshold: i32,
  // How far a segment may pass from a crossing, in 1/256 texel.
  sideways: i32,
  // How far surfaces may be from the line between the ends of a wall. It is shifted down by `shift` bits, as are the
  // distances that are compared with it.
  tolerance: i32,
  shift: u32,
  // The bias, which moves surfaces away from the light, is the sum of three terms (`biased_distance`).
  slope_bias: i32, // Times the slope for each texel, in 1/256.
  noise_share: i32, // Times the depth, in 2⁻²⁹. May be negative, but the sum with the constant is not.
  noise_constant: i32, // A distance.
}

@group(0) @binding(6) var<uniform> contour: ContourShape;

// Cells of a side of a tile.
const TILE: i32 = 16;
// Invocations of a tile in `contour_walls`.
const WALKERS: u32 = 64u;
// Units of a texel in which positions count.
const TEXEL: i32 = 256;
// The distance of the far end of the device depths. Samples that cast have smaller distances.
const RANGE: i32 = 0x20000000;
// The distance of a sample that casts nothing.
const FAR: i32 = 0x7fffffff;
// The least distance of a crossing from both ends of its edge, in 1/256 texel.
const CROSSING_MARGIN: i32 = 16;

// The offset of a corner of a cell from the cell's first sample, which is corner 0. Corners are numbered clockwise with rows
// downwards, modulo 4. Edge `i` lies between corners `i` and `i` + 1: 0 top, 1 right, 2 bottom, 3 left. Seen from within the
// cell, corner `i` is at the left end of edge `i`.
fn corner_offset(corner: u32) -> vec2<i32> {
  return vec2<i32>((vec2<u32>(6u, 12u) >> vec2<u32>(corner & 3u)) & vec2<u32>(1u));
}

// The step from a cell to its neighbour beyond an edge.
fn step_across(edge: u32) -> vec2<i32> {
  let sign = select(-1, 1, edge == 1u || edge == 2u);
  return select(vec2<i32>(0, sign), vec2<i32>(sign, 0), (edge & 1u) == 1u);
}

// The step to the next sample along an axis: 0 to the right, 1 down.
fn step_along(axis: u32) -> vec2<i32> {
  return select(vec2<i32>(1, 0), vec2<i32>(0, 1), axis == 1u);
}

// The first sample of an edge of a cell. The second is to the right of it, or below it for the odd edges.
fn first_sample_of_edge(cell: vec2<i32>, edge: u32) -> vec2<i32> {
  return select(cell, cell + step_across(edge), edge == 1u || edge == 2u);
}

// The minmod of two slopes: the one nearer to 0, or 0 if their signs differ.
fn minmod(a: i32, b: i32) -> i32 {
  return select(select(b, a, abs(a) < abs(b)), 0, (a ^ b) < 0);
}

// `value` · `factor` / 256, rounded down. The result must fit, and `factor` be below 2²³.
fn scale_256ths(value: i32, factor: i32) -> i32 {
  return (value >> 8u) * factor + (((value & 255) * factor) >> 8u);
}

// The distance of a sample from the near plane, for the depth truncated to units, or FAR, also beyond the lattice. It is below
// RANGE, so a reversed depth next to 0 is not at the far end. Keys (samples.wgsl) clamp depths to 0 and 1, and make NaN far.
fn load_distance(sample: vec2<i32>) -> i32 {
  let key = load_key(vec2<u32>(sample));
  let bits = depth_bits(key);
  let mantissa = (bits & 0x007fffffu) | 0x00800000u;
  let exponent = bits >> 23u;
  let large = mantissa << min(max(exponent, 121u) - 121u, 31u);
  let small = mantissa >> min(121u - min(exponent, 121u), 31u);
  let depth = select(i32(select(small, large, exponent > 121u)), 0, exponent == 0u);
  return select(min(select(depth, RANGE - depth, depth_map.is_reversed != 0u), RANGE - 1), FAR, key == FAR_KEY);
}

// The slope of a surface behind a sample, against the direction of a step: the minmod of the last two differences. 0 if one
// of the three samples is far.
fn backward_slope(sample: vec2<i32>, step: vec2<i32>) -> i32 {
  let distance = load_distance(sample);
  let first = load_distance(sample - step);
  let second = load_distance(sample - 2 * step);
  return select(minmod(distance - first, first - second), 0, max(distance, max(first, second)) == FAR);
}

// The size of the minmod of the differences to the samples before and after. 0 at a ridge or where one is far.
fn central_slope(sample: vec2<i32>, step: vec2<i32>) -> i32 {
  let before = load_distance(sample - step);
  let distance = load_distance(sample);
  let after = load_distance(sample + step);
  return select(abs(minmod(distance - before, after - distance)), 0, max(distance, max(before, after)) == FAR);
}

// The error that depths of the map may have, by their format and by a conversion from distances: `noise_share` of the depth,
// and `noise_constant`. It is a term of the bias, and `fit_conic` needs differences NOISE_FACTOR times as large. The error of
// the eye's depths is not in it: the matrix to the eye has that (`eye_matrix` in src/gpu/depth_map/view.rs).
fn depth_noise(distance: i32) -> i32 {
  let depth = select(distance, RANGE - distance, depth_map.is_reversed != 0u);
  return (((depth >> 10u) * contour.noise_share) >> 19u) + contour.noise_constant;
}

// The distance of a sample with the bias, which is at most half of the distance to the far end.
fn biased_distance(sample: vec2<i32>) -> i32 {
  let distance = load_distance(sample);
  if (distance == FAR) {
    return FAR;
  }
  let slopes = central_slope(sample, vec2<i32>(1, 0)) + central_slope(sample, vec2<i32>(0, 1));
  // RANGE / 2 stands for larger products, which might overflow.
  let is_large = (slopes >> 8u) > (RANGE / 2) / max(contour.slope_bias, 1);
  let slope_term = select(scale_256ths(slopes, contour.slope_bias), RANGE / 2, is_large);
  return distance + min(slope_term + depth_noise(distance), (RANGE - distance) / 2);
}

// Instead of a crossing, the offset of a rim, or `Conic.last_difference`: there is none.
const UNKNOWN: i32 = -1;
// A conic is fitted only if the last difference of distances is at least MIN_RISE, and at least NOISE_FACTOR times
// `depth_noise`.
const MIN_RISE: i32 = 1024;
const NOISE_FACTOR: i32 = 16;

// A conic through samples of a row, as a model of a smooth surface that ends at a rim. Its tangent at the rim is a ray of
// the light. So the square of the distance from the rim's depth is a quadratic polynomial of the position in the row.
struct Conic {
  // The difference of the last sample and the one before it, shifted down to at most eleven bits. UNKNOWN: no conic fits.
  last_difference: i32,
  // The rim's distance less that of the last sample, in the same units.
  rim_difference: i32,
  // The square for the sample before the last less that for the last, and the same one sample further back.
  square_difference: i32,
  previous_square_difference: i32,
}

// Fits a conic to a sample, which must not be FAR, and the three before it against the direction of `step`. The square of a
// fifth sample may be off by u² / `strictness`, where u is the last difference. docs/numerics/contours.md, "Jumps and
// crossings", has the formulas, by the same letters.
fn fit_conic(last: vec2<i32>, step: vec2<i32>, strictness: i32) -> Conic {
  let no_conic = Conic(UNKNOWN, 0, 0, 0);
  let last_distance = load_distance(last);
  // How much farther the last sample is than those before it, which must be nearer and nearer.
  var rises: array<i32, 5>;
  // Four iterations. Loops between constants need no `Turns:` comment.
  for (var index = 1; index < 5; index++) {
    let distance = load_distance(last - index * step);
    if (distance == FAR || last_distance - distance <= rises[index - 1]) {
      return no_conic;
    }
    rises[index] = last_distance - distance;
  }
  if (rises[1] < max(MIN_RISE, NOISE_FACTOR * min(depth_noise(last_distance), RANGE / NOISE_FACTOR))) {
    return no_conic;
  }
  // Eleven bits of `u` are enough. The test below makes sure that no other difference is larger.
  let shift = u32(max(21 - i32(countLeadingZeros(u32(rises[1]))), 0));
  let u = rises[1] >> shift;
  let v = (rises[2] >> shift) - u;
  let w = (rises[3] >> shift) - u - v;
  let x = (rises[4] >> shift) - u - v - w;
  let bend = u - 2 * v + w;
  if (max(v, max(w, x)) > u || bend <= 0) {
    return no_conic;
  }
  let numerator = 4 * u * v + 2 * v * v - u * u - w * (2 * (u + v) + w);
  if (numerator < 0 || numerator / bend > 16 * u) {
    return no_conic;
  }
  let y = numerator / (2 * bend);
  let first = u * (2 * y + u);
  let second = v * (2 * (y + u) + v);
  let third = w * (2 * (y + u + v) + w);
  let fourth = x * (2 * (y + u + v + w) + x);
  if (abs(fourth - 2 * third + second) > u * u / strictness) {
    return no_conic;
  }
  return Conic(u, y, first, second);
}
