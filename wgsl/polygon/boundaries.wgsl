// Boundaries of polygons and the lists of undecided polygons, for all stages of polygons: `polygon_facing`, `polygon_turns`,
// `polygon_pairs`, `polygon_masks`, `cut_edges`, `cut_quads`, in this order for each batch of up to 32 lights. A boundary is
// the directed edges around a polygon, in one loop or several; edges that it walks both ways have cancelled. `undecided`
// holds: a head, the arguments of indirect dispatches, reset for each batch; a record for each polygon to decide; and
// entries, each some edges and lights of a record for one workgroup. Records and entries come in no particular order, and no
// result may depend on it. src/gpu/extract/polygon_buffers.rs has the same layout and constants, but offsets in the head in
// bytes. docs/numerics/polygons.md.

#import common/positions
#import extract/one_caster

// For each polygon, and once more at the end: the index of its first edge among the edges, and its first triangle. ONE_LOOP
// in the first word: the boundary is one loop of at least three edges, each beginning where the previous one ends. Then the
// directed edges of all boundaries, as two vertices each.
@group(0) @binding(6) var<storage, read> boundaries: array<vec2<u32>>;
// The head, a record for each polygon, and the entries.
@group(0) @binding(7) var<storage, read_write> undecided: array<atomic<u32>>;

const ONE_LOOP: u32 = 0x80000000u;

// Words of the head. Four times: three words of workgroups, the arguments of indirect dispatches, then, at COUNT_WORD, the
// number of items.
// * RECORD_…: records, BOUNDARY_LANES a workgroup, for `polygon_turns`, `polygon_masks` and `cut_quads`.
// * ENTRY_COUNT, WORKGROUPS: entries for `polygon_pairs`, a workgroup each.
// * CUT_COUNT, CUT_WORKGROUPS: entries for `cut_edges`, by which `polygon_masks` overwrites those for
//   `polygon_pairs`.
// * CUT_GROUP_…: groups of up to GROUP_CUTS records of cuts, a workgroup each, for the later passes of `cut_edges`.
const COUNT_WORD: u32 = 3u;
const RECORD_WORKGROUPS: u32 = 0u;
const RECORD_COUNT: u32 = RECORD_WORKGROUPS + COUNT_WORD;
const WORKGROUPS: u32 = 4u;
const ENTRY_COUNT: u32 = WORKGROUPS + COUNT_WORD;
const CUT_WORKGROUPS: u32 = 8u;
const CUT_COUNT: u32 = CUT_WORKGROUPS + COUNT_WORD;
const CUT_GROUP_WORKGROUPS: u32 = 12u;
const UNDECIDED_HEAD: u32 = 16u;
// Records of a group of cuts (polygon/cuts.wgsl).
const GROUP_CUTS: u32 = 8u;

// Words of a record.
// * POLYGON: the polygon, with bit 31 (NOT_FINITE) if a corner is not finite.
// * LIGHTS: bits of the undecided lights, with NOT_FINITE all active ones; after `polygon_masks`, those for which `cut_edges`
//   cuts the boundary.
// * IN_HALF_SPACE to OFF_PLANE: `polygon_pairs` sets a light's bit if one edge shows it. All corners lie in a half-space as
//   seen from the light; the edge meets another, or the winding number on its left is not 0 or 1; that number is 1; it is 0;
//   the edge and a corner are not in one plane with the light.
// * TWISTED_QUAD: lights for which f32 proves that a quadrilateral is twisted (its boundary crosses itself as seen from
//   the light).
// * TURN_0, TURN_1: lights that see a counter-clockwise turn at corner 0, at corner 1. Only bits of TWISTED_QUAD are valid.
const RECORD_WORDS: u32 = 10u;
const POLYGON: u32 = 0u;
const LIGHTS: u32 = 1u;
const IN_HALF_SPACE: u32 = 2u;
const IS_NOT_SIMPLE: u32 = 3u;
const WINDS_ONCE: u32 = 4u;
const WINDS_NEVER: u32 = 5u;
const OFF_PLANE: u32 = 6u;
const TWISTED_QUAD: u32 = 7u;
const TURN_0: u32 = 8u;
const TURN_1: u32 = 9u;
const NOT_FINITE: u32 = 0x80000000u;

// A boundary with up to this many edges, of a polygon with up to as many triangles, is small. For a small boundary an
// invocation has an edge and a light, for a large one a workgroup does.
const SMALL_BOUNDARY: u32 = 32u;
// Invocations of a workgroup of `polygon_turns`, `polygon_pairs`, `polygon_masks`, `cut_edges`, `cut_quads`: their
// @workgroup_size.
const BOUNDARY_LANES: u32 = 64u;
// The edges and lights of an entry of a small boundary. Their product is BOUNDARY_LANES.
const ENTRY_EDGES: u32 = 4u;
const ENTRY_LIGHTS: u32 = 16u;
// Workgroups in a row of an indirect dispatch: as many as the device allows.
override ENTRY_ROW: u32 = 65535u;

struct PolygonBoundary {
  // The index of its first edge in `boundaries`, and the number of edges.
  first: u32,
  count: u32,
  is_loop: bool,
  // Its triangles.
  first_triangle: u32,
  end_triangle: u32,
}

fn boundary_of(polygon: u32) -> PolygonBoundary {
  let first_words = boundaries[polygon];
  let next_words = boundaries[polygon + 1u];
  let first = first_words.x & ~ONE_LOOP;
  return PolygonBoundary(
    chunk.count + 1u + first,
    (next_words.x & ~ONE_LOOP) - first,
    first_words.x >= ONE_LOOP,
    first_words.y,
    next_words.y,
  );
}

