// The samples around a near rectangle, and the draw of its cap.

struct DepthNearBox {
  // The first sample, and samples across and down.
  first: vec2<u32>,
  size: vec2<u32>,
  // The key of what is behind all of the near rectangle, and its distance.
  key: u32,
  distance: i32,
  unused: vec2<u32>,
}

@group(0) @binding(2) var<uniform> near: DepthNearBox;
// The draw of the cap.
@group(0) @binding(3) var<storage, read_write> draws: array<u32>;

const INVOCATIONS: u32 = 256u;
// 1: a sample is before it. It begins with 0.
var<workgroup> found: atomic<u32>;

// The sample with a number.
fn sample_of_box(number: u32) -> vec2<u32> {
  return near.first + vec2<u32>(number % near.size.x, number / near.size.x);
}

fn write_draw(local: u32) {
  workgroupBarrier();
  if (local == 0u) {
    draws[0] = 3u * atomicLoad(&found);
    draws[1] = 1u;
    draws[2] = 0u;
    draws[3] = 0u;
  }
}
