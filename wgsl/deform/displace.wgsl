// Stands in for the caller's displacement where there is none, for the stage `deform`: leaves positions as they are. The
// variant DISPLACED of that stage has the caller's function instead, of this name and with these arguments: the position in
// world space after morph targets and skin, the vertex's index in its source, and the time in seconds. It returns the
// displaced position in world space.
fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return position;
}
