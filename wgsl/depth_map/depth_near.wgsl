// Stage `depth_near`: may the near rectangle (the part of an eye's near plane in the picture) be in shadow? Dispatched for each
// eye, one workgroup, after the stages that list cells, and also where an earlier list is drawn. Not dispatched where the CPU
// knows the answer, nor for more than 65,536 samples, nor with contours (`depth_near_walls`).
// Reads the depth texture in a box (near_box.wgsl). Writes the indirect draw of `depth_near_cap`: 3 vertices, or 0 for light.
// A triangle is nowhere nearer to the light than its nearest sample, and samples are only moved away from it. So if no sample is
// before the rectangle, the cap would drop every pixel: the picture is the same without it. Integers decide.

#import depth_map/near_box
#import depth_map/samples

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
