// The boundary between light and shadow: its triangles, their vertices, and whether a place is behind it. Stage
// `depth_surface` draws it into the caller's stencil (`DepthMapFrame::draw`, in the caller's render pass after the eye's
// depths), once for each bit; `depth_walls`, which draws walls over contours instead, takes the near cap and what it needs
// from here. Depth is tested and not written; a fragment before what is seen turns the bit round, or counts.
// Triangles lie between samples, with one depth for each direction from the light. Samples are moved away from the light by a
// bias; far ones are at infinity (w is 0). The near rectangle is the part of the eye's near plane in the picture, where rays
// of the eye begin; a place on it is in shadow if it is behind the boundary.
// Importers bind `cells`: the list of `depth_cells`, or with contours the walls of `contour_walls`; and a view for each map.
// All triangles at a sample take its vertex from `surface_vertex`, at an invariant position, so a pixel on a common edge is
// counted once. Do not compute it anywhere else. docs/numerics/depth-maps.md, "Rounding of positions", bounds its rounding:
// keep operations and order.

#import depth_map/edge_code
#import depth_map/samples

struct DepthMapView {
  // Columns of the matrix to the eye's clip space, from twice the place on the lattice from its middle, and the depth.
  across: vec4<f32>,
  down: vec4<f32>,
  depth: vec4<f32>,
  middle: vec4<f32>,
  // The same for places at infinity, away from the light.
  far_across: vec4<f32>,
  far_down: vec4<f32>,
  far_middle: vec4<f32>,
  // Columns from x and y on the near rectangle, from -1 to 1, to the lattice and the depth: homogeneous.
  near_across: vec4<f32>,
  near_up: vec4<f32>,
  near_middle: vec4<f32>,
  // The depth at infinity, of the same terms as `far_across`. 1 in w: there is none, the light is parallel.
  infinity: vec4<f32>,
  // How far the surface moves: a share of its slope, of its depth, and a constant.
  bias: vec4<f32>,
}

// The length of the list, and the list.
@group(0) @binding(2) var<storage, read> cells: array<u32>;
// One for each map.
@group(0) @binding(3) var<storage, read> views: array<DepthMapView>;

fn depth_of(key: u32) -> f32 {
  return bitcast<f32>(depth_bits(key));
}

// The smaller size of the depth differences to the samples before and after, 0 where they have different signs or one is far.
fn slope(key: u32, before: u32, after: u32) -> f32 {
  if (max(key, max(before, after)) == FAR_KEY) {
    return 0.0;
  }
  let a = depth_of(key) - depth_of(before);
  let b = depth_of(after) - depth_of(key);
  return select(0.0, min(abs(a), abs(b)), (a > 0.0) == (b > 0.0));
}

// The depth difference to one side, from one sample to the next and on to the second: the smaller, so that a step is no slope.
fn slope_to(key: u32, first: u32, second: u32) -> f32 {
  if (max(key, max(first, second)) == FAR_KEY) {
    return 0.0;
  }
  return min(abs(depth_of(first) - depth_of(key)), abs(depth_of(second) - depth_of(first)));
}

// The slope at a sample along one axis. A boundary that is moved sideways leaves the surface on either side, so there the
// larger counts.
fn slope_along(at: vec2<u32>, step: vec2<u32>) -> f32 {
  let key = load_key(at);
  let before = load_key(at - step);
  let after = load_key(at + step);
  if (depth_map.spread != 0u) {
    return max(slope_to(key, before, load_key(at - 2u * step)), slope_to(key, after, load_key(at + 2u * step)));
  }
  return slope(key, before, after);
}

// The sum of the slopes at a sample across and down. At the border of a map of a cube, those of the samples next to it.
fn slopes_in_map(at: vec2<u32>) -> f32 {
  var here = vec4<u32>(at, at);
  if (depth_map.faces > 1u) {
    let local = at % depth_map.size.x;
    let inner = clamp(local, vec2<u32>(1u), depth_map.size - 2u);
    let corner = at - local;
    here = vec4<u32>(corner + vec2<u32>(inner.x, local.y), corner + vec2<u32>(local.x, inner.y));
  }
  return slope_along(here.xy, vec2<u32>(1u, 0u)) + slope_along(here.zw, vec2<u32>(0u, 1u));
}

// A map of a cube, and a sample of it.
struct CubeSample {
  face: u32,
  at: vec2<u32>,
}

fn cube_sample(at: vec2<u32>) -> CubeSample {
  let tile = at / depth_map.size.x;
  return CubeSample(tile.x + 3u * tile.y, at % depth_map.size.x);
}

fn is_on_border(at: vec2<u32>) -> bool {
  return any(at == vec2<u32>(0u)) || any(at == depth_map.size - 1u);
}

