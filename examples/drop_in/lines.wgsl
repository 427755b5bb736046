@vertex
fn line(@builtin(vertex_index) end: u32, @builtin(instance_index) instance: u32) -> @builtin(position) vec4<f32> {
  let silhouette = rimline_silhouette(0u, instance);
  if (!silhouette.valid) {
    return vec4<f32>(0.0, 0.0, 2.0, 1.0);
  }
  let p = rimline_position(select(silhouette.a, silhouette.b, end == 1u));
  // The same eye as the light's below, looking down the z axis with a field of view of 53 degrees.
  return vec4<f32>(2.0 * p.xy, 0.1, 4.0 - p.z);
}

@fragment
fn ink() -> @location(0) vec4<f32> {
  return vec4<f32>(0.05, 0.08, 0.2, 1.0);
}
