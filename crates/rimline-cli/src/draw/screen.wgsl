// Passes of outline_picture.rs after frame.wgsl: the blur of the contact shadow, ambient occlusion, and darkening by it.

@group(1) @binding(0) var sharp: texture_2d<f32>;
@group(1) @binding(1) var linear: sampler;
// The step between samples, in pixels.
@group(1) @binding(2) var<uniform> pitch: vec2<f32>;

// One direction of a Gaussian blur.
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

@group(1) @binding(0) var seen: texture_2d<u32>;
@group(1) @binding(1) var occlusion: texture_2d<f32>;

fn depth_at(pixel: vec2<i32>) -> f32 {
  let inside = clamp(pixel, vec2<i32>(0), vec2<i32>(frame.size) - 1);
  return depth_of(textureLoad(seen, frame.survey_scale * inside, 0));
}

fn view_at(pixel: vec2<i32>) -> vec3<f32> {
  let distance = frame.near / max(depth_at(pixel), 1e-20);
  let ndc = (vec2<f32>(pixel) + 0.5) / frame.size * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
  return vec3<f32>(ndc / vec2<f32>(frame.scale_x, frame.scale_y) * shrinking(distance), distance);
}

// The difference with less depth: it does not leap over an edge.
fn flatter(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
  return select(b, a, abs(a.z) < abs(b.z));
}

// Ambient occlusion: creases and hollows get less light. After McGuire, Osman, Bukowski and Hennessy, "The Alchemy
// Screen-Space Ambient Obscurance Algorithm", HPG 2011.
@fragment fn occlusion_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  const SAMPLES = 20u;
  let pixel = vec2<i32>(at.xy);
  if (depth_at(pixel) == 0.0) {
    return vec4<f32>(1.0);
  }
  let here = view_at(pixel);
  let dx = flatter(view_at(pixel + vec2<i32>(1, 0)) - here, here - view_at(pixel - vec2<i32>(1, 0)));
  let dy = flatter(view_at(pixel + vec2<i32>(0, 1)) - here, here - view_at(pixel - vec2<i32>(0, 1)));
  // Towards the eye; view space here is left-handed, x to the right, y up, z away, and pixels count downwards.
  var normal = normalize(cross(dx, dy));
  let sight = select(here, vec3<f32>(0.0, 0.0, 1.0), vec3<bool>(is_parallel()));
  normal = select(normal, -normal, dot(normal, sight) > 0.0);
  let radius = 0.10 * frame.extent;
  let pixels = clamp(radius * frame.scale_y / shrinking(here.z) * 0.5 * frame.size.y, 3.0, 0.2 * frame.size.y);
  let turn = dither(at.xy) * 6.2831853;
  var sum = 0.0;
  for (var i = 0u; i < SAMPLES; i++) {
    let along = (f32(i) + 0.5) / f32(SAMPLES);
    let angle = turn + f32(i) * 2.3999632;
    let offset = along * pixels * vec2<f32>(cos(angle), sin(angle));
    let other = pixel + vec2<i32>(round(offset));
    if (depth_at(other) == 0.0) {
      continue;
    }
    let to = view_at(other) - here;
    let squared = dot(to, to);
    let falloff = max(0.0, 1.0 - squared / (radius * radius));
    sum += falloff * max(0.0, dot(to, normal) - 0.004 * radius - 0.0008 * here.z) / (sqrt(squared) + 1e-3 * radius);
  }
  return vec4<f32>(saturate(1.0 - 2.2 * sum / f32(SAMPLES)));
}

// Multiplies the occlusion into the picture, smoothed over neighbours on the same surface.
@fragment fn darken_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let pixel = vec2<i32>(at.xy);
  let here = depth_of(textureLoad(seen, frame.survey_scale * pixel, 0));
  if (here == 0.0) {
    return vec4<f32>(1.0);
  }
  let last = vec2<i32>(frame.size) - 1;
  var sum = 0.0;
  var weights = 0.0;
  for (var y = -3; y <= 3; y++) {
    for (var x = -3; x <= 3; x++) {
      let other = clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), last);
      let there = depth_of(textureLoad(seen, frame.survey_scale * other, 0));
      let weight = exp(-f32(x * x + y * y) / 8.0) * saturate(1.0 - abs(there / here - 1.0) * 60.0);
      sum += weight * textureLoad(occlusion, other, 0).r;
      weights += weight;
    }
  }
  let light = sum / max(weights, 1e-6);
  // Occluded parts are darker and a little bluer.
  return vec4<f32>(mix(vec3<f32>(0.26, 0.27, 0.32), vec3<f32>(1.0), light), 1.0);
}
