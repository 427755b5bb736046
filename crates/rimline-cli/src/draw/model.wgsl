// The model, and what is behind it and below it: survey, contact shadow, paper, clay.

@group(1) @binding(0) var<storage, read> positions: array<f32>;
// The drawn faces, whose positions are all finite.
@group(1) @binding(1) var<storage, read> faces: array<u32>;
// A normal a corner, folded onto an octahedron.
@group(1) @binding(2) var<storage, read> normals: array<u32>;
// A base colour a corner, packed, if the model has colours.
@group(1) @binding(3) var<storage, read> colors: array<u32>;

fn position_of(corner: u32) -> vec3<f32> {
  let first = 3u * faces[corner];
  return vec3<f32>(positions[first], positions[first + 1u], positions[first + 2u]);
}

// The survey, for hidden lines (lines.wgsl): the face at each texel, and near plane / distance, also of an orthographic
// camera. Not the depth buffer, since naga writes no loads of depth textures for OpenGL; in integers, since OpenGL need not
// draw onto floats; not multisampled, since Mesa's OpenGL then reads zeros.

struct Seen {
  @builtin(position) clip: vec4<f32>,
  @location(0) distance: f32,
  // The index of the face among those drawn, plus 1.
  @location(1) @interpolate(flat) face: u32,
}

@vertex fn survey_vertex(@builtin(vertex_index) corner: u32) -> Seen {
  let view = to_view(position_of(corner));
  return Seen(to_clip(view), view.z, corner / 3u + 1u);
}

// The face's index plus 1 and the bits of its depth, each in two halves, the lower one first.
@fragment fn survey_fragment(in: Seen) -> @location(0) vec4<u32> {
  let depth = bitcast<u32>(frame.near / max(in.distance, frame.near));
  return vec4<u32>(in.face, in.face >> 16u, depth, depth >> 16u) & vec4<u32>(0xffffu);
}

// The contact shadow: how near the model comes to the ground, seen from below, blurred, and laid on the ground.

struct Below {
  @builtin(position) clip: vec4<f32>,
  @location(0) height: f32,
}

@vertex fn below_vertex(@builtin(vertex_index) corner: u32) -> Below {
  let position = position_of(corner);
  let at = (position.xz - frame.ground_centre) / frame.ground_half;
  return Below(vec4<f32>(at, 0.5, 1.0), (position.y - frame.ground) / frame.shadow_height);
}

@fragment fn below_fragment(in: Below) -> @location(0) vec4<f32> {
  let nearness = saturate(1.0 - in.height);
  return vec4<f32>(nearness * nearness);
}

// The blurred contact shadow, on its square of ground.
@group(1) @binding(0) var shadow: texture_2d<f32>;
@group(1) @binding(1) var linear: sampler;

struct Ground {
  @builtin(position) clip: vec4<f32>,
  @location(0) at: vec2<f32>,
}

@vertex fn shadow_vertex(@builtin(vertex_index) vertex: u32) -> Ground {
  let at = vec2<f32>(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
  let xz = frame.ground_centre + at * frame.ground_half;
  return Ground(to_clip(to_view(vec3<f32>(xz.x, frame.ground, xz.y))), at);
}

@fragment fn shadow_fragment(in: Ground) -> @location(0) vec4<f32> {
  let at = vec2<f32>(in.at.x, -in.at.y) * 0.5 + 0.5;
  let darkness = 0.8 * textureSampleLevel(shadow, linear, at, 0.0).r;
  // Multiplied in: warm light that is missing leaves a slightly cool grey.
  return vec4<f32>(1.0 - darkness * vec3<f32>(1.0, 0.97, 0.92), 1.0);
}

// The paper behind the model: warm, a little lighter behind its middle.
@fragment fn backdrop_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let p = (at.xy - 0.5 * frame.size) / frame.size.y;
  let centre = vec2<f32>(0.0, -0.06);
  let glow = exp(-1.9 * dot(p - centre, p - centre));
  let colour = mix(vec3<f32>(0.72, 0.675, 0.61), vec3<f32>(0.915, 0.885, 0.84), glow);
  // About half an 8-bit step of noise, so that the gradient shows no bands.
  return vec4<f32>(colour + (dither(at.xy) - 0.5) / 200.0, 1.0);
}

// The model, almost matte, in a small studio: a warm key from the upper left, a cool fill from the right, a rim light
// from behind, all of which move with the eye.

struct Surface {
  @builtin(position) clip: vec4<f32>,
  @location(0) normal: vec3<f32>,
  @location(1) position: vec3<f32>,
  @location(2) color: vec3<f32>,
}

@vertex fn surface_vertex(@builtin(vertex_index) corner: u32) -> Surface {
  let position = position_of(corner);
  var color = vec3<f32>(0.0);
  if (frame.is_colored != 0u) {
    color = 0.75 * unpack_color(colors[corner]);
  }
  return Surface(to_clip(to_view(position)), unfold(normals[corner]), position, color);
}

fn direction(right: f32, up: f32, back: f32) -> vec3<f32> {
  return normalize(right * frame.right + up * frame.up - back * frame.forward);
}

@fragment fn surface_fragment(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
  let to_eye = -normalize(ray(in.position - frame.eye));
  var n = normalize(in.normal);
  if (!front) {
    n = -n;
  }
  // Interpolated normals may lean away from the eye at the rim.
  n = normalize(n + max(0.0, 0.02 - dot(n, to_eye)) * to_eye);

  let key_from = direction(-0.52, 0.68, 0.72);
  let key = saturate((dot(n, key_from) + 0.2) / 1.2);
  let fill = saturate((dot(n, direction(0.95, 0.1, 0.5)) + 0.35) / 1.35);
  let sky = 0.5 + 0.5 * n.y;
  let rim = pow(1.0 - saturate(dot(n, to_eye)), 3.0) * saturate(dot(n, direction(0.8, 0.5, -0.5)) + 0.15);

  // Grey-blue; the inside of an open surface is brown.
  var clay = select(vec3<f32>(0.62, 0.44, 0.33), vec3<f32>(0.36, 0.49, 0.56), front);
  if (frame.is_colored != 0u) {
    clay = in.color;
  }
  var light = mix(vec3<f32>(0.24, 0.22, 0.22), vec3<f32>(0.36, 0.38, 0.41), sky);
  light += 0.84 * pow(key, 1.3) * vec3<f32>(1.0, 0.94, 0.86);
  light += 0.22 * fill * vec3<f32>(0.90, 0.94, 1.0);
  let halfway = normalize(to_eye + key_from);
  let sheen = 0.045 * pow(saturate(dot(n, halfway)), 20.0);
  let colour = clay * light + 0.18 * rim * vec3<f32>(0.95, 0.95, 1.0) + sheen;
  return vec4<f32>(colour, 1.0);
}
