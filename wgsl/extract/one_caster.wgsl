// What facing, exact facing and edges know of a single mesh: the faces, the lights, the layout of the positions.
// scene/many_casters.wgsl has the same functions for scenes.
//
// Expects: `take_item(slot, index)`, where faces or edge records are taken.

#import common/extraction

@group(0) @binding(0) var<uniform> batch: LightBatch;
@group(0) @binding(1) var<uniform> chunk: Chunk;

// A face.
struct Item {
  exists: bool,
  // Its place in the masks.
  slot: u32,
  // Its place in the topology.
  index: u32,
}

// The number of slots of faces.
fn face_slots() -> u32 {
  return chunk.count;
}

fn face_in_slot(slot: u32) -> Item {
  return Item(true, slot, slot);
}

// Whether faces that are not finite are counted here. Every batch sees them.
fn counts_non_finite() -> bool {
  return chunk.first_light == 0u;
}

fn position_offset() -> u32 {
  return batch.position_offset;
}

fn position_stride() -> u32 {
  return batch.position_stride;
}

fn light_places() -> u32 {
  return batch.count;
}

fn scaled_light(place: u32) -> vec4<f32> {
  return batch.lights[place];
}

fn given_light(place: u32) -> vec4<u32> {
  return batch.light_bits[place];
}

fn inexact_w(place: u32) -> f32 {
  return batch.inexact_w[place / 4u][place % 4u];
}

fn lights_reach() -> vec2<f32> {
  return batch.reach;
}

fn live_places() -> u32 {
  return batch.live;
}

fn live_lights() -> u32 {
  return batch.live;
}

// A mask with new bits. Of a single mesh all are new.
fn renewed(mask: u32, bits: u32) -> u32 {
  return bits;
}

// A mask without these bits. It is not read.
fn cleared(mask: u32) -> u32 {
  return 0u;
}

// The places of the lights that are not decided yet.
fn tested_places() -> u32 {
  return 0xffffffffu;
}

// Whether masks of excluded faces are those of an earlier frame. They are cleared before.
fn excluded_are_old() -> bool {
  return false;
}

// The bits of the lights at some places.
fn lights_at(places: u32) -> u32 {
  return places & batch.live;
}

// Takes the face or edge record `first`, if there is one. The importing file has `take_item`.
fn take_faces(first: u32, step: u32) {
  if (first < chunk.count) {
    take_item(first, first);
  }
}

fn take_edges(first: u32, step: u32) {
  take_faces(first, step);
}
