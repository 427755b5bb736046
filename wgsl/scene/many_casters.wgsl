// Casters of a scene, for the stages `facing`, `exact_facing`, `edges` and `clusters`: what interface/caster.wgsl tells, but
// for `take_faces` and `take_edges` (scene/walks.wgsl). extract/one_caster.wgsl and common/positions.wgsl have the same
// functions for a single mesh. The functions tell of the caster that was taken last: call `take_caster` or `face_in_slot`
// before any other. A caster has its lights one after the other, in the order of their bits in the batch (up to 32 lights): a
// light's place is its number among them. Only lights that `reach` wrote to `taken` are computed, and bits of all others must
// stay (`renewed`, `cleared`). For `edges` another array of `reach` is bound as `taken`: `lit`, the lights that matter to each
// caster. A slot is the index of a face or edge in the masks of the group.

#import common/casters
#import scene/table

@group(0) @binding(2) var<storage, read> positions: array<u32>;
// For each batch and caster the lights that the stage takes; `reach` writes it.
@group(0) @binding(3) var<storage, read> taken: array<u32>;

struct Item {
  exists: bool,
  slot: u32, // Its index in the masks.
  index: u32, // Its index in the page.
}

// The caster of the face or edge record at hand. `of_faces`: its first face slot, their number, the first face in the page, the
// word of vertex 0. `of_edges`: the same of edge records; w: words from one vertex to the next. `matter`: the bits of `lights`
// that are taken.
var<private> caster: u32;
var<private> flags: u32;
var<private> of_faces: vec4<u32>;
var<private> of_edges: vec4<u32>;
var<private> lights: CasterLights;
var<private> matter: u32;
// `decided`: lights for which all faces of the cluster have the same bit. `decided_facing`: those of them that the faces face.
// `tested`: the places of the lights that are tested for each face.
var<private> decided: u32;
var<private> decided_facing: u32;
var<private> tested: u32;

// Makes a caster the one at hand, with nothing decided for its faces.
fn take_caster(index: u32) {
  caster = index;
  flags = caster_part(caster, 4u).w;
  of_faces = caster_part(caster, 5u);
  of_edges = caster_part(caster, 6u);
  lights = caster_lights(caster, group.batch);
  matter = taken[group.batch * group.casters + caster];
  decided = 0u;
  decided_facing = 0u;
  tested = 0xffffffffu;
}

fn face_slots() -> u32 { return CHUNK * group.face_chunks; }

// The face in a slot, unless the slot is beyond the faces of its caster or no light of the caster is taken.
fn face_in_slot(slot: u32) -> Item {
  take_caster(caster_of(group.face_chunks_at, slot / CHUNK));
  let number = slot - of_faces.x;
  return Item(number < of_faces.y && matter != 0u, slot, of_faces.z + number);
}

// Whether faces that are not finite are counted here: in the first batch that takes a light of the caster.
fn counts_non_finite() -> bool {
  // Turns: 31.
  for (var batch = 0u; batch < group.batch; batch++) {
    if (taken[batch * group.casters + caster] != 0u) {
      return false;
    }
  }
  return true;
}

fn position_offset() -> u32 { return of_faces.w; }
fn position_stride() -> u32 { return of_edges.w; }
fn light_places() -> u32 { return countOneBits(lights.allowed); }
fn given_light(place: u32) -> vec4<u32> { return table[lights.first + 2u * min(place, light_places() - 1u)]; }
fn scaled_bits(place: u32) -> vec4<u32> { return table[lights.first + 2u * min(place, light_places() - 1u) + 1u]; }
fn scaled_light(place: u32) -> vec4<f32> { return bitcast<vec4<f32>>(scaled_bits(place)); }

// The same value as `LightBatch::new` in src/light_batch.rs has for it.
fn inexact_w(place: u32) -> f32 {
  let w = scaled_bits(place).w & 0x7fffffffu;
  let is_zero = (given_light(place).w & 0x7fffffffu) == 0u;
  // The bits of 2^-60.
  if (!is_zero && w < 0x21800000u) {
    return 0x1p-36;
  }
  return select(bitcast<f32>(w), 0.0, is_zero || (w & 0x7fffffu) == 0u);
}

fn lights_reach() -> vec2<f32> { return lights.reach; }
fn live_lights() -> u32 { return matter; }

// A mask with new bits, or without any, for the lights that are taken.
fn renewed(mask: u32, bits: u32) -> u32 { return (mask & ~matter) | (bits & ~decided) | decided_facing; }
fn cleared(mask: u32) -> u32 { return mask & ~matter; }

fn tested_places() -> u32 { return tested; }
fn excluded_are_old() -> bool { return (flags & GIVEN) == 0u; }
fn live_places() -> u32 { return places_of(matter); }

// The bits of the places of some lights.
fn places_of(bits: u32) -> u32 {
  var places = 0u;
  var place = 0u;
  // Turns: LIGHTS.
  for (var rest = lights.allowed; rest != 0u; rest &= rest - 1u) {
    places |= ((bits >> firstTrailingBit(rest)) & 1u) << place;
    place++;
  }
  return places;
}

// The bits of the lights at some places, as far as they are taken.
fn lights_at(places: u32) -> u32 {
  // Most casters have the first lights, so that places are bits.
  if ((lights.allowed & (lights.allowed + 1u)) == 0u) {
    return places & matter;
  }
  var bits = 0u;
  var left = places;
  // Turns: LIGHTS.
  for (var rest = lights.allowed; rest != 0u; rest &= rest - 1u) {
    bits |= (left & 1u) << firstTrailingBit(rest);
    left >>= 1u;
  }
  return bits & matter;
}

fn position_bits(vertex: u32, offset: u32, stride: u32) -> vec3<u32> {
  let word = offset + vertex * stride;
  return vec3<u32>(positions[word], positions[word + 1u], positions[word + 2u]);
}
