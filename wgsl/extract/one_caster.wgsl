// A single mesh as interface/caster.wgsl has it, for the stages `facing`, `exact_facing`, `edges`, `per_edge` and those of
// polygons: its faces, its lights, the layout of its positions. A batch is up to 32 lights, and a light's place is its bit. A
// slot of a face is its index, counted from the first face of the dispatch (`chunk`), from which on arrays are bound. For
// polygons `chunk` counts polygons. scene/many_casters.wgsl and scene/walks.wgsl have the same functions for scenes.
//
// Expects: `take_item(slot, index)`. Files that walk over neither faces nor edge records need none, since a module holds
// what is reached.

#import common/extraction

@group(0) @binding(0) var<uniform> batch: LightBatch;
@group(0) @binding(1) var<uniform> chunk: Chunk;

struct Item {
  exists: bool,
  slot: u32, // Its place in the masks.
  index: u32, // Its place in the topology.
}

fn face_slots() -> u32 { return chunk.count; }
fn face_in_slot(slot: u32) -> Item { return Item(true, slot, slot); }
// Every batch sees faces that are not finite. The first counts them.
fn counts_non_finite() -> bool { return chunk.first_light == 0u; }

fn position_offset() -> u32 { return batch.position_offset; }
fn position_stride() -> u32 { return batch.position_stride; }
fn light_places() -> u32 { return batch.count; }
fn scaled_light(place: u32) -> vec4<f32> { return batch.lights[place]; }
fn given_light(place: u32) -> vec4<u32> { return batch.light_bits[place]; }
fn inexact_w(place: u32) -> f32 { return batch.inexact_w[place / 4u][place % 4u]; }
fn lights_reach() -> vec2<f32> { return batch.reach; }
fn live_places() -> u32 { return batch.live; }
fn live_lights() -> u32 { return batch.live; }
fn tested_places() -> u32 { return 0xffffffffu; }
fn lights_at(places: u32) -> u32 { return places & batch.live; }

// All bits of a mask are new, and masks of excluded faces are cleared before.
fn renewed(mask: u32, bits: u32) -> u32 { return bits; }
fn cleared(mask: u32) -> u32 { return 0u; }
fn excluded_are_old() -> bool { return false; }

// An invocation takes one face or edge record.
fn take_faces(first: u32, step: u32) {
  if (first < chunk.count) {
    take_item(first, first);
  }
}

fn take_edges(first: u32, step: u32) {
  take_faces(first, step);
}
