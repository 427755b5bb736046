// Stage `depth_walls`: draws walls and flaps over contours into the caller's stencil bit, instead of the triangles of
// `depth_surface`. A contour is where a surface ends before another as the light sees it. A wall stands over it along rays
// of the light. A flap joins the top of a wall, its end nearer to the light, to samples of the nearer surface. Cells, edges,
// tiles, corners and distances are those of contour.wgsl, the lattice that of samples.wgsl. A distance counts units of
// device depth; it is no length. `DepthMapFrame::draw` draws walls and flaps by the indirect draw of `contour_walls`: six
// vertices a quadrilateral. Depth is tested and not written. Here the binding `cells` of surface.wgsl is the list of both.
// Then the near cap is drawn, by `depth_near_cap` and `depth_walls_near_cap_fragment`: it inverts the bit where the near
// rectangle, the part of the eye's near plane in the picture, is in shadow. It must agree with the walls and flaps. The
// surface on a point's side of the contour says whether the point is in shadow. An odd number of flap triangles there that
// say otherwise inverts the answer. If the list overflowed, triangles of cells are drawn and looked up instead.
// docs/numerics/contours.md, "Heights".

#import depth_map/contour
#import depth_map/contour_rim
#import depth_map/samples
#import depth_map/surface

// The two triangles of a wall or flap have its vertices 0, 1, 2 and 0, 2, 3. Word 0 of the list is the number of
// quadrilaterals that were found, more than there is room for if the list overflowed. From word 4 on the list has 12 words a
// quadrilateral: four vertices of x and y on the lattice, in 1/256 texel, and a distance with the bias, or FAR.
@vertex
fn depth_walls(@builtin(vertex_index) index: u32) -> SurfaceVertex {
  let corner = index % 6u;
  let vertex = select(corner, select(0u, corner - 2u, corner > 3u), corner >= 3u);
  let offset = 4u + 12u * (index / 6u) + 3u * vertex;
  let distance = bitcast<i32>(cells[offset + 2u]);
  let twice_position = vec2<f32>(vec2<u32>(cells[offset], cells[offset + 1u])) / f32(TEXEL / 2);
  // Twice the position from the middle of the lattice.
  let centred = twice_position - vec2<f32>(depth_map.size) - 1.0;
  let view = views[0];
  if (distance == FAR) {
    return SurfaceVertex(view.far_across * centred.x + view.far_down * centred.y + view.far_middle);
  }
  let depth = f32(select(distance, RANGE - distance, depth_map.is_reversed != 0u)) / f32(RANGE);
  return SurfaceVertex(view.across * centred.x + view.down * centred.y + view.depth * depth + view.middle);
}

// Whether a point in a cell that a contour crosses is farther from the light than the surface on its side of the contour.
// `edge_code` has a bit for each marked edge of the cell (contour_rim.wgsl).
fn is_behind_contour(point: NearPoint, cell: vec2<i32>, edge_code: u32) -> bool {
  let distance = contour_distance(cell, edge_code, point.lattice - floor(point.lattice));
  if (distance != FAR) {
    let depth = select(distance, RANGE - distance, depth_map.is_reversed != 0u);
    return is_behind_depth(point.depth, f32(depth) / f32(RANGE));
  }
  // FAR: the boundary is at infinity, as far surfaces are. For a parallel light it has no depth there.
  if (views[0].infinity.w != 0.0) {
    return false;
  }
  let centred = 2.0 * point.lattice - vec2<f32>(depth_map.size) - 1.0;
  return is_behind_depth(point.depth, dot(views[0].infinity.xyz, vec3<f32>(centred, 1.0)));
}

// Whether a point of the near rectangle, x and y from -1 to 1, is in shadow: behind the surface that goes on to the contour
// in its direction, unless flaps change that.
fn is_behind_contours(near_position: vec2<f32>) -> bool {
  let point = locate_near_point(near_position);
  // A list of walls that overflowed is not drawn. With contours Rust sets `depth_map.capacity` to `contour.capacity`.
  if (!point.is_inside || cells[0] > depth_map.capacity) {
    return point.is_inside && is_behind_triangle(point);
  }
  let first_sample = floor(point.lattice);
  let cell = vec2<i32>(first_sample);
  let edge_code = load_edge_code(cell);
  var is_behind = false;
  if (edge_code == 0u) {
    is_behind = is_behind_triangle(point);
  } else {
    is_behind = is_behind_contour(point, cell, edge_code);
  }
  return is_behind != flaps_change(cell, point.lattice - first_sample, point.depth, is_behind);
}

@fragment
fn depth_walls_near_cap_fragment(@location(0) @interpolate(linear, sample) near_position: vec2<f32>) {
  if (!is_behind_contours(near_position)) {
    discard;
  }
}

// Functions for flaps. Between the last samples of a surface and a wall, shadow begins at the flap, not at the surface as
// it goes on from these samples.

