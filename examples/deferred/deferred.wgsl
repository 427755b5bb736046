// A deferred renderer: the number of the face that each pixel sees, then light from it, its depth, and the shadow masks.

struct Lamp {
  position: vec3<f32>,
  // Where it fades to nothing.
  range: f32,
  color: vec3<f32>,
  reserved: f32,
}

struct Frame {
  // From positions less the eye to clip space, and back.
  to_clip: mat4x4<f32>,
  from_clip: mat4x4<f32>,
  eye: vec3<f32>,
  reserved: f32,
  // Eight, and the middle of the area light.
  lamps: array<Lamp, 9>,
}

// A corner of a face, in world space.
struct Corner {
  position: vec3<f32>,
  unused: f32,
  albedo: vec3<f32>,
  reserved: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> corners: array<Corner>;

struct Seen {
  @builtin(position) clip: vec4<f32>,
  // The face and one. 0 is the sky.
  @location(0) @interpolate(flat) face: u32,
}

@vertex fn surface(@builtin(vertex_index) at: u32) -> Seen {
  return Seen(frame.to_clip * vec4<f32>(corners[at].position - frame.eye, 1.0), at / 3u + 1u);
}

@fragment fn face_number(in: Seen) -> @location(0) u32 {
  return in.face;
}

@group(1) @binding(0) var faces: texture_2d<u32>;
@group(1) @binding(1) var depth: texture_2d<f32>;
// A bit for each of eight lamps, and for each of 32 points of the area light: 1 in shadow.
@group(1) @binding(2) var lamp_masks: texture_2d<u32>;
@group(1) @binding(3) var area_masks: texture_2d<u32>;

@vertex fn whole(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn light_of(lamp: Lamp, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
  let towards = lamp.position - position;
  let falloff = max(0.0, 1.0 - dot(towards, towards) / (lamp.range * lamp.range));
  return lamp.color * max(0.0, dot(normal, normalize(towards))) * falloff * falloff;
}

fn lit(pixel: vec2<i32>) -> vec3<f32> {
  let face = textureLoad(faces, pixel, 0).x;
  if (face == 0u) {
    return vec3<f32>(0.02, 0.02, 0.03);
  }
  let ndc = 2.0 * (vec2<f32>(pixel) + 0.5) / vec2<f32>(textureDimensions(faces)) - 1.0;
  let from_eye = frame.from_clip * vec4<f32>(ndc.x, -ndc.y, textureLoad(depth, pixel, 0).x, 1.0);
  let position = from_eye.xyz / from_eye.w + frame.eye;
  let corner = corners[3u * face - 3u];
  let across = cross(corners[3u * face - 2u].position - corner.position, corners[3u * face - 1u].position - corner.position);
  let normal = normalize(across);
  // The share of the area light that is not in shadow, of 32.
  let share = f32(32u - countOneBits(textureLoad(area_masks, pixel, 0).x)) / 32.0;
  var light = vec3<f32>(0.05, 0.05, 0.06) + share * light_of(frame.lamps[8], position, normal);
  let dark = textureLoad(lamp_masks, pixel, 0).x;
  for (var lamp = 0u; lamp < 8u; lamp++) {
    if ((dark >> lamp & 1u) == 0u) {
      light += light_of(frame.lamps[lamp], position, normal);
    }
  }
  return corner.albedo * light;
}

// Four pixels to one of the picture.
@fragment fn light(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  var sum = vec3<f32>();
  for (var part = 0; part < 4; part++) {
    let linear = lit(2 * vec2<i32>(at.xy) + vec2<i32>(part & 1, part >> 1u));
    sum += pow(min(linear, vec3<f32>(1.0)), vec3<f32>(1.0 / 2.2));
  }
  return vec4<f32>(0.25 * sum, 1.0);
}
