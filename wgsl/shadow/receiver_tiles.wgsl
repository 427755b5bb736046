// The first level of the receivers: an invocation takes the pixels of a tile. The files that follow have the texture.
//
// Expects: `depth_at(pixel, sample)`, and `samples()`, their number.

#import shadow/receivers

@group(0) @binding(0) var<uniform> receiver_view: ReceiverView;
@group(0) @binding(2) var<storage, read_write> receivers: array<u32>;

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
