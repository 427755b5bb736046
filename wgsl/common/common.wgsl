// Structs and constants that stages share with each other and with src/layout.rs. A test compares the two files.

const NO_FACE: u32 = 0xffffffffu;
// Bit 31 of face 0 of an edge record. It is set if both faces traverse the edge the same way.
const INCONSISTENT: u32 = 0x80000000u;
// Bit 31 of a list entry: the winding bit of the edge.
const WINDING: u32 = 0x80000000u;
// The number of edges that one workgroup compacts.
const BLOCK: u32 = 256u;

// A light's cone, in world space: the apex and 1 (0: the light has no cone), the axis of length 1 and the cosine of the angle from the
// axis to the border.
struct LightCone {
  apex: vec4<f32>,
  axis: vec4<f32>,
}

// A batch of up to 32 lights, one bit each, and the layout of the positions.
struct LightBatch {
  // Homogeneous (x, y, z, w), scaled by a power of two so that the largest component is between 1 and 2. This changes
  // no side. Entries past `count` repeat the last light.
  lights: array<vec4<f32>, 32>,
  // The lights as given, bit for bit.
  light_bits: array<vec4<u32>, 32>,
  // |w| of the scaled lights, four lights in each vector, as far as it adds to the error of products. It is 0 if w is a
  // power of two, since products are then exact. It is at least 2^-36 if scaling and flushing may lose w.
  inexact_w: array<vec4<f32>, 8>,
  // The largest |x|, |y| or |z| of all scaled lights, and their largest |w| or `inexact_w`.
  reach: vec2<f32>,
  count: u32,
  // The lowest `count` bits.
  live: u32,
  // The word of vertex 0 in the bound positions, and the words from one vertex to the next.
  position_offset: u32,
  position_stride: u32,
  reserved_0: u32,
  reserved_1: u32,
}

// The range of faces or edges of one dispatch. Its arrays are bound from its first item on.
struct Chunk {
  first: u32,
  count: u32,
  // The first light of the batch.
  first_light: u32,
  // Entries that the list of each light has room for.
  capacity: u32,
  // Blocks of edges in the whole mesh.
  blocks: u32,
}

// What turns counts of edges into draws.
struct DrawShape {
  lights: u32,
  capacity: u32,
  // Edge records in the mesh.
  edges: u32,
  vertices_per_edge: u32,
}

// The bits of an edge record, one for each light of a batch.
struct EdgeMasks {
  silhouette: u32,
  winding: u32,
}

struct ExtractionStatistics {
  // Faces with an infinite or NaN vertex. They face no light.
  non_finite_faces: atomic<u32>,
  // Lists that overflowed. The draws of their lights go over all edges.
  overflowed_lists: atomic<u32>,
  // Pairs of face and light that the filter left to exact arithmetic, and those of them whose determinant is zero.
  undecided_pairs: atomic<u32>,
  exact_zeros: atomic<u32>,
  // A bit for each light for which a polygon is L-twisted. Lights of all batches share the bits.
  twisted_lights: atomic<u32>,
}

// Statistics, and the list of undecided faces beside them: together they take one of a stage's few bindings.
struct FacingRecord {
  statistics: ExtractionStatistics,
  // How many faces are undecided, then the faces, counted from the chunk's first.
  undecided_count: atomic<u32>,
  undecided: array<u32>,
}

// The arguments that wgpu's draw_indirect reads.
struct DrawArguments {
  vertex_count: u32,
  instance_count: u32,
  first_vertex: u32,
  first_instance: u32,
}

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
  // If the first face continues a polygon, the place of the first triangle of that.
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
  // The number of undecided faces, at most 4. Bits 3 to 5, one for each of the first three, are set if an odd number of the decided
  // triangles of its polygon are between, and bit 6 if an odd number of triangles are, of the polygon of the last face of the range.
  state: u32,
  // The first three of them. If there are more, the first word has bits of polygons that go on behind their group of clusters, set
  // if an odd number of their triangles are between. Bit 0 is that of one that began before the range, and bit 1 + n that of one
  // that began in group n of the range.
  face_0: atomic<u32>,
  face_1: u32,
  face_2: u32,
  // An entry of another list: a pair of point and light that had more, and is counted again.
  recount: u32,
}

// One for each pair of point and light of a dispatch.
struct UndecidedPairs {
  // The number of pairs to count again, while they are listed and after.
  listed: atomic<u32>,
  recounts: u32,
  pairs: array<UndecidedFaces>,
}

// A dispatch of the deform stage.
struct DeformDispatch {
  // The word in `pose` where the chunks of its workgroups begin, a word each.
  workgroups: u32,
  // 0: `displace` is not called.
  displaced: u32,
  time: f32,
  // Instances of the model.
  instances: u32,
}

