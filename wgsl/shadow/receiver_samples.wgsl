// Receiver samples: the farthest receiver of each tile, of a texture with several samples for each pixel. All enter.

#import shadow/receiver_tiles

@group(0) @binding(1) var depth_texture: texture_depth_multisampled_2d;

fn samples() -> u32 {
  return textureNumSamples(depth_texture);
}

fn depth_at(pixel: vec2<u32>, sample: u32) -> f32 {
  return textureLoad(depth_texture, pixel, sample);
}

@compute @workgroup_size(64)
fn receiver_samples(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  take_tile(id.x + 64u * groups.x * id.y);
}
