// The boundary between light and shadow: its triangles and their vertices, and whether a point is behind it. Stage
// `depth_surface` draws it once for each stencil bit (`DepthMapFrame::draw`, in the caller's render pass after the eye's
// depths): fragments before what the eye sees invert the bit. `depth_walls`, which draws walls over contours instead,
// imports this file for `cells`, `views` and the near cap.
// Triangles lie between samples, so the boundary has one depth in each direction from the light. A bias moves samples away
// from the light; far ones are at infinity (w is 0 in the world, not in clip space). The near rectangle, where rays of the
// eye begin, is the part of the eye's near plane in the picture. Draws bind what edge_code.wgsl has, `cells` and `views`.
// Triangles at a sample share its vertex, `surface_vertex`, at an invariant position, so a pixel on a common edge is counted
// once. Do not compute it elsewhere; keep operations and order: docs/numerics/depth-maps.md, "Rounding of positions".

#import depth_map/edge_code
#import depth_map/samples

struct DepthMapView {
  // Columns of the matrix to the eye's clip space. It is for x, y, the depth, and 1, where x and y are twice the position on
  // the lattice from its middle.
  across: vec4<f32>,
  down: vec4<f32>,
  depth: vec4<f32>,
  middle: vec4<f32>,
  // The same for points at infinity, away from the light: columns for x, y and 1.
  far_across: vec4<f32>,
  far_down: vec4<f32>,
  far_middle: vec4<f32>,
  // Columns of the matrix from x and y on the near rectangle, from -1 to 1, to the lattice and the depth: homogeneous.
  near_across: vec4<f32>,
  near_up: vec4<f32>,
  near_middle: vec4<f32>,
  // x, y, z: the factors in the depth at infinity of x, y and 1, as for `across`. w: 1 for a parallel light, which has no
  // such depth.
  infinity: vec4<f32>,
  // The bias is the sum of x times the slopes, y times the depth, and z. Shaders take it and `infinity.w` from the first view
  // for all maps, so that these have one vertex where they meet.
  bias: vec4<f32>,
}

// The list of `depth_cells`: the number of cells, then the entries. With contours the list of walls (depth_walls.wgsl).
@group(0) @binding(2) var<storage, read> cells: array<u32>;
// One for each map.
@group(0) @binding(3) var<storage, read> views: array<DepthMapView>;

fn depth_of(key: u32) -> f32 {
  return bitcast<f32>(depth_bits(key));
}

// The size of the minmod of the depth differences to the samples before and after. 0 where one is far.
fn central_depth_slope(key: u32, before: u32, after: u32) -> f32 {
  if (max(key, max(before, after)) == FAR_KEY) {
    return 0.0;
  }
  let a = depth_of(key) - depth_of(before);
  let b = depth_of(after) - depth_of(key);
  return select(0.0, min(abs(a), abs(b)), (a > 0.0) == (b > 0.0));
}

// The smaller of the depth differences to the next sample and from that to the second, so that a jump is no slope. 0 where
// one is far.
fn one_sided_depth_slope(key: u32, first: u32, second: u32) -> f32 {
  if (max(key, max(first, second)) == FAR_KEY) {
    return 0.0;
  }
  return min(abs(depth_of(first) - depth_of(key)), abs(depth_of(second) - depth_of(first)));
}

// The slope at a sample along one axis. With several bits the boundary is moved sideways and leaves the surface on either
// side, so the larger slope of both sides counts.
fn depth_slope_along(sample: vec2<u32>, step: vec2<u32>) -> f32 {
  let key = load_key(sample);
  let before = load_key(sample - step);
  let after = load_key(sample + step);
  if (depth_map.spread != 0u) {
    return max(
      one_sided_depth_slope(key, before, load_key(sample - 2u * step)),
      one_sided_depth_slope(key, after, load_key(sample + 2u * step)));
  }
  return central_depth_slope(key, before, after);
}

