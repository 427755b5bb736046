// Contour flaps: between a surface and a wall, volumes begin at the flap, not where the surface goes on. Which flaps of the list
// of walls a place of the near rectangle is at.

// As `contour_walls` leaves them.
@group(0) @binding(7) var<storage, read> counts: array<u32>;

// Texels from a wall up to which its flaps reach.
const REACH: i32 = 2;

// Whether the line between two places crosses that from the origin to the right. It does not depend on their order.
fn crosses(a: vec2<f32>, b: vec2<f32>) -> bool {
  let upper = select(b, a, a.y < b.y);
  let lower = select(a, b, a.y < b.y);
  return upper.y <= 0.0 && lower.y > 0.0 && perp_dot(upper, lower) > 0.0;
}

// A vertex of a flap.
struct FlapVertex {
  // From the place on, in parts of a texel.
  at: vec2<f32>,
  // The device depth in the units of distances.
  depth: i32,
}

fn flap_vertex(quad: u32, number: u32, cell: vec2<i32>, part: vec2<f32>) -> FlapVertex {
  let word = 4u + 12u * quad + 3u * number;
  let at = vec2<i32>(vec2<u32>(cells[word], cells[word + 1u])) - cell * TEXEL;
  let distance = bitcast<i32>(cells[word + 2u]);
  return FlapVertex(vec2<f32>(at) - part * f32(TEXEL), select(distance, RANGE - distance, depth_map.is_reversed != 0u));
}

fn is_behind_depth(own: f32, depth: f32) -> bool {
  return select(own > depth, own < depth, depth_map.is_reversed != 0u);
}

// Whether a quadrilateral may be at a place of the cell.
fn may_be_in(quad: u32, cell: vec2<i32>) -> bool {
  let first = 4u + 12u * quad;
  var low = vec2<u32>(cells[first], cells[first + 1u]);
  var high = low;
  let second = vec2<u32>(cells[first + 3u], cells[first + 4u]);
  let third = vec2<u32>(cells[first + 6u], cells[first + 7u]);
  let fourth = vec2<u32>(cells[first + 9u], cells[first + 10u]);
  low = min(min(low, second), min(third, fourth));
  high = max(max(high, second), max(third, fourth));
  let from_cell = vec4<i32>(vec4<u32>(low, high)) - (cell * TEXEL).xyxy;
  return all(from_cell.xy <= vec2<i32>(TEXEL)) && all(from_cell.zw >= vec2<i32>(0));
}

// Whether a triangle of a flap is at the place, and the place is behind it, and not behind the surface, or the other way round.
fn triangle_changes(a: FlapVertex, b: FlapVertex, c: FlapVertex, depth: f32, is_behind: bool) -> bool {
  // No place is in a wall.
  if ((crosses(a.at, b.at) != crosses(b.at, c.at)) == crosses(c.at, a.at)) {
    return false;
  }
  let of_b = perp_dot(c.at, a.at);
  let of_c = perp_dot(a.at, b.at);
  let area = perp_dot(b.at, c.at) + of_b + of_c;
  let more = (of_b * f32(b.depth - a.depth) + of_c * f32(c.depth - a.depth)) / area;
  return is_behind_depth(depth, (f32(a.depth) + more) / f32(RANGE)) != is_behind;
}

// The number of a tile in the list of those that contours cross. The list's length: it is not in it.
fn number_of_tile(tile: u32) -> u32 {
  let list = contour.tiles.y * (1u + WALKERS);
  let count = counts[list + contour.tiles.y];
  var low = 0u;
  var high = count;
  // Turns: 22.
  while (low < high) {
    let middle = (low + high) / 2u;
    if (counts[list + middle] < tile) {
      low = middle + 1u;
    } else {
      high = middle;
    }
  }
  return select(count, low, low < count && counts[list + low] == tile);
}

// Whether an odd number of flaps at a place of a cell change whether it is behind what is there.
fn flaps_change(cell: vec2<i32>, part: vec2<f32>, depth: f32, is_behind: bool) -> bool {
  let across = contour.tiles.x;
  let tiles = vec2<u32>(across, contour.tiles.y / across);
  let first = vec2<u32>(max(cell - REACH, vec2<i32>(0)) / TILE);
  let last = min(vec2<u32>((cell + REACH) / TILE), tiles - 1u);
  let count = counts[contour.tiles.y * (2u + WALKERS)];
  var changes = false;
  // Turns: 2.
  for (var y = first.y; y <= last.y; y++) {
    // Turns: 2.
    for (var x = first.x; x <= last.x; x++) {
      let number = number_of_tile(y * across + x);
      if (number == count) {
        continue;
      }
      var end = cells[0];
      if (number + 1u < count) {
        end = counts[number + 1u];
      }
      // Turns: TILE_WALLS.
      for (var quad = counts[number]; quad < end; quad++) {
        if (!may_be_in(quad, cell)) {
          continue;
        }
        let a = flap_vertex(quad, 0u, cell, part);
        let c = flap_vertex(quad, 2u, cell, part);
        // Vertices 0, 1, 2 and 0, 2, 3.
        changes = changes != triangle_changes(a, flap_vertex(quad, 1u, cell, part), c, depth, is_behind);
        changes = changes != triangle_changes(a, flap_vertex(quad, 3u, cell, part), c, depth, is_behind);
      }
    }
  }
  return changes;
}
