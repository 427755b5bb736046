// Receivers of a view, by its depth buffer: two compute stages, for scenes, dispatched once for each view whose depth the
// caller gives, before the stages of shadow volumes. `receiver_depth`, an invocation a tile of 8 x 8 pixels, and right after
// it `receiver_pyramid`, one workgroup. A receiver is a pixel that shadows may fall on: all that was drawn, and the sky if the
// caller says so. They write the view's receivers (shadow/receivers.wgsl). `choose` reads these, to leave out volumes that no
// receiver can be in, so nothing that is written may be too near or too small. docs/numerics/receivers.md, "Volumes without a
// receiver".

#import common/casters
#import shadow/receivers

// Stage `receiver_depth`: finds the farthest receiver of each tile, the first level. The variant SAMPLES takes textures with
// several samples for each pixel, of which all enter: a receiver that is left out may lose its shadow.

@group(0) @binding(0) var<uniform> receiver_view: ReceiverView;
@group(0) @binding(2) var<storage, read_write> receivers: array<u32>;

#if SAMPLES
@group(0) @binding(1) var depth_texture: texture_depth_multisampled_2d;

fn samples() -> u32 { return textureNumSamples(depth_texture); }
fn depth_at(pixel: vec2<u32>, sample: u32) -> f32 { return textureLoad(depth_texture, pixel, sample); }
#else
@group(0) @binding(1) var depth_texture: texture_depth_2d;

fn samples() -> u32 { return 1u; }
fn depth_at(pixel: vec2<u32>, sample: u32) -> f32 { return textureLoad(depth_texture, pixel, 0); }
#endif

fn farthest_in(tile: vec2<u32>) -> u32 {
  let first = TILE * tile;
  let end = min(first + TILE, receiver_view.pixels);
  let sky = 1.0 - receiver_view.near_z;
  var key = 0u;
  // Turns: TILE.
  for (var y = first.y; y < end.y; y++) {
    // Turns: TILE.
    for (var x = first.x; x < end.x; x++) {
      // Turns: 64.
      for (var sample = 0u; sample < samples(); sample++) {
        let depth = depth_at(vec2<u32>(x, y), sample);
        if (depth != sky || receiver_view.sky_receives != 0u) {
          key = max(key, far_key(depth, receiver_view.near_z));
        }
      }
    }
  }
  return key;
}

fn take_tile(number: u32) {
  let tiles = (receiver_view.pixels + TILE - 1u) / TILE;
  if (number < tiles.x * tiles.y) {
    receivers[receiver_view.at + RECEIVERS_HEAD + number] = farthest_in(vec2<u32>(number % tiles.x, number / tiles.x));
  }
}

@compute @workgroup_size(64)
fn receiver_depth(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  take_tile(id.x + 64u * groups.x * id.y);
}

// Stage `receiver_pyramid`: writes the upper levels, the farthest receiver of each square of four cells, up to one for all;
// and the box of all places between the near rectangle (what the camera sees of the near plane) and the receivers, with slack
// above its rounding errors.

// The box is taken from the first level that has at most so many cells.
const MOST_BOXED: u32 = 1024u;
const UNPROJECTION: f32 = 1e-5; // Above the rounding error of a product of matrix and vector, relative to its terms.
// Ends of the box as ordered bits, inverted where they are lowest.
var<workgroup> ends: array<atomic<u32>, 6>;
var<workgroup> is_endless: atomic<u32>;

fn widen(low: vec3<f32>, high: vec3<f32>) {
  let lowest = ~ordered(bitcast<vec3<u32>>(low));
  let highest = ordered(bitcast<vec3<u32>>(high));
  for (var axis = 0u; axis < 3u; axis++) {
    atomicMax(&ends[axis], lowest[axis]);
    atomicMax(&ends[3u + axis], highest[axis]);
  }
}