// The sum of the slopes across and down. A sample on the border of a map of a cube has those of the samples next to it.
fn depth_slopes_in_map(sample: vec2<u32>) -> f32 {
  // Samples for the slopes across (x, y) and down (z, w).
  var inner_samples = vec4<u32>(sample, sample);
  if (depth_map.faces > 1u) {
    let in_map = sample % depth_map.size.x;
    let inner = clamp(in_map, vec2<u32>(1u), depth_map.size - 2u);
    let corner = sample - in_map;
    inner_samples = vec4<u32>(corner + vec2<u32>(inner.x, in_map.y), corner + vec2<u32>(in_map.x, inner.y));
  }
  return depth_slope_along(inner_samples.xy, vec2<u32>(1u, 0u)) + depth_slope_along(inner_samples.zw, vec2<u32>(0u, 1u));
}

// A map of a cube, and the position of a sample in it.
struct CubeSample {
  face: u32,
  in_map: vec2<u32>,
}

fn cube_sample(sample: vec2<u32>) -> CubeSample {
  let map = sample / depth_map.size.x;
  return CubeSample(map.x + 3u * map.y, sample % depth_map.size.x);
}

fn is_on_map_border(in_map: vec2<u32>) -> bool {
  return any(in_map == vec2<u32>(0u)) || any(in_map == depth_map.size - 1u);
}

// The sum of the slopes at a sample. In a cube it is the largest of all maps that have a sample on the same ray.
fn depth_slopes(sample: vec2<u32>) -> f32 {
  if (depth_map.faces > 1u) {
    let of_cube = cube_sample(sample);
    if (is_on_map_border(of_cube.in_map)) {
      let direction = sample_direction(of_cube.face, of_cube.in_map);
      var largest = 0.0;
      for (var face = 0u; face < 6u; face++) {
        if (has_direction(face, direction)) {
          let corner = vec2<u32>(face % 3u, face / 3u) * depth_map.size.x;
          largest = max(largest, depth_slopes_in_map(corner + sample_in_direction(face, direction)));
        }
      }
      return largest;
    }
  }
  return depth_slopes_in_map(sample);
}

// The depth of a sample that is not far, with the bias, which is at most half of the depth difference to the far end.
fn biased_depth(sample: vec2<u32>, key: u32) -> f32 {
  let depth = depth_of(key);
  let is_reversed = depth_map.is_reversed != 0u;
  let to_far = select(1.0 - depth, depth, is_reversed);
  let bias = views[0].bias;
  let offset = min(bias.x * depth_slopes(sample) + bias.y * depth + bias.z, 0.5 * to_far);
  return depth + select(offset, -offset, is_reversed);
}

// x and y: twice the position of a sample from the middle of the lattice. z: the map. In a cube the first map with a sample
// on the same ray counts, so that all maps have one vertex there.
fn view_position(sample: vec2<u32>) -> vec3<i32> {
  if (depth_map.faces == 1u) {
    return vec3<i32>(2 * vec2<i32>(sample) - 1 - vec2<i32>(depth_map.size), 0);
  }
  var of_cube = cube_sample(sample);
  if (is_on_map_border(of_cube.in_map)) {
    let direction = sample_direction(of_cube.face, of_cube.in_map);
    // Turns: 5.
    for (var face = 0u; face < of_cube.face; face++) {
      if (has_direction(face, direction)) {
        of_cube = CubeSample(face, sample_in_direction(face, direction));
      }
    }
  }
  return vec3<i32>(2 * vec2<i32>(of_cube.in_map) + 1 - vec2<i32>(depth_map.size), i32(of_cube.face));
}

// The vertex of a sample, in the eye's clip space.
fn surface_vertex(sample: vec2<u32>) -> vec4<f32> {
  let key = load_key(sample);
  let position_and_face = view_position(sample);
  let position = vec2<f32>(position_and_face.xy);
  let view = views[position_and_face.z];
  if (key == FAR_KEY) {
    return view.far_across * position.x + view.far_down * position.y + view.far_middle;
  }
  let depth = biased_depth(sample, key);
  return view.across * position.x + view.down * position.y + view.depth * depth + view.middle;
}

