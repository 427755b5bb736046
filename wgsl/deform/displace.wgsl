// Stands in for a caller's displacement where there is none.
fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return position;
}
