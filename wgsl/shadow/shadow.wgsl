// Structs and vertex arithmetic that the stages of shadow volumes share. `needs` and outline/scene_edges.wgsl import this
// file, too. Rust has the same structs in src/layout.rs, but for `Corner`, and a test compares them.
// A light is homogeneous, (x, y, z, w). A light at infinity has w = 0. A vertex V of a volume has three forms: V itself,
// its far vertex, and V projected from the light onto the near plane. The far vertex is on the ray from the light through
// V, at infinity or where the volume ends.
// Each form must have the same bits in every draw, and V itself also in a caller's depth pass that computes positions as
// `to_clip` does. So all arithmetic is written out, and no expression may be rearranged. docs/numerics/shadow-volumes.md.

#import common/casters

// Counts of the stages, for one frame. A pair is a caster and a light, in one view.
struct ShadowStatistics {
  // Pairs whose light is relevant to the caster, but whose volume is culled, or whose caster has no finite face.
  skipped: atomic<u32>,
  every_face: atomic<u32>, // Pairs for which every face casts.
  // Lists of a light, a group of casters and a view, as in the next two and `cached_lists`, that have near caps of faces.
  near_capped: atomic<u32>,
  overflowed_caps: atomic<u32>, // Lists whose cap faces overflowed, near caps or others.
  overflowed_sides: atomic<u32>, // Lists whose sides overflowed.
  ended: atomic<u32>, // Pairs whose volume ends, at the range of the light or behind all receivers.
  // An upper bound of the stencil counts of any count batch, light and view. 0 unless the caller asks for it; so is the next.
  count_bound: atomic<u32>,
  may_wrap: atomic<u32>, // Pairs of light and view whose bound exceeds `ShadowShape::largest_count`.
  cached_lists: atomic<u32>, // Lists that are cached.
  // Skipped pairs culled by receivers: no receiver can lie in the volume. Cached pairs are not counted.
  culled_by_receivers: atomic<u32>,
  culled_by_range: atomic<u32>, // Skipped pairs culled by light range. Cached pairs are not counted.
  // Pieces of twisted polygons that the list has no room for, in each view in which the caster casts. Shadows are wrong there.
  lost_pieces: atomic<u32>,
  most_pieces: atomic<u32>, // The most pieces of such a caster for a light, including those without room.
}

// The caller's camera, as a caster sees it. The camera frame has the axes of the world and the camera's origin at 0.
struct ShadowView {
  view_projection: array<vec4<f32>, 4>, // Columns of the matrix from the camera frame to clip space.
  // The near plane. Its dot product with (position, 1) is the height over the plane, positive in front of the camera.
  near_plane: vec4<f32>,
  placement: array<vec4<f32>, 3>, // Rows of the matrix from the space of the caster's positions to the camera frame.
  // The box around the near rectangle, in the camera frame: lowest corner here, highest corner below. The near rectangle is
  // what the camera sees of the near plane.
  near_min: vec3<f32>,
  near_w: f32, // Clip w of points on the near plane.
  near_max: vec3<f32>,
  near_z: f32, // Depth of the near plane, z / w: 1 with reversed depth, else 0.
}

// A light as a caster and a view see it, and the choices of the GPU for all three (shadow/choices.wgsl).
struct ShadowLight {
  light: vec4<f32>, // Homogeneous, in the space of the caster's positions, scaled so that w is 0 or a power of two.
  clip: vec4<f32>, // The light in clip space.
  // The dot product of near plane and light: w times the height. At infinity it is the rise of the direction to the light.
  height: f32,
  range: f32, // The range of the light, in world space. 0: no limit.
  casting: u32, // The faces that cast: one of the constants CAST_….
  counting: u32, // The counting method: one of the constants COUNT_….
  // The near end of the light's frustum, for ZP+ as published. For a point light it is the distance of the near end from the
  // light over that of the far end. For a light at infinity it is the height over the near plane.
  frustum_near: f32,
  // Where the volume ends. 0: at infinity. The far vertex is then out of range, or behind all receivers.
  // * Point light: the far vertex is the light plus (position - light) / end.
  // * Light at infinity: it is the position plus 1 / end times the direction away from the light.
  end: f32,
  // 1: the caster may have excluded faces for this light. These are faces with the light in their plane, where it may be in the
  // caster's box, faces that are not finite, twisted polygons (shadow/draw_lists.wgsl), and faces that the caller excludes.
  excludes: u32,
  scale: f32, // The caster's light in the scene table, times `scale`, is `light` (`light_for_caster`).
  // Rows x, y and w of the matrix of the light's frustum, for ZP+ as published. It maps (position in the camera frame, 1).
  frustum_x: vec4<f32>,
  frustum_y: vec4<f32>,
  frustum_w: vec4<f32>,
}

