// Choose: a compute stage that chooses for each caster (a mesh that throws shadows), light and view which of its faces cast and
// how the shadow is counted, without a look at its faces: nothing if its shadow cannot be seen; z-pass unless a face may lie
// between light and near rectangle (what the camera sees of the near plane); averted faces (those that do not face the light)
// where they suffice. Dispatched after `bounds`, an invocation a caster and light, a row of workgroups a view, for all batches of
// 32 lights together. It reads boxes and flags of casters and what shadows may fall on; for a single caster the statistics of the
// extraction, in a scene `lit` and FRESH. It writes choices (shadow/choices.wgsl), for `zp_plus_2005_cases`, `caps` and all
// stages after them, and statistics. All tests have slack, which must stay above their rounding errors: what is skipped casts
// nothing that is seen, and where a test leaves it open, every face casts, or near caps are looked for.
// docs/numerics/casting-faces.md, "Which faces cast", docs/numerics/shadow-volumes.md, "Volumes that end", and
// docs/numerics/receivers.md, "Volumes without a receiver".

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/shadow
#import shadow/visibility

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<storage, read> seen: array<SeenLight>;
@group(0) @binding(2) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> boxes: array<u32>;
// The words of `ExtractionStatistics`: 3 is how many pairs of face and light have the light in the face's plane, 4 has bits of
// the lights (modulo 32) for which a polygon is L-twisted: its outline crosses itself as seen from light L. In a scene, constants
// are bound instead, since facing is not waited for: a light may be in the plane of a face.
// Behind these there, for each group and batch, the lights of a caster of polygons for which one is twisted.
@group(0) @binding(4) var<storage, read> extraction_statistics: array<u32>;
@group(0) @binding(5) var<storage, read_write> choices: array<atomic<u32>>; // Choices of all casters, then measures.
@group(0) @binding(6) var<storage, read_write> shadow_statistics: ShadowStatistics;
// For each batch and caster of a scene the lights that matter. A single caster has none.
@group(0) @binding(7) var<storage, read> lit: array<u32>;

// Whether the box, moved to the camera's frame, meets the box of the near rectangle, with slack.
fn boxes_meet(view: ShadowView, low: vec3<f32>, high: vec3<f32>) -> bool {
  for (var axis = 0u; axis < 3u; axis++) {
    let row = view.placement[axis];
    let ends = vec2<f32>(dot_3(min(row.xyz * low, row.xyz * high), vec3<f32>(1.0)), dot_3(max(row.xyz * low, row.xyz * high), vec3<f32>(1.0)));
    let size = dot_3(abs(row.xyz), max(abs(low), abs(high))) + abs(row.w);
    let slack = SLACK * max(size, max(abs(view.near_min[axis]), abs(view.near_max[axis])));
    if (ends.x + row.w - slack > view.near_max[axis] || ends.y + row.w + slack < view.near_min[axis]) {
      return false;
    }
  }
  return true;
}

// Whether the light may be in the box, with slack. A light at infinity is not. Values are multiplied by w, so that
// nothing overflows.
fn light_meets(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  let w = light.light.w;
  let slack = SLACK * max(max(abs(w * low), abs(w * high)), abs(light.light.xyz));
  return w > 0.0 && all(w * low - slack <= light.light.xyz) && all(w * high + slack >= light.light.xyz);
}

// Whether the whole box is outside the pyramid of light and near rectangle.
fn misses_pyramid(view: ShadowView, light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  var out = vec4<bool>(true);
  var beyond = true;
  for (var number = 0u; number < 8u; number++) {
    let planes = pyramid_planes(view, light, box_corner(low, high, number));
    out = vec4<bool>(
      out.x && is_out(planes.value.x, planes.size.x),
      out.y && is_out(planes.value.y, planes.size.y),
      out.z && is_out(planes.value.z, planes.size.z),
      out.w && is_out(planes.value.w, planes.size.w));
    beyond = beyond && is_out(planes.depth, planes.depth_size);
  }
  return any(out) || beyond;
}

