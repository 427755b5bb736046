// Structs and constants that stages share with each other and with src/layout.rs. A test compares the two files.

const NO_FACE: u32 = 0xffffffffu;
// Bit 31 of an edge record's face 0: both faces traverse the edge the same way.
const INCONSISTENT: u32 = 0x80000000u;
// Bit 31 of a list entry: the edge's winding bit.
const WINDING: u32 = 0x80000000u;
// Edges that one workgroup compacts.
const BLOCK: u32 = 256u;

// Up to 32 lights, one bit each, and where the positions lie.
struct LightBatch {
  // Homogeneous (x, y, z, w), scaled by a power of two so that the largest is between 1 and 2: that changes no side.
  // Those past `count` repeat the last.
  lights: array<vec4<f32>, 32>,
  // The lights as given, bit for bit.
  light_bits: array<vec4<u32>, 32>,
  // Four lights each: |w| of the scaled light as far as its products' errors count: 0 where it is a power of two, so that
  // they are exact, and not less than 2^-36 where scaling and flushing may lose it.
  inexact_w: array<vec4<f32>, 8>,
  // Of all scaled lights the largest |x|, |y| or |z|, and the largest |w| or `inexact_w`.
  reach: vec2<f32>,
  count: u32,
  // The lowest `count` bits.
  live: u32,
  // First word of vertex 0 in the bound positions, and words from a vertex to the next.
  position_offset: u32,
  position_stride: u32,
  reserved_0: u32,
  reserved_1: u32,
}

// The part of the faces or edges that one dispatch works on; its arrays are bound from its first item on.
struct Chunk {
  first: u32,
  count: u32,
  // The first light of the 32 at hand.
  first_light: u32,
  // Entries that each light's list has room for.
  capacity: u32,
  // Blocks of edges in the whole mesh.
  blocks: u32,
}

// What turns counts into draws.
struct DrawShape {
  lights: u32,
  capacity: u32,
  // Edge records in the mesh.
  edges: u32,
  vertices_per_edge: u32,
}

// An edge record's bits, one a light.
struct Masks {
  silhouette: u32,
  winding: u32,
}

struct Statistics {
  // Faces with an infinite or NaN vertex: they face no light.
  non_finite_faces: atomic<u32>,
  // Lists that overflowed: these lights are drawn over all edges.
  overflowed_lists: atomic<u32>,
  // Pairs of face and light that the filter left to exact arithmetic, and those of them that it found to be zero.
  undecided_pairs: atomic<u32>,
  exact_zeros: atomic<u32>,
}

// What wgpu's draw_indirect reads.
struct DrawArguments {
  vertex_count: u32,
  instance_count: u32,
  first_vertex: u32,
  first_instance: u32,
}

// Faces of a cluster, and clusters of a group.
const CLUSTER: u32 = 32u;

// Faces and the box around those that count: finite, and naming three vertices.
struct FaceCluster {
  // Bits of the lowest x, y and z, and of the largest absolute coordinate.
  low: vec4<u32>,
  // Bits of the highest x, y and z, and 1 where any face counts; 0 where the box is empty, and all zeros.
  high: vec4<u32>,
  // The same of the group that begins with this cluster, in each group's first.
  group_low: vec4<u32>,
  group_high: vec4<u32>,
  // Three vertices a face. Faces past the mesh's last name vertex 0 three times.
  corners: array<u32, 96>,
}

// The points of one dispatch of the shadow depth query.
struct PointChunk {
  count: u32,
  // First word of the first point in the bound points, and words from a point to the next.
  offset: u32,
  stride: u32,
  // Lights of all words, and the first light of the word at hand.
  lights: u32,
  first_light: u32,
}

// The clusters that one dispatch goes over, from a group's first.
struct FaceRange {
  first: u32,
  end: u32,
  // 1 where these are the mesh's first: depths begin here.
  is_first: u32,
}

// Faces that a point and a light leave undecided.
struct UndecidedFaces {
  // How many, and the first three of them.
  count: u32,
  face_0: u32,
  face_1: u32,
  face_2: u32,
  // An entry of another list: a pair of point and light that had more, and is counted anew.
  recount: u32,
}

// One for each pair of point and light of a dispatch.
struct UndecidedPairs {
  // Pairs to count anew, while they are listed and when they are.
  listed: atomic<u32>,
  recounts: u32,
  pairs: array<UndecidedFaces>,
}

// The vertices of one instance that one dispatch deforms.
struct DeformChunk {
  // Vertices in this dispatch; the arrays are bound from its first vertex on.
  count: u32,
  // First word of the dispatch's first vertex in `positions`.
  first_word: u32,
  // Words in `pose` where the matrices begin (12 each, three rows of four) and where the active morph targets do
  // (two each, index and weight), and how many of these there are.
  palette: u32,
  targets: u32,
  target_count: u32,
  // 0: every vertex follows the palette's first matrix.
  skinned: u32,
  // 0: no displacement.
  displaced: u32,
  time: f32,
}

// The draws of one light's shadow volume.
struct ShadowDraws {
  // Sides as they are, and sides clipped at the near plane: one of them draws nothing.
  plain: DrawArguments,
  clipped: DrawArguments,
  // Caps that count up on their front, and on their back.
  front: DrawArguments,
  back: DrawArguments,
  // Sides that the published ZP+ leaves to z-fail.
  switched: DrawArguments,
  // Their light and dark caps; or with z-pass the dark caps of volumes that end.
  far_front: DrawArguments,
  far_back: DrawArguments,
  // Sides of holes, of which `plain` or `switched` and `clipped` have none.
  holes: DrawArguments,
  clipped_holes: DrawArguments,
}

struct ShadowStatistics {
  // Lights out of whose reach the caster is, or whose shadow the camera cannot see.
  skipped: atomic<u32>,
  // Lights for which every face casts.
  every_face: atomic<u32>,
  // Lights with a near cap.
  capped: atomic<u32>,
  // Lights whose list of cap faces overflowed.
  overflowed_caps: atomic<u32>,
  // Lights whose volume ends at their range.
  ended: atomic<u32>,
  // No count exceeds this, for any light; and lights for which that is more than 8 bits hold. 0 unless asked for.
  count_bound: atomic<u32>,
  may_wrap: atomic<u32>,
}
