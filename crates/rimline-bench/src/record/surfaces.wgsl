// Surfaces of one colour. Positions are taken relative to the camera's origin.

struct Frame {
  view_projection: mat4x4<f32>,
  eye: vec4<f32>,
}
// In a uniform it would do as well, but not with the volumes' draws on Mesa's software Vulkan.
@group(0) @binding(0) var<storage, read> frame: Frame;

@vertex fn surface(
  @location(0) position: vec3<f32>,
  @location(1) x: vec4<f32>,
  @location(2) y: vec4<f32>,
  @location(3) z: vec4<f32>,
) -> @invariant @builtin(position) vec4<f32> {
  let at = vec4(position, 1.0);
  let q = vec3(dot(x, at), dot(y, at), dot(z, at)) - frame.eye.xyz;
  // From q on the arithmetic of `rimline_clip` of the library's include, because z-fail needs equal depths. Volumes of moved
  // rigid casters round q otherwise (`CasterPositions::Rigid`).
  return frame.view_projection[0] * q.x + frame.view_projection[1] * q.y + frame.view_projection[2] * q.z +
    frame.view_projection[3];
}

@fragment fn nothing() {}

@fragment fn lit() -> @location(0) vec4<f32> {
  return vec4<f32>(0.15);
}
