// Structs that the stages of the shadow depth query share with each other and with src/layout.rs, which a test holds equal:
// no member may change here alone. The query counts faces between points and lights; `shadow_boxes`, `shadow_depth`,
// `exact_shadow_depth`, `depth_arguments` and `exact_shadow_depth_recount` run in this order. Faces are cut into clusters of
// 32 and groups of 32 clusters, in the order of the mesh, so that the triangles of a polygon follow each other.

// The number of faces in a cluster, and of clusters in a group.
const CLUSTER: u32 = 32u;

// Faces and their box. The box holds the faces that count: those that are finite and name three different vertices.
struct FaceCluster {
  // Bits of the lowest x, y and z, and of the largest absolute coordinate.
  low: vec4<u32>,
  // Bits of the highest x, y and z, and 1 if any face counts. All are 0 for an empty box.
  high: vec4<u32>,
  // The box of the group that begins with this cluster. Only the first cluster of a group has it.
  group_low: vec4<u32>,
  group_high: vec4<u32>,
  // Three vertices for each face. Entries past the last face of the mesh name vertex 0 three times.
  corners: array<u32, 96>,
  // A bit for each face, set if it belongs to the same polygon as the face before it.
  continues: u32,
  // If the first face continues a polygon, the place of the first triangle of that: 32 times its cluster plus its number in
  // it.
  head: u32,
  // The number that the mesh has for the first face. The others follow it.
  first_face: u32,
  padding: u32,
}

// The points of one dispatch of the shadow depth query.
struct PointChunk {
  count: u32,
  // The word of the first point in the bound points, and the words from one point to the next.
  offset: u32,
  stride: u32,
  // The number of lights in all batches, and the first light of the batch.
  lights: u32,
  first_light: u32,
  // The words from a point to the number of the face that it is on. 0 if points name no face.
  on_face: u32,
}

// The clusters that one dispatch goes over, from the first cluster of a group on.
struct FaceRange {
  first: u32,
  end: u32,
  // 1 if these are the first clusters of the mesh, so the depths begin at 0.
  is_first: u32,
  // The first cluster of the range before. The same as `first` if these are the first clusters of the binding.
  before: u32,
}

// The undecided faces of a pair of point and light.
struct UndecidedFaces {
  // The number of undecided faces, 4 for more than three. Bits 3 to 5, one for each of the first three, are set if an odd
  // number of the decided triangles of its polygon are between, and bit 6 if an odd number of triangles of the polygon of
  // the range's last face are.
  state: u32,
  // The first three of them. If there are more, the first word has bits of polygons that go on behind their group of
  // clusters, set if an odd number of their triangles are between. Bit 0 is that of one that began before the range, and bit
  // 1 + n that of one that began in group n of the range.
  face_0: atomic<u32>,
  face_1: u32,
  face_2: u32,
  // Word n of this member over all pairs is a list of its own: a pair of point and light that had more, and is counted
  // again.
  recount: u32,
}

// One for each pair of point and light of a dispatch.
struct UndecidedPairs {
  // How many pairs are to be counted again: while `shadow_depth` lists them, and from `depth_arguments` on.
  listed: atomic<u32>,
  recounts: u32,
  pairs: array<UndecidedFaces>,
}