// The near end of the light's frustum in ZP+ as published. Nothing of the caster lies before it. For a point light it
// is the caster's distance from the light over that of the near rectangle's farthest point. For a light at infinity it
// is the caster's height.
fn frustum_near(view: ShadowView, light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> f32 {
  if (light.light.w > 0.0) {
    let place = placed(view, light.light.xyz / light.light.w);
    let farthest = length_of(max(abs(view.near_min - place), abs(view.near_max - place)));
    // It is below 1 for casters beyond the near rectangle, which have nothing in the frustum. It is above 0 for lights
    // in the box, which the paper does not treat: with 0 or less nothing would be clipped at the near plane.
    return clamp(distance_below(light, low, high) / farthest, 0.001, 0.99);
  }
  var highest = 0.0;
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    let height = dot_3(view.near_plane.xyz, placed(view, position)) + view.near_plane.w;
    highest = max(highest, light_side(light) * height + SLACK * height_size(view, abs(placed(view, position))));
  }
  return select(1.0, highest, highest > 0.0);
}

// Whether a polygon of the caster may be L-twisted for a light, as a light of the same bit has it. Such polygons are excluded, so
// the caster is not closed.
fn is_cut(caster: u32, number: u32) -> bool {
  var word = 4u;
  if (MANY) {
    word = 5u + caster_part(caster, 7u).y * shape.batches + number / 32u;
  }
  return ((extraction_statistics[word] >> (number % 32u)) & 1u) != 0u;
}

// The light with the choices for a caster and a view, by the caster's box. A lower bound of the distance to a caster with
// a matrix is that in the caster's space times `scale`, the least that the matrix makes of a length.
fn chosen(view: ShadowView, given: ShadowLight, scale: f32, flags: u32, low: vec3<f32>, high: vec3<f32>, has_holes: bool, is_cut: bool) -> ShadowLight {
  var light = given;
  light.casting = CAST_NOTHING;
  light.counting = COUNT_Z_PASS;
  light.end = 0.0;
  light.excludes = 0u;
  if (shape.skip_unreached != 0u && out_of_range(light, scale, low, high)) {
    atomicAdd(&shadow_statistics.unreached, 1u);
    return light;
  }
  if (shape.skip_unseen != 0u && is_unseen(view, light, low, high)) {
    return light;
  }
  let light_is_inside = light_meets(light, low, high);
  light.excludes = select(0u, 1u, has_holes || is_cut || (light_is_inside && extraction_statistics[3] != 0u));
  // A caster with holes is not closed. Averted faces suffice if light and eye are outside the caster, and the eye does not
  // see into it: docs/numerics/casting-faces.md, "Which faces cast".
  let is_closed = shape.averted != 0u && (flags & CLOSED) != 0u && (flags & PROXY) == 0u;
  let is_outside = !boxes_meet(view, low, high) && !light_is_inside;
  light.casting = select(CAST_EVERY, CAST_AVERTED, is_closed && !has_holes && !is_cut && is_outside);
  light.counting = shape.counting;
  if (shape.counting == COUNT_ZP_PLUS_2005) {
    light.frustum_near = frustum_near(view, light, low, high);
    // The published method knows no excluded faces, and no caster that is not in the depth buffer.
    light.counting = select(COUNT_ZP_PLUS_2005, COUNT_Z_FAIL, light.excludes != 0u || (flags & PROXY) != 0u);
  }
  if (shape.counting == COUNT_AUTO) {
    light.counting = select(COUNT_ZP_PLUS, COUNT_Z_PASS, misses_pyramid(view, light, low, high));
  }
  // Near caps belong to volumes that do not end, so volumes that ZP+ counts do not end.
  let may_end = light.counting == COUNT_Z_PASS || light.counting == COUNT_Z_FAIL;
  if (may_end && shape.end_at_range != 0u && light.range > 0.0 && light.light.w > 0.0) {
    light.end = min(scale * distance_below(light, low, high) / light.range, 1.0);
  }
  return light;
}

// Counts the choices of an earlier encode, which stay.
fn count_kept(at: u32, bit: u32, measures: u32) {
  if ((atomicLoad(&choices[at + CASTS]) & bit) == 0u) {
    atomicAdd(&shadow_statistics.skipped, 1u);
    return;
  }
  if ((atomicLoad(&choices[at + EVERY]) & bit) != 0u) {
    atomicAdd(&shadow_statistics.every_face, 1u);
  }
  if (has_measures() && bitcast<f32>(atomicLoad(&choices[measures])) > 0.0) {
    atomicAdd(&shadow_statistics.ended, 1u);
  }
}

