@vertex
fn line(@builtin(vertex_index) end: u32, @builtin(instance_index) instance: u32) -> @builtin(position) vec4<f32> {
  let p = rimline_edge_vertex(0u, instance, end);
  // The same eye as the light's below, looking down the z axis with a field of view of 53 degrees.
  return vec4<f32>(2.0 * p.xy, 0.1 * p.w, 4.0 * p.w - p.z);
}

@fragment
fn ink() -> @location(0) vec4<f32> {
  return vec4<f32>(0.05, 0.08, 0.2, 1.0);
}
