// Multiplies the occlusion into the picture, smoothed over neighbours on the same surface.

@group(1) @binding(0) var seen: texture_2d<u32>;
@group(1) @binding(1) var occlusion: texture_2d<f32>;

@vertex fn darken_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return cover(vertex);
}

@fragment fn darken_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let pixel = vec2<i32>(at.xy);
  let here = depth_of(textureLoad(seen, frame.places * pixel, 0));
  if (here == 0.0) {
    return vec4<f32>(1.0);
  }
  let last = vec2<i32>(frame.size) - 1;
  var sum = 0.0;
  var weights = 0.0;
  for (var y = -3; y <= 3; y++) {
    for (var x = -3; x <= 3; x++) {
      let other = clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), last);
      let there = depth_of(textureLoad(seen, frame.places * other, 0));
      let weight = exp(-f32(x * x + y * y) / 8.0) * saturate(1.0 - abs(there / here - 1.0) * 60.0);
      sum += weight * textureLoad(occlusion, other, 0).r;
      weights += weight;
    }
  }
  let light = sum / max(weights, 1e-6);
  // Occluded clay is warmer: light that gets there has met more clay.
  return vec4<f32>(mix(vec3<f32>(0.26, 0.27, 0.32), vec3<f32>(1.0), light), 1.0);
}
