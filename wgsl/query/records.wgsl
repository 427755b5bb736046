// Structs of the query of occluder counts: how many faces lie between points and lights. src/layout.rs has the same structs,
// but for `UndecidedPairs`, and a test compares them: change both. The stages `shadow_boxes`, `shadow_depth`,
// `exact_shadow_depth`, `depth_arguments` and `exact_shadow_depth_recount` run in this order. A cluster has 32 entries for
// faces, a group is 32 clusters. Faces have the order of the mesh, in which the triangles of a polygon follow each other. A
// face index is 32 times the cluster plus the entry in the cluster. Clusters count from the first that is bound.

// The number of faces in a cluster, and of clusters in a group.
const CLUSTER: u32 = 32u;

// Faces and their box. The box contains the faces that can count: finite ones that name three different vertices.
struct FaceCluster {
  // Bits of the lowest x, y and z, and of the largest absolute coordinate.
  low: vec4<u32>,
  // Bits of the highest x, y and z, and 1 if any face counts. All are 0 for an empty box.
  high: vec4<u32>,
  // The box of the group that begins with this cluster. Only the first cluster of a group has it.
  group_low: vec4<u32>,
  group_high: vec4<u32>,
  // Three vertices for each face. Entries without a face name vertex 0 three times: those past the last face of the mesh, and
  // those left before a polygon so that it does not begin in one binding and end in the next.
  corners: array<u32, 96>,
  // A bit for each face, set if it belongs to the same polygon as the face before it.
  continues: u32,
  // If the first face continues a polygon, the face index of the polygon's first triangle. Else 0.
  head: u32,
  // The index of the first face in the mesh. The other faces follow it there.
  first_face: u32,
  padding: u32,
}

// The points of one dispatch.
struct PointChunk {
  count: u32,
  // The word of the first point in the bound points, and the words from one point to the next.
  offset: u32,
  stride: u32,
  // The number of lights in all batches, and the index of the first light of this batch among them.
  lights: u32,
  first_light: u32,
  // The words from a point to the index of the face that it is on. 0 if points name no face.
  on_face: u32,
}

// The clusters of one dispatch: all that are bound in `shadow_boxes`, which reads `end` only. `first` is the first cluster of
// a group.
struct FaceRange {
  first: u32,
  end: u32,
  // 1 if these are the first clusters of the mesh. Counts then begin at 0.
  is_first: u32,
  // The first cluster of the range before, or `first` if these are the first clusters of the binding.
  before: u32,
}

// The undecided faces of a pair of point and light.
struct UndecidedFaces {
  // Bits 0 to 2: the number of undecided faces, 4 for more than three. Bits 3 to 5, one for each of the first three: set if an
  // odd number of decided triangles of its polygon lie between. Bit 6: set if an odd number of triangles of the polygon of the
  // range's last face lie between; until `exact_shadow_depth`, of the decided ones. Bits 3 to 6 are 0 for more than three.
  state: u32,
  // The face indices of the first three. If there are more, `face_0` has a bit for each polygon that continues after its
  // group, set if an odd number of its triangles lie between. Bit 0: the polygon that began before the range. Bit 1 + n: the
  // one that began in group n of the range.
  face_0: atomic<u32>,
  face_1: u32,
  face_2: u32,
  // This member over all pairs is a separate list, of the pairs that have more undecided faces and are counted again.
  recount: u32,
}

// The undecided faces of each pair of point and light of a dispatch, and the number of pairs that are counted again.
struct UndecidedPairs {
  // `shadow_depth` counts in `listed` the pairs that it lists. `depth_arguments` moves the number to `recounts`.
  listed: atomic<u32>,
  recounts: u32,
  pairs: array<UndecidedFaces>,
}
