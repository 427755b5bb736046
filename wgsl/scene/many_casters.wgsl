// The casters of a scene: implements interface/caster.wgsl for the SCENE variants of `facing`, `exact_facing` and `edges`,
// but for the loops over chunks (scene/listed_chunks.wgsl). `clusters` imports it, too. Functions refer to the caster loaded
// last: call `load_caster` or `load_face` first. The table has the lights of a caster one after the other, in the order of
// their bits. A light index is a light's rank among them. Only active lights are computed; the bits of other lights, cached
// or not relevant, must not change (`updated_bits`, `clear_active`). `cull_lights` writes the active lights.

#import common/casters
#import scene/table

@group(0) @binding(2) var<storage, read> positions: array<u32>;
// The active lights of each batch and caster. `edges` binds the relevant lights instead, since a dirty list has the edges of
// all casters.
@group(0) @binding(3) var<storage, read> active_lights: array<u32>;

struct Item {
  exists: bool,
  slot: u32, // Its index in the masks.
  index: u32, // Its index in the page.
}

// The loaded caster.
var<private> caster: u32;
var<private> caster_flags: u32;
// x: first face slot; y: number of faces; z: index of the first face in the page; w: word of vertex 0 in `positions`.
var<private> face_range: vec4<u32>;
// x: first edge slot; y: number of edge records; z: index of the first record in the page; w: words from vertex to vertex.
var<private> edge_range: vec4<u32>;
var<private> lights: CasterLights;
var<private> first_lights: mat4x4<f32>; // The first four scaled lights, loaded by `process_face_chunk` only.
var<private> active_mask: u32; // The bits of the active lights.
// `decided`: lights for which all faces of the cluster have the same facing. `decided_facing`: those of them that the
// cluster faces. `tested`: the index mask of lights that need a test for each face.
var<private> decided: u32;
var<private> decided_facing: u32;
var<private> tested: u32;

// Loads a caster. No light is decided for its faces.
fn load_caster(index: u32) {
  caster = index;
  caster_flags = caster_part(caster, 4u).w;
  face_range = caster_part(caster, 5u);
  edge_range = caster_part(caster, 6u);
  lights = caster_lights(caster, group.batch);
  active_mask = active_lights[group.batch * group.casters + caster];
  decided = 0u;
  decided_facing = 0u;
  tested = 0xffffffffu;
}

fn face_slots() -> u32 { return CHUNK * group.face_chunks; }

// The face in a slot. There is none past the last face of the caster, or if the caster has no active light.
fn load_face(slot: u32) -> Item {
  load_caster(caster_of(group.face_chunks_offset, slot / CHUNK));
  let face = slot - face_range.x;
  return Item(face < face_range.y && active_mask != 0u, slot, face_range.z + face);
}

// The statistics count faces that are not finite once, in the first batch in which the caster has an active light.
fn is_first_active_batch() -> bool {
  // Turns: 31.
  for (var batch = 0u; batch < group.batch; batch++) {
    if (active_lights[batch * group.casters + caster] != 0u) {
      return false;
    }
  }
  return true;
}

fn position_offset() -> u32 { return face_range.w; }
fn position_stride() -> u32 { return edge_range.w; }
fn light_count() -> u32 { return countOneBits(lights.allowed); }
fn given_light(light_index: u32) -> vec4<u32> { return table[lights.first + 2u * min(light_index, light_count() - 1u)]; }
fn scaled_bits(light_index: u32) -> vec4<u32> {
  return table[lights.first + 2u * min(light_index, light_count() - 1u) + 1u];
}
fn scaled_light(light_index: u32) -> vec4<f32> { return bitcast<vec4<f32>>(scaled_bits(light_index)); }

fn load_four_lights(first: u32) -> mat4x4<f32> {
  return mat4x4<f32>(
    scaled_light(first), scaled_light(first + 1u), scaled_light(first + 2u), scaled_light(first + 3u));
}

// The first four are loaded once for all faces of a chunk.
fn four_lights(first: u32) -> mat4x4<f32> {
  if (first == 0u) {
    return first_lights;
  }
  return load_four_lights(first);
}

// `LightBatch::new` (src/light_batch.rs) computes the same value.
fn inexact_w(light_index: u32) -> f32 {
  let w = scaled_bits(light_index).w & 0x7fffffffu;
  let is_zero = (given_light(light_index).w & 0x7fffffffu) == 0u;
  // The bits of 2^-60.
  if (!is_zero && w < 0x21800000u) {
    return 0x1p-36;
  }
  return select(bitcast<f32>(w), 0.0, is_zero || (w & 0x7fffffu) == 0u);
}

fn light_magnitudes() -> vec2<f32> { return lights.magnitudes; }
fn active_bits() -> u32 { return active_mask; }
fn updated_bits(mask: u32, bits: u32) -> u32 { return (mask & ~active_mask) | (bits & ~decided) | decided_facing; }
fn clear_active(mask: u32) -> u32 { return mask & ~active_mask; }

fn tested_indices() -> u32 { return tested; }
fn has_stale_exclusions() -> bool { return (caster_flags & GROUP_EXCLUDES) == 0u; }
fn active_indices() -> u32 { return indices_of_lights(active_mask); }

// The index mask of lights given by their bits.
fn indices_of_lights(bits: u32) -> u32 {
  var index_mask = 0u;
  var light_index = 0u;
  // Turns: LIGHTS.
  for (var remaining = lights.allowed; remaining != 0u; remaining &= remaining - 1u) {
    index_mask |= ((bits >> firstTrailingBit(remaining)) & 1u) << light_index;
    light_index++;
  }
  return index_mask;
}

// The bits of the active lights of an index mask.
fn lights_of_indices(index_mask: u32) -> u32 {
  // Most casters have the first lights of the batch. Then indices and bits are equal.
  if ((lights.allowed & (lights.allowed + 1u)) == 0u) {
    return index_mask & active_mask;
  }
  var bits = 0u;
  var remaining_indices = index_mask;
  // Turns: LIGHTS.
  for (var remaining = lights.allowed; remaining != 0u; remaining &= remaining - 1u) {
    bits |= (remaining_indices & 1u) << firstTrailingBit(remaining);
    remaining_indices >>= 1u;
  }
  return bits & active_mask;
}

fn position_bits(vertex: u32, offset: u32, stride: u32) -> vec3<u32> {
  let word = offset + vertex * stride;
  return vec3<u32>(positions[word], positions[word + 1u], positions[word + 2u]);
}
