// The contact shadow: how near the model comes to the ground, seen from below, blurred, and laid on the ground.

@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;

struct Below {
  @builtin(position) clip: vec4<f32>,
  @location(0) height: f32,
}

@vertex fn below_vertex(@builtin(vertex_index) corner: u32) -> Below {
  let first = 3u * faces[corner];
  let position = vec3<f32>(positions[first], positions[first + 1u], positions[first + 2u]);
  let at = (position.xz - frame.ground_centre) / frame.ground_half;
  return Below(vec4<f32>(at, 0.5, 1.0), (position.y - frame.ground) / frame.shadow_height);
}

@fragment fn below_fragment(in: Below) -> @location(0) vec4<f32> {
  let nearness = saturate(1.0 - in.height);
  return vec4<f32>(nearness * nearness);
}
