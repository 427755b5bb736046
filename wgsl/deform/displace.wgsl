// The identity displacement. `deform` compiles with it if the caller has none, and then never calls it. The variant
// DISPLACED of `deform` has the caller's function of this name and signature instead. `position`: the position in world
// space after morph targets and skin. `vertex`: the index of the source vertex, before welding. `time`: in seconds. The
// result is the displaced position in world space.
fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
  return position;
}
