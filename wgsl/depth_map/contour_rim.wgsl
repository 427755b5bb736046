// Rims of smooth surfaces beyond their last sample, surfaces between their last sample and a contour, and marked edges.
// Imported by `contour_tiles` (for marks), `contour_crossings`, `contour_walls` and `depth_walls` (for its near cap), after
// `contour_marks`. Importers bind what contour.wgsl has, and `marks`.
// A contour is where a surface ends before another as the light sees it. It crosses the marked edges between samples.
// Offsets from a sample are in 1/256 texel, in the direction of a step.
// All is integer arithmetic, so results are the same on every device. At marked edges walls and near caps close because both
// take surfaces from `surface_distance`: do not compute them elsewhere. Only in the middle of a junction walls have other
// ones (contour_walls.wgsl). docs/numerics/contours.md, "Jumps and crossings" and "Heights".

#import depth_map/contour

// A rim may lie beyond the other sample by so much, in 1/256 texel, because of rounding.
const RIM_OVERSHOOT: i32 = 24;
// The strictness of `fit_conic` for rims.
const RIM_STRICTNESS: i32 = 5;

// The offset of the rim of a smooth surface from its last sample, which must not be FAR, up to TEXEL. UNKNOWN: one of the four
// edges before it is marked, samples are not on a conic that `fit_conic` takes, the conic turns back within two texels, or
// the rim is farther.
// The walk back stays on the lattice: its border is FAR, and edges between FAR and other samples are marked.
fn rim_offset(last: vec2<i32>, step: vec2<i32>) -> i32 {
  for (var index = 0; index < 4; index++) {
    if (is_marked_before(last - index * step, step)) {
      return UNKNOWN;
    }
  }
  let conic = fit_conic(last, step, RIM_STRICTNESS);
  // A rim within a texel is at most three times the last difference away from the last sample, in distance.
  if (conic.last_difference == UNKNOWN || conic.rim_difference > 3 * conic.last_difference) {
    return UNKNOWN;
  }
  // The rim is where rim_difference² = slope · offset + curve · offset².
  let square = (conic.rim_difference * conic.rim_difference) >> 12u;
  let curve = (conic.square_difference - conic.previous_square_difference) >> 13u;
  let slope = (conic.square_difference + (conic.square_difference - conic.previous_square_difference) / 2) >> 12u;
  // The search needs a right side that grows over two texels.
  if (curve * 4 < -slope) {
    return UNKNOWN;
  }
  // The offset's bits, from the highest on.
  var offset = 0;
  for (var bit = 256; bit > 0; bit /= 2) {
    let next = offset + bit;
    if ((slope * next + (curve * next * next) / TEXEL) <= square * TEXEL) {
      offset = next;
    }
  }
  return select(min(offset, TEXEL), UNKNOWN, offset > TEXEL + RIM_OVERSHOOT);
}

// How much the distance of a surface grows from its last sample, which must not be FAR, to an offset of at most TEXEL. It
// grows at the rate of the last difference, or not at all if the edge before the sample is marked. Without a threshold the
// rate is the minmod of the last two differences (the smaller one, or 0 if their signs differ), if the surface has two.
// `approach_bound` (depth_near.wgsl) relies on this: a surface comes nearer to the light at no larger rate than the last
// difference.
// Before a rim the surface bends away from the light. So where differences grow, the rate is multiplied by the square of
// their ratio. The ratio counts as 2 if it is larger, and the difference as RANGE / 8.
fn extrapolated_rise(sample: vec2<i32>, step: vec2<i32>, offset: i32) -> i32 {
  if (is_marked_before(sample, step)) {
    return 0;
  }
  let first = load_distance(sample - step);
  let last_difference = load_distance(sample) - first;
  if (is_marked_before(sample - step, step)) {
    return scale_256ths(last_difference, offset);
  }
  let previous_difference = first - load_distance(sample - 2 * step);
  // Without a threshold jumps are not marked, so the differences may be jumps.
  if (contour.threshold >= RANGE) {
    return scale_256ths(minmod(last_difference, previous_difference), offset);
  }
  if (last_difference <= max(previous_difference, 0)) {
    return scale_256ths(last_difference, offset);
  }
  // In 1/256, from 1 to 2.
  let ratio =
    clamp(last_difference / max(max(previous_difference, last_difference / 2) >> 8u, 1), TEXEL, 2 * TEXEL);
  return scale_256ths(scale_256ths(scale_256ths(min(last_difference, RANGE / 8), offset), ratio), ratio);
}

// The distance, with the bias, of the surface of a sample at an offset of at most TEXEL, or FAR if the sample is. If
// `min_texels` is above 0, the surface goes away from the light by at least so many times the last difference, which counts
// as RANGE / 8 if it is larger, and as 0 if it is negative or may be a jump. Then the surface never comes nearer. In any case
// it goes at most half of the way to the far end.
fn surface_distance(sample: vec2<i32>, step: vec2<i32>, offset: i32, min_texels: i32) -> i32 {
  let distance = load_distance(sample);
  if (distance == FAR) {
    return FAR;
  }
  var rise = extrapolated_rise(sample, step, offset);
  if (min_texels > 0) {
    // Without a threshold the last difference may be a jump.
    let is_slope = contour.threshold < RANGE && !is_marked_before(sample, step);
    let slope = select(0, clamp(distance - load_distance(sample - step), 0, RANGE / 8), is_slope);
    rise = max(rise, min_texels * slope);
  }
  return clamp(biased_distance(sample) + rise, 0, distance + (RANGE - distance) / 2);
}

// From `contour_marks`: two bits for each sample, 16 samples in a word, `contour.words` words in a row.
@group(0) @binding(8) var<storage, read> marks: array<u32>;

// Whether edges of a sample are marked. Bit 0: the edge to the right. Bit 1: the edge down. The sample must be on the
// lattice.
fn load_marks(sample: vec2<i32>) -> u32 {
  let word = marks[u32(sample.y) * contour.words + u32(sample.x) / 16u];
  return (word >> (2u * (u32(sample.x) & 15u))) & 3u;
}

// The edge code of a cell: bits 0 to 3 are set for marked edges at the top, right, bottom and left.
fn load_edge_code(cell: vec2<i32>) -> u32 {
  let first = load_marks(cell);
  let right = load_marks(cell + vec2<i32>(1, 0));
  let below = load_marks(cell + vec2<i32>(0, 1));
  return (first & 1u) | (right & 2u) | ((below & 1u) << 2u) | ((first & 2u) << 2u);
}

// Whether the edge between a sample and the one before it, `sample - step`, is marked. Both must be on the lattice.
fn is_marked_before(sample: vec2<i32>, step: vec2<i32>) -> bool {
  return ((load_marks(min(sample, sample - step)) >> u32(step.y != 0)) & 1u) == 1u;
}
