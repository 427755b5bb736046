// The ground: four triangles from the point below the eye to the horizon, whose other corners lie at infinity.

struct GroundVertex {
  @invariant @builtin(position) clip: vec4<f32>,
  // Whether the light is above the ground. Fragment shaders branch on this: no shader may branch on uniforms alone
  // (scene.wgsl).
  @location(0) @interpolate(flat) is_lit: u32,
}

@vertex fn ground_vertex(@builtin(vertex_index) vertex: u32) -> GroundVertex {
  return GroundVertex(ground_corner(vertex), u32(is_lit()));
}

fn ground_corner(vertex: u32) -> vec4<f32> {
  let corner = vertex % 3u;
  if (corner == 0u) {
    let q = vec3<f32>(0.0, frame.ground, 0.0);
    return direction_to_clip(q) + frame.view_projection[3];
  }
  let turn = (vertex / 3u + corner) % 4u;
  let away = select(1.0, -1.0, turn >= 2u);
  return direction_to_clip(select(vec3<f32>(0.0, 0.0, away), vec3<f32>(away, 0.0, 0.0), (turn & 1u) == 0u));
}

struct GroundPoint {
  // Relative to the eye, in units.
  q: vec3<f32>,
  // How much of it the backdrop has taken: 1 also at the horizon and above it, where `q` has no meaning.
  faded: f32,
}

// How far from the centre the ground begins to fade, over how long it fades: it has faded at 3.3 times that distance.
const BEFORE_FADING = 1.0 / 2.3;

fn ground_point(pixel: vec2<f32>) -> GroundPoint {
  let at = pixel * frame.aside_step + frame.aside;
  let aside = at.x * frame.right + at.y * frame.up;
  let is_parallel = frame.is_parallel != 0u;
  // The rays of an orthographic camera begin aside and have one direction.
  let begin = select(vec3<f32>(0.0), aside * frame.per_unit, is_parallel);
  let ray = select(aside, vec3<f32>(0.0), vec3<bool>(is_parallel)) + frame.forward;
  let q = begin + ray * ((frame.ground - begin.y) / min(ray.y, -1e-6));
  if (ray.y > -1e-6) {
    return GroundPoint(q, 1.0);
  }
  let faded = saturate(length(q.xz - frame.centre) * frame.fade_slope - BEFORE_FADING);
  return GroundPoint(q, faded * faded * (3.0 - 2.0 * faded));
}

const ALBEDO = vec3<f32>(0.80, 0.79, 0.77);

fn is_lit() -> bool {
  return shaded.light.y - shaded.light.w * frame.ground > 0.0;
}

@fragment fn ambient_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return vec4<f32>(mix(ALBEDO * frame.ambient, backdrop(at.xy), ground_point(at.xy).faded), 1.0);
}

// Without a discard, devices leave out pixels in shadow before they shade them.
@fragment fn lit_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let point = ground_point(at.xy);
  let light = arriving(point.q);
  let cosine = select(0.0, max(0.0, light.towards.y), is_lit());
  return vec4<f32>((1.0 - point.faded) * ALBEDO * light.color * cosine, 0.0);
}

// Keeps all pixels if the light is not above the ground; its range and cone do not count.
@fragment fn back_facing_fragment(in: GroundVertex) -> @location(0) vec4<f32> {
  if (in.is_lit != 0u) {
    discard;
  }
  return vec4<f32>(0.0);
}

@fragment fn black_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return vec4<f32>(backdrop(at.xy) * ground_point(at.xy).faded, 1.0);
}

// A factor for what is there.
@fragment fn dim_fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  return vec4<f32>(vec3<f32>(mix(0.5, 1.0, ground_point(at.xy).faded)), 1.0);
}

@fragment fn dark_fragment() -> @location(0) vec4<f32> {
  return vec4<f32>(0.0);
}

@fragment fn mask_fragment(in: GroundVertex) -> @location(0) vec4<f32> {
  if (in.is_lit == 0u || !arriving(ground_point(in.clip.xy).q).reached) {
    discard;
  }
  return vec4<f32>(1.0);
}
