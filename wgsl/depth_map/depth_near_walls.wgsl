// Depth near walls: as depth near, for surfaces that go on beyond their samples, up to contours.

#import depth_map/contour
#import depth_map/near_box

// By how much a surface may come nearer within a texel of a sample along a step: as much as it does from the sample on the other
// side.
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
