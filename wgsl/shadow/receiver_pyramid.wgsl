// Stages `receiver_depth` and `receiver_pyramid`: compute the receivers of a view from its depth buffer
// (shadow/receivers.wgsl). A receiver is a pixel on which shadows may fall: each pixel that was drawn, and the sky if the
// caller says so.
// Dispatched once for each view with a depth buffer, before the stages of shadow volumes. `receiver_depth` has an
// invocation a tile of 8 x 8 pixels. `receiver_pyramid` follows it with one workgroup.
// Reads: the depth texture. Writes: the words of the view in `receivers`.
// `counting_methods` culls volumes without a receiver. So no depth may be too near, and the box must not be too small.
// docs/numerics/receivers.md, "Volumes without a receiver".

#import common/order_keys
#import shadow/receivers

// Stage `receiver_depth`: finds the farthest receiver of each tile, for the first level of the pyramid. The variant SAMPLES
// is for multisampled textures. It takes all samples of a pixel, since a receiver that is left out may lose its shadow.

@group(0) @binding(0) var<uniform> receiver_view: ReceiverView;
@group(0) @binding(2) var<storage, read_write> receivers: array<u32>;

// Depth is read as floats, because naga writes no loads of depth textures for OpenGL.
#if SAMPLES
@group(0) @binding(1) var depth_texture: texture_multisampled_2d<f32>;

fn sample_count() -> u32 { return textureNumSamples(depth_texture); }
fn load_depth(pixel: vec2<u32>, sample: u32) -> f32 { return textureLoad(depth_texture, pixel, sample).x; }
#else
@group(0) @binding(1) var depth_texture: texture_2d<f32>;

fn sample_count() -> u32 { return 1u; }
fn load_depth(pixel: vec2<u32>, sample: u32) -> f32 { return textureLoad(depth_texture, pixel, 0).x; }
#endif

// The key of the farthest receiver in a tile. 0: there is none.
fn farthest_key(tile: vec2<u32>) -> u32 {
  let first = TILE * tile;
  let end = min(first + TILE, receiver_view.pixels);
  let cleared_depth = 1.0 - receiver_view.near_z;
  var key = 0u;
  // Turns: TILE.
  for (var y = first.y; y < end.y; y++) {
    // Turns: TILE.
    for (var x = first.x; x < end.x; x++) {
      // Turns: 64.
      for (var sample = 0u; sample < sample_count(); sample++) {
        let depth = load_depth(vec2<u32>(x, y), sample);
        if (depth != cleared_depth || receiver_view.sky_receives != 0u) {
          key = max(key, receiver_key(depth, receiver_view.near_z));
        }
      }
    }
  }
  return key;
}

// An invocation takes several tiles only where the device does not allow one for each.
@compute @workgroup_size(64)
fn receiver_depth(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let tiles = (receiver_view.pixels + TILE - 1u) / TILE;
  let row = 64u * groups.x;
  // Turns: 1.
  for (var index = id.x + row * id.y; index < tiles.x * tiles.y; index += row * groups.y) {
    receivers[receiver_view.offset + RECEIVERS_HEAD + index] = farthest_key(vec2<u32>(index % tiles.x, index / tiles.x));
  }
}

// Stage `receiver_pyramid`: writes the further levels, and the head with the box around all rays from the near rectangle to
// the receivers. The near rectangle is what the camera sees of the near plane. The box has slack above its rounding errors.

// The box is computed from the first level with at most this many cells.
const MOST_BOXED: u32 = 1024u;
// The slack of the product of matrix and vector, relative to the sum of the absolute terms. It is above the rounding errors.
const UNPROJECTION_SLACK: f32 = 1e-5;
// Keys of the lowest corner of the box, inverted, then of the highest. Keys are integers with the order of floats.
var<workgroup> box_keys: array<atomic<u32>, 6>;
var<workgroup> is_endless: atomic<u32>; // Whether the box has no end.

// Extends the box by another box.
fn extend_box(low: vec3<f32>, high: vec3<f32>) {
  let lowest = ~order_keys(bitcast<vec3<u32>>(low));
  let highest = order_keys(bitcast<vec3<u32>>(high));
  for (var axis = 0u; axis < 3u; axis++) {
    atomicMax(&box_keys[axis], lowest[axis]);
    atomicMax(&box_keys[3u + axis], highest[axis]);
  }
}

// Extends the box by a position in normalised device coordinates.
fn extend_box_by_position(x: f32, y: f32, depth: f32) {
  let m = receiver_view.inverse;
  let position = m[0] * x + m[1] * y + m[2] * depth + m[3];
  let error = UNPROJECTION_SLACK * (abs(m[0] * x) + abs(m[1] * y) + abs(m[2] * depth) + abs(m[3]));
  let lowest_w = position.w - error.w;
  if (!(lowest_w > 0.0)) {
    atomicStore(&is_endless, 1u);
    return;
  }
  let highest_w = position.w + error.w;
  let low = position.xyz - error.xyz;
  let high = position.xyz + error.xyz;
  let lowest = min(low / lowest_w, low / highest_w);
  let highest = max(high / lowest_w, high / highest_w);
  extend_box(lowest - UNPROJECTION_SLACK * abs(lowest), highest + UNPROJECTION_SLACK * abs(highest));
}