// Chooses for a caster, a light and a view, and writes it.
fn choose_light(caster: u32, number: u32, view_number: u32) {
  let at = CHOICE_WORDS * choices_of(caster, number / 32u, view_number);
  let bit = 1u << (number % 32u);
  let measures = CHOICE_WORDS * shape.views * shape.batches * shape.casters + 2u * measures_of(caster, number, view_number);
  let first = CHOICE_WORDS * choices_of(first_of_group(caster), number / 32u, view_number);
  let is_fresh = !MANY || (atomicLoad(&choices[first + FRESH]) & bit) != 0u;
  // Earlier choices go. A caster that did not cast has none.
  if (MANY && is_fresh && (atomicLoad(&choices[at + CASTS]) & bit) != 0u) {
    // Turns: 8.
    for (var word = CASTS; word <= EXCLUDES; word++) {
      atomicAnd(&choices[at + word], ~bit);
    }
  }
  if (MANY && (lit[number / 32u * shape.casters + caster] & bit) == 0u) {
    return;
  }
  let flags = caster_flags(caster);
  let own = box_of(caster);
  let is_excluding = (flags & EXCLUDING) != 0u;
  let entry = view_number * shape.lights + number;
  // A view that is not used is all zeros, and so are numbers without a light where a caster has all lights.
  if (seen[entry].view.near_w == 0.0) {
    return;
  }
  if (!is_fresh) {
    count_kept(at, bit, measures);
    return;
  }
  let view = view_of(caster, seen[entry].view);
  let scale = select(1.0, bitcast<f32>(caster_part(caster, 3u).w), MANY);
  let receivers_at = seen[entry].version.y;
  var light = light_of(caster, seen[entry].light, number);
  light.casting = CAST_NOTHING;
  if (!own.is_empty) {
    light = chosen(view, light, scale, flags, own.low, own.high, own.has_holes, is_cut(caster, number));
    light.excludes = select(light.excludes, 1u, is_excluding);
    if (light.casting != CAST_NOTHING && receivers_at != 0u && is_hidden(view, light, scale, own.low, own.high, receivers_at)) {
      light.casting = CAST_NOTHING;
      atomicAdd(&shadow_statistics.hidden, 1u);
    }
  }
  if (light.casting == CAST_NOTHING) {
    atomicAdd(&shadow_statistics.skipped, 1u);
    return;
  }
  if (receivers_at != 0u && (light.counting == COUNT_Z_PASS || light.counting == COUNT_Z_FAIL)) {
    light.end = max(light.end, end_behind(view, light, scale, own.low, own.high, receivers_at));
  }
  if (light.end > 0.0) {
    atomicAdd(&shadow_statistics.ended, 1u);
  }
  atomicOr(&choices[at + CASTS], bit);
  if (light.casting == CAST_EVERY) {
    atomicOr(&choices[at + EVERY], bit);
    atomicAdd(&shadow_statistics.every_face, 1u);
  }
  if (light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005) {
    atomicOr(&choices[at + NEAR], bit);
  }
  if (is_cut(caster, number) && light.counting == COUNT_ZP_PLUS) {
    // Pieces of twisted polygons have near caps, which `caps` does not see.
    atomicOr(&choices[at + CAPPED], bit);
  }
  if (light.excludes != 0u) {
    atomicOr(&choices[at + EXCLUDES], bit);
    atomicOr(&choices[first + select(MAY_EXCLUDE, DOES_EXCLUDE, own.has_holes || is_excluding || is_cut(caster, number))], bit);
  }
  if (has_measures()) {
    atomicStore(&choices[measures], bitcast<u32>(light.end));
    atomicStore(&choices[measures + 1u], bitcast<u32>(light.frustum_near));
  }
}

@compute @workgroup_size(64)
fn choose(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // Turns: ITEMS.
  for (var pair = id.x; pair < shape.casters * shape.used_lights; pair += 64u * groups.x) {
    // Neighbouring invocations take the same light, so that they take the same branches.
    choose_light(pair % shape.casters, pair / shape.casters, id.y);
  }
}
