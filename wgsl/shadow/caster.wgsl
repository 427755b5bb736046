// Casters, as the stages of shadow volumes find them in the table, and what was chosen for them. The table begins with the
// casters, eight vec4s each (`SceneCaster`).

// Whether there may be several casters. If not, all slots are those of the first caster, which is in world space.
override MANY: bool = false;

fn caster_part(caster: u32, part: u32) -> vec4<u32> {
  return table[8u * caster + part];
}

fn caster_flags(caster: u32) -> u32 {
  return caster_part(caster, 4u).w;
}

// Faces: the first slot, their number, the first in the page, and the word of vertex 0 in the bound positions.
fn face_run(caster: u32) -> vec4<u32> {
  return caster_part(caster, 5u);
}

// Edge records: the first slot, their number, the first in the page, and the words from one vertex to the next.
fn edge_run(caster: u32) -> vec4<u32> {
  return caster_part(caster, 6u);
}

// The caster of a slot. `chunks_at` is where the casters of the chunks begin in the table.
fn caster_of(chunks_at: u32, slot: u32) -> u32 {
  if (!MANY) {
    return 0u;
  }
  let chunk = slot / CHUNK;
  return table[chunks_at + chunk / 4u][chunk % 4u];
}

// The camera as a caster sees it: the placement is that of its positions.
fn view_of(caster: u32, view: ShadowView) -> ShadowView {
  if (!MANY) {
    return view;
  }
  let x = bitcast<vec4<f32>>(caster_part(caster, 0u));
  let y = bitcast<vec4<f32>>(caster_part(caster, 1u));
  let z = bitcast<vec4<f32>>(caster_part(caster, 2u));
  var own = view;
  own.placement = array<vec4<f32>, 3>(
    vec4<f32>(x.xyz, x.w + view.placement[0].w),
    vec4<f32>(y.xyz, y.w + view.placement[1].w),
    vec4<f32>(z.xyz, z.w + view.placement[2].w));
  return own;
}

// The light as a caster sees it: in the space of its positions.
fn light_of(caster: u32, light: ShadowLight, number: u32) -> ShadowLight {
  if (!MANY || (caster_flags(caster) & RIGID) == 0u) {
    return light;
  }
  // The bits of the caster's lights in the batch, and where they begin.
  let lights = table[shape.lights_at + number / 32u * shape.casters + caster];
  let place = countOneBits(lights.x & ((1u << (number % 32u)) - 1u));
  let given = bitcast<vec4<f32>>(table[lights.y + 2u * place]);
  var own = light;
  own.light = vec4<f32>(given.xyz * light.scale, light.light.w);
  return own;
}

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
// In the words of the first caster: some caster has excluded faces if any light is in the plane of a face, or has some in any
// case. Then sides are not among the silhouettes alone.
const MAY_EXCLUDE: u32 = 5u;
const DOES_EXCLUDE: u32 = 6u;
const CHOICE_WORDS: u32 = 8u;

// The place of a caster's two measures for a light and a view: the end of the volume, and the near end of the light's
// frustum.
fn measures_of(caster: u32, light: u32, view: u32) -> u32 {
  return (view * shape.lights + light) * shape.casters + caster;
}

fn has_measures() -> bool {
  return shape.end_at_range != 0u || shape.counting == COUNT_ZP_PLUS_2005;
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
