// Stage `counting_methods`: chooses for each caster, light and view which faces cast, how the stencil counts, and where
// the volume ends. It looks at the caster's box, never at its faces. Culled volumes cast nothing. With COUNT_AUTO z-pass
// counts, but ZP+ if a face may lie between light and near rectangle (what the camera sees of the near plane). Else the
// caller chose the method. Back-facing faces cast where they suffice, else every face. Dispatched after
// `bounds`, once for all light batches: an invocation a caster and light, a row of workgroups a view. Reads: boxes and
// flags of casters, receivers, the relevant lights of casters, CHOICE_DIRTY. Writes: choices (shadow/choices.wgsl), for
// `zp_plus_2005_cases`, `caps` and all later stages; statistics. All tests have slack above their rounding errors. If a
// test is not certain, the volume is not culled, every face casts, and `caps` looks for near caps.
// docs/numerics/casting-faces.md, "Which faces cast"; docs/numerics/shadow-volumes.md, "Volumes that end";
// docs/numerics/receivers.md, "Volumes without a receiver".

#import common/casters
#import shadow/caster
#import shadow/choices
#import shadow/culling
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape; // The first group's and batch's: read only what all share.
@group(0) @binding(1) var<storage, read> view_lights: array<ViewLight>; // For each view all lights.
@group(0) @binding(2) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> boxes: array<u32>;
// For each group and batch the lights for which a polygon of its only caster is twisted: as seen from the light, its
// boundary crosses itself or goes around the light, or a hole is outside. 0 for casters of triangles.
@group(0) @binding(4) var<storage, read> twisted_lights: array<u32>;
@group(0) @binding(5) var<storage, read_write> choices: array<atomic<u32>>; // Choices of all casters, then their measures.
@group(0) @binding(6) var<storage, read_write> shadow_statistics: ShadowStatistics;
@group(0) @binding(7) var<storage, read> relevant_lights: array<u32>; // By batch and caster.

// Which values are finite. Tests bits, like `is_finite`.
fn are_finite(values: vec3<f32>) -> vec3<bool> {
  let infinite = vec3<u32>(0x7f800000u);
  return (bitcast<vec3<u32>>(values) & infinite) != infinite;
}

// Whether the box may meet the box around the near rectangle, in the camera frame. Along an axis whose numbers overflow it
// may.
fn can_meet_near_rectangle(view: ShadowView, low: vec3<f32>, high: vec3<f32>) -> bool {
  for (var axis = 0u; axis < 3u; axis++) {
    let row = view.placement[axis];
    let ends = vec2<f32>(
      dot_3(min(row.xyz * low, row.xyz * high), vec3<f32>(1.0)),
      dot_3(max(row.xyz * low, row.xyz * high), vec3<f32>(1.0)));
    let terms = dot_3(abs(row.xyz), max(abs(low), abs(high))) + abs(row.w);
    let slack = SLACK * max(terms, max(abs(view.near_min[axis]), abs(view.near_max[axis])));
    let below = ends.x + row.w - slack;
    let above = ends.y + row.w + slack;
    if (is_finite(vec3<f32>(below, above, slack)) && (below > view.near_max[axis] || above < view.near_min[axis])) {
      return false;
    }
  }
  return true;
}

// Whether the light may be in the box. False for a light at infinity. Values are multiplied by w, which is at most 1. Along
// an axis whose numbers overflow the light may be in the box.
fn can_contain_light(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  let w = light.light.w;
  let slack = SLACK * max(max(abs(w * low), abs(w * high)), abs(light.light.xyz));
  let below = w * low - slack;
  let above = w * high + slack;
  return w > 0.0 && all((below <= light.light.xyz) | !are_finite(below)) &&
    all((above >= light.light.xyz) | !are_finite(above));
}

// Whether the whole box is certainly outside one plane of the pyramid of light and near rectangle.
fn is_outside_pyramid(view: ShadowView, light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  var outside = vec4<bool>(true);
  var outside_near = true;
  for (var index = 0u; index < 8u; index++) {
    let planes = pyramid_planes(view, light, box_corner(low, high, index));
    outside = outside & are_negative(planes.side_heights, planes.side_terms);
    outside_near = outside_near && is_negative(planes.depth, planes.depth_terms);
  }
  return any(outside) || outside_near;
}

