// Stages `depth_near` and `depth_near_walls`: whether the near rectangle may be in shadow of a depth map, so that the near
// cap has to be drawn. The near rectangle is the part of the eye's near plane in the picture, where all rays of the eye
// begin. The near cap inverts the stencil bit where the rectangle is in shadow. Usually all of it is in light.
// `depth_near` is for triangles of cells, `depth_near_walls` for contours, also if their list overflows. One of the two is
// the last dispatch of an encode: one workgroup. The CPU leaves it out in two cases (`near_cap` in
// src/gpu/depth_map/recording.rs). If near.rs finds the rectangle in light, no cap is drawn. If it finds no box of up to
// 65,536 samples that decide, or the option `skip_near_caps` is off, the cap is drawn.
// Reads `near`, which the CPU fills, and the depths of the samples in its box; with contours those of their neighbours, too.
// Writes the indirect draw of `depth_near_cap`: 3 vertices, or 0 for light. Bounds err on one side only: a cap may be drawn
// for nothing, but one that would invert a bit is never missing (docs/numerics/depth-maps.md, "Near caps"). The cap of
// contours itself may be wrong near a rim (docs/numerics/contours.md, "Heights").
// Nearer, before and behind are as the light sees it.

#import depth_map/contour
#import depth_map/samples

struct DepthNearBox {
  // A box with all samples whose surfaces may be before the near rectangle: its first sample on the lattice; its columns
  // and rows. Surfaces of other samples there may be behind it.
  first: vec2<u32>,
  size: vec2<u32>,
  // A surface with a larger key (samples.wgsl, for `depth_near`) or a larger distance (contour.wgsl, for
  // `depth_near_walls`) is behind all of the near rectangle.
  key: u32,
  distance: i32,
  unused: vec2<u32>,
}

@group(0) @binding(2) var<uniform> near: DepthNearBox;
// Indirect arguments of the cap: 3 vertices or 0, 1 instance, 0, 0.
@group(0) @binding(3) var<storage, read_write> draws: array<u32>;

const INVOCATIONS: u32 = 256u;
// 1: a surface may be between the light and the rectangle. 0 at the start.
var<workgroup> may_be_dark: atomic<u32>;

// The sample of the box at an index, row by row.
fn sample_of_box(index: u32) -> vec2<u32> {
  return near.first + vec2<u32>(index % near.size.x, index / near.size.x);
}

// All invocations call it, because it has a barrier. Invocations that find a surface set `may_be_dark` before.
fn write_draw(lane: u32) {
  workgroupBarrier();
  if (lane == 0u) {
    draws[0] = 3u * atomicLoad(&may_be_dark);
    draws[1] = 1u;
    draws[2] = 0u;
    draws[3] = 0u;
  }
}

// Stage `depth_near`. A triangle is nowhere nearer to the light than its nearest sample, and the bias only moves samples
// away from it. So if no sample is before the rectangle, the cap would discard every fragment. Integers decide.

@compute @workgroup_size(INVOCATIONS)
fn depth_near(@builtin(local_invocation_index) lane: u32) {
  var nearest = FAR_KEY;
  // Turns: NEAR_SAMPLES / INVOCATIONS.
  for (var index = lane; index < near.size.x * near.size.y; index += INVOCATIONS) {
    nearest = min(nearest, load_key(sample_of_box(index)));
  }
  if (nearest <= near.key) {
    atomicStore(&may_be_dark, 1u);
  }
  write_draw(lane);
}

// Stage `depth_near_walls`. A surface goes on from its last sample to the contour, and may come nearer to the light there.
// An upper bound of that is subtracted from the distance of each sample. Distances are integers.

// An upper bound of how much nearer to the light than a sample its surface comes within a texel, along an axis: the larger
// difference from the samples beside it. Towards one of the same surface it is interpolated. Beyond the last one it comes
// nearer by at most its last difference (`extrapolated_rise` in contour_rim.wgsl).
fn approach_bound(sample: vec2<i32>, distance: i32, step: vec2<i32>) -> i32 {
  let before = load_distance(sample - step);
  let after = load_distance(sample + step);
  return max(select(abs(before - distance), 0, before == FAR), select(abs(after - distance), 0, after == FAR));
}

@compute @workgroup_size(INVOCATIONS)
fn depth_near_walls(@builtin(local_invocation_index) lane: u32) {
  var nearest = FAR;
  // Turns: NEAR_SAMPLES / INVOCATIONS.
  for (var index = lane; index < near.size.x * near.size.y; index += INVOCATIONS) {
    let sample = vec2<i32>(sample_of_box(index));
    let distance = load_distance(sample);
    if (distance != FAR) {
      nearest = min(
        nearest,
        distance - approach_bound(sample, distance, vec2<i32>(1, 0)) - approach_bound(sample, distance, vec2<i32>(0, 1)));
    }
  }
  if (nearest <= near.distance) {
    atomicStore(&may_be_dark, 1u);
  }
  write_draw(lane);
}
