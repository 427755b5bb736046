// The interface through which the stage `outline_edges` reads edges: those of an extraction, or of a group of a scene's
// casters (casters that are drawn together). Either side of the `#if` gives these functions. The first two take the
// caster of their edge. All others are about the caster that was taken last.
//
// * `outlined_silhouette(instance) -> RimlineSilhouette`: the edge of an instance of the light's indirect draw.
// * `outlined_record(slot) -> RimlineSilhouette`: the edge in a slot, which is an edge's index in an extraction.
//   NO_EDGE as its kind: there is none, or the caster has no outline.
// * `outlined_faces(edge) -> vec2<u32>`: the packed faces of an edge. `outlined_first_face() -> u32`: the index of the
//   caster's first face in the bound faces.
// * `outlined_position(vertex) -> vec3<f32>`: a vertex of the caster, along the axes of the world, from any origin.
// * `outlined_offset(vertex) -> vec3<f32>`: a vertex less the camera's origin.
// * `outlined_is_marked(edge) -> bool`: whether the caller marked the edge.

#if SCENE
#import outline/scene_edges
#else
#import outline/mesh_edges
#endif
