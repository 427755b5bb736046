// Visibility: what can be told of a box and its shadow before anything is drawn: whether a light reaches it, whether a camera
// may see it or its shadow, whether it may lie between light and near rectangle (what the camera sees of the near plane), and
// whether anything that shadows fall on can be in its shadow. `choose` takes all but `box_is_unseen`, `caps` the planes
// between light and near rectangle, and `needs` whether a light reaches a box and a camera may see it or its shadow. Tests
// have slack, which must stay above their rounding errors: a box is out only if it certainly is.
// docs/numerics/shadow-volumes.md, and docs/numerics/receivers.md, "Volumes without a receiver".

#import common/casters
#import shadow/receivers
#import shadow/shadow

const SLACK: f32 = 4e-6; // The relative slack of all tests. It is far above the rounding error of the tests.

// Whether a point is outside a plane, from its `value` there. `size` bounds the terms whose sum is the value.
fn is_out(value: f32, size: f32) -> bool { return value < -SLACK * size; }

// The planes through the light and the sides of the near rectangle, at a position. Faces between both cast onto it.
struct PyramidPlanes {
  // Left, right, bottom, top; negative outside. Then bounds on the terms whose sums they are.
  value: vec4<f32>,
  size: vec4<f32>,
  // Negative on the far side of the near plane as seen from the light.
  depth: f32,
  depth_size: f32,
}

// Bounds on the terms whose sums are a position's clip coordinates.
fn clip_size(view: ShadowView, q: vec3<f32>) -> vec4<f32> {
  return abs(view.view_projection[0]) * q.x + abs(view.view_projection[1]) * q.y + abs(view.view_projection[2]) * q.z +
    abs(view.view_projection[3]);
}

fn height_size(view: ShadowView, q: vec3<f32>) -> f32 {
  return dot_3(abs(view.near_plane.xyz), q) + abs(view.near_plane.w);
}

// A face may lie between light and near rectangle unless all its corners are outside the same plane.
fn pyramid_planes(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> PyramidPlanes {
  let s = light_side(light);
  let v = corner(view, light, position);
  let q = abs(placed(view, position));
  let size = clip_size(view, q);
  let height = height_size(view, q);
  let xy = s * (v.near.xy * light.height - light.clip.xy * v.height);
  let w = s * view.near_w * (light.height - light.light.w * v.height);
  let xy_size = size.xy * abs(light.height) + abs(light.clip.xy) * height;
  let w_size = view.near_w * (abs(light.height) + light.light.w * height);
  return PyramidPlanes(
    vec4<f32>(w + xy.x, w - xy.x, w + xy.y, w - xy.y),
    w_size + vec4<f32>(xy_size.xx, xy_size.yy),
    s * v.height,
    height,
  );
}

// Whether the whole box is beyond the light's range.
fn out_of_range(light: ShadowLight, scale: f32, low: vec3<f32>, high: vec3<f32>) -> bool {
  if (light.range <= 0.0 || light.light.w <= 0.0) {
    return false;
  }
  let place = light.light.xyz / light.light.w;
  let d = scale * max(max(low - place, place - high), vec3<f32>(0.0));
  // The largest side is factored out, because squares may overflow.
  let size = max(max(d.x, d.y), max(d.z, light.range));
  let r = light.range / size;
  let e = d / size;
  return dot_3(e, e) > r * r * (1.0 + SLACK);
}

// Bounds on the terms whose sums are the vector from the light to a position.
fn extrusion_size(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec3<f32> {
  let terms = abs(light.light.w * position) + abs(light.light.xyz);
  return vec3<f32>(
    dot_3(abs(view.placement[0].xyz), terms), dot_3(abs(view.placement[1].xyz), terms), dot_3(abs(view.placement[2].xyz), terms));
}

// Whether the whole volume of the box is outside the left, right, bottom, top or near plane of the camera.
fn is_unseen(view: ShadowView, light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  var out = vec4<bool>(true);
  var before = true;
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    let v = corner(view, light, position);
    let q = abs(placed(view, position));
    let size = clip_size(view, q);
    let away = extrusion_size(view, light, position);
    let far_size = clip_size(view, away);
    let near_x = size.w + size.x;
    let near_y = size.w + size.y;
    let far_x = far_size.w + far_size.x;
    let far_y = far_size.w + far_size.y;
    out = vec4<bool>(
      out.x && is_out(v.near.w + v.near.x, near_x) && is_out(v.far.w + v.far.x, far_x),
      out.y && is_out(v.near.w - v.near.x, near_x) && is_out(v.far.w - v.far.x, far_x),
      out.z && is_out(v.near.w + v.near.y, near_y) && is_out(v.far.w + v.far.y, far_y),
      out.w && is_out(v.near.w - v.near.y, near_y) && is_out(v.far.w - v.far.y, far_y));
    before = before && is_out(v.height, height_size(view, q)) &&
      is_out(v.far_height, far_size.w + dot_3(abs(view.near_plane.xyz), away));
  }
  return any(out) || before;
}

// Whether the whole box is outside the left, right, bottom, top or near plane of the camera.
fn box_is_unseen(view: ShadowView, low: vec3<f32>, high: vec3<f32>) -> bool {
  var out = vec4<bool>(true);
  var before = true;
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    let q = placed(view, position);
    let size = clip_size(view, abs(q));
    let clip = to_clip(view, position);
    out = vec4<bool>(
      out.x && is_out(clip.w + clip.x, size.w + size.x),
      out.y && is_out(clip.w - clip.x, size.w + size.x),
      out.z && is_out(clip.w + clip.y, size.w + size.y),
      out.w && is_out(clip.w - clip.y, size.w + size.y));
    before = before && is_out(dot_3(view.near_plane.xyz, q) + view.near_plane.w, height_size(view, abs(q)));
  }
  return any(out) || before;
}