// The offset from a cell's first sample to corner 0, 1 or 2 of one of its two triangles. `entry` has the cell's diagonal.
fn triangle_corner(entry: u32, triangle: u32, corner: u32) -> vec2<u32> {
  // Samples, two bits each: 0 is (0, 0), 1 is (1, 0), 2 is (0, 1), 3 is (1, 1).
  let plain = select(0x34u, 0x2cu, triangle != 0u);
  let split = select(0x24u, 0x2du, triangle != 0u);
  let index = (select(plain, split, (entry & SPLIT) != 0u) >> (2u * corner)) & 3u;
  return vec2<u32>(index & 1u, index >> 1u);
}

struct SurfaceVertex {
  @builtin(position) @invariant position: vec4<f32>,
}

// The depth of a sample as a corner of a plane triangle. A far sample has the depth at infinity, which a parallel light does
// not have.
fn plane_depth(sample: vec2<u32>) -> f32 {
  let key = load_key(sample);
  if (key == FAR_KEY) {
    let view = view_position(sample);
    return dot(views[view.z].infinity.xyz, vec3<f32>(vec2<f32>(view.xy), 1.0));
  }
  return biased_depth(sample, key);
}

// A point of the near rectangle on the lattice of a map, with its depth: homogeneous.
fn near_point_in_map(face: u32, near_position: vec2<f32>) -> vec4<f32> {
  return views[face].near_across * near_position.x + views[face].near_up * near_position.y + views[face].near_middle;
}

// A point of the near rectangle in the map that has it.
struct NearPoint {
  // False outside of the maps, and behind the light.
  is_inside: bool,
  face: u32,
  // Its position on the lattice of the map, and its depth there.
  lattice: vec2<f32>,
  depth: f32,
}

// Finds the point at x and y of the near rectangle, from -1 to 1.
fn locate_near_point(near_position: vec2<f32>) -> NearPoint {
  // The map in whose direction of view the point is farthest from the light, which w measures in the same units for all
  // maps.
  var point = near_point_in_map(0u, near_position);
  var face = 0u;
  // Turns: 5.
  for (var other_face = 1u; other_face < depth_map.faces; other_face++) {
    let other_point = near_point_in_map(other_face, near_position);
    if (other_point.w > point.w) {
      point = other_point;
      face = other_face;
    }
  }
  var lattice = point.xy / point.w;
  var is_inside = point.w > 0.0;
  if (depth_map.faces > 1u) {
    // Rounding may put it beyond the border.
    lattice = clamp(lattice, vec2<f32>(0.0), vec2<f32>(depth_map.size - 1u));
  } else {
    is_inside = is_inside && all(lattice >= vec2<f32>(0.0)) && all(lattice < vec2<f32>(depth_map.size + 1u));
  }
  return NearPoint(is_inside, face, lattice, point.z / point.w);
}

