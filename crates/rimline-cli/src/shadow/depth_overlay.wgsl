// The boundary of the shadows of a depth map: its triangles as tinted glass, and lines: where what casts ends before
// nothing, as the light sees it, and some of the rays there; of walls and flaps, their sides. Where a list overflowed, every
// cell that is not all far is shown. Fragment shaders are those of overlay.wgsl. No shader branches on uniforms alone
// (scene.wgsl).

// A map as the picture's camera sees it.
struct DepthView {
  // To clip space, of x, y and depth in the map's device coordinates.
  across: vec4<f32>,
  up: vec4<f32>,
  depth: vec4<f32>,
  middle: vec4<f32>,
  // The same for points at infinity, of x and y.
  far_across: vec4<f32>,
  far_up: vec4<f32>,
  far_middle: vec4<f32>,
}

struct DepthViews {
  // Texels of a map.
  size: vec2<u32>,
  // 1, or the 6 of a cube, which lie three in a row. 0: one, whose list has walls.
  maps: u32,
  is_reversed: u32,
  // Cells, or walls, that the list has room for.
  capacity: u32,
  views: array<DepthView, 6>,
}

@group(2) @binding(0) var<uniform> maps: DepthViews;
// How many there are, then cells or walls, as `rimline::gpu::depth_map::DepthMapVolumes::cells` has them.
@group(2) @binding(1) var<storage, read> cells: array<u32>;
@group(2) @binding(2) var depths: texture_2d<f32>;

// A sample: where it is in its map, and whether it casts.
struct Sample {
  map: u32,
  // Position of its texel, from the first. It may be beside the map.
  texel: vec2<i32>,
  depth: f32,
  is_far: bool,
}

fn sample_at(map: u32, texel: vec2<i32>) -> Sample {
  let is_outside = any(texel < vec2<i32>(0)) || any(texel >= vec2<i32>(maps.size));
  let texel_position = texel + vec2<i32>(vec2<u32>(map % 3u, map / 3u) * maps.size);
  let depth = textureLoad(depths, clamp(texel_position, vec2<i32>(0), vec2<i32>(textureDimensions(depths)) - 1), 0).x;
  // Neither is so for NaN.
  let casts = select((depth < 1.0), (depth > 0.0), maps.is_reversed != 0u);
  return Sample(map, texel, clamp(depth, 0.0, 1.0), is_outside || !casts);
}

fn sample_clip(s: Sample) -> vec4<f32> {
  let ndc = (2.0 * vec2<f32>(s.texel) + 1.0) / vec2<f32>(maps.size) - 1.0;
  let view = maps.views[s.map];
  if (s.is_far) {
    return view.far_across * ndc.x - view.far_up * ndc.y + view.far_middle;
  }
  return view.across * ndc.x - view.up * ndc.y + view.depth * s.depth + view.middle;
}

struct DepthTriangle {
  is_drawn: bool,
  corners: array<Sample, 3>,
}

// Same order as `sample_key` of the library: larger is farther.
fn key_of(s: Sample) -> u32 {
  let bits = bitcast<u32>(s.depth);
  return select(select(bits, 0x3f800000u - bits, maps.is_reversed != 0u), 0x7fffffffu, s.is_far);
}

fn key_distance(a: Sample, b: Sample) -> u32 {
  return max(key_of(a), key_of(b)) - min(key_of(a), key_of(b));
}