const LARGEST_HEIGHT: f32 = 3.4028234663852886e38; // The largest f32.

// `ShadowLight::frustum_near`, for ZP+ as published. Nothing of the caster lies before the near end of the frustum, unless
// the least value below is farther. For a point light it is the distance of the caster over that of the farthest point of
// the near rectangle. For a light at infinity it is the height of the caster over the near plane, on the light's side.
fn frustum_near_end(view: ShadowView, light: ShadowLight, scale: f32, low: vec3<f32>, high: vec3<f32>) -> f32 {
  if (light.light.w > 0.0) {
    let light_position = to_camera_frame(view, light.light.xyz / light.light.w);
    let farthest = vector_length(max(abs(view.near_min - light_position), abs(view.near_max - light_position)));
    // Above 0 for lights in the box, which the paper does not treat: else nothing would be clipped at the near plane. Below
    // 1 for casters beyond the near rectangle, of which nothing is in the frustum. The least where overflow gives no number.
    let share = scale * distance_lower_bound(light, low, high) / farthest;
    let is_number = (bitcast<u32>(share) & 0x7fffffffu) <= 0x7f800000u;
    return select(0.001, clamp(share, 0.001, 0.99), is_number);
  }
  var highest = 0.0;
  for (var index = 0u; index < 8u; index++) {
    let position = box_corner(low, high, index);
    let height = dot_3(view.near_plane.xyz, to_camera_frame(view, position)) + view.near_plane.w;
    let above = light_side(light) * height + SLACK * height_terms(view, abs(to_camera_frame(view, position)));
    // A height that overflows may be any.
    highest = select(LARGEST_HEIGHT, max(highest, above), is_finite(vec3<f32>(above)));
  }
  return select(1.0, highest, highest > 0.0);
}

// Whether a polygon of the caster is twisted for a light. Such a polygon is excluded, so the caster is not closed.
fn has_twisted_polygon(caster: u32, light_index: u32) -> bool {
  return ((twisted_lights[caster_part(caster, 7u).y * shape.batches + light_index / 32u] >> (light_index % 32u)) & 1u) != 0u;
}

// The light with the choices that the caster's box allows, `low` to `high`, in the space of its positions. `scale` is at
// most the smallest factor by which the caster's matrix scales lengths: distances times `scale` are lower bounds in world
// space.
fn choose_by_box(
  view: ShadowView,
  given: ShadowLight,
  scale: f32,
  flags: u32,
  low: vec3<f32>,
  high: vec3<f32>,
  has_holes: bool,
  has_twisted: bool,
) -> ShadowLight {
  var light = given;
  light.casting = CAST_NOTHING;
  light.counting = COUNT_Z_PASS;
  light.end = 0.0;
  light.excludes = 0u;
  if (shape.cull_by_range != 0u && is_out_of_range(light, scale, low, high)) {
    atomicAdd(&shadow_statistics.culled_by_range, 1u);
    return light;
  }
  if (shape.cull_by_view != 0u && is_volume_outside_view(view, light, low, high)) {
    return light;
  }
  let is_light_inside = can_contain_light(light, low, high);
  // A light in the box may be in the plane of a face. Facing would tell, but this stage does not wait for it. With the light
  // outside the box such a face does no harm, excluded or not.
  light.excludes = select(0u, 1u, has_holes || has_twisted || is_light_inside || (flags & EXCLUDES) != 0u);
  // Back-facing faces suffice for a closed caster if light and eye are outside it. A caster with holes is not closed.
  // docs/numerics/casting-faces.md, "Which faces cast".
  let is_closed = shape.allow_back_facing != 0u && (flags & CLOSED) != 0u && (flags & PROXY) == 0u;
  let is_outside = !can_meet_near_rectangle(view, low, high) && !is_light_inside;
  light.casting = select(CAST_EVERY, CAST_BACK_FACING, is_closed && !has_holes && !has_twisted && is_outside);
  light.counting = shape.counting;
  if (shape.counting == COUNT_ZP_PLUS_2005) {
    light.frustum_near = frustum_near_end(view, light, scale, low, high);
    // The published method does not treat excluded faces, or casters that are not in the depth buffer.
    light.counting = select(COUNT_ZP_PLUS_2005, COUNT_Z_FAIL, light.excludes != 0u || (flags & PROXY) != 0u);
  }
  if (shape.counting == COUNT_AUTO) {
    light.counting = select(COUNT_ZP_PLUS, COUNT_Z_PASS, is_outside_pyramid(view, light, low, high));
  }
  // Near caps assume a volume to infinity, so volumes that ZP+ counts do not end.
  let can_end = light.counting == COUNT_Z_PASS || light.counting == COUNT_Z_FAIL;
  if (can_end && shape.end_at_range != 0u && light.range > 0.0 && light.light.w > 0.0) {
    // A volume whose end is not finite does not end.
    let end = scale * distance_lower_bound(light, low, high) / light.range;
    light.end = select(0.0, min(end, 1.0), is_finite(vec3<f32>(end)));
  }
  return light;
}

