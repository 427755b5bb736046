// Shared by the stages of extraction, of scenes and of queries, and by those that read results: structs and constants of batches
// of lights, ranges of dispatches, masks, statistics, draws. src/layout.rs has the same structs, which a test holds equal: no
// member may change here alone.

const NO_FACE: u32 = 0xffffffffu;
// Bit 31 of face 0 of an edge record. It is set if both faces traverse the edge the same way.
const INCONSISTENT: u32 = 0x80000000u;
const WINDING: u32 = 0x80000000u; // Bit 31 of a list entry: the winding bit of the edge.
// The number of edges that one workgroup compacts.
const BLOCK: u32 = 256u;

// A batch of up to 32 lights, one bit each, and the layout of the positions.
struct LightBatch {
  // Homogeneous (x, y, z, w), scaled by a power of two so that the largest component is between 1 and 2. This changes
  // no side. Entries past `count` repeat the last light.
  lights: array<vec4<f32>, 32>,
  light_bits: array<vec4<u32>, 32>, // The lights as given, bit for bit.
  // |w| of the scaled lights, four lights in each vector, as far as it adds to the error of products. It is 0 if w is a
  // power of two, since products are then exact. It is at least 2^-36 if scaling and flushing may lose w.
  inexact_w: array<vec4<f32>, 8>,
  // The largest |x|, |y| or |z| of all scaled lights, and their largest |w| or `inexact_w`.
  reach: vec2<f32>,
  count: u32,
  live: u32, // The lowest `count` bits.
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
  first_light: u32, // The first light of the batch.
  capacity: u32, // Entries that the list of each light has room for.
  blocks: u32, // Blocks of edges in the whole mesh.
}

// How counts of edges become draws.
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
  non_finite_faces: atomic<u32>, // Faces with an infinite or NaN vertex. They face no light.
  overflowed_lists: atomic<u32>, // Lists that overflowed. The draws of their lights go over all edges.
  // Pairs of face and light that the filter left to exact arithmetic, and those of them whose determinant is zero.
  undecided_pairs: atomic<u32>,
  exact_zeros: atomic<u32>,
  // A bit for each light for which a polygon is L-twisted: it has lit and dark parts. Lights of all batches share the bits.
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
