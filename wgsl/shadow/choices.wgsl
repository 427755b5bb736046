// Choices: what `choose` chose for each caster, light and view, as nearly all stages of shadow volumes read it: which faces cast,
// how shadows are counted, whether near caps are needed, where the volume ends. A batch is up to 32 lights. For each view, batch
// and caster there are eight words with a bit for each light; behind all of them, two measures for each view, light and caster.
// `relist`, `choose`, `zp_plus_2005_cases` and `caps` write them, in this order. For the stages from `list_sides` on and for
// draws they are copied into the table. Sides and caps of a volume must read the same choices, or it does not close.
//
// Expects: `shape`, and `table`, the table of casters, which has the choices once all are made.

#import shadow/shadow

// The place of a caster's choices for a batch and a view.
fn choices_of(caster: u32, batch: u32, view: u32) -> u32 {
  return (view * shape.batches + batch) * shape.casters + caster;
}

// Which words.
const CASTS: u32 = 0u; // The caster casts.
const EVERY: u32 = 1u; // Every face casts. If not set, averted ones do.
const NEAR: u32 = 2u; // The near cap may be needed.
const CAPPED: u32 = 3u; // The near cap has faces.
const EXCLUDES: u32 = 4u; // Faces may be excluded.
// In the words of the first caster of a group: some caster has excluded faces if any light is in the plane of a face, or has
// some in any case. Then sides are not among the silhouettes alone.
const MAY_EXCLUDE: u32 = 5u;
const DOES_EXCLUDE: u32 = 6u;
// Likewise: the lists for the view are made anew. All that was chosen for other lights stays.
const FRESH: u32 = 7u;
const CHOICE_WORDS: u32 = 8u;

// The place of a caster's two measures for a light and a view: the end of the volume, and the near end of the light's frustum.
fn measures_of(caster: u32, light: u32, view: u32) -> u32 {
  return (view * shape.lights + light) * shape.casters + caster;
}

// Whether measures are written and read at all.
fn has_measures() -> bool {
  return shape.end_at_range != 0u || shape.has_receivers != 0u || shape.counting == COUNT_ZP_PLUS_2005;
}

// The light with the choices for a caster, whose words from CASTS on are `first` and whose word EXCLUDES is `excludes`, for the
// light's `bit` of them. Bits of `near` say that the caster has a near cap. The end of the volume stays as it was.
fn with_choices(light: ShadowLight, bit: u32, first: vec4<u32>, excludes: u32, near: u32) -> ShadowLight {
  var own = light;
  own.casting = CAST_NOTHING;
  own.counting = COUNT_Z_PASS;
  own.excludes = 0u;
  if (((first[CASTS] >> bit) & 1u) == 0u) {
    return own;
  }
  own.casting = select(CAST_AVERTED, CAST_EVERY, ((first[EVERY] >> bit) & 1u) != 0u);
  own.excludes = (excludes >> bit) & 1u;
  let has_near_cap = ((near >> bit) & 1u) != 0u;
  if (shape.counting == COUNT_ZP_PLUS_2005) {
    own.counting = select(COUNT_Z_FAIL, COUNT_ZP_PLUS_2005, has_near_cap);
  } else if (shape.counting == COUNT_Z_FAIL) {
    own.counting = COUNT_Z_FAIL;
  } else if (has_near_cap) {
    own.counting = COUNT_ZP_PLUS;
  }
  return own;
}

// Four words of a caster's choices, from the table: `part` 0 or 1.
fn choice_part(caster: u32, batch: u32, view: u32, part: u32) -> vec4<u32> {
  return table[shape.choices_at + 2u * choices_of(caster, batch, view) + part];
}

// A light with all that was chosen for it and a caster.
fn chosen_light(caster: u32, light: ShadowLight, number: u32, view: u32) -> ShadowLight {
  let first = choice_part(caster, number / 32u, view, 0u);
  let excludes = choice_part(caster, number / 32u, view, 1u).x;
  // With ZP+ as published a caster has a near cap wherever z-fail does not count it.
  let near = select(first[NEAR] & first[CAPPED], first[NEAR], shape.counting == COUNT_ZP_PLUS_2005);
  var own = with_choices(light, number % 32u, first, excludes, near);
  own.end = 0.0;
  if (has_measures()) {
    let at = measures_of(caster, number, view);
    let words = table[shape.measures_at + at / 2u];
    let measures = bitcast<vec2<f32>>(select(words.xy, words.zw, (at & 1u) != 0u));
    own.end = measures.x;
    own.frustum_near = measures.y;
  }
  return own;
}

// Whether a caster is in a batch of casters that are counted together.
fn is_counted(caster: u32, count_batch: u32) -> bool { return caster % shape.count_batches == count_batch; }