// The sum of the slopes at a sample: in a cube, the largest of all maps that have a sample on its ray.
fn slopes(at: vec2<u32>) -> f32 {
  if (depth_map.faces > 1u) {
    let own = cube_sample(at);
    if (is_on_border(own.at)) {
      let direction = sample_direction(own.face, own.at);
      var most = 0.0;
      for (var face = 0u; face < 6u; face++) {
        if (has_direction(face, direction)) {
          let corner = vec2<u32>(face % 3u, face / 3u) * depth_map.size.x;
          most = max(most, slopes_in_map(corner + sample_in_direction(face, direction)));
        }
      }
      return most;
    }
  }
  return slopes_in_map(at);
}

// The depth of a sample that is not far, moved away from the light. It stays before the far plane.
fn moved_depth(at: vec2<u32>, key: u32) -> f32 {
  let depth = depth_of(key);
  let is_reversed = depth_map.is_reversed != 0u;
  let to_far = select(1.0 - depth, depth, is_reversed);
  let bias = views[0].bias;
  let offset = min(bias.x * slopes(at) + bias.y * depth + bias.z, 0.5 * to_far);
  return depth + select(offset, -offset, is_reversed);
}

// The map whose view a sample is taken with (z): the first with a sample on its ray, so that all maps give that one vertex. x
// and y: twice that sample's place from the middle of the lattice.
fn view_of(at: vec2<u32>) -> vec3<i32> {
  if (depth_map.faces == 1u) {
    return vec3<i32>(2 * vec2<i32>(at) - 1 - vec2<i32>(depth_map.size), 0);
  }
  var own = cube_sample(at);
  if (is_on_border(own.at)) {
    let direction = sample_direction(own.face, own.at);
    // Turns: 5.
    for (var face = 0u; face < own.face; face++) {
      if (has_direction(face, direction)) {
        own = CubeSample(face, sample_in_direction(face, direction));
      }
    }
  }
  return vec3<i32>(2 * vec2<i32>(own.at) + 1 - vec2<i32>(depth_map.size), i32(own.face));
}

// The vertex of a sample, in the eye's clip space.
fn surface_vertex(at: vec2<u32>) -> vec4<f32> {
  let key = load_key(at);
  let own = view_of(at);
  let place = vec2<f32>(own.xy);
  let view = views[own.z];
  if (key == FAR_KEY) {
    return view.far_across * place.x + view.far_down * place.y + view.far_middle;
  }
  let depth = moved_depth(at, key);
  return view.across * place.x + view.down * place.y + view.depth * depth + view.middle;
}

// The sample of corner 0 to 2 of a cell's triangle (`second`: 0 or 1), from sample (0, 0) of the cell. `entry` tells its
// split.
fn triangle_corner(entry: u32, second: u32, corner: u32) -> vec2<u32> {
  // Numbers of samples, two bits each: 0 is (0, 0), 1 is (1, 0), 2 is (0, 1), 3 is (1, 1).
  let plain = select(0x34u, 0x2cu, second != 0u);
  let split = select(0x24u, 0x2du, second != 0u);
  let number = (select(plain, split, (entry & SPLIT) != 0u) >> (2u * corner)) & 3u;
  return vec2<u32>(number & 1u, number >> 1u);
}

struct SurfaceVertex {
  @builtin(position) @invariant position: vec4<f32>,
}

// The depth of a sample in the plane of a triangle. A parallel light has none for far samples.
fn plane_depth(at: vec2<u32>) -> f32 {
  let key = load_key(at);
  if (key == FAR_KEY) {
    let view = view_of(at);
    return dot(views[view.z].infinity.xyz, vec3<f32>(vec2<f32>(view.xy), 1.0));
  }
  return moved_depth(at, key);
}

// A place on the near rectangle in a map: homogeneous, on the lattice.
fn near_point(face: u32, place: vec2<f32>) -> vec4<f32> {
  return views[face].near_across * place.x + views[face].near_up * place.y + views[face].near_middle;
}

// A place on the near rectangle in the map that has it.
struct NearPlace {
  is_in: bool,
  face: u32,
  // On the lattice of the map.
  lattice: vec2<f32>,
  depth: f32,
}