// A light and a view. Its 512 bytes are a multiple of 256, at which bindings begin.
struct ViewLight {
  view: ShadowView,
  light: ShadowLight,
  // x: the version of the camera and its receivers, the number of the first encode that had both as they are. y: the offset
  // of the view's receivers, or 0 for none. z, w: 0. For `needs` x is 1 if the view has the light, and the others are 0.
  version: vec4<u32>,
  cone: LightCone, // Only for `needs`.
  reserved: array<vec4<u32>, 12>,
}

// A group of casters and a light batch, and the caller's options.
struct ShadowShape {
  casters: u32, // Casters of all groups.
  lights: u32, // Lights of all batches, 32 each, some of which may be unused.
  batches: u32, // Batches of up to 32 lights.
  faces: u32, // Face slots of the group.
  edges: u32, // Edge slots of the group.
  // Entries that four lists of one light have room for: silhouettes; sides; near caps; light and dark caps.
  capacity: u32,
  side_capacity: u32,
  near_capacity: u32,
  far_capacity: u32,
  allow_back_facing: u32, // 1: back-facing faces alone may cast. 0: the caller asks for every face.
  counting: u32, // One of the constants COUNT_….
  cull_by_range: u32, // 1: cull casters by light range.
  cull_by_view: u32, // 1: cull volumes by view.
  end_at_range: u32, // 1: volumes end at the range of their light, but for those that ZP+ counts.
  // Offsets in the table, in vec4s: choices and measures (shadow/choices.wgsl), lights of casters, casters of the chunks of
  // face slots and of edge slots.
  choices_offset: u32,
  measures_offset: u32,
  lights_offset: u32,
  face_chunks_offset: u32,
  edge_chunks_offset: u32,
  views: u32,
  count_batches: u32, // Casters are counted in this many count batches, one after the other.
  proxies: u32, // 1: some casters of the group are not in the depth buffer.
  group_and_batch: u32, // The index of group and light batch: group * batches + batch.
  first_caster: u32, // The first caster of the group.
  lists_offset: u32, // The offset in `cache` of the encodes that made the silhouette lists of the batch, one for each light.
  uses_cache: u32, // 1: lists of sides and caps of earlier encodes are used where they are not dirty.
  needs_boxes: u32, // 1: stages after `counting_methods` read boxes, too.
  used_lights: u32, // The index of the last light that is used, plus 1.
  has_receivers: u32, // 1: views may have receivers. Volumes may then end behind all of them.
  largest_count: u32, // The largest count that does not wrap around in the counting bits of the stencil.
  piece_capacity: u32, // Pieces of twisted polygons that the list of one light has room for.
}

// The light, view and count batch of a draw, or the light batch and view of a dispatch.
struct ShadowDraw {
  light: u32, // The light of a draw, by its index in the frame.
  first_light: u32, // The first light of the batch.
  view: u32,
  count_batch: u32, // The count batch that a draw counts.
}

const CAST_NOTHING: u32 = 0u;
const CAST_BACK_FACING: u32 = 1u; // Back-facing faces cast.
const CAST_EVERY: u32 = 2u; // Every face casts.
const COUNT_Z_PASS: u32 = 0u;
const COUNT_ZP_PLUS: u32 = 1u;
const COUNT_Z_FAIL: u32 = 2u;
// Chosen for each caster, light and view: z-pass if no face lies between light and near rectangle, else ZP+.
const COUNT_AUTO: u32 = 3u;
const COUNT_ZP_PLUS_2005: u32 = 4u; // ZP+ as published.

