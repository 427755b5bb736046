// The paper behind the model: warm, a little lighter behind its middle.

@vertex fn backdrop_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return cover(vertex);
}

@fragment fn backdrop_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let p = (at.xy - 0.5 * frame.size) / frame.size.y;
  let centre = vec2<f32>(0.0, -0.06);
  let glow = exp(-1.9 * dot(p - centre, p - centre));
  let colour = mix(vec3<f32>(0.72, 0.675, 0.61), vec3<f32>(0.915, 0.885, 0.84), glow);
  // Half a step of noise, so that the gradient shows no bands.
  return vec4<f32>(colour + (dither(at.xy) - 0.5) / 200.0, 1.0);
}
