// Behind the models and above the horizon.

@vertex fn backdrop_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return cover(vertex);
}

@fragment fn backdrop_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return vec4<f32>(backdrop(at.xy), 1.0);
}
