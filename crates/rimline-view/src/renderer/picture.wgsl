// The backdrop behind the models, and the picture that the light becomes.

@fragment fn backdrop_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return vec4<f32>(backdrop(at.xy), 1.0);
}

@group(1) @binding(0) var light: texture_2d<f32>;

// Exposed, the brightest parts pressed together instead of cut off.
fn pressed(light: vec3<f32>) -> vec3<f32> {
  let x = frame.exposure * light;
  const KNEE = 0.7;
  let over = max(x - KNEE, vec3<f32>(0.0)) / (1.0 - KNEE);
  return min(x, vec3<f32>(KNEE)) + (1.0 - KNEE) * over / (1.0 + over);
}

// sRGB's curve, since the target is not decoded by those who show it. With half a step of noise, so that gradients show no
// bands.
@fragment fn tone_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let x = pressed(textureLoad(light, vec2<i32>(at.xy), 0).rgb);
  let curved = select(1.055 * pow(x, vec3<f32>(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3<f32>(0.0031308));
  return vec4<f32>(curved + (dither(at.xy) - 0.5) / 255.0, 1.0);
}
