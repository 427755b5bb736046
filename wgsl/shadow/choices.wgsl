// What was chosen for casters: words for each batch of lights and view, with a bit for each light.
//
// Expects: `shape`, and `table`, the table of casters, for lights as casters choose for them.

#import common/casters
#import shadow/caster
#import shadow/shadow

// The place of a caster's choices for a batch and a view: eight words, each with a bit for each light of the batch.
fn choices_of(caster: u32, batch: u32, view: u32) -> u32 {
  return (view * shape.batches + batch) * shape.casters + caster;
}

// Which words. A light for which a caster casts is in the first.
const CASTS: u32 = 0u;
// Every face casts. If not set, averted ones do.
const EVERY: u32 = 1u;
// The near cap may be needed.
const NEAR: u32 = 2u;
// The near cap has faces.
const CAPPED: u32 = 3u;
// Faces may be excluded.
const EXCLUDES: u32 = 4u;
// In the words of the first caster of a group: some caster has excluded faces if any light is in the plane of a face, or has
// some in any case. Then sides are not among the silhouettes alone.
const MAY_EXCLUDE: u32 = 5u;
const DOES_EXCLUDE: u32 = 6u;
// Likewise, of a scene: the lists for the view are made anew. All that was chosen for other lights stays.
const FRESH: u32 = 7u;
const CHOICE_WORDS: u32 = 8u;

// The place of a caster's two measures for a light and a view: the end of the volume, and the near end of the light's
// frustum.
fn measures_of(caster: u32, light: u32, view: u32) -> u32 {
  return (view * shape.lights + light) * shape.casters + caster;
}

fn has_measures() -> bool {
  return shape.end_at_range != 0u || shape.has_receivers != 0u || shape.counting == COUNT_ZP_PLUS_2005;
}

// The light with the choices for a caster, whose first words are `first` and the next `excludes`. `near`: near caps are
// needed.
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

// ==== shadow/chosen
// Choices of casters, as stages read them once all are made: from the table.

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
fn is_counted(caster: u32, count_batch: u32) -> bool {
  return !MANY || caster % shape.count_batches == count_batch;
}

// ==== shadow/casting
// Tells which faces cast, what their caps count, and where they are listed.

fn casts(light: ShadowLight, facing: bool) -> bool {
  return light.casting == CAST_EVERY || (light.casting == CAST_AVERTED && !facing);
}

fn has_near_cap(light: ShadowLight) -> bool {
  return light.counting == COUNT_ZP_PLUS || light.counting == COUNT_ZP_PLUS_2005;
}

// Whether there are caps besides near caps: with z-fail, where the volume ends at the range, and where the caster is not in
// the depth buffer, so that the eye sees through its faces. A volume that ends behind all receivers needs no dark cap.
fn has_far_caps(light: ShadowLight, flags: u32) -> bool {
  return light.counting == COUNT_Z_FAIL || (light.end > 0.0 && shape.end_at_range != 0u) || (flags & PROXY) != 0u;
}

// A light has four lists of cap faces: near caps of both classes in one run, from the front and from the back, and other
// caps of both classes in another run. Caps of the first class count up where their front is seen, those of the second
// where their back is. A matrix that mirrors turns all faces.
const CAP_COUNTS: u32 = 128u;
const FAR: u32 = 2u;

// On the near plane the front of a face that faces the light is seen if the light is on the eye's side.
fn near_kind(light: ShadowLight, facing: bool, mirrored: bool) -> u32 {
  let turned = light_side(light) > 0.0;
  return select(0u, 1u, (facing == turned) != mirrored);
}

fn far_kind(facing: bool, mirrored: bool) -> u32 {
  return FAR + select(0u, 1u, facing == mirrored);
}

fn cap_capacity(kind: u32) -> u32 {
  return select(shape.near_capacity, shape.far_capacity, kind >= FAR);
}

fn cap_place(bit: u32, kind: u32, place: u32) -> u32 {
  let run = CAP_COUNTS + bit * (shape.near_capacity + shape.far_capacity) + select(0u, shape.near_capacity, kind >= FAR);
  return run + select(place, cap_capacity(kind) - 1u - place, (kind & 1u) != 0u);
}
