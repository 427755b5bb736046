// Shared by all stages of shadow volumes, and `needs`: structs that Rust writes (a test holds them equal to src/layout.rs), clip
// space, and the three forms of a vertex V of a volume: V itself, its far vertex at infinity or where the volume ends, and its
// projection from the light onto the near plane. A light L is homogeneous, (x, y, z, w); a light at infinity has w = 0. All
// arithmetic is written out, and must stay so, so that a vertex has the same bits wherever it is computed: in two draws, and in a
// caller's depth pass that takes `to_clip`. docs/numerics/shadow-volumes.md.

#import common/casters

struct ShadowStatistics {
  // Pairs of caster and light that are skipped: the light does not reach the caster, or the camera cannot see the shadow.
  skipped: atomic<u32>,
  every_face: atomic<u32>, // Pairs for which every face casts.
  capped: atomic<u32>, // Lights with a near cap.
  overflowed_caps: atomic<u32>, // Lights with a list of cap faces that overflowed.
  overflowed_sides: atomic<u32>, // Lights with a list of sides that overflowed.
  ended: atomic<u32>, // Pairs whose volume ends, at the light's range or behind all receivers.
  // An upper bound of all stencil counts, for any light, and the lights whose bound exceeds 8 bits. 0 unless asked for.
  count_bound: atomic<u32>,
  may_wrap: atomic<u32>,
  kept_lists: atomic<u32>, // Groups of casters, lights and views whose lists were kept.
  hidden: atomic<u32>, // Pairs that are skipped because no receiver can be in their volume.
  unreached: atomic<u32>, // Pairs that are skipped because the light does not reach the box.
  lost_pieces: atomic<u32>, // Pieces of L-twisted polygons that there was no room for. Where they would be, shadows are wrong.
}

// The caller's camera, as a caster sees it. The camera's frame has the world's axes and the camera's origin at 0.
struct ShadowView {
  view_projection: array<vec4<f32>, 4>, // Columns of the matrix from the camera's frame to clip space.
  // The near plane. Its product with (place, 1) is the height over the plane, positive in front of the camera.
  near_plane: vec4<f32>,
  placement: array<vec4<f32>, 3>, // Rows of the matrix from positions to the camera's frame.
  // Bounds of the near rectangle, in the camera's frame, and clip w of points on the near plane.
  near_min: vec3<f32>,
  near_w: f32,
  near_max: vec3<f32>,
  near_z: f32, // z / w of points on the near plane: 1 with reversed depth, else 0.
}

// A light, and what the GPU chose for it and a caster.
struct ShadowLight {
  light: vec4<f32>, // Homogeneous, in the space of the positions, scaled so that w is 0 or a power of two.
  // The same in clip space, and its height over the near plane.
  clip: vec4<f32>,
  height: f32,
  range: f32, // The range. Casters farther away are skipped. 0: no limit.
  // The faces that cast, and the counting method.
  casting: u32,
  counting: u32,
  // The near end of the light's frustum, for ZP+ as published. For a point light it is the distance of the near end
  // over that of the far end. For a light at infinity it is the height over the near plane.
  frustum_near: f32,
  // The end of the volume: the caster's distance over the range. Every far vertex, (position - light) / end from the
  // light, is then out of range, or behind all receivers. If the light is at infinity, a far vertex is the position plus 1 / end
  // times the direction away from the light. 0: far vertices are at infinity.
  end: f32,
  excludes: u32, // 1: faces of the caster may be excluded: those in whose plane the light is, and those that are not finite.
  scale: f32, // The light as given times this is the light as above.
  // Rows x, y and w of the matrix of that frustum. It maps (position - origin, 1).
  frustum_x: vec4<f32>,
  frustum_y: vec4<f32>,
  frustum_w: vec4<f32>,
}

// A light and a camera, with 512 bytes: bindings begin at multiples of 256.
struct SeenLight {
  view: ShadowView,
  light: ShadowLight,
  // The encode that was the first to have the camera as it is; the word where the view's receivers begin, 0 for none; zeros.
  version: vec4<u32>,
  cone: LightCone,
  reserved: array<vec4<u32>, 12>,
}

