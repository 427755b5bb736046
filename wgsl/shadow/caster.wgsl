// Casters, as the stages of shadow volumes find them in the table. It begins with the casters, eight vec4s each
// (`SceneCaster`).

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

fn first_of_group(caster: u32) -> u32 {
  if (!MANY) {
    return 0u;
  }
  return caster_part(caster, 7u).z;
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
