// Stage `depth_walls`: draws walls and flaps over contours into the caller's stencil bit, in place of the triangles of
// `depth_surface`. A contour is where a surface ends before another as the light sees it; a wall stands over it along rays of the
// light, and a flap joins the wall's top to samples of the nearer surface.
// `DepthMapFrame::draw`: `depth_walls` has six vertices for each quadrilateral of `contour_walls`, which wrote the indirect draw;
// then `depth_walls_near_cap_fragment` turns the bit round where the near rectangle (the eye's near plane in the picture) is in
// shadow, with the vertex shader `depth_near_cap`. Depth is tested for walls, never written. `cells` is the list of walls here.
// The near cap must answer for what is drawn. The surface on a place's side of the contour answers first; if an odd number of
// triangles of flaps over the place tell otherwise, the answer is turned round. If the list overflowed, triangles of cells are
// drawn and looked up instead.

#import depth_map/contour
#import depth_map/contour_rim
#import depth_map/samples
#import depth_map/surface

// Vertices 0 to 5 of a wall or flap (`corner`) are its two triangles. `number`, 0 to 3, is the vertex in the list.
@vertex
fn depth_walls(@builtin(vertex_index) index: u32) -> SurfaceVertex {
  let corner = index % 6u;
  // Vertices 0, 1, 2 and 0, 2, 3.
  let number = select(corner, select(0u, corner - 2u, corner > 3u), corner >= 3u);
  let word = 4u + 12u * (index / 6u) + 3u * number;
  let distance = bitcast<i32>(cells[word + 2u]);
  let found = vec2<f32>(vec2<u32>(cells[word], cells[word + 1u])) / f32(TEXEL / 2);
  let place = found - vec2<f32>(depth_map.size) - 1.0;
  let view = views[0];
  if (distance == FAR) {
    return SurfaceVertex(view.far_across * place.x + view.far_down * place.y + view.far_middle);
  }
  let depth = f32(select(distance, RANGE - distance, depth_map.is_reversed != 0u)) / f32(RANGE);
  return SurfaceVertex(view.across * place.x + view.down * place.y + view.depth * depth + view.middle);
}

// Whether a place of a cell that a contour crosses is behind the surface on its side.
fn is_behind_contour(found: NearPlace, cell: vec2<i32>, code: u32) -> bool {
  let distance = contour_distance(cell, code, found.lattice - floor(found.lattice));
  if (distance != FAR) {
    let depth = select(distance, RANGE - distance, depth_map.is_reversed != 0u);
    return is_behind_depth(found.depth, f32(depth) / f32(RANGE));
  }
  if (views[0].infinity.w != 0.0) {
    return false;
  }
  let twice = 2.0 * found.lattice - vec2<f32>(depth_map.size) - 1.0;
  return is_behind_depth(found.depth, dot(views[0].infinity.xyz, vec3<f32>(twice, 1.0)));
}

// Whether a place on the near rectangle, from -1 to 1, is in shadow: behind the surfaces that end at contours, and their flaps.
fn is_behind_contours(place: vec2<f32>) -> bool {
  let found = near_place(place);
  // A list of walls that overflowed is not drawn. With contours `depth_map.capacity` is the room of this list: Rust sets it to
  // `contour.capacity`.
  if (!found.is_in || cells[0] > depth_map.capacity) {
    return found.is_in && is_behind_triangle(found);
  }
  // The cell's first sample.
  let corner = floor(found.lattice);
  let cell = vec2<i32>(corner);
  let code = load_edge_code(cell);
  var is_behind = false;
  if (code == 0u) {
    is_behind = is_behind_triangle(found);
  } else {
    is_behind = is_behind_contour(found, cell, code);
  }
  return is_behind != flaps_change(cell, found.lattice - corner, found.depth, is_behind);
}

@fragment
fn depth_walls_near_cap_fragment(@location(0) @interpolate(linear, sample) place: vec2<f32>) {
  if (!is_behind_contours(place)) {
    discard;
  }
}

// Flaps: between the last samples of a surface and a wall, volumes begin at the flap, not where the surface goes on.

// From `contour_walls`: for each listed tile where its walls begin; the list of tiles and its length follow (contour_tiles.wgsl).
@group(0) @binding(7) var<storage, read> counts: array<u32>;

// Texels from a wall up to which its flaps reach.
const REACH: i32 = 2;

// Whether the line between two points crosses the ray from the origin to the right. It does not depend on their order. Rows go
// down, so the upper point has the minmod y.
fn crosses(a: vec2<f32>, b: vec2<f32>) -> bool {
  let upper = select(b, a, a.y < b.y);
  let lower = select(a, b, a.y < b.y);
  return upper.y <= 0.0 && lower.y > 0.0 && perp_dot(upper, lower) > 0.0;
}

