// Tests by which casters and volumes are culled before anything is drawn: by light range, by view and by receivers. A
// further test is whether a box or face may lie between light and near rectangle. The near rectangle is what the camera
// sees of the near plane. A box is the axis-aligned box of a caster, and its volume is the shadow volume of the whole box.
// View and light must be for the space of the box (shadow/caster.wgsl). `counting_methods` calls all of them but
// `is_box_outside_view`. `caps` tests faces by `pyramid_planes`, and `needs` calls the tests by range and view. Every test
// has slack above its rounding errors. It says that a box or volume is outside only if this is certain, so nothing visible
// is culled. docs/numerics/shadow-volumes.md, "Slack of culling", and docs/numerics/receivers.md, "Volumes without a
// receiver".

#import common/casters
#import shadow/receivers
#import shadow/shadow

// The slack of all tests, relative to the terms of a value: the sum of the absolute values of the terms that the value is a
// sum of. It is above their rounding errors. Functions and variables named `…_terms` give upper bounds on terms.
const SLACK: f32 = 4e-6;

// Whether values are certainly negative: beyond the slack. Values that are not finite are not. Tests bits, like `is_finite`.
fn are_negative(values: vec4<f32>, terms: vec4<f32>) -> vec4<bool> {
  let infinite = vec4<u32>(0x7f800000u);
  let exponents = bitcast<vec4<u32>>(values) & infinite;
  let exponents_of_terms = bitcast<vec4<u32>>(terms) & infinite;
  return (exponents != infinite) & (exponents_of_terms != infinite) & (values < -SLACK * terms);
}

fn is_negative(value: f32, terms: f32) -> bool { return are_negative(vec4<f32>(value), vec4<f32>(terms)).x; }

// A position relative to the pyramid with the light as its apex and the near rectangle as its base.
struct PyramidPlanes {
  // Distances from the planes through the light and the left, right, bottom and top side of the near rectangle, times some
  // positive factor. Negative: outside.
  side_heights: vec4<f32>,
  side_terms: vec4<f32>, // The terms of `side_heights`.
  depth: f32, // The distance from the near plane. Negative: on the side away from the light.
  depth_terms: f32, // The terms of `depth`.
}

// The terms of a position's clip coordinates. `q` has the absolute values, or the terms, of the position in the camera
// frame.
fn clip_terms(view: ShadowView, q: vec3<f32>) -> vec4<f32> {
  return abs(view.view_projection[0]) * q.x + abs(view.view_projection[1]) * q.y + abs(view.view_projection[2]) * q.z +
    abs(view.view_projection[3]);
}

// The terms of a position's height over the near plane. `q` as for `clip_terms`.
fn height_terms(view: ShadowView, q: vec3<f32>) -> f32 {
  return dot_3(abs(view.near_plane.xyz), q) + abs(view.near_plane.w);
}