// Extends the box by the corners of what is seen through a cell of the pyramid and one pixel around it, at the depth of its
// farthest receiver. Nearer receivers lie between these and the near rectangle, which the box must contain, too. A cell has
// `size` pixels, across and down.
fn extend_box_by_cell(cell: vec2<u32>, size: u32, key: u32) {
  if (key == 0u) {
    return;
  }
  let pixels = vec2<f32>(receiver_view.pixels);
  let begin = (vec2<f32>(cell * size) - 1.0) / pixels * 2.0 - 1.0;
  let end = (vec2<f32>((cell + 1u) * size) + 1.0) / pixels * 2.0 - 1.0;
  let depth = depth_of_key(key, receiver_view.near_z);
  for (var corner = 0u; corner < 4u; corner++) {
    extend_box_by_position(
      select(begin.x, end.x, (corner & 1u) != 0u), -select(begin.y, end.y, (corner & 2u) != 0u), depth);
  }
}

// A level of the pyramid.
struct PyramidLevel {
  cells: vec2<u32>,
  // The pixels of a cell, across and down.
  size: u32,
  // The offset of its keys in `receivers`. Those of the next level follow them.
  offset: u32,
}

fn cell_count(level: PyramidLevel) -> u32 {
  return level.cells.x * level.cells.y;
}

// The level with cells twice as wide and high.
fn next_level(level: PyramidLevel) -> PyramidLevel {
  return PyramidLevel((level.cells + 1u) / 2u, level.size * 2u, level.offset + cell_count(level));
}

fn key_of_cell(level: PyramidLevel, cell: vec2<u32>) -> u32 {
  return receivers[level.offset + cell.y * level.cells.x + cell.x];
}

// The thread's part of extending the box by all cells of a level. It has at most MOST_BOXED.
fn extend_box_by_level(level: PyramidLevel, thread: u32) {
  let count = cell_count(level);
  // Turns: MOST_BOXED / 256 in all.
  for (var cell = thread; cell < count; cell += 256u) {
    extend_box_by_cell(vec2<u32>(cell % level.cells.x, cell / level.cells.x), level.size, receivers[level.offset + cell]);
  }
}

// The thread's part of writing a level from the one before.
fn write_level(level: PyramidLevel, previous: PyramidLevel, thread: u32) {
  let count = cell_count(level);
  // Turns: RECEIVER_CELLS in all.
  for (var cell = thread; cell < count; cell += 256u) {
    let begin = 2u * vec2<u32>(cell % level.cells.x, cell / level.cells.x);
    let end = min(begin + 1u, previous.cells - 1u);
    let upper = max(key_of_cell(previous, begin), key_of_cell(previous, vec2<u32>(end.x, begin.y)));
    let lower = max(key_of_cell(previous, vec2<u32>(begin.x, end.y)), key_of_cell(previous, end));
    receivers[level.offset + cell] = max(upper, lower);
  }
}

// Writes the head: the sizes of the first level and of the view, the farthest key, and the box.
fn write_head(tiles: vec2<u32>, farthest_key_offset: u32, thread: u32) {
  let head = receiver_view.offset;
  if (thread == 0u) {
    receivers[head] = tiles.x;
    receivers[head + 1u] = tiles.y;
    receivers[head + 2u] = receiver_view.pixels.x;
    receivers[head + 3u] = receiver_view.pixels.y;
    receivers[head + 4u] = receivers[farthest_key_offset];
    receivers[head + 5u] = select(1u, 0u, atomicLoad(&is_endless) != 0u);
  }
  if (thread < 3u) {
    // x: the lowest coordinate along the axis. y: the highest.
    let ends = floats_of_keys(vec3<u32>(~atomicLoad(&box_keys[thread]), atomicLoad(&box_keys[3u + thread]), 0u));
    let is_finite_box = atomicLoad(&is_endless) == 0u;
    receivers[head + 6u + thread] = select(0u, bitcast<u32>(ends.x), is_finite_box);
    receivers[head + 9u + thread] = select(0u, bitcast<u32>(ends.y), is_finite_box);
  }
}

@compute @workgroup_size(256)
fn receiver_pyramid(@builtin(local_invocation_index) thread: u32) {
  let tiles = (receiver_view.pixels + TILE - 1u) / TILE;
  if (thread < 6u) {
    atomicStore(&box_keys[thread], 0u);
  }
  if (thread == 6u) {
    atomicStore(&is_endless, 0u);
  }
  workgroupBarrier();
  if (thread == 0u) {
    extend_box(receiver_view.near_min, receiver_view.near_max);
  }
  // The level that was written last.
  var level = PyramidLevel(tiles, TILE, receiver_view.offset + RECEIVERS_HEAD);
  var is_boxed = false;
  // Turns: RECEIVER_LEVELS.
  while (true) {
    let count = cell_count(level);
    if (!is_boxed && count <= MOST_BOXED) {
      is_boxed = true;
      extend_box_by_level(level, thread);
    }
    if (count <= 1u) {
      break;
    }
    let next = next_level(level);
    write_level(next, level, thread);
    level = next;
    storageBarrier();
    workgroupBarrier();
  }
  workgroupBarrier();
  write_head(tiles, level.offset, thread);
}
