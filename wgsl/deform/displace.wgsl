// Replaces the caller's displacement if there is none.
fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return position;
}
