// The interface through which the stage `outline_edges` reads edges: those of an extraction, or of a group of a scene's
// casters (casters of one page that read one position buffer). Both files below define these functions. In a scene the
// first two store the caster of their edge in a private variable. `outlined_first_face`, `outlined_position` and
// `outlined_offset` read it, so call one of the first two before. `RimlineSilhouette` is in extract/results.wgsl. Its
// `edge`, `a`, `b` and `kind` must hold also if the edge is no silhouette (`valid`): `outline_feature` draws creases.
// `edge` below is that member, a record's index in the bound records, which is no slot in a scene. The world space of an
// extraction is the space of its positions.
//
// * `outlined_silhouette(instance) -> RimlineSilhouette`: the edge of an instance of the light's indirect draw. Instances
//   are slots if the list overflowed, and then the edge may be no silhouette.
// * `outlined_record(slot) -> RimlineSilhouette`: the edge in a slot, which is an edge's index in an extraction.
//   Its kind is NO_EDGE if a slot of a scene has no edge, or if the light is not relevant for the caster. Then `valid` is
//   false, and the other members have no meaning.
// * `outlined_faces(edge) -> vec2<u32>`: the two faces of an edge record, counted from the caster's first face. The first
//   triangle stands for a polygon. x is face 0; its bit 31 is set if the edge is inconsistent. y is face 1, or 0xffffffff
//   for a boundary.
// * `outlined_first_face() -> u32`: the index of the caster's first face in the bound faces.
// * `outlined_position(vertex) -> vec3<f32>`: a vertex in world space without the caster's translation, for differences.
// * `outlined_offset(vertex) -> vec3<f32>`: a vertex in world space, relative to the camera's origin.
// * `outlined_is_marked(edge) -> bool`: whether the caller marked the edge. Edges of scenes have no marks.

#if SCENE
#import outline/scene_edges
#else
#import outline/mesh_edges
#endif
