// Samples of a light's depth map as integers, and the lattice that holds them. All stages here but `mesh_depth` have it. A
// sample is the depth in the middle of a texel. Its key is an integer that grows with the distance from the light: the bits of
// the depth, or with reversed depth the bits of 1, as an integer, less these. FAR_KEY: nothing casts there (at the far end or
// beyond it, or NaN).
// The lattice has one more row and column on each side than the map; they are far, so nothing casts outside of a map. Sample
// (1, 1) is texel (0, 0). A cube has six maps, three in a row in one texture, without that border: sample (0, 0) is texel (0,
// 0). An importer binds `depth_map` and a texture of that size. A place outside of the lattice is far; in a cube its key is to
// be dropped.
// Keys come from bits, never from float arithmetic, so all devices and the CPU decide alike. Keep it so.

struct DepthMapShape {
  // Texels across and down, of one map.
  size: vec2<u32>,
  // All cells. Blocks: of 64 strips of cells (cell_words.wgsl), or of 256 texels in the stages that write a map.
  cells: u32,
  blocks: u32,
  // Cells that the list has room for.
  capacity: u32,
  // 1: every cell that is not far is marked. 0: differences above the threshold are.
  every_cell: u32,
  // Bits of the threshold, in device depth.
  threshold: u32,
  // 1: near is 1 and far is 0.
  is_reversed: u32,
  // Maps: 1, or the 6 of a cube.
  faces: u32,
  // 1: edges between different objects are marked.
  objects: u32,
  // 1: triangles at the ends of marked edges are drawn, too.
  spread: u32,
  // 0.
  unused: u32,
}

@group(0) @binding(0) var<uniform> depth_map: DepthMapShape;
@group(0) @binding(1) var depth_texture: texture_2d<f32>;

// The key of a sample that casts nothing. All other keys are smaller. A larger key is farther.
const FAR_KEY: u32 = 0x7fffffffu;
const ONE: u32 = 0x3f800000u;

// The key of a depth's bits. Less than 2^-126, also below 0, counts as 0, more than 1 as 1. It works on bits, because a device
// may flush a subnormal and may assume that there is no NaN.
fn sample_key(bits: u32) -> u32 {
  let size = bits & 0x7fffffffu;
  let is_zero = ((bits >> 31u) == 1u) | (size < 0x00800000u);
  let unit = select(min(size, ONE), 0u, is_zero);
  let is_reversed = depth_map.is_reversed != 0u;
  let is_far = unit == select(ONE, 0u, is_reversed);
  return select(select(unit, ONE - unit, is_reversed), FAR_KEY, is_far | (size > 0x7f800000u));
}

// The bits of the depth of a key that is not far.
fn depth_bits(key: u32) -> u32 {
  return select(key, ONE - key, depth_map.is_reversed != 0u);
}

// The bits of the depth of any key.
fn bits_of_key(key: u32) -> u32 {
  return select(depth_bits(key), select(ONE, 0u, depth_map.is_reversed != 0u), key == FAR_KEY);
}

// The key of a sample of the lattice. One on the border reads a texel beside it, and drops it: one place loads for all.
fn key_at(at: vec2<u32>) -> u32 {
  let is_cube = depth_map.faces > 1u;
  let inside = clamp(at, vec2<u32>(1u), depth_map.size);
  let texel = select(inside - 1u, at, is_cube);
  let key = sample_key(bitcast<u32>(textureLoad(depth_texture, vec2<i32>(texel), 0).x));
  return select(key, FAR_KEY, !is_cube && any(inside != at));
}

// `turns` itself, if their sum with `cells` does not overflow, but no constant for a compiler: a loop up to it is not
// unrolled.
fn opaque(turns: u32) -> u32 {
  return min(turns, turns + depth_map.cells);
}

// Six depth maps around a light: which samples of two or three of them lie on one ray. `depth_cube` gives such samples one
// depth, and surface.wgsl (draws) one vertex, so the boundary of shadow closes across the maps.
// Maps 0 to 5 look along +x, -x, +y, -y, +z, -z. The middles of a map's outermost texels lie on the edges of the cube. `at` is
// a sample within its map, from (0, 0) on. Directions are integers, so all is exact. Axes are those of
// src/gpu/depth_map/meeting.rs, which makes cameras: keep both alike.

// The axes of a map: along its view, to its right, and up.
struct CubeFace {
  forward: vec3<i32>,
  right: vec3<i32>,
  up: vec3<i32>,
}

fn cube_face(face: u32) -> CubeFace {
  let sign = 1 - 2 * i32(face & 1u);
  switch face >> 1u {
    case 0u: {
      return CubeFace(vec3<i32>(sign, 0, 0), vec3<i32>(0, 0, sign), vec3<i32>(0, 1, 0));
    }
    case 1u: {
      return CubeFace(vec3<i32>(0, sign, 0), vec3<i32>(1, 0, 0), vec3<i32>(0, 0, sign));
    }
    default: {
      return CubeFace(vec3<i32>(0, 0, sign), vec3<i32>(-sign, 0, 0), vec3<i32>(0, 1, 0));
    }
  }
}

fn product(a: vec3<i32>, b: vec3<i32>) -> i32 {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The direction of a sample from the light. The size of its largest component is the number of cells along a side of the map.
fn direction_of(face: u32, at: vec2<u32>) -> vec3<i32> {
  let axes = cube_face(face);
  let most = i32(depth_map.size.x) - 1;
  return most * axes.forward + (2 * i32(at.x) - most) * axes.right + (most - 2 * i32(at.y)) * axes.up;
}

// Whether a map has a sample in the direction of a sample: its component along the map's view is the largest possible.
fn has_direction(face: u32, direction: vec3<i32>) -> bool {
  return product(cube_face(face).forward, direction) == i32(depth_map.size.x) - 1;
}

// The sample that a map has in a direction. `has_direction` must hold.
fn sample_of(face: u32, direction: vec3<i32>) -> vec2<u32> {
  let axes = cube_face(face);
  let most = i32(depth_map.size.x) - 1;
  return vec2<u32>(
    u32((most + product(direction, axes.right)) / 2), u32((most - product(direction, axes.up)) / 2));
}