// Where `choices` has those of a caster for a light and a view.
struct ChoiceWords {
  choices_offset: u32, // The caster's words.
  group_offset: u32, // The words of the first caster of its group.
  measures_offset: u32,
  light_mask: u32, // The light's bit of each word.
}

fn choice_words(caster: u32, light_index: u32, view_index: u32) -> ChoiceWords {
  let batch = light_index / 32u;
  return ChoiceWords(
    CHOICE_WORDS * choice_index(caster, batch, view_index),
    CHOICE_WORDS * choice_index(first_caster_of_group(caster), batch, view_index),
    CHOICE_WORDS * shape.views * shape.batches * shape.casters + 2u * measure_index(caster, light_index, view_index),
    1u << (light_index % 32u));
}

// Clears earlier choices. A caster that did not cast has none. Measures stay: they have a meaning only if the caster casts.
fn clear_choices(words: ChoiceWords) {
  if ((atomicLoad(&choices[words.choices_offset + CHOICE_CASTS]) & words.light_mask) == 0u) {
    return;
  }
  // Turns: 8.
  for (var word = CHOICE_CASTS; word <= CHOICE_EXCLUDES; word++) {
    atomicAnd(&choices[words.choices_offset + word], ~words.light_mask);
  }
}

// Counts cached choices in the statistics.
fn count_cached_choices(words: ChoiceWords) {
  if ((atomicLoad(&choices[words.choices_offset + CHOICE_CASTS]) & words.light_mask) == 0u) {
    atomicAdd(&shadow_statistics.skipped, 1u);
    return;
  }
  if ((atomicLoad(&choices[words.choices_offset + CHOICE_EVERY_FACE]) & words.light_mask) != 0u) {
    atomicAdd(&shadow_statistics.every_face, 1u);
  }
  if (has_measures() && bitcast<f32>(atomicLoad(&choices[words.measures_offset])) > 0.0) {
    atomicAdd(&shadow_statistics.ended, 1u);
  }
}

// The light with the choices for a caster with a finite face. `entry`: the light and view in `view_lights`. Receivers may
// cull the volume, or end it.
fn chosen_light(caster: u32, light_index: u32, entry: u32, bounding_box: CasterBox, has_twisted: bool) -> ShadowLight {
  let view = view_for_caster(caster, view_lights[entry].view);
  let scale = bitcast<f32>(caster_part(caster, 3u).w);
  let receivers_offset = view_lights[entry].version.y;
  var light = choose_by_box(
    view,
    light_for_caster(caster, view_lights[entry].light, light_index),
    scale,
    caster_flags(caster),
    bounding_box.low,
    bounding_box.high,
    bounding_box.has_holes,
    has_twisted);
  if (light.casting == CAST_NOTHING || receivers_offset == 0u) {
    return light;
  }
  if (is_volume_without_receivers(view, light, scale, bounding_box.low, bounding_box.high, receivers_offset)) {
    light.casting = CAST_NOTHING;
    atomicAdd(&shadow_statistics.culled_by_receivers, 1u);
  } else if (light.counting == COUNT_Z_PASS || light.counting == COUNT_Z_FAIL) {
    light.end = max(
      light.end,
      end_behind_receivers(view, light, scale, bounding_box.low, bounding_box.high, receivers_offset));
  }
  return light;
}