// A position's distances from the planes of the pyramid of light and near rectangle. A face may lie between the two unless
// all its corners are outside of one plane.
fn pyramid_planes(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> PyramidPlanes {
  let s = light_side(light);
  let v = corner(view, light, position);
  let q = abs(to_camera_frame(view, position));
  let terms = clip_terms(view, q);
  let terms_of_height = height_terms(view, q);
  let xy = s * (v.near.xy * light.height - light.clip.xy * v.height);
  let w = s * view.near_w * (light.height - light.light.w * v.height);
  let xy_terms = terms.xy * abs(light.height) + abs(light.clip.xy) * terms_of_height;
  let w_terms = view.near_w * (abs(light.height) + light.light.w * terms_of_height);
  return PyramidPlanes(
    vec4<f32>(w + xy.x, w - xy.x, w + xy.y, w - xy.y),
    w_terms + vec4<f32>(xy_terms.xx, xy_terms.yy),
    s * v.height,
    terms_of_height,
  );
}

// A light's position in the space of the caster's positions is off by less than this times its largest coordinate.
// docs/numerics/shadow-volumes.md, "Rigid casters".
const LIGHT_ERROR: f32 = 0x1.8p-21;

// Whether the whole box is out of the light's range. `scale` is at most the smallest factor by which the caster's matrix
// scales lengths. Here lengths are multiplied by w, which is 0 or a power of two, so products with it do not round.
fn is_out_of_range(light: ShadowLight, scale: f32, low: vec3<f32>, high: vec3<f32>) -> bool {
  let position = light.light.xyz;
  let w = light.light.w;
  let range = w * light.range;
  let reach = range + scale * (LIGHT_ERROR * largest_component(position));
  let d = scale * max(max(w * low - position, position - w * high), vec3<f32>(0.0));
  // The largest component is factored out, because squares may overflow.
  let size = max(max(d.x, d.y), max(d.z, reach));
  let r = reach / size;
  let e = d / size;
  return range > 0.0 && is_finite(d) && dot_3(e, e) > r * r * (1.0 + SLACK);
}

// The terms of `extrusion`.
fn extrusion_terms(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec3<f32> {
  let terms = abs(light.light.w * position) + abs(light.light.xyz);
  return vec3<f32>(
    dot_3(abs(view.placement[0].xyz), terms),
    dot_3(abs(view.placement[1].xyz), terms),
    dot_3(abs(view.placement[2].xyz), terms));
}

// Whether the whole volume of a box, to infinity, is outside one plane of the camera: left, right, bottom, top or near.
fn is_volume_outside_view(view: ShadowView, light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  var outside = vec4<bool>(true); // Left, right, bottom, top.
  var outside_near = true;
  for (var index = 0u; index < 8u; index++) {
    let position = box_corner(low, high, index);
    let v = corner(view, light, position);
    let q = abs(to_camera_frame(view, position));
    let terms = clip_terms(view, q);
    let away = extrusion_terms(view, light, position);
    let far_terms = clip_terms(view, away);
    let near_x = terms.w + terms.x;
    let near_y = terms.w + terms.y;
    let far_x = far_terms.w + far_terms.x;
    let far_y = far_terms.w + far_terms.y;
    outside = vec4<bool>(
      outside.x && is_negative(v.near.w + v.near.x, near_x) && is_negative(v.far.w + v.far.x, far_x),
      outside.y && is_negative(v.near.w - v.near.x, near_x) && is_negative(v.far.w - v.far.x, far_x),
      outside.z && is_negative(v.near.w + v.near.y, near_y) && is_negative(v.far.w + v.far.y, far_y),
      outside.w && is_negative(v.near.w - v.near.y, near_y) && is_negative(v.far.w - v.far.y, far_y));
    outside_near = outside_near && is_negative(v.height, height_terms(view, q)) &&
      is_negative(v.far_height, far_terms.w + dot_3(abs(view.near_plane.xyz), away));
  }
  return any(outside) || outside_near;
}

// Whether the whole box is outside one plane of the camera: left, right, bottom, top or near.
fn is_box_outside_view(view: ShadowView, low: vec3<f32>, high: vec3<f32>) -> bool {
  var outside = vec4<bool>(true); // Left, right, bottom, top.
  var outside_near = true;
  for (var index = 0u; index < 8u; index++) {
    let position = box_corner(low, high, index);
    let q = to_camera_frame(view, position);
    let terms = clip_terms(view, abs(q));
    let clip = to_clip(view, position);
    outside = vec4<bool>(
      outside.x && is_negative(clip.w + clip.x, terms.w + terms.x),
      outside.y && is_negative(clip.w - clip.x, terms.w + terms.x),
      outside.z && is_negative(clip.w + clip.y, terms.w + terms.y),
      outside.w && is_negative(clip.w - clip.y, terms.w + terms.y));
    outside_near = outside_near &&
      is_negative(dot_3(view.near_plane.xyz, q) + view.near_plane.w, height_terms(view, abs(q)));
  }
  return any(outside) || outside_near;
}

// The receivers of all views (shadow/receivers.wgsl). Functions below take the offset of a view's words, which
// must not be 0.
@group(0) @binding(8) var<storage, read> receivers: array<u32>;

fn load_receiver_corner(offset: u32) -> vec3<f32> {
  return vec3<f32>(
    bitcast<f32>(receivers[offset]),
    bitcast<f32>(receivers[offset + 1u]),
    bitcast<f32>(receivers[offset + 2u]));
}

// Where a volume has left the box of the receivers. V is a vertex of the caster's box, and d is its `extrusion`.
struct VolumeExtent {
  has_no_receiver: bool, // Every receiver is nearer to the light than every point of the caster's box.
  // The far vertex with this factor is behind all receivers.
  // * Point light: it is d + factor * light. 0: there is no limit.
  // * Light at infinity: it is V + factor * d. Negative: there is no limit.
  factor: f32,
}

// The extent of the volume of a caster's box, which is in the space of the caster's positions. `scale` is at most the
// smallest factor by which the caster's matrix scales lengths.
fn volume_extent(
  view: ShadowView,
  light: ShadowLight,
  scale: f32,
  low: vec3<f32>,
  high: vec3<f32>,
  receivers_offset: u32,
) -> VolumeExtent {
  let is_limited = receivers[receivers_offset + 5u] != 0u;
  let near = load_receiver_corner(receivers_offset + 6u);
  let far = load_receiver_corner(receivers_offset + 9u);
  if (light.light.w > 0.0) {
    if (!is_limited) {
      return VolumeExtent(false, 0.0);
    }
    let l = light.light.xyz / light.light.w;
    let light_position = to_camera_frame(view, l);
    let terms = camera_frame_terms(view, l);
    let apart = max(abs(near - light_position), abs(far - light_position)) +
      SLACK * (max(abs(near), abs(far)) + terms);
    let factor = (1.0 - SLACK) * scale * distance_lower_bound(light, low, high) / vector_length(apart);
    // A factor that is not finite limits nothing.
    let is_certain = is_finite(vec3<f32>(factor));
    return VolumeExtent(
      is_certain && factor > 1.0 && factor < 0x1p100,
      select(0.0, factor, is_certain && factor > 0.0 && factor <= 1.0));
  }
  if (!is_limited) {
    return VolumeExtent(false, -1.0);
  }
  let d = direction_to_camera_frame(view, -light.light.xyz);
  var farthest = 0.0;
  var terms = 0.0;
  for (var axis = 0u; axis < 3u; axis++) {
    farthest += max(near[axis] * d[axis], far[axis] * d[axis]);
    terms += max(abs(near[axis]), abs(far[axis])) * abs(d[axis]);
  }
  var is_certain = is_finite(vec3<f32>(farthest, terms, terms));
  var nearest = 0x1p127;
  for (var index = 0u; index < 8u; index++) {
    let position = box_corner(low, high, index);
    let corner_depth = dot_3(to_camera_frame(view, position), d);
    let corner_terms = dot_3(camera_frame_terms(view, position), abs(d));
    // Maximum and minimum may drop a NaN.
    is_certain = is_certain && is_finite(vec3<f32>(corner_depth, corner_terms, corner_terms));
    nearest = min(nearest, corner_depth);
    terms = max(terms, corner_terms);
  }
  if (!is_certain) {
    return VolumeExtent(false, -1.0);
  }
  // Four times the slack: both values have these terms, and d itself is rounded.
  let beyond = farthest - nearest + 4.0 * SLACK * terms;
  return VolumeExtent(beyond < 0.0, (1.0 + SLACK) * max(beyond, 0.0) / dot_3(d, d));
}

// The terms of `to_camera_frame`.
fn camera_frame_terms(view: ShadowView, position: vec3<f32>) -> vec3<f32> {
  let q = abs(position);
  return vec3<f32>(
    dot_3(abs(view.placement[0].xyz), q) + abs(view.placement[0].w),
    dot_3(abs(view.placement[1].xyz), q) + abs(view.placement[1].w),
    dot_3(abs(view.placement[2].xyz), q) + abs(view.placement[2].w));
}

// A convex hull of vertices in clip space.
struct Hull {
  outside: vec4<bool>, // All vertices are outside the left, right, bottom or top plane.
  outside_near: bool, // All vertices are before the near plane.
  is_beyond_near: bool, // All vertices are beyond the near plane. Only then the fields below have a meaning.
  low: vec2<f32>, // The rectangle around the hull on the screen, in normalised device coordinates.
  high: vec2<f32>,
  nearest: f32, // The nearest depth.
}

// The hull with one more vertex. `terms` are those of `clip`, `terms_of_height` those of the height over the near plane.
fn with_hull_vertex(
  hull: Hull,
  view: ShadowView,
  clip: vec4<f32>,
  terms: vec4<f32>,
  height: f32,
  terms_of_height: f32,
) -> Hull {
  var next = hull;
  let x_terms = terms.w + terms.x;
  let y_terms = terms.w + terms.y;
  next.outside = vec4<bool>(
    hull.outside.x && is_negative(clip.w + clip.x, x_terms),
    hull.outside.y && is_negative(clip.w - clip.x, x_terms),
    hull.outside.z && is_negative(clip.w + clip.y, y_terms),
    hull.outside.w && is_negative(clip.w - clip.y, y_terms));
  next.outside_near = hull.outside_near && is_negative(height, terms_of_height);
  let is_certain = is_finite(terms.xyz) && is_finite(vec3<f32>(terms.w, height, terms_of_height));
  next.is_beyond_near = hull.is_beyond_near && is_certain && height > SLACK * terms_of_height &&
    clip.w > 0x1p-10 * terms.w && all(terms < vec4<f32>(0x1p100));
  if (next.is_beyond_near) {
    let ndc = clip.xyz / clip.w;
    let error = 2.0 * SLACK * (terms.xyz + abs(ndc) * terms.w) / clip.w;
    next.low = min(hull.low, ndc.xy - error.xy);
    next.high = max(hull.high, ndc.xy + error.xy);
    next.nearest = select(
      min(hull.nearest, ndc.z - error.z), max(hull.nearest, ndc.z + error.z), view.near_z != 0.0);
  }
  return next;
}

// The key of the farthest receiver in a rectangle, in normalised device coordinates, and one pixel around it. 0: there is
// none. It reads up to 4 × 4 cells, on the first level of the pyramid on which these cover the rectangle.
fn farthest_receiver_key(low: vec2<f32>, high: vec2<f32>, receivers_offset: u32) -> u32 {
  let pixels = vec2<f32>(f32(receivers[receivers_offset + 2u]), f32(receivers[receivers_offset + 3u]));
  let begin = (vec2<f32>(low.x, -high.y) * 0.5 + 0.5) * pixels - 1.0;
  let end = (vec2<f32>(high.x, -low.y) * 0.5 + 0.5) * pixels + 1.0;
  var first = vec2<u32>(clamp(begin, vec2<f32>(0.0), pixels - 1.0)) / TILE;
  var last = vec2<u32>(clamp(end, vec2<f32>(0.0), pixels - 1.0)) / TILE;
  var cells = vec2<u32>(receivers[receivers_offset], receivers[receivers_offset + 1u]);
  var level_offset = receivers_offset + RECEIVERS_HEAD;
  // Turns: RECEIVER_LEVELS.
  while (any(last - first > vec2<u32>(3u))) {
    level_offset += cells.x * cells.y;
    cells = (cells + 1u) / 2u;
    first /= 2u;
    last /= 2u;
  }
  var key = 0u;
  // Turns: 4.
  for (var y = first.y; y <= last.y; y++) {
    // Turns: 4.
    for (var x = first.x; x <= last.x; x++) {
      key = max(key, receivers[level_offset + y * cells.x + x]);
    }
  }
  return key;
}

// The end of a volume behind all receivers, as `ShadowLight::end`. 0: the volume has to go to infinity.
fn end_behind_receivers(
  view: ShadowView,
  light: ShadowLight,
  scale: f32,
  low: vec3<f32>,
  high: vec3<f32>,
  receivers_offset: u32,
) -> f32 {
  let extent = volume_extent(view, light, scale, low, high, receivers_offset);
  if (light.light.w > 0.0) {
    return extent.factor;
  }
  // The bound moves the end farther away, which is harmless. With a factor that is not finite the volume goes to infinity.
  let end = min(1.0 / extent.factor, 0x1p20);
  return select(0.0, end, is_finite(vec3<f32>(extent.factor)) && extent.factor >= 0.0 && extent.factor < 0x1p100);
}

// Whether certainly no receiver lies in the volume of a box.
fn is_volume_without_receivers(
  view: ShadowView,
  light: ShadowLight,
  scale: f32,
  low: vec3<f32>,
  high: vec3<f32>,
  receivers_offset: u32,
) -> bool {
  if (receivers[receivers_offset + 4u] == 0u) {
    return true;
  }
  let extent = volume_extent(view, light, scale, low, high, receivers_offset);
  if (extent.has_no_receiver) {
    return true;
  }
  var hull = Hull(vec4<bool>(true), true, true, vec2<f32>(0x1p127), vec2<f32>(-0x1p127), 1.0 - view.near_z);
  for (var index = 0u; index < 8u; index++) {
    let position = box_corner(low, high, index);
    let clip = to_clip(view, position);
    let terms = clip_terms(view, camera_frame_terms(view, position));
    let height = dot_3(view.near_plane.xyz, to_camera_frame(view, position)) + view.near_plane.w;
    let near_height_terms = height_terms(view, camera_frame_terms(view, position));
    hull = with_hull_vertex(hull, view, clip, terms, height, near_height_terms);
    let away = extrusion(view, light, position);
    let away_terms = extrusion_terms(view, light, position);
    var far = direction_to_clip(view, away);
    var far_terms = clip_terms(view, away_terms);
    var far_height = dot_3(view.near_plane.xyz, away);
    var far_height_terms = dot_3(abs(view.near_plane.xyz), away_terms);
    if (light.light.w > 0.0) {
      far += extent.factor * light.clip;
      far_terms += extent.factor * abs(light.clip);
      far_height += extent.factor * light.height;
      far_height_terms += extent.factor * abs(light.height);
    } else if (extent.factor >= 0.0) {
      far = clip + extent.factor * far;
      far_terms = terms + extent.factor * far_terms;
      far_height = height + extent.factor * far_height;
      far_height_terms = near_height_terms + extent.factor * far_height_terms;
    }
    hull = with_hull_vertex(hull, view, far, far_terms, far_height, far_height_terms);
  }
  if (any(hull.outside) || hull.outside_near) {
    return true;
  }
  if (!hull.is_beyond_near) {
    return false;
  }
  let key = farthest_receiver_key(hull.low, hull.high, receivers_offset);
  if (key == 0u) {
    return true;
  }
  let farthest = depth_of_key(key, view.near_z);
  return select(hull.nearest > farthest, hull.nearest < farthest, view.near_z != 0.0);
}

// The length of a vector without negative components. The largest is factored out, because squares may overflow.
fn vector_length(d: vec3<f32>) -> f32 {
  let size = max(max(d.x, d.y), d.z);
  if (size <= 0.0) {
    return 0.0;
  }
  let e = d / size;
  return size * sqrt(dot_3(e, e));
}

// A lower bound of the distance from a point light to the box, in the space of the caster's positions.
fn distance_lower_bound(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> f32 {
  let light_position = light.light.xyz / light.light.w;
  let slack = SLACK * max(max(abs(low), abs(high)), abs(light_position));
  let d = max(max(low - light_position, light_position - high) - slack, vec3<f32>(0.0));
  return vector_length(d) * (1.0 - SLACK);
}
