// What edges read and write: of a single mesh, or of all casters of a scene.
//
// * `facing_mask(face) -> u32`: the facing mask of a face of the topology. In a scene, of the caster that was taken last.
// * `emit(slot, silhouette, winding)`: writes the masks of an edge record, appends it to the lists of its lights, or both.

#if SCENE
#import scene/edge_lists
#else
#import extract/edge_lists
#endif
