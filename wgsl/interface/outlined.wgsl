// The interface through which the stage `outline_edges` knows edges: those of an extraction, or of a group of a scene's casters
// (the casters that lists hold together). Either side of the `#if` gives these functions. The caster is the one whose edge was
// taken last, by the first two functions.
//
// * `outlined_silhouette(instance) -> RimlineSilhouette`: the edge of an instance of the light's indirect draw.
// * `outlined_record(number) -> RimlineSilhouette`: an edge by its number. NO_EDGE as its kind: there is none, or the caster
//   has no outline.
// * `outlined_faces(edge) -> vec2<u32>`: the packed faces of an edge. `outlined_first_face() -> u32`: where the faces of the
//   caster begin in the bound faces.
// * `outlined_position(vertex) -> vec3<f32>`: a vertex of the caster, along the axes of the world, from any origin.
// * `outlined_offset(vertex) -> vec3<f32>`: a vertex less the camera's origin.
// * `outlined_is_marked(edge) -> bool`: whether the caller marked the edge.

#if SCENE
#import outline/scene_edges
#else
#import outline/mesh_edges
#endif
