// Outlines of polygons and the lists of undecided ones, for all stages of polygons: `polygon_facing`, `polygon_turns`,
// `outline`, `polygon_masks`, `cut_edges`, `cut_quads`, in this order for each batch of up to 32 lights. An outline is the
// directed edges on a polygon's border, in one loop or several; edges that it walks both ways have cancelled. `undecided`
// holds: a head, the arguments of indirect dispatches, which is reset for each batch; a record for each polygon that is left
// to decide; and entries, each the work of one workgroup: some edges and lights of a record. Records and entries come in no
// particular order, and no result may depend on it. src/gpu/extract/polygon_buffers.rs writes the same layout and has the
// same constants. docs/numerics/polygons.md.

#import common/positions
#import extract/one_caster

// For each polygon, and once more at the end, where its outline begins, counted in edges, and where its triangles begin;
// then the directed edges of all outlines. The highest bit of the first word (ONE_LOOP) is set if the outline is one loop of
// at least three edges, each beginning where the one before it ends.
@group(0) @binding(6) var<storage, read> outlines: array<vec2<u32>>;
// The head, room for a record of each polygon, and the entries.
@group(0) @binding(7) var<storage, read_write> undecided: array<atomic<u32>>;

const ONE_LOOP: u32 = 0x80000000u;

// Words of the head: the three words of each of four indirect dispatches, with the number of its items behind them. The
// first is over records, OUTLINE_LANES of them a workgroup, for `polygon_turns`, `polygon_masks` and `cut_quads`; the second
// over entries, for `outline`. `polygon_masks` overwrites the entries by others, for `cut_edges`: the third is over these.
// The fourth is over groups of up to GROUP_CUTS of the cuts that `cut_edges` lists for one light.
const RECORD_WORKGROUPS: u32 = 0u;
const RECORD_COUNT: u32 = 3u;
const WORKGROUPS: u32 = 4u;
const ENTRY_COUNT: u32 = 7u;
const CUT_WORKGROUPS: u32 = 8u;
const CUT_COUNT: u32 = 11u;
const ROW_WORKGROUPS: u32 = 12u;
const ROW_COUNT: u32 = 15u;
const UNDECIDED_HEAD: u32 = 16u;
// Cuts of a group.
const GROUP_CUTS: u32 = 8u;

// Words of a record. POLYGON: the polygon, with bit 31 (NOT_FINITE) if a corner is not finite; so a word >= NOT_FINITE tells
// it. LIGHTS: bits of the lights that are undecided; after `polygon_masks`, of those for which `cut_edges` cuts the outline.
// FITS to OFF_PLANE: `outline` sets the bit of an undecided light if it finds this at any edge: all corners lie within a
// half-space seen from the light; the edge meets another, or the winding number of the outline on the edge's left is not 0
// or 1; it is 1; it is 0; the edge and a corner are not in one plane with the light. TWISTED_QUAD: lights for which f32 is
// certain that a quadrilateral is L-twisted (crosses itself as seen from the light); TURN_0, TURN_1: those of them that see
// a counter-clockwise turn at corner 0, at corner 1.
const RECORD_WORDS: u32 = 10u;
const POLYGON: u32 = 0u;
const LIGHTS: u32 = 1u;
const FITS: u32 = 2u;
const IS_NOT_SIMPLE: u32 = 3u;
const WINDS_ONCE: u32 = 4u;
const WINDS_NEVER: u32 = 5u;
const OFF_PLANE: u32 = 6u;
const TWISTED_QUAD: u32 = 7u;
const TURN_0: u32 = 8u;
const TURN_1: u32 = 9u;
const NOT_FINITE: u32 = 0x80000000u;

// An outline of up to so many edges, of a polygon of up to as many triangles, is small: an invocation takes an edge and a
// light of it. In a large one a workgroup does.
const SMALL_OUTLINE: u32 = 32u;
// Invocations of a workgroup of `polygon_turns`, `outline`, `polygon_masks`, `cut_edges`, `cut_quads`: their
// @workgroup_size.
const OUTLINE_LANES: u32 = 64u;
// The edges and lights of an entry of a small outline.
const ENTRY_EDGES: u32 = 4u;
const ENTRY_LIGHTS: u32 = 16u;
// Entries in a row of workgroups: as many as the device allows.
override ENTRY_ROW: u32 = 65535u;

struct OutlineRange {
  // The first edge, counted in `outlines`, and the number of edges.
  first: u32,
  count: u32,
  is_loop: bool,
  // Its triangles.
  first_triangle: u32,
  end_triangle: u32,
}

fn outline_of(polygon: u32) -> OutlineRange {
  let own = outlines[polygon];
  let next = outlines[polygon + 1u];
  let first = own.x & ~ONE_LOOP;
  return OutlineRange(chunk.count + 1u + first, (next.x & ~ONE_LOOP) - first, own.x >= ONE_LOOP, own.y, next.y);
}