// The corner of a box with an index from 0 to 7.
fn box_corner(low: vec3<f32>, high: vec3<f32>, index: u32) -> vec3<f32> {
  return select(low, high, (vec3<u32>(index) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
}

// A direction in the space of the positions, in the camera frame.
fn direction_to_camera_frame(view: ShadowView, d: vec3<f32>) -> vec3<f32> {
  return vec3<f32>(dot_3(view.placement[0].xyz, d), dot_3(view.placement[1].xyz, d), dot_3(view.placement[2].xyz, d));
}

// A position in the camera frame. For positions in world space it has the bits of the position minus the camera's origin,
// because products with 1 and 0 do not round.
fn to_camera_frame(view: ShadowView, position: vec3<f32>) -> vec3<f32> {
  return direction_to_camera_frame(view, position) +
    vec3<f32>(view.placement[0].w, view.placement[1].w, view.placement[2].w);
}

// A position in clip space. A caller's depth pass has the same bits if it computes this expression.
fn to_clip(view: ShadowView, position: vec3<f32>) -> vec4<f32> {
  let q = to_camera_frame(view, position);
  return view.view_projection[0] * q.x + view.view_projection[1] * q.y + view.view_projection[2] * q.z +
    view.view_projection[3];
}

// The vector from the light to a position, times the light's w, in the camera frame.
fn extrusion(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec3<f32> {
  return direction_to_camera_frame(view, light.light.w * position - light.light.xyz);
}

// A direction in clip space: a point at infinity.
fn direction_to_clip(view: ShadowView, direction: vec3<f32>) -> vec4<f32> {
  return view.view_projection[0] * direction.x + view.view_projection[1] * direction.y +
    view.view_projection[2] * direction.z;
}

// The far vertex of a position: at infinity, or where the volume ends.
fn far_vertex(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
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

// A vertex V of a volume, with the values from which its three forms are computed. The far vertex here is at infinity.
struct Corner {
  near: vec4<f32>, // V in clip space.
  height: f32, // The height of V over the near plane.
  far: vec4<f32>, // The far vertex in clip space: a direction.
  far_height: f32, // The height of this direction over the near plane.
  // Whether the light is farther from V than the camera's origin is. `project_to_near_plane` computes with the shorter of
  // the two vectors: with V if this is set, else with V - L.
  is_light_farther: bool,
}

// The largest absolute component.
fn largest_component(a: vec3<f32>) -> f32 { return max(max(abs(a.x), abs(a.y)), abs(a.z)); }

// Makes the sign of the far vertex's height agree with the signs of the other heights, despite rounding. Without rounding,
// far height = w * height - light height. So with the light below the plane, a vertex above the plane has a far height of 0
// or more. With the light above or on the plane, a vertex below the plane has a negative one. A clipped polygon has at most
// five vertices only if both hold.
fn consistent_rise(light: ShadowLight, height: f32, far_height: f32) -> f32 {
  let is_light_below = light.height < 0.0;
  return select(
    select(far_height, min(far_height, -1e-37), !is_light_below && height < 0.0),
    max(far_height, 0.0),
    is_light_below && height >= 0.0);
}

// The vertex of a volume at a position.
fn corner(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> Corner {
  let d = extrusion(view, light, position);
  let q = to_camera_frame(view, position);
  let height = dot_3(view.near_plane.xyz, q) + view.near_plane.w;
  return Corner(
    to_clip(view, position),
    height,
    direction_to_clip(view, d),
    consistent_rise(light, height, dot_3(view.near_plane.xyz, d)),
    largest_component(d) > light.light.w * largest_component(q),
  );
}

// Whether all components are finite. It tests bits, because WGSL allows an implementation to assume that floats are finite.
fn is_finite(position: vec3<f32>) -> bool {
  let exponent = bitcast<vec3<u32>>(position) & vec3<u32>(0x7f800000u);
  return all(exponent != vec3<u32>(0x7f800000u));
}

// The light's side of the near plane: -1 on the eye's side, else 1.
fn light_side(light: ShadowLight) -> f32 { return select(1.0, -1.0, light.height < 0.0); }

// The vertex, projected from the light onto the near plane, in clip space. It has a meaning only if the vertex lies between
// both: its heights, near and far, have different signs.
fn project_to_near_plane(view: ShadowView, light: ShadowLight, v: Corner) -> vec4<f32> {
  let s = light_side(light);
  var xy = v.far.xy * light.height - light.clip.xy * v.far_height;
  var w = view.near_w * (light.light.w * v.far_height);
  if (v.is_light_farther) {
    xy = v.near.xy * light.height - light.clip.xy * v.height;
    w = view.near_w * v.far_height;
  }
  return vec4<f32>(s * xy, -s * w * view.near_z, -s * w);
}

// The intersection of an edge with the near plane, in clip space. It has a meaning only if the ends lie on different sides.
// `a` must have the lower vertex index, so that all draws have the same bits.
fn on_near_plane(view: ShadowView, a: Corner, b: Corner) -> vec4<f32> {
  let t = a.height / (a.height - b.height);
  return vec4<f32>(a.near.xy + (b.near.xy - a.near.xy) * t, view.near_z * view.near_w, view.near_w);
}

// A position in clip space that is not before the near plane: its depth is corrected if rounding moved it there.
fn behind_near_plane(view: ShadowView, clip: vec4<f32>) -> vec4<f32> {
  return vec4<f32>(clip.xy, select(max(clip.z, 0.0), min(clip.z, clip.w), view.near_z != 0.0), clip.w);
}

// The far vertex, at infinity, of the point of an edge at which the direction away from the light is parallel to the near
// plane. It has a meaning only if the far heights of the ends have different signs. `a` must have the lower vertex index.
fn parallel_to_near_plane(a: Corner, b: Corner) -> vec4<f32> {
  let t = a.far_height / (a.far_height - b.far_height);
  return vec4<f32>(a.far.xy + (b.far.xy - a.far.xy) * t, 0.0, 0.0);
}