// Casters that are drawn together, and the caller's options.
struct ShadowShape {
  casters: u32,
  // Lights of all batches, and batches.
  lights: u32,
  batches: u32,
  // Slots of faces and of edges.
  faces: u32,
  edges: u32,
  // Entries that each list has room for: of silhouettes, of sides, of near caps and of other caps.
  capacity: u32,
  side_capacity: u32,
  near_capacity: u32,
  far_capacity: u32,
  averted: u32, // 1: averted faces may cast. The caller does not ask for every face.
  counting: u32, // One of the constants below.
  skip_unreached: u32, // 1: skip casters that the light's range does not reach.
  skip_unseen: u32, // 1: skip casters where the camera cannot see their shadow.
  end_at_range: u32, // 1: volumes end at the range of their light.
  // Where these begin in the table, in vec4s: choices and measures, lights of casters, casters of the chunks of face slots and
  // of edge slots.
  choices_at: u32,
  measures_at: u32,
  lights_at: u32,
  face_chunks_at: u32,
  edge_chunks_at: u32,
  views: u32,
  count_batches: u32, // Casters are counted in so many batches, one after the other.
  proxies: u32, // 1: some casters are not in the depth buffer.
  // The number of the group and batch, and the first caster of the group.
  part: u32,
  first_caster: u32,
  lists_at: u32, // The word of what is kept of the extraction where the encodes are that made its lists, one for each light.
  keeps: u32, // 1: lists for views are kept.
  needs_boxes: u32, // 1: boxes are needed for more than what is chosen.
  used_lights: u32, // Numbers up to that of the last light.
  has_receivers: u32, // 1: views may have receivers. Then volumes may end behind all of them.
  most_count: u32, // The largest count that the bits which count hold.
  piece_capacity: u32, // Pieces of L-twisted polygons that the list of each light has room for.
}

// The light, or the batch of lights, of a draw or dispatch.
struct ShadowDraw {
  light: u32,
  // The first light of its batch.
  first_light: u32,
  view: u32,
  count_batch: u32, // The batch of casters that is counted.
}

const CAST_NOTHING: u32 = 0u;
const CAST_AVERTED: u32 = 1u;
const CAST_EVERY: u32 = 2u;
const COUNT_Z_PASS: u32 = 0u;
const COUNT_ZP_PLUS: u32 = 1u;
const COUNT_Z_FAIL: u32 = 2u;
// z-pass where no face lies between light and near rectangle, else ZP+; decided for each caster and light.
const COUNT_AUTO: u32 = 3u;
const COUNT_ZP_PLUS_2005: u32 = 4u; // ZP+ as published.