// From `contour_walls`: for each index of the list of tiles the index of that tile's first wall. The list of tiles and its
// length follow at offsets that contour_tiles.wgsl describes.
@group(0) @binding(7) var<storage, read> counts: array<u32>;

// Flaps extend less than so many texels from their wall, which lies in its tile. FLAP in src/gpu/depth_map/near.rs is the
// same.
const FLAP_LENGTH: i32 = 2;

// Whether the segment between two points crosses the ray from the origin to the right. Their order does not matter. Rows go
// down, so the upper point has the smaller y.
fn crosses_ray(a: vec2<f32>, b: vec2<f32>) -> bool {
  let upper = select(b, a, a.y < b.y);
  let lower = select(a, b, a.y < b.y);
  return upper.y <= 0.0 && lower.y > 0.0 && perp_dot(upper, lower) > 0.0;
}

// A vertex of a wall or flap.
struct FlapVertex {
  // Its position relative to the point that is looked up, in 1/256 texel.
  position: vec2<f32>,
  // The device depth times RANGE.
  depth: i32,
}

// A vertex, 0 to 3, of the wall or flap at index `quad` of the list, relative to the point at `fraction` of a texel from a
// cell's first sample.
fn flap_vertex(quad: u32, vertex: u32, cell: vec2<i32>, fraction: vec2<f32>) -> FlapVertex {
  let offset = 4u + 12u * quad + 3u * vertex;
  let from_cell = vec2<i32>(vec2<u32>(cells[offset], cells[offset + 1u])) - cell * TEXEL;
  let distance = bitcast<i32>(cells[offset + 2u]);
  return FlapVertex(
    vec2<f32>(from_cell) - fraction * f32(TEXEL), select(distance, RANGE - distance, depth_map.is_reversed != 0u));
}

// Whether the device depth of a point is farther from the light than `depth`.
fn is_behind_depth(point_depth: f32, depth: f32) -> bool {
  return select(point_depth > depth, point_depth < depth, depth_map.is_reversed != 0u);
}

// Whether the bounding box of a quadrilateral meets a cell, as seen from the light.
fn box_meets_cell(quad: u32, cell: vec2<i32>) -> bool {
  let offset = 4u + 12u * quad;
  var low = vec2<u32>(cells[offset], cells[offset + 1u]);
  var high = low;
  let second = vec2<u32>(cells[offset + 3u], cells[offset + 4u]);
  let third = vec2<u32>(cells[offset + 6u], cells[offset + 7u]);
  let fourth = vec2<u32>(cells[offset + 9u], cells[offset + 10u]);
  low = min(min(low, second), min(third, fourth));
  high = max(max(high, second), max(third, fourth));
  let from_cell = vec4<i32>(vec4<u32>(low, high)) - (cell * TEXEL).xyxy;
  return all(from_cell.xy <= vec2<i32>(TEXEL)) && all(from_cell.zw >= vec2<i32>(0));
}

// Whether a triangle of a flap covers the origin, where the point is, and contradicts `is_behind`. `depth`: the device depth
// of the point. Triangles of walls have no area, so they cover nothing.
fn triangle_changes(a: FlapVertex, b: FlapVertex, c: FlapVertex, depth: f32, is_behind: bool) -> bool {
  // An even number of sides crosses the ray: the origin is outside.
  if ((crosses_ray(a.position, b.position) != crosses_ray(b.position, c.position)) == crosses_ray(c.position, a.position)) {
    return false;
  }
  let weight_b = perp_dot(c.position, a.position);
  let weight_c = perp_dot(a.position, b.position);
  let area = perp_dot(b.position, c.position) + weight_b + weight_c;
  let depth_from_a = (weight_b * f32(b.depth - a.depth) + weight_c * f32(c.depth - a.depth)) / area;
  return is_behind_depth(depth, (f32(a.depth) + depth_from_a) / f32(RANGE)) != is_behind;
}

