// The models, as matte clay, or in their base colours. A face's side towards a light is the bit that the extraction
// found for it; smooth normals only shade.

struct Clay {
  front: vec3<f32>,
  // Whether corners have colours, which replace the clay's on both sides.
  is_colored: u32,
  back: vec3<f32>,
}

@group(2) @binding(0) var<uniform> clay: Clay;
@group(2) @binding(1) var<storage, read> positions: array<u32>;
@group(2) @binding(2) var<storage, read> faces: array<u32>;
// A normal a corner, folded onto an octahedron.
@group(2) @binding(3) var<storage, read> normals: array<u32>;
// Where each face's masks are. With two flags. TURNED: the face is turned away from the eye, and shown as the one that it
// coincides with, which is not; `normals` and `colors` of its corners then are that one's. OPPOSITE, only with TURNED: the
// masks are its own, whose opposites are that one's; otherwise they are that one's, too.
@group(2) @binding(4) var<storage, read> slots: array<u32>;
@group(2) @binding(5) var<storage, read> facing: array<u32>;
// A base colour a corner, packed, if the model has colours; otherwise any words, of which the first is read and dropped.
@group(2) @binding(6) var<storage, read> colors: array<u32>;

const TURNED = 0x80000000u;
const OPPOSITE = 0x40000000u;

// White is as bright as the ground.
const BRIGHTNESS = 0.8;

struct Surface {
  @invariant @builtin(position) clip: vec4<f32>,
  @location(0) normal: vec3<f32>,
  // From the eye, in units.
  @location(1) q: vec3<f32>,
  // Whether the face that is shown faces the light.
  @location(2) @interpolate(flat) faces_light: u32,
  @location(3) @interpolate(flat) is_turned: u32,
  @location(4) color: vec3<f32>,
}

fn position(vertex: u32) -> vec3<f32> {
  return bitcast<vec3<f32>>(vec3<u32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]));
}

@vertex fn surface_vertex(@builtin(vertex_index) corner: u32) -> Surface {
  let face = corner / 3u;
  let a = position(faces[3u * face]);
  let b = position(faces[3u * face + 1u]);
  let c = position(faces[3u * face + 2u]);
  if (!is_finite(a) || !is_finite(b) || !is_finite(c)) {
    return Surface(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec3<f32>(0.0), vec3<f32>(0.0), 0u, 0u, vec3<f32>(0.0));
  }
  let p = position(faces[corner]);
  let slot = slots[face];
  let mask = facing[slot & ~(TURNED | OPPOSITE)] >> shaded.bit;
  let faces_light = (mask & 1u) ^ u32((slot & OPPOSITE) != 0u);
  let color = BRIGHTNESS * unpack_color(colors[select(0u, corner, clay.is_colored != 0u)]);
  let is_turned = u32((slot & TURNED) != 0u);
  return Surface(to_clip(p), unfold(normals[corner]), from_eye(p), faces_light, is_turned, color);
}

// Whether the front is seen of the face that is shown.
fn shows_front(in: Surface, front: bool) -> bool {
  return front != (in.is_turned != 0u);
}

// Towards the eye; interpolated normals may lean away from it at the rim.
fn shading_normal(in: Surface, front: bool, to_eye: vec3<f32>) -> vec3<f32> {
  let n = normalize(select(-in.normal, in.normal, front));
  return normalize(n + max(0.0, 0.02 - dot(n, to_eye)) * to_eye);
}

fn albedo(in: Surface, front: bool) -> vec3<f32> {
  return select(select(clay.back, clay.front, front), in.color, clay.is_colored != 0u);
}

@fragment fn ambient_fragment(in: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
  let front = shows_front(in, is_front);
  let to_eye = towards_eye(in.q);
  let n = shading_normal(in, front, to_eye);
  // More from above; and a little from the eye and its right, so that what is in shadow keeps its shape.
  let around = mix(0.5, 1.0, 0.5 + 0.5 * n.y) * mix(0.55, 1.05, saturate(dot(n, to_eye))) *
    (1.0 + 0.18 * dot(n, frame.right));
  return vec4<f32>(albedo(in, front) * frame.ambient * around, 1.0);
}

// Light and eye are on the same side of the face.
fn is_lit(in: Surface, front: bool) -> bool {
  return (in.faces_light != 0u) == front;
}

@fragment fn lit_fragment(in: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
  let front = shows_front(in, is_front);
  if (!is_lit(in, front)) {
    discard;
  }
  let to_eye = towards_eye(in.q);
  let n = shading_normal(in, front, to_eye);
  let light = arriving(in.q);
  // Flat faces turn from the light one at a time, smooth normals do not: the light fades before the first face turns.
  let cosine = saturate(dot(n, light.towards));
  let diffuse = cosine * smoothstep(0.0, 0.3, cosine);
  let halfway = normalize(to_eye + light.towards);
  let sheen = 0.06 * pow(saturate(dot(n, halfway)), 24.0) * smoothstep(0.0, 0.3, cosine);
  return vec4<f32>((albedo(in, front) * diffuse + sheen) * light.color, 0.0);
}

// Keeps the pixels whose visible side is back-facing to the light.
@fragment fn back_facing_fragment(in: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
  let front = shows_front(in, is_front);
  if (is_lit(in, front)) {
    discard;
  }
  return vec4<f32>(0.0);
}

@fragment fn black_fragment() -> @location(0) vec4<f32> {
  return vec4<f32>(vec3<f32>(0.0), 1.0);
}

// A factor for what is there.
@fragment fn dim_fragment() -> @location(0) vec4<f32> {
  return vec4<f32>(vec3<f32>(0.5), 1.0);
}

@fragment fn dark_fragment() -> @location(0) vec4<f32> {
  return vec4<f32>(0.0);
}

@fragment fn mask_fragment(in: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
  let front = shows_front(in, is_front);
  if (!is_lit(in, front) || !arriving(in.q).reached) {
    discard;
  }
  return vec4<f32>(1.0);
}

// Faces that cast: those that are back-facing to the light.
@fragment fn caps_fragment(in: Surface) -> @location(0) vec4<f32> {
  if (in.faces_light != 0u) {
    discard;
  }
  let brightest = max(max(shaded.color.r, shaded.color.g), max(shaded.color.b, 1e-6));
  return vec4<f32>(shaded.color / brightest * 0.55 / frame.exposure, 0.35);
}