// The receivers of all views: what shadows may fall on. `at` is the word where those of a view begin.
@group(0) @binding(8) var<storage, read> receivers: array<u32>;

fn receiver_corner(at: u32) -> vec3<f32> {
  return vec3<f32>(bitcast<f32>(receivers[at]), bitcast<f32>(receivers[at + 1u]), bitcast<f32>(receivers[at + 2u]));
}

// How far a volume goes until it has left the box of the receivers. V is a vertex, and d its `extrusion`.
struct Reach {
  is_none: bool, // No receiver is beyond any point of the caster, as seen from the light.
  // With a light at a point: the least factor of the light in the far vertex `d + factor * light`; 0 if there is no limit. With a
  // light at infinity: the largest factor of d in the far vertex `V + factor * d`; negative if there is no limit.
  factor: f32,
}

// For the volume of a caster's box, in the space of its positions; `scale` is at most the smallest factor by which lengths there
// grow in the world. `at` is the word where the view's receivers begin.
fn reach_to(view: ShadowView, light: ShadowLight, scale: f32, low: vec3<f32>, high: vec3<f32>, at: u32) -> Reach {
  let is_limited = receivers[at + 5u] != 0u;
  let near = receiver_corner(at + 6u);
  let far = receiver_corner(at + 9u);
  if (light.light.w > 0.0) {
    if (!is_limited) {
      return Reach(false, 0.0);
    }
    let l = light.light.xyz / light.light.w;
    let place = placed(view, l);
    let terms = placed_size(view, l);
    let apart = max(abs(near - place), abs(far - place)) + SLACK * (max(abs(near), abs(far)) + terms);
    let factor = (1.0 - SLACK) * scale * distance_below(light, low, high) / length_of(apart);
    // NaN limits nothing.
    return Reach(factor > 1.0 && factor < 0x1p100, select(0.0, factor, factor > 0.0 && factor <= 1.0));
  }
  if (!is_limited) {
    return Reach(false, -1.0);
  }
  let d = turned(view, -light.light.xyz);
  var farthest = 0.0;
  var size = 0.0;
  for (var axis = 0u; axis < 3u; axis++) {
    farthest += max(near[axis] * d[axis], far[axis] * d[axis]);
    size += max(abs(near[axis]), abs(far[axis])) * abs(d[axis]);
  }
  var nearest = 0x1p127;
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    nearest = min(nearest, dot_3(placed(view, position), d));
    size = max(size, dot_3(placed_size(view, position), abs(d)));
  }
  // Twice: the terms of both, and d itself is rounded.
  let beyond = farthest - nearest + 4.0 * SLACK * size;
  return Reach(beyond < 0.0, (1.0 + SLACK) * max(beyond, 0.0) / dot_3(d, d));
}

