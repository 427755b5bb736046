// Receivers: what the shadows of a view may fall on, from the depth buffer that they are drawn against. They are kept as a
// pyramid: for each tile of 8 x 8 pixels the farthest depth of a receiver, then for each square of four the farthest of those, up
// to one for all; and as a box of all places between the near rectangle (what the camera sees of the near plane) and the
// receivers. Depths are kept as keys, integers that grow with the distance, whichever way the depth buffer runs. `receiver_depth`
// and `receiver_pyramid` write them, and `choose` reads them, through shadow/visibility.wgsl. Keys keep their order exactly; a
// depth made of one again is never nearer than it was. docs/numerics/receivers.md, "Volumes without a receiver".

struct ReceiverView {
  inverse: array<vec4<f32>, 4>, // Columns of the matrix from normalised device coordinates to the camera's frame.
  near_min: vec3<f32>, // The box of the near rectangle, in the camera's frame.
  // Depth of the near plane. The other end of 0 to 1 is the depth that is cleared to.
  near_z: f32,
  near_max: vec3<f32>,
  // 1: pixels at the cleared depth are receivers.
  sky_receives: u32,
  pixels: vec2<u32>,
  // The word where the view's receivers begin.
  at: u32,
  reserved: u32,
}

// Words before the levels: 0 and 1 tiles across and down, 2 and 3 pixels across and down, 4 the key of the farthest receiver, 5
// whether the box is finite, from 6 on its lowest corner, from 9 on its highest; four are unused.
const RECEIVERS_HEAD: u32 = 16u;
// Pixels of a tile, across and down.
const TILE: u32 = 8u;

// The key of a depth: it grows with the distance, from 1 on. 0 is no receiver. `near_z`: depth of the near plane, 1 if reversed.
fn far_key(depth: f32, near_z: f32) -> u32 {
  let bits = bitcast<u32>(clamp(depth, 0.0, 1.0));
  return select(bits + 1u, 0x40000000u - bits, near_z != 0.0);
}

// A depth that is not nearer than that of a key, which must not be 0, however it was stored: formats have 24 bits at least.
fn depth_of_key(key: u32, near_z: f32) -> f32 {
  if (near_z != 0.0) {
    let depth = bitcast<f32>(0x40000000u - key);
    return depth - (0x1p-22 * depth + 0x1p-23);
  }
  let depth = bitcast<f32>(key - 1u);
  return depth + (0x1p-22 * depth + 0x1p-23);
}
