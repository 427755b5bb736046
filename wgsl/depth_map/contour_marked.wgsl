// Reads marks of edges, and goes on with surfaces up to them.

@group(0) @binding(9) var<storage, read> marks: array<u32>;

// Two bits: the edges to the right of a sample and below it.
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

// Whether a contour crosses between a sample and the one before it, seen in the direction of a step along an axis.
fn is_marked_before(at: vec2<i32>, step: vec2<i32>) -> bool {
  return ((marks_at(min(at, at - step)) >> u32(step.y != 0)) & 1u) == 1u;
}

// How far the surface at a sample goes away on the way to a place beside it, in parts of a texel in the direction of a step. It
// goes on as between the last samples. Where it bends away from the light, as towards a rim, it goes on bending: the slope grows
// twice as it did last, to four times at most.
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

// The distance of the surface of a sample at a place beside it, in parts of a texel in the direction of a step.
fn surface_distance(at: vec2<i32>, step: vec2<i32>, place: i32) -> i32 {
  let own = distance_at(at);
  if (own == FAR) {
    return FAR;
  }
  return clamp(moved_distance(at) + way_on(at, step, place), 0, own + (RANGE - own) / 2);
}