// Bounds on the terms whose sums are a position in the camera's frame.
fn placed_size(view: ShadowView, position: vec3<f32>) -> vec3<f32> {
  let q = abs(position);
  return vec3<f32>(
    dot_3(abs(view.placement[0].xyz), q) + abs(view.placement[0].w),
    dot_3(abs(view.placement[1].xyz), q) + abs(view.placement[1].w),
    dot_3(abs(view.placement[2].xyz), q) + abs(view.placement[2].w));
}

// A hull of vertices in clip space, as far as it is known.
struct Hull {
  // Whether all are outside the left, right, bottom and top plane, or before the near plane.
  out: vec4<bool>,
  before: bool,
  is_ahead: bool, // Whether all are in front of the near plane. Only then the rest is known.
  // Ends on the screen.
  low: vec2<f32>,
  high: vec2<f32>,
  nearest: f32, // The nearest depth.
}

// Takes a vertex with bounds on the terms of its coordinates and of its height over the near plane.
fn with_vertex(hull: Hull, view: ShadowView, clip: vec4<f32>, size: vec4<f32>, height: f32, height_size: f32) -> Hull {
  var next = hull;
  let along_x = size.w + size.x;
  let along_y = size.w + size.y;
  next.out = vec4<bool>(
    hull.out.x && is_out(clip.w + clip.x, along_x),
    hull.out.y && is_out(clip.w - clip.x, along_x),
    hull.out.z && is_out(clip.w + clip.y, along_y),
    hull.out.w && is_out(clip.w - clip.y, along_y));
  next.before = hull.before && is_out(height, height_size);
  next.is_ahead = hull.is_ahead && height > SLACK * height_size && clip.w > 0x1p-10 * size.w &&
    all(size < vec4<f32>(0x1p100));
  if (next.is_ahead) {
    let place = clip.xyz / clip.w;
    let error = 2.0 * SLACK * (size.xyz + abs(place) * size.w) / clip.w;
    next.low = min(hull.low, place.xy - error.xy);
    next.high = max(hull.high, place.xy + error.xy);
    next.nearest = select(
      min(hull.nearest, place.z - error.z), max(hull.nearest, place.z + error.z), view.near_z != 0.0);
  }
  return next;
}

// The key of the farthest receiver that is seen through a rectangle, in normalised device coordinates, and a pixel around; 0 if
// there is none. It reads up to 4 × 4 cells of the first level of the pyramid on which these suffice.
fn farthest_through(low: vec2<f32>, high: vec2<f32>, at: u32) -> u32 {
  let pixels = vec2<f32>(f32(receivers[at + 2u]), f32(receivers[at + 3u]));
  let begin = (vec2<f32>(low.x, -high.y) * 0.5 + 0.5) * pixels - 1.0;
  let end = (vec2<f32>(high.x, -low.y) * 0.5 + 0.5) * pixels + 1.0;
  var first = vec2<u32>(clamp(begin, vec2<f32>(0.0), pixels - 1.0)) / TILE;
  var last = vec2<u32>(clamp(end, vec2<f32>(0.0), pixels - 1.0)) / TILE;
  var cells = vec2<u32>(receivers[at], receivers[at + 1u]);
  var level = at + RECEIVERS_HEAD;
  // Turns: RECEIVER_LEVELS.
  while (any(last - first > vec2<u32>(3u))) {
    level += cells.x * cells.y;
    cells = (cells + 1u) / 2u;
    first /= 2u;
    last /= 2u;
  }
  var key = 0u;
  // Turns: 4.
  for (var y = first.y; y <= last.y; y++) {
    // Turns: 4.
    for (var x = first.x; x <= last.x; x++) {
      key = max(key, receivers[level + y * cells.x + x]);
    }
  }
  return key;
}

