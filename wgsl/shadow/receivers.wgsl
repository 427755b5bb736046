// Receivers of a view: the pixels on which shadows may fall, from the depth buffer that volumes are drawn against. A view
// has words in the buffer `receivers` of the importer: a head, then a pyramid of keys, each level row by row. A key is an
// integer that grows with the distance, for reversed and standard depth. The first level of the pyramid has the farthest
// receiver of each tile of 8 x 8 pixels. Each further level has that of four cells, up to one cell for all. The head has a
// box around all rays from the near rectangle to the receivers. The near rectangle is what the camera sees of the near
// plane.
// `receiver_depth` and `receiver_pyramid` write, `counting_methods` reads through shadow/culling.wgsl. Keys have exactly the
// order of depths. A depth computed from a key is never nearer than the receiver. docs/numerics/receivers.md, "Volumes
// without a receiver".

// The uniform of `receiver_depth` and `receiver_pyramid`, for one view. src/layout.rs has the same struct.
struct ReceiverView {
  inverse: array<vec4<f32>, 4>, // Columns of the matrix from normalised device coordinates to the camera frame.
  near_min: vec3<f32>, // Lowest corner of the box around the near rectangle, in the camera frame.
  near_z: f32, // Depth of the near plane: 1 with reversed depth, else 0. The depth buffer is cleared to 1 less it.
  near_max: vec3<f32>, // Highest corner of the box.
  sky_receives: u32, // 1: pixels at the cleared depth are receivers.
  pixels: vec2<u32>,
  offset: u32, // The offset of the view's words in `receivers`.
  reserved: u32,
}

// The number of words of the head. 0, 1: tiles across and down. 2, 3: pixels across and down. 4: key of the farthest
// receiver. 5: 1 if the box has an end, else 0. 6 to 8: lowest corner of the box. 9 to 11: highest corner. Both are 0 for a
// box without an end. The others are not used.
const RECEIVERS_HEAD: u32 = 16u;
// Pixels of a tile, across and down.
const TILE: u32 = 8u;

// The key of a depth, at least 1. 0 stands for no receiver. `near_z` is the depth of the near plane, which
// tells reversed depth (1) from standard depth (0).
fn receiver_key(depth: f32, near_z: f32) -> u32 {
  // Without a sign: a format of floats may hold -0, which `clamp` may leave as it is.
  let bits = bitcast<u32>(clamp(depth, 0.0, 1.0)) & 0x7fffffffu;
  return select(bits + 1u, 0x40000000u - bits, near_z != 0.0);
}

// A depth that is not nearer than any depth which a depth format may have stored for a key. Formats have at least 24 bits.
// The key must not be 0. The result may lie a little beyond the range from 0 to 1.
fn depth_of_key(key: u32, near_z: f32) -> f32 {
  if (near_z != 0.0) {
    let depth = bitcast<f32>(0x40000000u - key);
    return depth - (0x1p-22 * depth + 0x1p-23);
  }
  let depth = bitcast<f32>(key - 1u);
  return depth + (0x1p-22 * depth + 0x1p-23);
}
