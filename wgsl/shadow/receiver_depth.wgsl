// Receiver depth: a compute stage, for scenes, that finds the farthest receiver of each tile of 8 x 8 pixels in the depth buffer
// of a view. A receiver is a pixel that shadows may fall on: all that was drawn, and the sky if the caller says so. Dispatched
// once for each view whose depth the caller gives, an invocation a tile, before the stages of shadow volumes. It writes the first
// level of the view's receivers (shadow/receivers.wgsl); `receiver_pyramid`, the next stage, makes the others. The variant
// SAMPLES takes textures with several samples for each pixel, of which all enter: a receiver that is left out may lose its
// shadow.

#import shadow/receivers

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
