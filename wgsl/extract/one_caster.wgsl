// A single mesh as a caster: implements interface/caster.wgsl, but for `position_bits`. `facing`, `exact_facing` and `edges`
// take it by the interface, `per_edge` and the stages of polygons import it. It holds the items and lights of a dispatch and
// the layout of positions. A light index is the light's bit. A slot is the index of a face or edge record, counted from the
// first of the dispatch (`chunk`), where bindings begin. For polygons `chunk` has all polygons. Some functions return
// constants, because scenes (scene/many_casters.wgsl, scene/listed_chunks.wgsl) need more. The test that composes all
// stages fails if one side lacks a function. Rust finds bindings by name.
//
// Expects: `process_item(slot, index)`, called by the last two functions. src/compose.rs leaves out functions that no entry
// point reaches, so files that call neither need none.

#import common/extraction

@group(0) @binding(0) var<uniform> batch: LightBatch;
@group(0) @binding(1) var<uniform> chunk: Chunk;

struct Item {
  exists: bool,
  slot: u32, // Its index in the masks.
  index: u32, // Its index in the bound faces or edge records.
}

fn face_slots() -> u32 { return chunk.count; }
fn load_face(slot: u32) -> Item { return Item(true, slot, slot); }
// Each batch finds the same faces that are not finite. The statistics count them once.
fn is_first_active_batch() -> bool { return chunk.first_light == 0u; }

fn position_offset() -> u32 { return batch.position_offset; }
fn position_stride() -> u32 { return batch.position_stride; }
fn light_count() -> u32 { return batch.count; }
fn scaled_light(light_index: u32) -> vec4<f32> { return batch.lights[light_index]; }
fn four_lights(first: u32) -> mat4x4<f32> {
  return mat4x4<f32>(batch.lights[first], batch.lights[first + 1u], batch.lights[first + 2u], batch.lights[first + 3u]);
}
fn given_light(light_index: u32) -> vec4<u32> { return batch.light_bits[light_index]; }
fn inexact_w(light_index: u32) -> f32 { return batch.inexact_w[light_index / 4u][light_index % 4u]; }
fn light_magnitudes() -> vec2<f32> { return batch.magnitudes; }
fn active_indices() -> u32 { return batch.active_bits; }
fn active_bits() -> u32 { return batch.active_bits; }
// Only scenes have clusters that decide lights for many faces at once.
fn tested_indices() -> u32 { return 0xffffffffu; }
fn lights_of_indices(index_mask: u32) -> u32 { return index_mask & batch.active_bits; }

// No bit of an earlier encode stays: facing masks are overwritten, and excluded masks are cleared before the first stage.
// `clear_active` is never called.
fn updated_bits(mask: u32, bits: u32) -> u32 { return bits; }
fn clear_active(mask: u32) -> u32 { return 0u; }
fn has_stale_exclusions() -> bool { return false; }

// An invocation processes one item of `chunk`, a face or an edge record. `step` has no effect.
fn process_faces(first: u32, step: u32) {
  if (first < chunk.count) {
    process_item(first, first);
  }
}

fn process_edges(first: u32, step: u32) {
  process_faces(first, step);
}
