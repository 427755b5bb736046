// Makes each pixel of the picture from 2 × 2 linear ones: the mean of their colours after gamma. All linear pixels are in
// layer 0, or each block of 4 × 4 has one in each of 16 layers. `pixel_of_part` in stage.rs has the inverse.

@group(0) @binding(0) var linear: texture_2d_array<f32>;

@vertex fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(vertex & 1u) * 4.0 - 1.0, f32(vertex >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn load(pixel: vec2<i32>) -> vec3<f32> {
  if (textureNumLayers(linear) < 16u) {
    return textureLoad(linear, pixel, 0, 0).rgb;
  }
  let within = pixel & vec2<i32>(1);
  let tile = (pixel >> vec2<u32>(1u)) & vec2<i32>(1);
  let layer = within.x + 2 * within.y + 4 * (tile.x + 2 * tile.y);
  return textureLoad(linear, pixel >> vec2<u32>(2u), layer, 0).rgb;
}

fn developed(pixel: vec2<i32>) -> vec3<f32> {
  let x = load(pixel);
  return pow(min(x, vec3<f32>(1.0)), vec3<f32>(1.0 / 2.2));
}

@fragment fn tone(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let p = 2 * vec2<i32>(at.xy);
  let sum = developed(p) + developed(p + vec2<i32>(1, 0)) + developed(p + vec2<i32>(0, 1)) + developed(p + vec2<i32>(1, 1));
  return vec4<f32>(0.25 * sum, 1.0);
}
