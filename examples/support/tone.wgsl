// Four linear pixels to one of the picture.

@group(0) @binding(0) var linear: texture_2d<f32>;

@vertex fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(vertex & 1u) * 4.0 - 1.0, f32(vertex >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn developed(pixel: vec2<i32>) -> vec3<f32> {
  let x = textureLoad(linear, pixel, 0).rgb;
  return pow(min(x, vec3<f32>(1.0)), vec3<f32>(1.0 / 2.2));
}

@fragment fn tone(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let p = 2 * vec2<i32>(at.xy);
  let sum = developed(p) + developed(p + vec2<i32>(1, 0)) + developed(p + vec2<i32>(0, 1)) + developed(p + vec2<i32>(1, 1));
  return vec4<f32>(0.25 * sum, 1.0);
}
