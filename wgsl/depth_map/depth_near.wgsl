// Depth near: whether a near rectangle may be in shadow. It is, only if a surface among the samples around it is nearer to the
// light. If none is, its cap is not drawn.

#import depth_map/near_box
#import depth_map/samples

// Triangles between samples: none is nearer than its nearest sample.
@compute @workgroup_size(INVOCATIONS)
fn depth_near(@builtin(local_invocation_index) local: u32) {
  var nearest = FAR_KEY;
  // Turns: NEAR_SAMPLES / INVOCATIONS.
  for (var number = local; number < near.size.x * near.size.y; number += INVOCATIONS) {
    nearest = min(nearest, key_at(sample_of_box(number)));
  }
  if (nearest <= near.key) {
    atomicStore(&found, 1u);
  }
  write_draw(local);
}
