// Samples of a light's depth map as integer keys, and the lattice that holds them. All stages of this folder but
// `mesh_depth` import it. They bind `depth_map`, and `depth_texture` if they read depths.
// A sample is the depth at the centre of a texel. Its key is an integer that grows with the distance from the light. It is
// the bits of the depth or, with reversed depth, the bits of 1 less those. FAR_KEY: nothing casts there, because the depth
// is at or beyond the far end, or NaN.
// The lattice of a single map has a border of one far sample on each side: sample (1, 1) is texel (0, 0). A cube has six
// maps in one texture, three in a row, without borders: sample (0, 0) is texel (0, 0).
// Keys come from bits, never from float arithmetic, so every device and the CPU have the same keys
// (docs/numerics/depth-maps.md, "Exact decisions").

// In the stages that write a map, fields other than `size`, `blocks`, `is_reversed` and `faces` are 0.
struct DepthMapShape {
  // Texels of one map: width and height, without the border of the lattice.
  size: vec2<u32>,
  // The number of cells of all maps. (The buffer `cells` of importers is a list.) A cell is the square between four samples.
  cells: u32,
  // Blocks of 64 strips of cells (cell_words.wgsl); in the stages that write a map, blocks of 256 texels.
  blocks: u32,
  // How many cells, or with contours walls and flaps, the list has room for.
  capacity: u32,
  // The rule of `is_marked` (edge_code.wgsl). Where `depth_edges` or contours mark edges by their own rules, it counts only
  // if the list overflowed. 1: every edge but those between two far samples is marked. 0: edges with one far sample, or a
  // difference above the threshold, are. Rust sets 1 for `EveryCell`, and for all methods with `depth_edges`.
  every_cell: u32,
  // Bits of the threshold of `is_marked` as a float. The threshold is a difference of device depths.
  threshold: u32,
  // 1: the near plane has depth 1 and the far end 0.
  is_reversed: u32,
  // The number of maps: 1, or 6 for the faces of a cube, which are no faces of a mesh.
  faces: u32,
  // 1: edges between different objects are marked.
  has_objects: u32,
  // 1: triangles with a sample that is not far at the end of a marked edge are drawn, too (`depth_edges` has RINGS instead),
  // and slopes are those of the steeper side (surface.wgsl). Rust sets it if the boundary has several bits of the stencil,
  // which a cube has not.
  spread: u32,
  // 0.
  unused: u32,
}

@group(0) @binding(0) var<uniform> depth_map: DepthMapShape;
@group(0) @binding(1) var depth_texture: texture_2d<f32>;

// The key of a sample where nothing casts, larger than all others.
const FAR_KEY: u32 = 0x7fffffffu;
// The bits of 1.0.
const ONE: u32 = 0x3f800000u;

// The key of a depth, from its bits. Depths below 2^-126 count as 0 and those above 1 as 1. Comparisons are of integers,
// because a device may flush subnormals and may assume that there is no NaN.
fn sample_key(bits: u32) -> u32 {
  let magnitude = bits & 0x7fffffffu;
  let is_zero = ((bits >> 31u) == 1u) | (magnitude < 0x00800000u);
  let clamped = select(min(magnitude, ONE), 0u, is_zero);
  let is_reversed = depth_map.is_reversed != 0u;
  let is_far = clamped == select(ONE, 0u, is_reversed);
  return select(select(clamped, ONE - clamped, is_reversed), FAR_KEY, is_far | (magnitude > 0x7f800000u));
}

// The bits of a depth from its key. For FAR_KEY they have no meaning, and callers drop them.
fn depth_bits(key: u32) -> u32 {
  return select(key, ONE - key, depth_map.is_reversed != 0u);
}

// The bits of a depth from its key. FAR_KEY gives the depth of the far end.
fn depth_bits_or_far(key: u32) -> u32 {
  return select(depth_bits(key), select(ONE, 0u, depth_map.is_reversed != 0u), key == FAR_KEY);
}

// The key of a sample. Outside of a single map it is FAR_KEY. Outside of a map of a cube the result has no meaning. Callers
// drop it, or are reached only with `spread`, so never for a cube. Samples of the border load a texel too, so that there is
// one load without a branch.
fn load_key(sample: vec2<u32>) -> u32 {
  let is_cube = depth_map.faces > 1u;
  let inside = clamp(sample, vec2<u32>(1u), depth_map.size);
  let texel = select(inside - 1u, sample, is_cube);
  let key = sample_key(bitcast<u32>(textureLoad(depth_texture, vec2<i32>(texel), 0).x));
  return select(key, FAR_KEY, !is_cube && any(inside != sample));
}

// Returns `count`. Compilers cannot know that, because the value depends on a uniform, so they do not unroll a loop up to
// it. `count + depth_map.cells` must not overflow.
fn opaque(count: u32) -> u32 {
  return min(count, count + depth_map.cells);
}

// Six depth maps around a light: which samples of two or three maps lie on one ray. `depth_cube` gives such samples one
// depth, and surface.wgsl gives them one vertex, so the boundary of the shadow closes across maps.
// Maps 0 to 5 look along +x, -x, +y, -y, +z, -z. Centres of the outermost texels lie on the edges of the cube. Samples count
// from (0, 0) in their map. Directions are integers, so comparisons are exact.
// AXES in src/gpu/depth_map/meeting.rs, which cameras are made from, must have the same axes.

// The axes of a map: the direction of view, right and up.
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

fn integer_dot(a: vec3<i32>, b: vec3<i32>) -> i32 {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The direction from the light to a sample. The size of its largest component is the number of cells along a side of the map.
fn sample_direction(face: u32, sample: vec2<u32>) -> vec3<i32> {
  let axes = cube_face(face);
  let last = i32(depth_map.size.x) - 1;
  return last * axes.forward + (2 * i32(sample.x) - last) * axes.right + (last - 2 * i32(sample.y)) * axes.up;
}

// Whether a map has a sample in the direction of another map's sample.
fn has_direction(face: u32, direction: vec3<i32>) -> bool {
  return integer_dot(cube_face(face).forward, direction) == i32(depth_map.size.x) - 1;
}

// The sample that a map has in a direction for which `has_direction` holds.
fn sample_in_direction(face: u32, direction: vec3<i32>) -> vec2<u32> {
  let axes = cube_face(face);
  let last = i32(depth_map.size.x) - 1;
  return vec2<u32>(
    u32((last + integer_dot(direction, axes.right)) / 2), u32((last - integer_dot(direction, axes.up)) / 2));
}
