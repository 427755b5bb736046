// Stage `depth_merge`: for each texel the nearer of two depths, of two maps that one camera of a light made. Dispatched by
// `DepthMapMerge::encode`, before the encode that reads the result as `depth_texture`. One invocation a texel.
// Reads both maps, of any depth format. Writes a texture of `r32float` with the depth of the smaller key (an integer that grows
// with the distance from the light): from 0 to 1, none subnormal or NaN, and the far end where nothing casts in either map.
// Integers decide, so the choice is exact. A texel of the result has the very key that it was made from.

#import depth_map/samples

@group(0) @binding(2) var second_texture: texture_2d<f32>;
@group(0) @binding(3) var merged_texture: texture_storage_2d<r32float, write>;

const BLOCK: u32 = 256u;

// A workgroup takes further blocks only where the device may not have a workgroup for each.
@compute @workgroup_size(BLOCK)
fn depth_merge(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  // Turns: 1.
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let texel = block * BLOCK + local;
    let at = vec2<u32>(texel % depth_map.size.x, texel / depth_map.size.x);
    if (at.y < depth_map.size.y) {
      let first = key_at(at + 1u);
      let second = sample_key(bitcast<u32>(textureLoad(second_texture, at, 0).x));
      textureStore(merged_texture, at, vec4<f32>(bitcast<f32>(bits_of_key(min(first, second))), 0.0, 0.0, 0.0));
    }
  }
}