// Writes and counts the choices for a caster that casts. It only sets bits: `clear_choices` cleared those of the caster,
// `relist` those of its group. `does_exclude`: it has excluded faces, also if the light lies in the plane of none.
fn write_choices(words: ChoiceWords, light: ShadowLight, does_exclude: bool, has_twisted: bool) {
  let choices_offset = words.choices_offset;
  let light_mask = words.light_mask;
  if (light.end > 0.0) {
    atomicAdd(&shadow_statistics.ended, 1u);
  }
  atomicOr(&choices[choices_offset + CHOICE_CASTS], light_mask);
  if (light.casting == CAST_EVERY) {
    atomicOr(&choices[choices_offset + CHOICE_EVERY_FACE], light_mask);
    atomicAdd(&shadow_statistics.every_face, 1u);
  }
  if (light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005) {
    atomicOr(&choices[choices_offset + CHOICE_NEAR_CAP], light_mask);
  }
  if (has_twisted && light.counting == COUNT_ZP_PLUS) {
    // `caps` lists no near caps of pieces, so it cannot set this bit for them.
    atomicOr(&choices[choices_offset + CHOICE_LISTED_NEAR_CAP], light_mask);
  }
  if (light.excludes != 0u) {
    atomicOr(&choices[choices_offset + CHOICE_EXCLUDES], light_mask);
    atomicOr(&choices[words.group_offset + select(CHOICE_MAY_EXCLUDE, CHOICE_DOES_EXCLUDE, does_exclude)], light_mask);
  }
  if (has_measures()) {
    atomicStore(&choices[words.measures_offset], bitcast<u32>(light.end));
    atomicStore(&choices[words.measures_offset + 1u], bitcast<u32>(light.frustum_near));
  }
}

// Chooses for a caster, a light and a view, and writes the choices.
fn choose_for_light(caster: u32, light_index: u32, view_index: u32) {
  let words = choice_words(caster, light_index, view_index);
  let is_dirty = (atomicLoad(&choices[words.group_offset + CHOICE_DIRTY]) & words.light_mask) != 0u;
  let entry = view_index * shape.lights + light_index;
  // Entries of unused views are zeros, and so are those of lights that the view leaves out.
  let is_in_view = view_lights[entry].view.near_w != 0.0;
  if (is_dirty || !is_in_view) {
    clear_choices(words);
  }
  if (!is_in_view || (relevant_lights[light_index / 32u * shape.casters + caster] & words.light_mask) == 0u) {
    return;
  }
  if (!is_dirty) {
    count_cached_choices(words);
    return;
  }
  let bounding_box = caster_box(caster);
  var light: ShadowLight; // Casts nothing.
  var has_twisted = false;
  if (!bounding_box.is_empty) {
    has_twisted = has_twisted_polygon(caster, light_index);
    light = chosen_light(caster, light_index, entry, bounding_box, has_twisted);
  }
  if (light.casting == CAST_NOTHING) {
    atomicAdd(&shadow_statistics.skipped, 1u);
    return;
  }
  let does_exclude = bounding_box.has_holes || has_twisted || (caster_flags(caster) & EXCLUDES) != 0u;
  write_choices(words, light, does_exclude, has_twisted);
}

@compute @workgroup_size(64)
fn counting_methods(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // Turns: ITEMS.
  for (var pair = id.x; pair < shape.casters * shape.used_lights; pair += 64u * groups.x) {
    // Neighbouring invocations have the same light, so that they take the same branches.
    choose_for_light(pair % shape.casters, pair / shape.casters, id.y);
  }
}
