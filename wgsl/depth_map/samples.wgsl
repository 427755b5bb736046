// The samples of a depth map on a lattice that has one row and column more on each side, which are far. NUMERICS.md,
// "Volumes from depth maps".

struct DepthMapShape {
  // Texels across and down, of one map.
  size: vec2<u32>,
  // Cells between four samples of the lattice, and blocks of them.
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
  // Maps: 1, or the 6 of a cube, which lie three in a row and have no border.
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

// Works on bits, because a device may flush a subnormal and may assume that there is no NaN.
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

// Sample (1, 1) of the lattice is texel (0, 0). In a cube, sample (0, 0) is. A sample on the border of the lattice reads a texel
// beside it, and drops it: one place loads for all.
fn key_at(at: vec2<u32>) -> u32 {
  let is_cube = depth_map.faces > 1u;
  let inside = clamp(at, vec2<u32>(1u), depth_map.size);
  let texel = select(inside - 1u, at, is_cube);
  let key = sample_key(bitcast<u32>(textureLoad(depth_texture, vec2<i32>(texel), 0).x));
  return select(key, FAR_KEY, !is_cube && any(inside != at));
}

// Bounds of loops, which a compiler does not know, so that it leaves them as they are.
fn opaque(turns: u32) -> u32 {
  return min(turns, turns + depth_map.cells);
}