fn is_large(outline: OutlineRange) -> bool {
  return max(outline.count, outline.end_triangle - outline.first_triangle) > SMALL_OUTLINE;
}

fn record_at(number: u32) -> u32 {
  return UNDECIDED_HEAD + RECORD_WORDS * number;
}

fn polygon_of(record: u32) -> u32 {
  return atomicLoad(&undecided[record + POLYGON]) & ~NOT_FINITE;
}

// Takes room for items of a dispatch, a workgroup each, by words of the head: the count at `count_at`, the dispatch from
// `workgroups_at` on, which grows to rows of ENTRY_ROW workgroups. Returns the number of the first item.
fn allot(count_at: u32, workgroups_at: u32, entries: u32) -> u32 {
  let place = atomicAdd(&undecided[count_at], entries);
  let end = place + entries;
  atomicMax(&undecided[workgroups_at], min(end, ENTRY_ROW));
  atomicMax(&undecided[workgroups_at + 1u], (end + ENTRY_ROW - 1u) / ENTRY_ROW);
  return place;
}

fn write_entry(place: u32, number: u32, part: u32) {
  atomicStore(&undecided[entry_at(place)], number);
  atomicStore(&undecided[entry_at(place) + 1u], part);
}

// Lists entries for some lights of record `number`: ENTRY_EDGES edges and ENTRY_LIGHTS lights of a small outline each, one
// edge and light of a large one. `count_at` and `workgroups_at` are the words of the head that count them.
fn list_work(number: u32, outline: OutlineRange, lights: u32, count_at: u32, workgroups_at: u32) {
  let edges = outline.count;
  if (is_large(outline)) {
    var place = allot(count_at, workgroups_at, edges * countOneBits(lights));
    for (var rest = lights; rest != 0u; rest &= rest - 1u) {
      // Turns: OUTLINE_EDGES.
      for (var edge = 0u; edge < edges; edge++) {
        write_entry(place, number, edge | (firstTrailingBit(rest) << 16u));
        place++;
      }
    }
    return;
  }
  let runs = (edges + ENTRY_EDGES - 1u) / ENTRY_EDGES;
  let halves = vec2<bool>((lights & 0xffffu) != 0u, lights > 0xffffu);
  let place = allot(count_at, workgroups_at, runs * (select(0u, 1u, halves.x) + select(0u, 1u, halves.y)));
  // Turns: SMALL_OUTLINE / ENTRY_EDGES.
  for (var run = 0u; run < runs; run++) {
    if (halves.x) {
      write_entry(place + run, number, ENTRY_EDGES * run);
    }
    if (halves.y) {
      write_entry(place + select(0u, runs, halves.x) + run, number, (ENTRY_EDGES * run) | (1u << 16u));
    }
  }
}

// Where the two words of an entry are: its record's number; and its first edge, counted from the outline's first, with in
// the upper half the light, or for a small outline which ENTRY_LIGHTS lights: 0 or 1.
fn entry_at(number: u32) -> u32 {
  return UNDECIDED_HEAD + RECORD_WORDS * chunk.count + 2u * number;
}

// The bits of a position. Both zeros are one, so that equal bits are equal places.
fn place_of(vertex: u32) -> vec3<u32> {
  let bits = position_bits(vertex, position_offset(), position_stride());
  return select(bits, vec3<u32>(0u), bits == vec3<u32>(0x80000000u));
}

// The directed edge of an outline.
struct Edge {
  a: vec3<u32>,
  b: vec3<u32>,
  has_length: bool,
}

fn edge_at(index: u32) -> Edge {
  let ends = outlines[index];
  let a = place_of(ends.x);
  let b = place_of(ends.y);
  return Edge(a, b, any(a != b));
}

// The edge of an outline and the light that an invocation takes from an entry. In a large outline all invocations of a
// workgroup have the same.
struct Work {
  exists: bool, // False also for an edge without length, or a light that is not among the record's LIGHTS.
  is_large: bool,
  edge: Edge,
  index: u32, // The edge's number in the outline.
  place: u32, // The light's bit.
}

// `part` is the second word of an entry, and `lights` the record's LIGHTS.
fn work_of(outline: OutlineRange, part: u32, lights: u32, lane: u32) -> Work {
  var work: Work;
  work.is_large = is_large(outline);
  work.index = part & 0xffffu;
  work.place = part >> 16u;
  if (!work.is_large) {
    work.index += lane % ENTRY_EDGES;
    work.place = ENTRY_LIGHTS * work.place + lane / ENTRY_EDGES;
  }
  work.exists = work.index < outline.count && ((lights >> (work.place % 32u)) & 1u) != 0u;
  if (work.exists) {
    work.edge = edge_at(outline.first + work.index);
    work.exists = work.edge.has_length;
  }
  return work;
}