// The index of a tile in the list of tiles, or the list's length if it is not in the list.
fn list_index_of_tile(tile: u32) -> u32 {
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

// Whether flaps contradict `is_behind` at a point: an odd number of their triangles over it do. The point is at `fraction`
// of a texel from a cell's first sample, and has a device depth.
fn flaps_change(cell: vec2<i32>, fraction: vec2<f32>, depth: f32, is_behind: bool) -> bool {
  let tiles_across = contour.tiles.x;
  let tiles = vec2<u32>(tiles_across, contour.tiles.y / tiles_across);
  let first = vec2<u32>(max(cell - FLAP_LENGTH, vec2<i32>(0)) / TILE);
  let last = min(vec2<u32>((cell + FLAP_LENGTH) / TILE), tiles - 1u);
  let count = counts[contour.tiles.y * (2u + WALKERS)];
  var is_odd = false;
  // Turns: 2.
  for (var y = first.y; y <= last.y; y++) {
    // Turns: 2.
    for (var x = first.x; x <= last.x; x++) {
      let index = list_index_of_tile(y * tiles_across + x);
      if (index == count) {
        continue;
      }
      var end = cells[0];
      if (index + 1u < count) {
        end = counts[index + 1u];
      }
      // Turns: TILE_WALLS.
      for (var quad = counts[index]; quad < end; quad++) {
        if (!box_meets_cell(quad, cell)) {
          continue;
        }
        let a = flap_vertex(quad, 0u, cell, fraction);
        let c = flap_vertex(quad, 2u, cell, fraction);
        // Vertices 0, 1, 2 and 0, 2, 3.
        is_odd = is_odd != triangle_changes(a, flap_vertex(quad, 1u, cell, fraction), c, depth, is_behind);
        is_odd = is_odd != triangle_changes(a, flap_vertex(quad, 3u, cell, fraction), c, depth, is_behind);
      }
    }
  }
  return is_odd;
}

// The surface that a point in a marked cell belongs to.

// From `contour_crossings`, moved by `contour_walls`: crossings of marked edges on segments, in 1/65,536 texel. A word
// for each sample: the lower half for the edge to the right, the upper for the edge down. Positions in
// `cells` are in 1/256 texel.
@group(0) @binding(5) var<storage, read> crossings: array<u32>;

// The point where the contour crosses an edge of a cell, in texels from the cell's first sample. The middle of an edge that
// is not marked.
fn crossing_point(cell: vec2<i32>, edge: u32) -> vec2<f32> {
  let first = first_sample_of_edge(cell, edge);
  let word = crossings[u32(first.y) * (depth_map.size.x + 2u) + u32(first.x)];
  let crossing = (word >> (16u * (edge & 1u))) & 0xffffu;
  let is_marked = ((load_marks(first) >> (edge & 1u)) & 1u) == 1u;
  let along = select(0.5, f32(crossing) / 65536.0, is_marked);
  return vec2<f32>(first - cell) + vec2<f32>(step_along(edge & 1u)) * along;
}

// Positive if b is clockwise of a, as the light sees them, because rows go down.
fn perp_dot(a: vec2<f32>, b: vec2<f32>) -> f32 {
  return a.x * b.y - a.y * b.x;
}

// The corner of a marked cell whose surface a point belongs to, numbered as in `corner_offset`. `point` is in texels from
// the cell's first sample.
fn corner_of_surface(cell: vec2<i32>, edge_code: u32, point: vec2<f32>) -> u32 {
  var best = 0u;
  // One contour through the cell: the nearest corner on the point's side of it. Left of the contour from the first marked
  // edge to the second are the corners between these edges.
  if (countOneBits(edge_code) == 2u) {
    let first = countTrailingZeros(edge_code);
    let second = 31u - countLeadingZeros(edge_code);
    let start = crossing_point(cell, first);
    let is_left = perp_dot(crossing_point(cell, second) - start, point - start) < 0.0;
    var nearest = 4.0;
    for (var corner = 0u; corner < 4u; corner++) {
      let away = abs(point - vec2<f32>(corner_offset(corner)));
      if ((corner > first && corner <= second) == is_left && away.x + away.y < nearest) {
        nearest = away.x + away.y;
        best = corner;
      }
    }
    return best;
  }
  // A junction: corner `i` has the sector between the crossings of edges `i` - 1 and `i`, as seen from the middle. If the
  // point is in two sectors, the lower corner wins.
  let from_middle = point - 0.5;
  for (var next_corner = 4u; next_corner > 0u; next_corner--) {
    let before = crossing_point(cell, (next_corner + 2u) & 3u) - 0.5;
    let after = crossing_point(cell, next_corner - 1u) - 0.5;
    if (perp_dot(before, from_middle) >= 0.0 && perp_dot(from_middle, after) >= 0.0) {
      best = next_corner - 1u;
    }
  }
  return best;
}

// The distance, with the bias, of the surface at a point of a marked cell, or FAR. The point is in texels from the cell's
// first sample. Between neighbours of the same surface the distance is interpolated, towards those of another one
// extrapolated.
fn contour_distance(cell: vec2<i32>, edge_code: u32, point: vec2<f32>) -> i32 {
  let corner = corner_offset(corner_of_surface(cell, edge_code, point));
  let sample = cell + corner;
  let corner_distance = biased_distance(sample);
  if (corner_distance == FAR) {
    return FAR;
  }
  let offset = vec2<i32>(abs(point - vec2<f32>(corner)) * f32(TEXEL));
  var distance = corner_distance;
  for (var axis = 0u; axis < 2u; axis++) {
    let step = step_along(axis) * (1 - 2 * corner[axis]);
    if (is_marked_before(sample + step, step)) {
      distance += surface_distance(sample, step, offset[axis], 0) - corner_distance;
    } else {
      distance += scale_256ths(biased_distance(sample + step) - corner_distance, offset[axis]);
    }
  }
  return clamp(distance, 0, RANGE - 1);
}