// Where a volume may end behind all receivers, as `ShadowLight::end` has it. 0: nowhere.
fn end_behind(view: ShadowView, light: ShadowLight, scale: f32, low: vec3<f32>, high: vec3<f32>, at: u32) -> f32 {
  let reach = reach_to(view, light, scale, low, high, at);
  if (light.light.w > 0.0) {
    return reach.factor;
  }
  // It may be farther away than need be. A NaN ends nowhere.
  let end = min(1.0 / reach.factor, 0x1p20);
  return select(0.0, end, reach.factor >= 0.0 && reach.factor < 0x1p100);
}

// Whether no receiver can be in the volume of a box.
fn is_hidden(view: ShadowView, light: ShadowLight, scale: f32, low: vec3<f32>, high: vec3<f32>, at: u32) -> bool {
  if (receivers[at + 4u] == 0u) {
    return true;
  }
  let reach = reach_to(view, light, scale, low, high, at);
  if (reach.is_none) {
    return true;
  }
  var hull = Hull(vec4<bool>(true), true, true, vec2<f32>(0x1p127), vec2<f32>(-0x1p127), 1.0 - view.near_z);
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    let clip = to_clip(view, position);
    let size = clip_size(view, placed_size(view, position));
    let height = dot_3(view.near_plane.xyz, placed(view, position)) + view.near_plane.w;
    let near_size = height_size(view, placed_size(view, position));
    hull = with_vertex(hull, view, clip, size, height, near_size);
    let away = extrusion(view, light, position);
    let terms = extrusion_size(view, light, position);
    var far = direction_to_clip(view, away);
    var far_size = clip_size(view, terms);
    var rise = dot_3(view.near_plane.xyz, away);
    var rise_size = dot_3(abs(view.near_plane.xyz), terms);
    if (light.light.w > 0.0) {
      far += reach.factor * light.clip;
      far_size += reach.factor * abs(light.clip);
      rise += reach.factor * light.height;
      rise_size += reach.factor * abs(light.height);
    } else if (reach.factor >= 0.0) {
      far = clip + reach.factor * far;
      far_size = size + reach.factor * far_size;
      rise = height + reach.factor * rise;
      rise_size = near_size + reach.factor * rise_size;
    }
    hull = with_vertex(hull, view, far, far_size, rise, rise_size);
  }
  if (any(hull.out) || hull.before) {
    return true;
  }
  if (!hull.is_ahead) {
    return false;
  }
  let key = farthest_through(hull.low, hull.high, at);
  if (key == 0u) {
    return true;
  }
  let farthest = depth_of_key(key, view.near_z);
  return select(hull.nearest > farthest, hull.nearest < farthest, view.near_z != 0.0);
}

// The length of a vector without negative components. The largest is factored out, because squares may overflow.
fn length_of(d: vec3<f32>) -> f32 {
  let size = max(max(d.x, d.y), d.z);
  if (size <= 0.0) {
    return 0.0;
  }
  let e = d / size;
  return size * sqrt(dot_3(e, e));
}

// A lower bound of the distance from the light to the box.
fn distance_below(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> f32 {
  let place = light.light.xyz / light.light.w;
  let slack = SLACK * max(max(abs(low), abs(high)), abs(place));
  let d = max(max(low - place, place - high) - slack, vec3<f32>(0.0));
  return length_of(d) * (1.0 - SLACK);
}
