// The backdrop behind the models, and the picture that the light becomes.

// Behind the models and above the horizon.
@fragment fn backdrop_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return vec4<f32>(backdrop(at.xy), 1.0);
}

// The picture's light as one texture, or in 16 parts: four of each pixel, for four pixels in turn.
@group(1) @binding(0) var whole: texture_2d<f32>;
@group(1) @binding(0) var parts: texture_2d_array<f32>;

fn pressed(light: vec3<f32>) -> vec3<f32> {
  let x = frame.exposure * light;
  const KNEE = 0.7;
  let over = max(x - KNEE, vec3<f32>(0.0)) / (1.0 - KNEE);
  return min(x, vec3<f32>(KNEE)) + (1.0 - KNEE) * over / (1.0 + over);
}

// From linear light to the picture: exposed, the brightest parts pressed together instead of cut off. With noise, so that
// gradients show no bands. The target encodes it with sRGB's curve.
fn toned(light: vec3<f32>, at: vec2<f32>) -> vec4<f32> {
  return vec4<f32>(pressed(light) + (dither(at) - 0.5) / 300.0, 1.0);
}

@fragment fn tone_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return toned(textureLoad(whole, vec2<i32>(at.xy), 0).rgb, at.xy);
}

// The same for a target without sRGB's curve, which is applied here. The noise is up to half a step of the target.
@fragment fn tone_encoded_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let x = pressed(textureLoad(whole, vec2<i32>(at.xy), 0).rgb);
  let curved = select(1.055 * pow(x, vec3<f32>(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3<f32>(0.0031308));
  return vec4<f32>(curved + (dither(at.xy) - 0.5) / 255.0, 1.0);
}

@fragment fn tone_parts_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let pixel = vec2<i32>(at.xy);
  let first = 4 * ((pixel.x & 1) + 2 * (pixel.y & 1));
  var sum = vec3<f32>(0.0);
  // Turns: 4.
  for (var part = first; part < first + 4; part++) {
    sum += textureLoad(parts, pixel >> vec2<u32>(1u), part, 0).rgb;
  }
  return toned(0.25 * sum, at.xy);
}
