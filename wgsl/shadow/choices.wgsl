// The choices of `counting_methods` for each caster, light and view: the faces that cast, the counting method, near
// caps, the end of the volume. Eight words for each view, light batch and caster have one bit a light. Two measures for
// each view, light and caster follow behind all of them. `relist`, `counting_methods`, `zp_plus_2005_cases` and `caps`
// write them, in this order. They are then copied into the scene table, from which `list_sides`, all later stages and
// the draws read them. Sides and caps of a volume must read the same choices, or the volume is not closed.
//
// Expects: `shape`, and `table`, the scene table, which has the choices once all are made.

#import shadow/shadow

// The index of a caster's choices for a batch and a view. They begin at word CHOICE_WORDS times the index.
fn choice_index(caster: u32, batch: u32, view: u32) -> u32 {
  return (view * shape.batches + batch) * shape.casters + caster;
}

// The eight words of a caster's choices. Each has one bit a light.
const CHOICE_CASTS: u32 = 0u; // The caster casts.
const CHOICE_EVERY_FACE: u32 = 1u; // Every face casts. If not set, back-facing faces do.
const CHOICE_NEAR_CAP: u32 = 2u; // The volume may need near caps.
// The volume has near caps: `caps` has listed one, or pieces of polygons may have one.
const CHOICE_LISTED_NEAR_CAP: u32 = 3u;
const CHOICE_EXCLUDES: u32 = 4u; // The caster may have excluded faces.
// Only in the words of the first caster of a group: a caster of it has excluded faces (DOES), or has some if the light lies in
// the plane of a face (MAY). Sides may then lie at edges that are no silhouettes.
const CHOICE_MAY_EXCLUDE: u32 = 5u;
const CHOICE_DOES_EXCLUDE: u32 = 6u;
// Only in the words of the first caster of a group: the lists for the view are dirty. Choices for other lights are cached.
const CHOICE_DIRTY: u32 = 7u;
const CHOICE_WORDS: u32 = 8u;

// The index of a caster's two measures for a light and a view: the end of the volume, and the near end of the light's
// frustum.
fn measure_index(caster: u32, light_index: u32, view: u32) -> u32 {
  return (view * shape.lights + light_index) * shape.casters + caster;
}

// Whether any stage reads measures. If not, none are written. `choice_bytes` (src/gpu/shadow/sizes.rs) has room by the same
// rule. A caster that does not cast has stale measures.
fn has_measures() -> bool {
  return shape.end_at_range != 0u || shape.has_receivers != 0u || shape.counting == COUNT_ZP_PLUS_2005;
}

// The light with the choices for a caster, except for the measures. `words` are the caster's words 0 to 3, of which it reads
// two, `excludes` is CHOICE_EXCLUDES. `bit`: the light's bit in these and in `near_caps`, where it is 1 if the volume may have
// near caps.
fn with_choices(light: ShadowLight, bit: u32, words: vec4<u32>, excludes: u32, near_caps: u32) -> ShadowLight {
  var result = light;
  result.casting = CAST_NOTHING;
  result.counting = COUNT_Z_PASS;
  result.excludes = 0u;
  if (((words[CHOICE_CASTS] >> bit) & 1u) == 0u) {
    return result;
  }
  result.casting = select(CAST_BACK_FACING, CAST_EVERY, ((words[CHOICE_EVERY_FACE] >> bit) & 1u) != 0u);
  result.excludes = (excludes >> bit) & 1u;
  let has_near_cap = ((near_caps >> bit) & 1u) != 0u;
  if (shape.counting == COUNT_ZP_PLUS_2005) {
    result.counting = select(COUNT_Z_FAIL, COUNT_ZP_PLUS_2005, has_near_cap);
  } else if (shape.counting == COUNT_Z_FAIL) {
    result.counting = COUNT_Z_FAIL;
  } else if (has_near_cap) {
    result.counting = COUNT_ZP_PLUS;
  }
  return result;
}

// Four of the eight words of a caster's choices, from the table: words 0 to 3 (`part` 0) or 4 to 7 (`part` 1).
fn choice_part(caster: u32, batch: u32, view: u32, part: u32) -> vec4<u32> {
  return table[shape.choices_offset + 2u * choice_index(caster, batch, view) + part];
}

// The words of the first caster of a group that hold for all its casters: CHOICE_MAY_EXCLUDE, CHOICE_DOES_EXCLUDE and
// CHOICE_DIRTY.
struct GroupChoices {
  may_exclude: u32,
  does_exclude: u32,
  dirty: u32,
}

// The choices for the group of casters in `shape`, a batch and a view, from the table.
fn group_choices(batch: u32, view: u32) -> GroupChoices {
  let words = choice_part(shape.first_caster, batch, view, 1u);
  return GroupChoices(words.y, words.z, words.w); // Words 5 to 7.
}

// The light with all choices for a caster and a view, from the table.
fn with_stored_choices(caster: u32, light: ShadowLight, light_index: u32, view: u32) -> ShadowLight {
  let words = choice_part(caster, light_index / 32u, view, 0u);
  let excludes = choice_part(caster, light_index / 32u, view, 1u).x;
  // ZP+ as published has CHOICE_NEAR_CAP alone: where that is not set, z-fail counts.
  let near_caps = select(
    words[CHOICE_NEAR_CAP] & words[CHOICE_LISTED_NEAR_CAP],
    words[CHOICE_NEAR_CAP],
    shape.counting == COUNT_ZP_PLUS_2005);
  var result = with_choices(light, light_index % 32u, words, excludes, near_caps);
  result.end = 0.0;
  if (has_measures()) {
    let index = measure_index(caster, light_index, view);
    let pair = table[shape.measures_offset + index / 2u];
    let measures = bitcast<vec2<f32>>(select(pair.xy, pair.zw, (index & 1u) != 0u));
    result.end = measures.x;
    result.frustum_near = measures.y;
  }
  return result;
}

// Whether a caster is in a count batch: the casters that the stencil counts together.
fn is_in_count_batch(caster: u32, count_batch: u32) -> bool { return caster % shape.count_batches == count_batch; }