// `place`: x and y on the near rectangle, from -1 to 1. Outside of the map, or behind the light, `is_in` is false.
fn near_place(place: vec2<f32>) -> NearPlace {
  // The map along which the place is farthest away from the light. w counts the distance, in the same units for all.
  var point = near_point(0u, place);
  var face = 0u;
  // Turns: 5.
  for (var other = 1u; other < depth_map.faces; other++) {
    let there = near_point(other, place);
    if (there.w > point.w) {
      point = there;
      face = other;
    }
  }
  var lattice = point.xy / point.w;
  var is_in = point.w > 0.0;
  if (depth_map.faces > 1u) {
    // Rounding may put it beyond the border.
    lattice = clamp(lattice, vec2<f32>(0.0), vec2<f32>(depth_map.size - 1u));
  } else {
    is_in = is_in && all(lattice >= vec2<f32>(0.0)) && all(lattice < vec2<f32>(depth_map.size + 1u));
  }
  return NearPlace(is_in, face, lattice, point.z / point.w);
}

// Whether a place on the near rectangle is behind the triangle there, which is the very one that a draw would have. A place
// beside a far sample of a parallel light is not.
fn is_behind_triangle(found: NearPlace) -> bool {
  var corner = vec2<u32>(0u);
  var cell = floor(found.lattice);
  if (depth_map.faces > 1u) {
    corner = vec2<u32>(found.face % 3u, found.face / 3u) * depth_map.size.x;
    cell = min(cell, vec2<f32>(depth_map.size - 2u));
  }
  let at = corner + vec2<u32>(cell);
  let part = found.lattice - cell;
  let entry = templates(at);
  let is_split = (entry & SPLIT) != 0u;
  let second = select((part.x < part.y), (part.x + part.y > 1.0), is_split);
  // The shares of the samples (0, 0), (1, 0), (0, 1), (1, 1).
  var shares = vec4<f32>(1.0 - part.x, part.x - part.y, 0.0, part.y);
  if (is_split) {
    shares = vec4<f32>(1.0 - part.x - part.y, part.x, part.y, 0.0);
    if (second) {
      shares = vec4<f32>(0.0, 1.0 - part.y, 1.0 - part.x, part.x + part.y - 1.0);
    }
  } else if (second) {
    shares = vec4<f32>(1.0 - part.y, 0.0, part.y - part.x, part.x);
  }
  var depth = 0.0;
  for (var number = 0u; number < 4u; number++) {
    if (shares[number] > 0.0) {
      let sample = at + vec2<u32>(number & 1u, number >> 1u);
      if (views[0].infinity.w != 0.0 && load_key(sample) == FAR_KEY) {
        return false;
      }
      depth += shares[number] * plane_depth(sample);
    }
  }
  let ahead = found.depth - depth;
  return select(ahead > 0.0, ahead < 0.0, depth_map.is_reversed != 0u);
}

// Entry points. `depth_surface` with `nothing`: six vertices for each listed cell, an indirect draw whose arguments
// `depth_cells` wrote. With contours only if the list of walls overflowed. If a list overflowed, it draws every cell and
// decides about it as the list would. `depth_near_cap` with its fragment shader: one triangle over the picture, which turns
// the bit round where the near rectangle is in shadow; 3 vertices, or 0 if `depth_near` found it in light. Both together turn
// the bit just where what is seen is behind the boundary, unless a detector missed an edge.

// Vertices 0 to 2 are the first triangle of a cell, 3 to 5 the second. If it is not drawn, they lie in one point.
@vertex
fn depth_surface(@builtin(vertex_index) index: u32) -> SurfaceVertex {
  let number = index / 6u;
  let second = (index / 3u) & 1u;
  var entry = 0u;
  if (cells[0] > depth_map.capacity) {
    entry = entry_of_cell(number);
  } else {
    entry = cells[1u + number];
  }
  if ((entry & (FIRST_TRIANGLE << second)) == 0u) {
    return SurfaceVertex(vec4<f32>(0.0, 0.0, 0.0, 1.0));
  }
  let at = corner_of_cell(entry & CELL_MASK) + triangle_corner(entry, second, index % 3u);
  return SurfaceVertex(surface_vertex(at));
}

struct NearVertex {
  @builtin(position) position: vec4<f32>,
  @location(0) @interpolate(linear, sample) place: vec2<f32>,
}

@vertex
fn depth_near_cap(@builtin(vertex_index) index: u32) -> NearVertex {
  let place = vec2<f32>(select(-1.0, 3.0, index == 1u), select(-1.0, 3.0, index == 2u));
  return NearVertex(vec4<f32>(place, 0.5, 1.0), place);
}

// Whether a place on the near rectangle, from -1 to 1, is behind the boundary.
fn is_behind(place: vec2<f32>) -> bool {
  let found = near_place(place);
  return found.is_in && is_behind_triangle(found);
}

@fragment
fn depth_near_cap_fragment(@location(0) @interpolate(linear, sample) place: vec2<f32>) {
  if (!is_behind(place)) {
    discard;
  }
}

@fragment
fn nothing() {}
