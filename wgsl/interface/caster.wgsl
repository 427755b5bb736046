// The interface through which `facing`, `exact_facing` and `edges` read casters: one mesh, or all casters of a scene. Both
// sides of the `#if` define these functions, so the stages have one text. src/compose.rs expands `#import` and `#if`.
//
// Terms. A caster is a mesh that throws shadows. A slot is the index of a face or edge record in the masks and lists. A
// batch has up to 32 lights, a bit each. A light index counts the lights that a caster has in the batch; it is the light's
// bit for a single mesh. In an index mask bit i is the light with index i. In a scene, functions refer to the caster loaded
// last.
//
// Items:
// * `face_slots() -> u32`: the number of slots of faces.
// * `load_face(slot) -> Item`: the face in one of these slots, or none. Loads its caster.
// * `process_faces(first, step)`, `process_edges(first, step)`: call `process_item(slot, index)` of the importing file for
//   the faces or edge records of invocation `first` of `step`. `index` counts the bound faces or edge records. For a single
//   mesh an invocation has at most one, so `step` must not be below their number. A scene has those of listed chunks.
// Positions:
// * `position_bits(vertex, position_offset(), position_stride()) -> vec3<u32>`: the position of a vertex.
// Lights:
// * `light_count() -> u32`: the number of light indices. `lights_of_indices(mask) -> u32`: index mask to bits of lights, of
//   the active ones only.
// * `active_bits() -> u32`: the bits of the lights to compute. `active_indices() -> u32`: their index mask.
// * `tested_indices() -> u32`: the index mask of active lights that no cluster decided. All bits if it decided none.
// * `given_light(light_index) -> vec4<u32>`: the light as given, bit for bit. `scaled_light(light_index) -> vec4<f32>`:
//   scaled by a power of two. `four_lights(first) -> mat4x4<f32>`: those of four indices, of which past ones repeat the
//   last; in a scene only within `process_faces`. `inexact_w(light_index) -> f32`, `light_magnitudes() -> vec2<f32>`: see
//   `LightBatch`.
// Results of the current face:
// * `updated_bits(mask, bits) -> u32`: `mask` with `bits` for the active lights, or a cluster's if it decided. `bits` must
//   be 0 for other lights. `clear_active(mask) -> u32`: `mask` with zeros for the active lights.
// * `is_first_active_batch() -> bool`: whether this dispatch counts faces that are not finite.
// * `has_stale_exclusions() -> bool`: whether the face's excluded mask may hold bits of an earlier frame. `facing` then
//   clears those of active lights. Else it was cleared or copied before. The mask has the lights in the face's plane, or all
//   for a face that is not finite.

#if SCENE
#import scene/listed_chunks
#import scene/many_casters
#else
#import common/positions
#import extract/one_caster
#endif
