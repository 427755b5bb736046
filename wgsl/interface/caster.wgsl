// What facing, exact facing and edges know of casters: of a single mesh, or of all casters of a scene. Two files give these
// functions, so that one text serves both. A slot is a place of a face or an edge record in masks and lists; an index is one
// in the topology that is bound. A place of a light is its bit for a single mesh, and its number among the lights of the caster
// in a scene. In a scene the functions tell about the caster that was taken last, by `face_in_slot` or before `take_item`.
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
// * `live_lights() -> u32`: the bits that are computed. `live_places() -> u32`: their places.
// * `tested_places() -> u32`: the places that are not decided already. Places past the last may be among them.
// * `given_light(place) -> vec4<u32>`: the light as given, bit for bit. `scaled_light(place) -> vec4<f32>`: scaled by a power
//   of two. `inexact_w(place) -> f32`, `lights_reach() -> vec2<f32>`: see `LightBatch`.
// Results:
// * `renewed(mask, bits) -> u32`: a mask with new bits. `cleared(mask) -> u32`: a mask without those that are computed.
// * `counts_non_finite() -> bool`: whether this dispatch counts faces that are not finite.
// * `excluded_are_old() -> bool`: whether masks of excluded faces are those of an earlier frame.

#if SCENE
#import scene/caster_positions
#import scene/many_casters
#import scene/walks
#else
#import common/positions
#import extract/one_caster
#endif
