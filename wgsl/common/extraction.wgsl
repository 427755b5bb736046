// Structs and constants of batches of lights, dispatches, masks, statistics and draws, for the stages of extraction, scenes
// and queries. Readers of results import them, too. src/layout.rs has the same structs, and a test compares them: change
// both. Rust also has NO_FACE, INCONSISTENT (INCONSISTENT_BIT), WINDING and BLOCK (WORKGROUP); no test compares these. An
// edge record is a directed edge (a, b) with its faces, in two words. The first: face 0, which traverses it from a to b, and
// the bit INCONSISTENT. The second: face 1, or NO_FACE.

// In the second word of a record, which never has INCONSISTENT. Callers of queries write it for points on no face.
const NO_FACE: u32 = 0xffffffffu;
// Bit 31 of the first word of a record (in `per_edge`, of its first vertex): face 1 traverses the edge in the direction of
// face 0.
const INCONSISTENT: u32 = 0x80000000u;
// Bit 31 of an entry of a list of silhouette edges or sides: the winding, by `EdgeMasks` or `EdgeSide`.
const WINDING: u32 = 0x80000000u;
// Edges of a workgroup of `compact`, and its invocations. Rust's WORKGROUP is also the 256 in other files: change all.
const BLOCK: u32 = 256u;

// A batch of up to 32 lights, one bit each, and the layout of the positions.
struct LightBatch {
  // Homogeneous (x, y, z, w), scaled by a power of two so that the largest absolute component is at least 1 and below 2. A
  // light of zeros stays. Scaling changes no sign. Here and in the next two arrays, entries that are not active repeat the
  // last light.
  lights: array<vec4<f32>, 32>,
  light_bits: array<vec4<u32>, 32>, // The lights as given, bit for bit.
  // |w| of the scaled lights, four lights a vector, for the error of products: 0 if w is a power of two,
  // since products are then exact; at least 2^-36 if scaling and flushing may lose w.
  inexact_w: array<vec4<f32>, 8>,
  // x: the largest of |x|, |y|, |z| of all scaled lights. y: the largest of all their |w| and `inexact_w`.
  magnitudes: vec2<f32>,
  count: u32,
  active_bits: u32, // The lowest `count` bits. In a scene those of lights that the caster does not have are 0.
  // The word of vertex 0 in the bound positions, and the words from one vertex to the next.
  position_offset: u32,
  position_stride: u32,
  reserved_0: u32,
  reserved_1: u32,
}

// The range of faces, edges or polygons of one dispatch. Bindings with an element for each item begin at item `first`.
struct Chunk {
  first: u32,
  count: u32,
  first_light: u32, // The index of the batch's first light among all lights, a multiple of 32.
  capacity: u32, // Entries that the list of each light has room for; for polygons, pieces.
  blocks: u32, // Blocks of BLOCK edges in the whole mesh; the last one may not be full. 0 for polygons.
  twisted_offset: u32, // The offset of the twisted masks behind the facing masks, for polygons. 0: no face is twisted.
}

// How counts of silhouette edges become draws.
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
  winding: u32, // Face 0 faces the light. If face 0 is twisted: the bit of face 1 for the direction of face 0.
}

// A binding that is only read cannot hold atomics.
#if STATISTICS_READ
alias StatisticsWord = u32;
#else
alias StatisticsWord = atomic<u32>;
#endif

// `chunks` and `list_sides` decide by `exact_zeros`, and `counting_methods` by `twisted_lights`. A polygon counts as a face.
struct ExtractionStatistics {
  non_finite_faces: StatisticsWord, // Faces with an infinite or NaN vertex. They face no light.
  // Lists that overflowed. The draws of their lights have an instance for every edge; the vertex shader drops the others.
  overflowed_lists: StatisticsWord,
  // Pairs of face and light that the filter passed to exact arithmetic, and those of them whose determinant is zero.
  undecided_pairs: StatisticsWord,
  exact_zeros: StatisticsWord,
  // Lights for which a polygon is twisted: as seen from the light, its boundary crosses itself or goes around the light, or
  // a hole is outside. Bit n stands for the lights n, n + 32, …
  twisted_lights: StatisticsWord,
}

// Statistics and the list of undecided faces. They share a binding, because a stage may have only eight storage buffers.
struct FacingRecord {
  statistics: ExtractionStatistics,
  // The number of undecided faces, including those that the list has no room for. Then their slots, in a single mesh counted
  // from the chunk's first face.
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
