// Contour side: the surface that a place within a marked cell belongs to.

// As `contour_walls` leaves them.
@group(0) @binding(5) var<storage, read> places: array<u32>;

// The place on the edge of a cell, from the cell's first sample on. Its middle, if it is not marked.
fn point_of(cell: vec2<i32>, bit: u32) -> vec2<f32> {
  let first = edge_of_cell(cell, bit);
  let word = places[u32(first.y) * (depth_map.size.x + 2u) + u32(first.x)];
  let found = (word >> (16u * (bit & 1u))) & 0xffffu;
  let is_marked = ((marks_at(first) >> (bit & 1u)) & 1u) == 1u;
  let along = select(0.5, f32(found) / 65536.0, is_marked);
  return vec2<f32>(first - cell) + vec2<f32>(step_along(bit & 1u)) * along;
}

fn perp_dot(a: vec2<f32>, b: vec2<f32>) -> f32 {
  return a.x * b.y - a.y * b.x;
}

// The corner of a marked cell, in turn, whose surface a place of the cell belongs to.
fn contour_side(cell: vec2<i32>, code: u32, place: vec2<f32>) -> u32 {
  var best = 0u;
  if (countOneBits(code) == 2u) {
    let first = countTrailingZeros(code);
    let second = 31u - countLeadingZeros(code);
    let start = point_of(cell, first);
    let is_left = perp_dot(point_of(cell, second) - start, place - start) < 0.0;
    var nearest = 4.0;
    for (var corner = 0u; corner < 4u; corner++) {
      let away = abs(place - vec2<f32>(turn(corner)));
      if ((corner > first && corner <= second) == is_left && away.x + away.y < nearest) {
        nearest = away.x + away.y;
        best = corner;
      }
    }
    return best;
  }
  let own = place - 0.5;
  for (var corner = 4u; corner > 0u; corner--) {
    let before = point_of(cell, (corner + 2u) & 3u) - 0.5;
    let after = point_of(cell, corner - 1u) - 0.5;
    if (perp_dot(before, own) >= 0.0 && perp_dot(own, after) >= 0.0) {
      best = corner - 1u;
    }
  }
  return best;
}

// The distance of the surface at a place of a marked cell: between samples of the same surface, and as it goes on from the last.
fn contour_distance(cell: vec2<i32>, code: u32, place: vec2<f32>) -> i32 {
  let corner = turn(contour_side(cell, code, place));
  let at = cell + corner;
  let own = moved_distance(at);
  if (own == FAR) {
    return FAR;
  }
  let offset = vec2<i32>(abs(place - vec2<f32>(corner)) * f32(TEXEL));
  var there = own;
  for (var axis = 0u; axis < 2u; axis++) {
    let step = step_along(axis) * (1 - 2 * corner[axis]);
    if (is_marked_before(at + step, step)) {
      there += surface_distance(at, step, offset[axis], 0) - own;
    } else {
      there += parts(moved_distance(at + step) - own, offset[axis]);
    }
  }
  return clamp(there, 0, RANGE - 1);
}
