// One direction of a Gaussian blur.

@group(1) @binding(0) var sharp: texture_2d<f32>;
@group(1) @binding(1) var linear: sampler;
// From a sample to the next, in pixels.
@group(1) @binding(2) var<uniform> pitch: vec2<f32>;

@vertex fn blur_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return cover(vertex);
}

@fragment fn blur_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let size = vec2<f32>(textureDimensions(sharp));
  var sum = 0.0;
  var weights = 0.0;
  for (var i = -12; i <= 12; i++) {
    let offset = f32(i) / 6.0;
    let weight = exp(-0.5 * offset * offset);
    sum += weight * textureSampleLevel(sharp, linear, (at.xy + f32(i) * pitch) / size, 0.0).r;
    weights += weight;
  }
  return vec4<f32>(sum / weights);
}
