// The interface through which the stage `outline_edges` reads edges: those of an extraction, or of a group of a scene's
// casters (casters that are drawn together). Either file below defines these functions. In a scene the first two store the
// caster of their edge in a private variable and the others read it, so call one of the first two before them.
// `RimlineSilhouette` is in extract/results.wgsl.
//
// * `outlined_silhouette(instance) -> RimlineSilhouette`: the edge of an instance of the light's indirect draw.
// * `outlined_record(slot) -> RimlineSilhouette`: the edge in a slot, which is an edge's index in an extraction.
//   Its kind is NO_EDGE if there is none, or, in a scene, if the caster has no outline.
// * `outlined_faces(edge) -> vec2<u32>`: the two faces of an edge, packed as in `rimline_edge_faces`.
// * `outlined_first_face() -> u32`: the index of the caster's first face in the bound faces.
// * `outlined_position(vertex) -> vec3<f32>`: a vertex in world space, up to a translation.
// * `outlined_offset(vertex) -> vec3<f32>`: a vertex less the camera's origin.
// * `outlined_is_marked(edge) -> bool`: whether the caller marked the edge. Edges of scenes have no marks.

#if SCENE
#import outline/scene_edges
#else
#import outline/mesh_edges
#endif
