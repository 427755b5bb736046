// The blurred contact shadow on its square of ground.

@group(1) @binding(0) var shadow: texture_2d<f32>;
@group(1) @binding(1) var linear: sampler;

struct Ground {
  @builtin(position) clip: vec4<f32>,
  @location(0) at: vec2<f32>,
}

@vertex fn shadow_vertex(@builtin(vertex_index) vertex: u32) -> Ground {
  let at = vec2<f32>(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
  let xz = frame.ground_centre + at * frame.ground_half;
  return Ground(to_clip(to_view(vec3<f32>(xz.x, frame.ground, xz.y))), at);
}

@fragment fn shadow_fragment(in: Ground) -> @location(0) vec4<f32> {
  let at = vec2<f32>(in.at.x, -in.at.y) * 0.5 + 0.5;
  let darkness = 0.8 * textureSampleLevel(shadow, linear, at, 0.0).r;
  // Multiplied in: warm light that is missing leaves a slightly cool grey.
  return vec4<f32>(1.0 - darkness * vec3<f32>(1.0, 0.97, 0.92), 1.0);
}