// A corner of a box, by its number from 0 to 7.
fn box_corner(low: vec3<f32>, high: vec3<f32>, number: u32) -> vec3<f32> {
  return select(low, high, (vec3<u32>(number) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
}

// A direction, given in the space of the positions, in the camera's frame.
fn turned(view: ShadowView, d: vec3<f32>) -> vec3<f32> {
  return vec3<f32>(dot_3(view.placement[0].xyz, d), dot_3(view.placement[1].xyz, d), dot_3(view.placement[2].xyz, d));
}

// A position in the camera's frame. Where positions are in world space this is exactly the difference from the camera's
// origin, because products with 1 and 0 do not round.
fn placed(view: ShadowView, position: vec3<f32>) -> vec3<f32> {
  return turned(view, position) + vec3<f32>(view.placement[0].w, view.placement[1].w, view.placement[2].w);
}

// A position in clip space. A caller's depth pass gets the same bits if it computes positions in this way.
fn to_clip(view: ShadowView, position: vec3<f32>) -> vec4<f32> {
  let q = placed(view, position);
  return view.view_projection[0] * q.x + view.view_projection[1] * q.y + view.view_projection[2] * q.z +
    view.view_projection[3];
}

// The vector from the light to a position, times the light's w, in the camera's frame.
fn extrusion(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec3<f32> {
  return turned(view, light.light.w * position - light.light.xyz);
}

// A direction in clip space: a point at infinity.
fn direction_to_clip(view: ShadowView, direction: vec3<f32>) -> vec4<f32> {
  return view.view_projection[0] * direction.x + view.view_projection[1] * direction.y +
    view.view_projection[2] * direction.z;
}

// The far vertex of a position: at infinity, or where the volume ends.
fn far_end(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
  let far = direction_to_clip(view, extrusion(view, light, position));
  if (light.light.w == 0.0 && light.end > 0.0) {
    return far + light.end * to_clip(view, position);
  }
  return far + light.end * light.clip;
}

// Whether the camera is orthographic: clip w is the same everywhere.
fn is_orthographic(view: ShadowView) -> bool {
  return view.view_projection[0].w == 0.0 && view.view_projection[1].w == 0.0 && view.view_projection[2].w == 0.0;
}

// A vertex of a volume.
struct Corner {
  // The vertex in clip space, and its height over the near plane.
  near: vec4<f32>,
  height: f32,
  // The far vertex, and its height over the near plane.
  far: vec4<f32>,
  far_height: f32,
  // Whether the light is farther from the vertex than the camera's origin is. `project_to_near_plane` then computes
  // with V, else with V - L: with the shorter of both.
  is_far: bool,
}

// The largest of three absolute values.
fn size_3(a: vec3<f32>) -> f32 { return max(max(abs(a.x), abs(a.y)), abs(a.z)); }

// The height of a far vertex over the near plane is the light's w times the vertex's height, less the light's height. So it is
// not negative if the vertex is above the plane and the light below it, and negative if the vertex is below and the light is not.
// This keeps both true despite rounding: else a clipped shape might have more than five vertices.
fn consistent_rise(light: ShadowLight, height: f32, far_height: f32) -> f32 {
  let below = light.height < 0.0;
  return select(
    select(far_height, min(far_height, -1e-37), !below && height < 0.0), max(far_height, 0.0), below && height >= 0.0);
}

// A vertex of a volume, from its position.
fn corner(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> Corner {
  let d = extrusion(view, light, position);
  let q = placed(view, position);
  let height = dot_3(view.near_plane.xyz, q) + view.near_plane.w;
  return Corner(
    to_clip(view, position),
    height,
    direction_to_clip(view, d),
    consistent_rise(light, height, dot_3(view.near_plane.xyz, d)),
    size_3(d) > light.light.w * size_3(q),
  );
}

// The test is on the bits, because WGSL allows an implementation to assume that floats are finite.
fn is_finite(position: vec3<f32>) -> bool {
  let exponent = bitcast<vec3<u32>>(position) & vec3<u32>(0x7f800000u);
  return all(exponent != vec3<u32>(0x7f800000u));
}

// The light's side of the near plane: -1 in front of the plane, on the eye's side, else 1.
fn light_side(light: ShadowLight) -> f32 { return select(1.0, -1.0, light.height < 0.0); }

// The vertex, projected from the light onto the near plane.
fn project_to_near_plane(view: ShadowView, light: ShadowLight, v: Corner) -> vec4<f32> {
  let s = light_side(light);
  var xy = v.far.xy * light.height - light.clip.xy * v.far_height;
  var w = view.near_w * (light.light.w * v.far_height);
  if (v.is_far) {
    xy = v.near.xy * light.height - light.clip.xy * v.height;
    w = view.near_w * v.far_height;
  }
  return vec4<f32>(s * xy, -s * w * view.near_z, -s * w);
}

// The intersection of an edge with the near plane, on whose two sides its ends must be. `a` is the vertex of lower index.
fn on_near_plane(view: ShadowView, a: Corner, b: Corner) -> vec4<f32> {
  let t = a.height / (a.height - b.height);
  return vec4<f32>(a.near.xy + (b.near.xy - a.near.xy) * t, view.near_z * view.near_w, view.near_w);
}

// Corrects a depth that rounding may have put in front of the near plane.
fn behind_near_plane(view: ShadowView, clip: vec4<f32>) -> vec4<f32> {
  return vec4<f32>(clip.xy, select(max(clip.z, 0.0), min(clip.z, clip.w), view.near_z != 0.0), clip.w);
}

// The point of an edge whose far direction is parallel to the near plane. `a` is the vertex of lower index.
fn parallel_to_near_plane(a: Corner, b: Corner) -> vec4<f32> {
  let t = a.far_height / (a.far_height - b.far_height);
  return vec4<f32>(a.far.xy + (b.far.xy - a.far.xy) * t, 0.0, 0.0);
}
