// Reads marks of edges.

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
