struct Camera {
  view_projection: mat4x4<f32>,
  origin: vec4<f32>,
}
// In a uniform it would do as well, but not with the volumes' draws on Mesa's software Vulkan.
@group(0) @binding(0) var<storage, read> camera: Camera;

@vertex fn surface(
  @location(0) position: vec3<f32>,
  @location(1) x: vec4<f32>,
  @location(2) y: vec4<f32>,
  @location(3) z: vec4<f32>,
) -> @builtin(position) vec4<f32> {
  let at = vec4(position, 1.0);
  let placed = vec3(dot(x, at), dot(y, at), dot(z, at)) - camera.origin.xyz;
  return camera.view_projection * vec4(placed, 1.0);
}
