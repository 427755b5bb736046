// From linear light to the picture: exposed, the brightest parts pressed together instead of cut off.

@vertex fn tone_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return cover(vertex);
}

fn pressed(light: vec3<f32>) -> vec3<f32> {
  let x = frame.exposure * light;
  const KNEE = 0.7;
  let over = max(x - KNEE, vec3<f32>(0.0)) / (1.0 - KNEE);
  return min(x, vec3<f32>(KNEE)) + (1.0 - KNEE) * over / (1.0 + over);
}

@fragment fn tone_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  // Half a step of noise, so that gradients show no bands.
  return vec4<f32>(pressed(scene_at(vec2<i32>(at.xy))) + (dither(at.xy) - 0.5) / 300.0, 1.0);
}
