// The interface through which the stages `facing`, `exact_facing` and `edges` know casters: a single mesh, or all casters of a
// scene. Either side of the `#if` gives these functions, so one text serves both; src/compose.rs expands `#import` and `#if`. A
// caster is a mesh that throws shadows. A slot is the index of a face or edge record in masks and lists; an index is that in the
// bound faces or edge records. Lights come in batches of up to 32, a bit each. The place of a light is its bit for a single mesh,
// and its number among the lights of the caster in a scene. In a scene the functions tell of the caster that was taken last, by
// `face_in_slot` or before `take_item`.
//
// Walks:
// * `face_slots() -> u32`: the number of slots of faces.
// * `face_in_slot(slot) -> Item`: the face in a slot, or none. Takes its caster.
// * `take_faces(first, step)`, `take_edges(first, step)`: calls `take_item(slot, index)` of the importing file for the faces or
//   edge records that invocation `first` of `step` takes.
// Positions:
// * `position_bits(vertex, position_offset(), position_stride()) -> vec3<u32>`: a vertex.
// Lights:
// * `light_places() -> u32`: the number of places. `lights_at(places) -> u32`: the bits of the lights at some places.
// * `live_lights() -> u32`: the bits of the lights that are computed. `live_places() -> u32`: the bits of their places.
// * `tested_places() -> u32`: the bits of the places that are not decided already. Bits past the last place may be set.
// * `given_light(place) -> vec4<u32>`: the light as given, bit for bit. `scaled_light(place) -> vec4<f32>`: scaled by a power
//   of two. `inexact_w(place) -> f32`, `lights_reach() -> vec2<f32>`: see `LightBatch`.
// Results, of the face that was taken:
// * `renewed(mask, bits) -> u32`: `mask` with `bits` for the lights that are computed. `cleared(mask) -> u32`: with zeros there.
// * `counts_non_finite() -> bool`: whether this dispatch counts faces that are not finite.
// * `excluded_are_old() -> bool`: whether the face's mask of lights for which it is excluded (its plane has the light, or it is
//   not finite) still has bits of an earlier frame, so that `facing` clears it. Else it was cleared or copied anew before.

#if SCENE
#import scene/many_casters
#import scene/walks
#else
#import common/positions
#import extract/one_caster
#endif
