// Where a smooth surface ends beyond its last sample (its rim), how a surface goes on up to a contour, and which edges are
// marked. Imported by `contour_tiles` (marks), `contour_places`, `contour_walls`, and `depth_walls` (near cap); after
// `contour_marks`.
// A contour is where a surface ends before another as the light sees it; it crosses the marked edges between samples.
// Importers bind what contour.wgsl has, and `marks`. Places are in 256 parts of a texel, in the direction of a step from a
// sample.
// Integers only, so the same on every device. Walls and near cap both take surfaces from `surface_distance`: no copy of it
// elsewhere.

#import depth_map/contour

// Parts of a texel up to which a rim may lie beyond the other sample: rounding brings it there.
const BEYOND: i32 = 24;
// Parts of the square of the last difference that a fifth sample may be off its conic.
const ON_CONIC: i32 = 5;

// The place of the rim of a smooth surface beyond its last sample, in the direction of a step: parts of a texel from it, up to
// TEXEL. UNTOLD: depths do not tell it, or it is farther.
fn rim_beyond(last: vec2<i32>, step: vec2<i32>) -> i32 {
  for (var number = 0; number < 4; number++) {
    if (is_marked_before(last - number * step, step)) {
      return UNTOLD;
    }
  }
  let conic = conic_before(last, step, ON_CONIC);
  // The rise is at most three times the last difference, if the rim is within a texel.
  if (conic.u == UNTOLD || conic.y > 3 * conic.u) {
    return UNTOLD;
  }
  // y² = slope · place + curve · place²
  let square = (conic.y * conic.y) >> 12u;
  let curve = (conic.first - conic.second) >> 13u;
  let slope = (conic.first + (conic.first - conic.second) / 2) >> 12u;
  if (curve * 4 < -slope) {
    return UNTOLD;
  }
  var place = 0;
  for (var part = 256; part > 0; part /= 2) {
    let next = place + part;
    if ((slope * next + (curve * next * next) / TEXEL) <= square * TEXEL) {
      place = next;
    }
  }
  return select(min(place, TEXEL), UNTOLD, place > TEXEL + BEYOND);
}

// How much the distance of the surface at a sample grows on the way to a place beside it, in parts of a texel in the direction of
// a step. It goes on as between the last samples. Where it bends away from the light, as towards a rim, it goes on bending: the
// slope grows by the square of its last growth, to four times at most.
fn way_on(at: vec2<i32>, step: vec2<i32>, place: i32) -> i32 {
  if (is_marked_before(at, step)) {
    return 0;
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

// The distance of the surface of a sample at a place beside it, in the direction of a step, moved by the bias. If `texels` is
// above 0, it grows on the way by as many times the last difference at least.
fn surface_distance(at: vec2<i32>, step: vec2<i32>, place: i32, texels: i32) -> i32 {
  let own = distance_at(at);
  if (own == FAR) {
    return FAR;
  }
  var way = way_on(at, step, place);
  if (texels > 0) {
    // Without a threshold it may be a jump.
    let is_slope = contour.threshold < RANGE && !is_marked_before(at, step);
    let slope = select(0, clamp(own - distance_at(at - step), 0, RANGE / 8), is_slope);
    way = max(way, texels * slope);
  }
  return clamp(moved_distance(at) + way, 0, own + (RANGE - own) / 2);
}

// From `contour_marks`: for each sample two bits, 16 samples a word, `contour.words` words a row.
@group(0) @binding(9) var<storage, read> marks: array<u32>;

// Two bits, whether the edges to the right of a sample and below it are marked. `at` must be on the lattice.
fn marks_at(at: vec2<i32>) -> u32 {
  let word = marks[u32(at.y) * contour.words + u32(at.x) / 16u];
  return (word >> (2u * (u32(at.x) & 15u))) & 3u;
}

// The edges of a cell that are marked: bits for top, right, bottom and left.
fn code_of_cell(cell: vec2<i32>) -> u32 {
  let own = marks_at(cell);
  let right = marks_at(cell + vec2<i32>(1, 0));
  let below = marks_at(cell + vec2<i32>(0, 1));
  return (own & 1u) | (right & 2u) | ((below & 1u) << 2u) | ((own & 2u) << 2u);
}

// Whether a contour crosses between a sample and `at - step`. The step is one sample along an axis.
fn is_marked_before(at: vec2<i32>, step: vec2<i32>) -> bool {
  return ((marks_at(min(at, at - step)) >> u32(step.y != 0)) & 1u) == 1u;
}