// A vertex of a wall or flap.
struct FlapVertex {
  // Its point relative to the place that is asked for, in parts of a texel.
  at: vec2<f32>,
  // The device depth times RANGE: the distance, or RANGE less it with reversed depth.
  depth: i32,
}

// Vertex `number` of a quadrilateral of the list, for the place that is `part` of a texel from the first sample of a cell.
fn flap_vertex(quad: u32, number: u32, cell: vec2<i32>, part: vec2<f32>) -> FlapVertex {
  let word = 4u + 12u * quad + 3u * number;
  let at = vec2<i32>(vec2<u32>(cells[word], cells[word + 1u])) - cell * TEXEL;
  let distance = bitcast<i32>(cells[word + 2u]);
  return FlapVertex(vec2<f32>(at) - part * f32(TEXEL), select(distance, RANGE - distance, depth_map.is_reversed != 0u));
}

// Whether device depth `own` is farther from the light than `depth`.
fn is_behind_depth(own: f32, depth: f32) -> bool {
  return select(own > depth, own < depth, depth_map.is_reversed != 0u);
}

// Whether the box of a quadrilateral meets the cell.
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

// Whether a triangle of a flap is over the place, and tells otherwise than `is_behind` whether the place is behind it. Walls have
// no area over any place.
fn triangle_changes(a: FlapVertex, b: FlapVertex, c: FlapVertex, depth: f32, is_behind: bool) -> bool {
  if ((crosses(a.at, b.at) != crosses(b.at, c.at)) == crosses(c.at, a.at)) {
    return false;
  }
  let of_b = perp_dot(c.at, a.at);
  let of_c = perp_dot(a.at, b.at);
  let area = perp_dot(b.at, c.at) + of_b + of_c;
  let more = (of_b * f32(b.depth - a.depth) + of_c * f32(c.depth - a.depth)) / area;
  return is_behind_depth(depth, (f32(a.depth) + more) / f32(RANGE)) != is_behind;
}

// The index of a tile in the list of those that contours cross, or the list's length if it is not in it.
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

// Whether an odd number of triangles of flaps over a place tell otherwise than `is_behind`. The place is `part` of a texel from
// the first sample of the cell, at a device depth.
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

// The surface that a place within a marked cell belongs to.

// Where contours cross edges (contour_places.wgsl), moved onto segments by `contour_walls`: 16 bits an edge, in 65,536 parts of a
// texel, where points in `cells` are in 256 parts.
@group(0) @binding(5) var<storage, read> places: array<u32>;

// The point on edge `bit` of a cell where the contour crosses it, in texels from the cell's first sample. The middle of an edge
// that is not marked.
fn point_of(cell: vec2<i32>, bit: u32) -> vec2<f32> {
  let first = first_sample_of_edge(cell, bit);
  let word = places[u32(first.y) * (depth_map.size.x + 2u) + u32(first.x)];
  let found = (word >> (16u * (bit & 1u))) & 0xffffu;
  let is_marked = ((load_marks(first) >> (bit & 1u)) & 1u) == 1u;
  let along = select(0.5, f32(found) / 65536.0, is_marked);
  return vec2<f32>(first - cell) + vec2<f32>(step_along(bit & 1u)) * along;
}

fn perp_dot(a: vec2<f32>, b: vec2<f32>) -> f32 {
  return a.x * b.y - a.y * b.x;
}

// The corner of a marked cell whose surface a place of the cell belongs to, as `corner_offset` numbers it. `code`: bits of marked
// edges.
fn contour_side(cell: vec2<i32>, code: u32, place: vec2<f32>) -> u32 {
  var best = 0u;
  if (countOneBits(code) == 2u) {
    let first = countTrailingZeros(code);
    let second = 31u - countLeadingZeros(code);
    let start = point_of(cell, first);
    let is_left = perp_dot(point_of(cell, second) - start, place - start) < 0.0;
    var nearest = 4.0;
    for (var corner = 0u; corner < 4u; corner++) {
      let away = abs(place - vec2<f32>(corner_offset(corner)));
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
// `corner` is the offset of a corner here, its number in `contour_side`.
fn contour_distance(cell: vec2<i32>, code: u32, place: vec2<f32>) -> i32 {
  let corner = corner_offset(contour_side(cell, code, place));
  let at = cell + corner;
  let own = biased_distance(at);
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
      there += scale_256ths(biased_distance(at + step) - own, offset[axis]);
    }
  }
  return clamp(there, 0, RANGE - 1);
}
