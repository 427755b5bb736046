// Stage `depth_near_walls`: `depth_near` for contours (borders of surfaces, with walls in place of triangles): may the near
// rectangle (the part of an eye's near plane in the picture) be in shadow? Dispatched for each eye, one workgroup, after
// `contour_walls`, and also where an earlier list is drawn.
// Reads the depth texture in a box (near_box.wgsl). Writes the indirect draw of the near cap: 3 vertices, or 0 for light.
// A surface goes on from its last sample to the contour and may come nearer to the light there. By how much, at most, is taken
// off each sample. If none is before the rectangle then, the cap would drop every pixel. Distances are integers (contour.wgsl).

#import depth_map/contour
#import depth_map/near_box

// By how much a surface may come nearer within a texel of a sample along an axis, to either side: it goes on as between its last
// samples, so at most by as much as from the sample on the opposite side to this one.
fn nearing(at: vec2<i32>, own: i32, step: vec2<i32>) -> i32 {
  let before = distance_at(at - step);
  let after = distance_at(at + step);
  return max(0, max(select(before - own, 0, before == FAR), select(after - own, 0, after == FAR)));
}

@compute @workgroup_size(INVOCATIONS)
fn depth_near_walls(@builtin(local_invocation_index) local: u32) {
  var nearest = FAR;
  // Turns: NEAR_SAMPLES / INVOCATIONS.
  for (var number = local; number < near.size.x * near.size.y; number += INVOCATIONS) {
    let at = vec2<i32>(sample_of_box(number));
    let own = distance_at(at);
    if (own != FAR) {
      nearest = min(nearest, own - nearing(at, own, vec2<i32>(1, 0)) - nearing(at, own, vec2<i32>(0, 1)));
    }
  }
  if (nearest <= near.distance) {
    atomicStore(&found, 1u);
  }
  write_draw(local);
}
