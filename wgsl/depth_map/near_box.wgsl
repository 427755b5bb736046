// The samples of a depth map around a near rectangle, and the draw of its near cap. Imported by `depth_near` and
// `depth_near_walls`.
// The near rectangle is the part of the eye's near plane that the picture shows. All rays of the eye begin there, so a pass over
// the picture, the near cap, turns the stencil bit round where the rectangle itself is in shadow. Mostly it is in light: no cap
// is drawn.
// The CPU fills `near` (src/gpu/depth_map/near.rs). An importer, one workgroup, looks at all samples of the box, sets `found` if
// one may be before the rectangle, and calls `write_draw`. `DepthMapFrame::draw` draws the cap by `draws`.
// A cap may be drawn for nothing, but never be left out where it turns a pixel round: bounds err on that side only.

struct DepthNearBox {
  // The first sample of the box, and samples across and down.
  first: vec2<u32>,
  size: vec2<u32>,
  // A surface with a larger key (samples.wgsl), or a larger distance (contour.wgsl), is behind all of the near rectangle.
  key: u32,
  distance: i32,
  unused: vec2<u32>,
}

@group(0) @binding(2) var<uniform> near: DepthNearBox;
// Indirect arguments of the cap: 3 vertices or 0, 1 instance, 0, 0.
@group(0) @binding(3) var<storage, read_write> draws: array<u32>;

const INVOCATIONS: u32 = 256u;
// 1: a surface may be before the rectangle. Zero at the start.
var<workgroup> found: atomic<u32>;

// The sample of the box with an index, row by row.
fn sample_of_box(number: u32) -> vec2<u32> {
  return near.first + vec2<u32>(number % near.size.x, number / near.size.x);
}

// All invocations of the only workgroup call it, after they set `found`.
fn write_draw(local: u32) {
  workgroupBarrier();
  if (local == 0u) {
    draws[0] = 3u * atomicLoad(&found);
    draws[1] = 1u;
    draws[2] = 0u;
    draws[3] = 0u;
  }
}
