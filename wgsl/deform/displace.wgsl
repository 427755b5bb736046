// The identity displacement, for `deform` if the caller has none. The variant DISPLACED of `deform` has the caller's
// function of this name and signature instead. `position`: the position in world space after morph targets and skin.
// `vertex`: the vertex's index in its source. `time`: in seconds. The result is the displaced position in world space.
fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return position;
}