// Whether a point is behind the triangle in its direction from the light, even if the triangle is not drawn. For a parallel
// light no point is behind a triangle with a far sample.
fn is_behind_triangle(point: NearPoint) -> bool {
  var corner = vec2<u32>(0u);
  var cell = floor(point.lattice);
  if (depth_map.faces > 1u) {
    corner = vec2<u32>(point.face % 3u, point.face / 3u) * depth_map.size.x;
    cell = min(cell, vec2<f32>(depth_map.size - 2u));
  }
  let first = corner + vec2<u32>(cell);
  let fraction = point.lattice - cell;
  let split = is_split(load_cell_keys(first));
  let is_second = select((fraction.x < fraction.y), (fraction.x + fraction.y > 1.0), split);
  // Barycentric weights of the samples (0, 0), (1, 0), (0, 1), (1, 1).
  var weights = vec4<f32>(1.0 - fraction.x, fraction.x - fraction.y, 0.0, fraction.y);
  if (split) {
    weights = vec4<f32>(1.0 - fraction.x - fraction.y, fraction.x, fraction.y, 0.0);
    if (is_second) {
      weights = vec4<f32>(0.0, 1.0 - fraction.y, 1.0 - fraction.x, fraction.x + fraction.y - 1.0);
    }
  } else if (is_second) {
    weights = vec4<f32>(1.0 - fraction.y, 0.0, fraction.y - fraction.x, fraction.x);
  }
  var depth = 0.0;
  for (var index = 0u; index < 4u; index++) {
    if (weights[index] > 0.0) {
      let sample = first + vec2<u32>(index & 1u, index >> 1u);
      if (views[0].infinity.w != 0.0 && load_key(sample) == FAR_KEY) {
        return false;
      }
      depth += weights[index] * plane_depth(sample);
    }
  }
  let difference = point.depth - depth;
  return select(difference > 0.0, difference < 0.0, depth_map.is_reversed != 0u);
}

// Entry points. `depth_surface`, with the fragment shader `nothing`, has six vertices for each listed cell, by the indirect
// draw of `depth_cells`. If the list overflowed it has six for every cell, and decides about each as `depth_cells_count`
// would. It cannot know the marks of `depth_edges`: where these made the list, it draws every triangle that has a sample
// that is not far. With contours it is drawn only if the list of walls overflowed.
// `depth_near_cap`, with `depth_near_cap_fragment` or that of depth_walls.wgsl, is a triangle over the whole picture that
// inverts the bit where the near rectangle is in shadow. It is left out if the CPU, `depth_near` or `depth_near_walls` found
// the rectangle in light. For pixels of one sample `drawn_wgsl` (src/gpu/depth_map/pipelines.rs) replaces the text of the
// attribute that interpolates `near_position`: keep it, also in depth_walls.wgsl, and read no other value of a sample.
// Together they invert the bit exactly where the visible point is behind the boundary, unless a detector missed an edge.

// Vertices 0 to 2 are the first triangle of a cell, 3 to 5 the second. A triangle that is not drawn is degenerate.
@vertex
fn depth_surface(@builtin(vertex_index) index: u32) -> SurfaceVertex {
  let cell_index = index / 6u;
  let triangle = (index / 3u) & 1u;
  var entry = 0u;
  if (cells[0] > depth_map.capacity) {
    entry = entry_of_cell(cell_index);
  } else {
    entry = cells[1u + cell_index];
  }
  if ((entry & (FIRST_TRIANGLE << triangle)) == 0u) {
    return SurfaceVertex(vec4<f32>(0.0, 0.0, 0.0, 1.0));
  }
  let sample = first_sample_of_cell(entry & CELL_MASK) + triangle_corner(entry, triangle, index % 3u);
  return SurfaceVertex(surface_vertex(sample));
}

struct NearVertex {
  @builtin(position) position: vec4<f32>,
  @location(0) @interpolate(linear, sample) near_position: vec2<f32>,
}

@vertex
fn depth_near_cap(@builtin(vertex_index) index: u32) -> NearVertex {
  let near_position = vec2<f32>(select(-1.0, 3.0, index == 1u), select(-1.0, 3.0, index == 2u));
  return NearVertex(vec4<f32>(near_position, 0.5, 1.0), near_position);
}

// Whether a point of the near rectangle, x and y from -1 to 1, is behind the boundary.
fn is_behind_boundary(near_position: vec2<f32>) -> bool {
  let point = locate_near_point(near_position);
  return point.is_inside && is_behind_triangle(point);
}

@fragment
fn depth_near_cap_fragment(@location(0) @interpolate(linear, sample) near_position: vec2<f32>) {
  if (!is_behind_boundary(near_position)) {
    discard;
  }
}

@fragment
fn nothing() {}