// Triangle 0 or 1 of a listed cell. Bits 30 and 31 tell which are drawn, bit 29 along which diagonal the cell is split.
// Where the list overflowed, of any cell, unless all of it is far.
fn triangle(number: u32, second: u32) -> DepthTriangle {
  let is_of_all = cells[0] > maps.capacity;
  let entry = select(cells[min(1u + number, arrayLength(&cells) - 1u)], number, is_of_all);
  // The only map has cells all around, too: sample (0, 0) is beside the first texel.
  let is_cube = maps.maps > 1u;
  let across = select(maps.size.x + 1u, maps.size.x - 1u, is_cube);
  let cells_of_map = select(0xffffffffu, across * across, is_cube);
  let map = min((entry & 0x1fffffffu) / cells_of_map, 5u);
  let cell = (entry & 0x1fffffffu) % cells_of_map;
  let first = vec2<i32>(vec2<u32>(cell % across, cell / across)) - select(vec2<i32>(1), vec2<i32>(0), is_cube);
  var is_split = (entry & 0x20000000u) != 0u;
  var is_drawn = number + 1u < arrayLength(&cells) && (entry & (0x40000000u << second)) != 0u;
  if (is_of_all) {
    let a = sample_at(map, first);
    let b = sample_at(map, first + vec2<i32>(1, 0));
    let c = sample_at(map, first + vec2<i32>(0, 1));
    let d = sample_at(map, first + vec2<i32>(1, 1));
    is_split = key_distance(a, d) > key_distance(b, c);
    is_drawn = !(a.is_far && b.is_far && c.is_far && d.is_far);
  }
  var offsets = array<vec2<i32>, 3>(vec2<i32>(0, 0), vec2<i32>(1, 0), vec2<i32>(1, 1));
  if (is_split) {
    offsets[2] = vec2<i32>(0, 1);
  }
  if (second != 0u) {
    offsets = array<vec2<i32>, 3>(vec2<i32>(0, 0), vec2<i32>(0, 1), vec2<i32>(1, 1));
    if (is_split) {
      offsets[0] = vec2<i32>(1, 0);
    }
  }
  return DepthTriangle(
    is_drawn,
    array<Sample, 3>(
      sample_at(map, first + offsets[0]), sample_at(map, first + offsets[1]), sample_at(map, first + offsets[2])));
}

const NOWHERE = vec4<f32>(0.0, 0.0, 0.0, 1.0);

// A corner of a wall or flap: a position in parts of 256 of a texel, with texel (0, 0) at (256, 256), and a distance
// from the near plane.
fn wall_clip(number: u32, corner: u32) -> vec4<f32> {
  let word = 4u + 12u * number + 3u * corner;
  let size = vec2<f32>(maps.size);
  let ndc = (vec2<f32>(vec2<u32>(cells[word], cells[word + 1u])) / 128.0 - 1.0) / size - 1.0;
  let distance = cells[word + 2u];
  let view = maps.views[0];
  if (distance == 0x7fffffffu) {
    return view.far_across * ndc.x - view.far_up * ndc.y + view.far_middle;
  }
  let depth = f32(distance) / 536870912.0;
  let device = select(depth, 1.0 - depth, maps.is_reversed != 0u);
  return view.across * ndc.x - view.up * ndc.y + view.depth * device + view.middle;
}

// `listed`: how many cells or walls there are.
fn are_walls(listed: u32) -> bool {
  return (maps.maps == 0u) & (listed <= maps.capacity);
}

@vertex fn depth_volumes_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
  let vertex = index % 6u;
  if (are_walls(cells[0])) {
    return wall_clip(index / 6u, select(vertex, select(0u, vertex - 2u, vertex > 3u), vertex >= 3u));
  }
  var drawn = triangle(index / 6u, vertex / 3u);
  if (!drawn.is_drawn) {
    return NOWHERE;
  }
  return sample_clip(drawn.corners[vertex % 3u]);
}

// For each triangle a line between its two corners that cast, then a ray, if the third is far. A cell has six ends of
// lines in each of two instances, of which the first eight are taken.
@vertex fn depth_edges_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Edge {
  let vertex = 6u * instance + index % 6u;
  let nothing = Edge(NOWHERE, 0.0);
  if (vertex >= 8u) {
    return nothing;
  }
  // The four sides of a wall.
  if (are_walls(cells[0])) {
    return Edge(wall_clip(index / 6u, (vertex / 2u + vertex % 2u) % 4u), 0.4);
  }
  var drawn = triangle(index / 6u, vertex / 4u);
  if (!drawn.is_drawn) {
    return nothing;
  }
  var far = 3u;
  var count = 0u;
  for (var corner = 0u; corner < 3u; corner++) {
    if (drawn.corners[corner].is_far) {
      far = corner;
      count++;
    }
  }
  if (count != 1u) {
    return nothing;
  }
  let one = drawn.corners[(far + 1u) % 3u];
  let other = drawn.corners[(far + 2u) % 3u];
  let end = vertex & 1u;
  if ((vertex & 2u) == 0u) {
    var at = one;
    if (end != 0u) {
      at = other;
    }
    return Edge(sample_clip(at), 0.4);
  }
  // About as many rays as a body of some hundred faces has.
  let apart = max(i32(maps.size.x) / 32, 1);
  if ((one.texel.x + one.texel.y) % apart != 0) {
    return nothing;
  }
  var at = one;
  at.is_far = end != 0u;
  return Edge(sample_clip(at), 0.4);
}