fn is_large(boundary: PolygonBoundary) -> bool {
  return max(boundary.count, boundary.end_triangle - boundary.first_triangle) > SMALL_BOUNDARY;
}

// The offset of a record in `undecided`.
fn record_offset(index: u32) -> u32 {
  return UNDECIDED_HEAD + RECORD_WORDS * index;
}

// The polygon of the record at word `offset` of `undecided`.
fn polygon_of(offset: u32) -> u32 {
  return atomicLoad(&undecided[offset + POLYGON]) & ~NOT_FINITE;
}

// Reserves items of a dispatch, a workgroup each, and returns the index of the first. `workgroups_word` is the first word of
// the dispatch in the head. Its workgroups are in rows of ENTRY_ROW.
fn reserve_entries(workgroups_word: u32, entries: u32) -> u32 {
  let first = atomicAdd(&undecided[workgroups_word + COUNT_WORD], entries);
  let end = first + entries;
  atomicMax(&undecided[workgroups_word], min(end, ENTRY_ROW));
  // Rounded up without a sum that could wrap: a device without a limit has 2^32 - 1.
  atomicMax(&undecided[workgroups_word + 1u], end / ENTRY_ROW + min(end % ENTRY_ROW, 1u));
  return first;
}

fn write_entry(index: u32, record_index: u32, part: u32) {
  atomicStore(&undecided[entry_offset(index)], record_index);
  atomicStore(&undecided[entry_offset(index) + 1u], part);
}

// Lists entries for `lights`, the LIGHTS of a record: ENTRY_EDGES edges and ENTRY_LIGHTS lights each for a small boundary,
// one edge and light for a large one. `workgroups_word`: see `reserve_entries`.
fn list_entries(record_index: u32, boundary: PolygonBoundary, lights: u32, workgroups_word: u32) {
  let edges = boundary.count;
  if (is_large(boundary)) {
    var index = reserve_entries(workgroups_word, edges * countOneBits(lights));
    for (var remaining = lights; remaining != 0u; remaining &= remaining - 1u) {
      // Turns: BOUNDARY_EDGES.
      for (var edge = 0u; edge < edges; edge++) {
        write_entry(index, record_index, edge | (firstTrailingBit(remaining) << 16u));
        index++;
      }
    }
    return;
  }
  let entry_rows = (edges + ENTRY_EDGES - 1u) / ENTRY_EDGES;
  let has_half = vec2<bool>((lights & 0xffffu) != 0u, lights > 0xffffu);
  let first = reserve_entries(
    workgroups_word, entry_rows * (select(0u, 1u, has_half.x) + select(0u, 1u, has_half.y)));
  // Turns: SMALL_BOUNDARY / ENTRY_EDGES.
  for (var entry_row = 0u; entry_row < entry_rows; entry_row++) {
    if (has_half.x) {
      write_entry(first + entry_row, record_index, ENTRY_EDGES * entry_row);
    }
    if (has_half.y) {
      write_entry(
        first + select(0u, entry_rows, has_half.x) + entry_row, record_index, (ENTRY_EDGES * entry_row) | (1u << 16u));
    }
  }
}

// The offset of an entry's two words: the record's index; and the first edge, counted from the boundary's first, with, in
// the upper half, the light index, or for a small boundary which ENTRY_LIGHTS lights: 0 or 1.
fn entry_offset(index: u32) -> u32 {
  return UNDECIDED_HEAD + RECORD_WORDS * chunk.count + 2u * index;
}

// The bits of a position. -0 becomes 0, so that equal positions have equal bits.
fn position_of(vertex: u32) -> vec3<u32> {
  let bits = position_bits(vertex, position_offset(), position_stride());
  return select(bits, vec3<u32>(0u), bits == vec3<u32>(0x80000000u));
}

// A directed edge of a boundary.
struct Edge {
  a: vec3<u32>,
  b: vec3<u32>,
  has_length: bool,
}

fn load_edge(index: u32) -> Edge {
  let ends = boundaries[index];
  let a = position_of(ends.x);
  let b = position_of(ends.y);
  return Edge(a, b, any(a != b));
}

// The edge and the light of an invocation. For a large boundary all invocations of a workgroup have the same.
struct Work {
  exists: bool, // False also for an edge without length, and for a light that is not among the record's LIGHTS.
  is_large: bool,
  edge: Edge,
  edge_index: u32, // The edge's index in the boundary.
  light_index: u32, // The light index, which is the light's bit.
}

// The work of invocation `lane` for an entry. `part`: its second word. `lights`: the record's LIGHTS.
fn work_of(boundary: PolygonBoundary, part: u32, lights: u32, lane: u32) -> Work {
  var work: Work;
  work.is_large = is_large(boundary);
  work.edge_index = part & 0xffffu;
  work.light_index = part >> 16u;
  if (!work.is_large) {
    work.edge_index += lane % ENTRY_EDGES;
    work.light_index = ENTRY_LIGHTS * work.light_index + lane / ENTRY_EDGES;
  }
  work.exists = work.edge_index < boundary.count && ((lights >> (work.light_index % 32u)) & 1u) != 0u;
  if (work.exists) {
    work.edge = load_edge(boundary.first + work.edge_index);
    work.exists = work.edge.has_length;
  }
  return work;
}
