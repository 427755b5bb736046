// A single mesh as interface/caster.wgsl has it, for the stages `facing`, `exact_facing`, `edges`, `per_edge` and those of
// polygons: its faces, its lights, the layout of its positions. A batch is up to 32 lights; the place of a light, by which
// functions here name it, is its bit. A slot of a face is its index, counted from the first face of the dispatch (`chunk`), from
// which on arrays are bound. For polygons `chunk` counts polygons. scene/many_casters.wgsl and scene/walks.wgsl have the same
// functions for scenes, where places, slots and kept bits differ: so some here return constants or ignore an argument. A function
// that one side lacks fails the test that composes all stages. Bindings are found by name; numbers must only differ in a module.
//
// Expects: `take_item(slot, index)`, called by the last two functions. src/compose.rs leaves out functions that no entry point
// reaches, so files that call neither need none.

#import common/extraction

@group(0) @binding(0) var<uniform> batch: LightBatch;
@group(0) @binding(1) var<uniform> chunk: Chunk;

struct Item {
  exists: bool,
  slot: u32, // Its index in the masks.
  index: u32, // Its index in the bound faces or edge records.
}

fn face_slots() -> u32 { return chunk.count; }
fn face_in_slot(slot: u32) -> Item { return Item(true, slot, slot); }
// Each batch finds the same faces that are not finite. Only dispatches of the first batch count them in the statistics.
fn counts_non_finite() -> bool { return chunk.first_light == 0u; }

fn position_offset() -> u32 { return batch.position_offset; }
fn position_stride() -> u32 { return batch.position_stride; }
fn light_places() -> u32 { return batch.count; }
fn scaled_light(place: u32) -> vec4<f32> { return batch.lights[place]; }
fn given_light(place: u32) -> vec4<u32> { return batch.light_bits[place]; }
fn inexact_w(place: u32) -> f32 { return batch.inexact_w[place / 4u][place % 4u]; }
fn lights_reach() -> vec2<f32> { return batch.reach; }
// Places and bits of lights are the same here.
fn live_places() -> u32 { return batch.live; }
fn live_lights() -> u32 { return batch.live; }
// Only in scenes clusters decide lights before.
fn tested_places() -> u32 { return 0xffffffffu; }
fn lights_at(places: u32) -> u32 { return places & batch.live; }

// No bit of a mask is kept from an earlier encode. Masks of excluded faces (by light: its plane has the light, or it is not
// finite) are zeros: `Extractor::encode` clears the buffers before the first stage. So `cleared` is never called.
fn renewed(mask: u32, bits: u32) -> u32 { return bits; }
fn cleared(mask: u32) -> u32 { return 0u; }
fn excluded_are_old() -> bool { return false; }

// Invocation `first` takes item `first` of the dispatch and no other. The items are what `chunk` counts: faces, or edge records.
fn take_faces(first: u32, step: u32) {
  if (first < chunk.count) {
    take_item(first, first);
  }
}

fn take_edges(first: u32, step: u32) {
  take_faces(first, step);
}
