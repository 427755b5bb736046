// Boundaries of shadows, drawn as tinted glass and lines.

struct Edge {
  @builtin(position) clip: vec4<f32>,
  @location(0) @interpolate(flat) opacity: f32,
}

fn tint() -> vec3<f32> {
  let brightest = max(max(shaded.color.r, shaded.color.g), max(shaded.color.b, 1e-6));
  return shaded.color / brightest;
}

@fragment fn volumes_fragment() -> @location(0) vec4<f32> {
  let volume_overlay = mix(vec3<f32>(0.9, 0.62, 0.18), tint(), 0.75) * vec3<f32>(0.8, 0.62, 0.36);
  return vec4<f32>(volume_overlay / frame.exposure, 0.14 * shaded.density);
}

@fragment fn edges_fragment(in: Edge) -> @location(0) vec4<f32> {
  return vec4<f32>(vec3<f32>(0.35, 0.14, 0.02) * tint() / frame.exposure, in.opacity * shaded.density);
}
