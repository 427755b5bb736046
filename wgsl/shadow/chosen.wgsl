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