// A run of vertices of one instance, for whole workgroups. Words count from where the dispatch binds the arrays.
struct DeformChunk {
  // The number of its first workgroup in the dispatch.
  first_workgroup: u32,
  // Vertices.
  count: u32,
  // The words of the first vertex in `rest`, `morph`, `skin`, `source_vertices` and `positions`.
  rest: u32,
  morph: u32,
  skin: u32,
  sources: u32,
  positions: u32,
  // The word in `pose` where the matrices begin (12 words each, three rows of four), the word where the active morph
  // targets begin (two words each, index and weight), and the number of these targets.
  palette: u32,
  targets: u32,
  target_count: u32,
  // 0: all vertices follow the first matrix of the palette.
  skinned: u32,
  // The word in `pose` that is 1 if the positions of the instance are a point, since it was not needed before. So many words
  // behind it as there are instances, a word is 1 if it is not needed now.
  before: u32,
}

// Slots of a chunk, which are those of one caster.
const CHUNK: u32 = 64u;
// Invocations that share a chunk.
const LANES: u32 = 8u;
// Flags of a caster.
const CLOSED: u32 = 1u;
const MIRRORED: u32 = 2u;
const RIGID: u32 = 4u;
const HOLED: u32 = 8u;
const EXCLUDING: u32 = 16u;
const PROXY: u32 = 128u;
const BOUNDED: u32 = 256u;
// The word of a scene's counts of silhouettes that tells whether a light was in the plane of a face whose bits are kept.
const KEPT_ZEROS: u32 = 32u;

// A caster in the table of casters. Slots are places in the masks of what is drawn together; other places are in the buffers
// of the mesh.
struct SceneCaster {
  // Rows of the matrix from mesh space to world space.
  row_0: vec4<f32>,
  row_1: vec4<f32>,
  row_2: vec4<f32>,
  // The box of the finite faces, in mesh space, or a box that the caller states. Low is above high if there is none.
  low: vec3<f32>,
  // At most the smallest factor by which the matrix scales a length.
  scale: f32,
  high: vec3<f32>,
  // Bits: 1 closed; 2 mirrored; 4 rigid, so lights are moved to its mesh space and the box is known; 8 a face is not finite;
  // 16 the caller excludes faces; 32 positions may have changed; 64 the caller excludes faces of a caster of the group; 128
  // not in the depth buffer; 256 the box is one that the caller states, in world space.
  flags: u32,
  first_face_slot: u32,
  faces: u32,
  first_face: u32,
  // The word of vertex 0 in the bound positions.
  position_offset: u32,
  first_edge_slot: u32,
  edges: u32,
  first_edge: u32,
  // Words from one vertex to the next.
  position_stride: u32,
  // The encode that was the first to have it as it is, and its group of casters.
  version: u32,
  group: u32,
  // The first caster of the group.
  first_caster: u32,
  // Of a rigid caster the word of the page's clusters where those of its mesh begin, or NO_CLUSTERS. Of another its number
  // among the figures that may not be needed, counted from 1, or 0 if it is none.
  clusters_or_figure: u32,
}

// The draws of one light's shadow volume.
struct ShadowDraws {
  // Sides that are not clipped, and sides clipped at the near plane, or sides of ZP+ as published.
  plain: DrawArguments,
  clipped: DrawArguments,
  // Near caps that count up on their front, and on their back.
  near_front: DrawArguments,
  near_back: DrawArguments,
  // Light and dark caps of z-fail, likewise. With z-pass, the dark caps of volumes that end.
  far_front: DrawArguments,
  far_back: DrawArguments,
  // With z-pass and ZP+, the light caps of casters that are not in the depth buffer.
  light_front: DrawArguments,
  light_back: DrawArguments,
}

// The draws of the pieces of a light's L-twisted polygons.
struct PieceDraws {
  // Sides that are not clipped, and sides clipped at the near plane.
  plain: DrawArguments,
  clipped: DrawArguments,
  // Near caps that count up on their front, or on their back.
  near_front: DrawArguments,
  near_back: DrawArguments,
  // Caps at the polygon, and at the far end.
  light_cap: DrawArguments,
  dark_cap: DrawArguments,
}

struct ShadowStatistics {
  // Pairs of caster and light that are skipped: the light does not reach the caster, or the camera cannot see the shadow.
  skipped: atomic<u32>,
  // Pairs for which every face casts.
  every_face: atomic<u32>,
  // Lights with a near cap.
  capped: atomic<u32>,
  // Lights with a list of cap faces that overflowed.
  overflowed_caps: atomic<u32>,
  // Lights with a list of sides that overflowed.
  overflowed_sides: atomic<u32>,
  // Pairs whose volume ends at the light's range.
  ended: atomic<u32>,
  // An upper bound of all stencil counts, for any light, and the lights whose bound exceeds 8 bits. 0 unless asked for.
  count_bound: atomic<u32>,
  may_wrap: atomic<u32>,
  // Groups of casters, lights and views whose lists were kept.
  kept_lists: atomic<u32>,
  // Of the pairs that are skipped, those whose volume no receiver can be in.
  hidden: atomic<u32>,
  // And those whose box the light does not reach.
  unreached: atomic<u32>,
  // Pieces of L-twisted polygons that there was no room for. Where they would be, shadows are wrong.
  lost_pieces: atomic<u32>,
}
