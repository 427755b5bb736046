// Near rectangles: may the near rectangle (the part of the eye's near plane that the picture shows) be in shadow of a depth
// map? All rays of the eye begin there, so a pass over the picture, the near cap, turns the stencil bit round where the
// rectangle itself is in shadow. Mostly it is in light: no cap is drawn. Two stages: `depth_near` for triangles of cells, and
// `depth_near_walls` for contours (borders of surfaces, with walls in place of triangles).
// One of the two is dispatched last in an encode, one workgroup. None where the CPU finds the rectangle in light. None, and a
// cap is always drawn, where it cannot tell which samples matter (src/gpu/depth_map/near.rs), for more than 65,536 samples, and
// with `skip_near_caps` off. The CPU fills `near`. Reads the depth texture in a box of samples. Writes the indirect draw of the
// cap, `depth_near_cap` (surface.wgsl), which `DepthMapFrame::draw` draws: 3 vertices, or 0 for light.
// A cap may be drawn for nothing, but never be left out where it turns a pixel round: bounds err on that side only.

#import depth_map/contour
#import depth_map/samples

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

// Stage `depth_near`. A triangle is nowhere nearer to the light than its nearest sample, and samples are only moved away from
// it. So if no sample is before the rectangle, the cap would drop every pixel: the picture is the same without it. Integers
// decide.

@compute @workgroup_size(INVOCATIONS)
fn depth_near(@builtin(local_invocation_index) local: u32) {
  var nearest = FAR_KEY;
  // Turns: NEAR_SAMPLES / INVOCATIONS.
  for (var number = local; number < near.size.x * near.size.y; number += INVOCATIONS) {
    nearest = min(nearest, load_key(sample_of_box(number)));
  }
  if (nearest <= near.key) {
    atomicStore(&found, 1u);
  }
  write_draw(local);
}

// Stage `depth_near_walls`. A surface goes on from its last sample to the contour and may come nearer to the light there. By
// how much, at most, is taken off each sample. If none is before the rectangle then, the cap would drop every pixel. Distances
// are integers (contour.wgsl).

// By how much a surface may come nearer within a texel of a sample along an axis, to either side: it goes on as between its
// last samples, so at most by as much as from the sample on the opposite side to this one.
fn nearing(at: vec2<i32>, own: i32, step: vec2<i32>) -> i32 {
  let before = load_distance(at - step);
  let after = load_distance(at + step);
  return max(0, max(select(before - own, 0, before == FAR), select(after - own, 0, after == FAR)));
}

@compute @workgroup_size(INVOCATIONS)
fn depth_near_walls(@builtin(local_invocation_index) local: u32) {
  var nearest = FAR;
  // Turns: NEAR_SAMPLES / INVOCATIONS.
  for (var number = local; number < near.size.x * near.size.y; number += INVOCATIONS) {
    let at = vec2<i32>(sample_of_box(number));
    let own = load_distance(at);
    if (own != FAR) {
      nearest = min(nearest, own - nearing(at, own, vec2<i32>(1, 0)) - nearing(at, own, vec2<i32>(0, 1)));
    }
  }
  if (nearest <= near.distance) {
    atomicStore(&found, 1u);
  }
  write_draw(local);
}