// Takes a place on a ray from the eye, in normalised device coordinates, into the box.
fn take_place(x: f32, y: f32, depth: f32) {
  let m = receiver_view.inverse;
  let place = m[0] * x + m[1] * y + m[2] * depth + m[3];
  let error = UNPROJECTION * (abs(m[0] * x) + abs(m[1] * y) + abs(m[2] * depth) + abs(m[3]));
  let least = place.w - error.w;
  if (!(least > 0.0)) {
    atomicStore(&is_endless, 1u);
    return;
  }
  let most = place.w + error.w;
  let low = place.xyz - error.xyz;
  let high = place.xyz + error.xyz;
  let lowest = min(low / least, low / most);
  let highest = max(high / least, high / most);
  widen(lowest - UNPROJECTION * abs(lowest), highest + UNPROJECTION * abs(highest));
}

// Takes what is seen through a cell of `size` pixels, and a pixel around.
fn take_cell(cell: vec2<u32>, size: u32, key: u32) {
  if (key == 0u) {
    return;
  }
  let pixels = vec2<f32>(receiver_view.pixels);
  let begin = (vec2<f32>(cell * size) - 1.0) / pixels * 2.0 - 1.0;
  let end = (vec2<f32>((cell + 1u) * size) + 1.0) / pixels * 2.0 - 1.0;
  let depth = depth_of_key(key, receiver_view.near_z);
  for (var corner = 0u; corner < 4u; corner++) {
    take_place(select(begin.x, end.x, (corner & 1u) != 0u), -select(begin.y, end.y, (corner & 2u) != 0u), depth);
  }
}

@compute @workgroup_size(256)
fn receiver_pyramid(@builtin(local_invocation_index) thread: u32) {
  let head = receiver_view.at;
  let tiles = (receiver_view.pixels + TILE - 1u) / TILE;
  if (thread < 6u) {
    atomicStore(&ends[thread], 0u);
  }
  if (thread == 6u) {
    atomicStore(&is_endless, 0u);
  }
  workgroupBarrier();
  if (thread == 0u) {
    widen(receiver_view.near_min, receiver_view.near_max);
  }
  var cells = tiles;
  var size = TILE;
  var first = head + RECEIVERS_HEAD;
  var is_boxed = false;
  // Turns: RECEIVER_LEVELS.
  while (true) {
    let count = cells.x * cells.y;
    if (!is_boxed && count <= MOST_BOXED) {
      is_boxed = true;
      // Turns: MOST_BOXED / 256 in all.
      for (var cell = thread; cell < count; cell += 256u) {
        take_cell(vec2<u32>(cell % cells.x, cell / cells.x), size, receivers[first + cell]);
      }
    }
    if (count <= 1u) {
      break;
    }
    let next = (cells + 1u) / 2u;
    // Turns: RECEIVER_CELLS in all.
    for (var cell = thread; cell < next.x * next.y; cell += 256u) {
      let begin = 2u * vec2<u32>(cell % next.x, cell / next.x);
      let end = min(begin + 1u, cells - 1u);
      let upper = max(receivers[first + begin.y * cells.x + begin.x], receivers[first + begin.y * cells.x + end.x]);
      let lower = max(receivers[first + end.y * cells.x + begin.x], receivers[first + end.y * cells.x + end.x]);
      receivers[first + count + cell] = max(upper, lower);
    }
    first += count;
    cells = next;
    size *= 2u;
    storageBarrier();
    workgroupBarrier();
  }
  workgroupBarrier();
  if (thread == 0u) {
    receivers[head] = tiles.x;
    receivers[head + 1u] = tiles.y;
    receivers[head + 2u] = receiver_view.pixels.x;
    receivers[head + 3u] = receiver_view.pixels.y;
    receivers[head + 4u] = receivers[first];
    receivers[head + 5u] = select(1u, 0u, atomicLoad(&is_endless) != 0u);
  }
  if (thread < 3u) {
    let found = unordered(vec3<u32>(~atomicLoad(&ends[thread]), atomicLoad(&ends[3u + thread]), 0u));
    let is_limited = atomicLoad(&is_endless) == 0u;
    receivers[head + 6u + thread] = select(0u, bitcast<u32>(found.x), is_limited);
    receivers[head + 9u + thread] = select(0u, bitcast<u32>(found.y), is_limited);
  }
}
