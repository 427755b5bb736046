// Outlines of polygons, their edges at their places, the lists of those that `f32` leaves undecided, and the edge and light that an
// invocation takes from such a list. All stages of polygons import it. docs/numerics/polygons.md.

#import common/positions
#import extract/one_caster

// For each polygon, and once more at the end, where its outline begins and where its triangles begin; then the directed
// edges of all outlines. The highest bit of the first word is set if the outline is one loop, whose edges follow each other.
@group(0) @binding(6) var<storage, read> outlines: array<vec2<u32>>;
// The head, a record for each undecided polygon, and the entries that are decided by a workgroup each.
@group(0) @binding(7) var<storage, read_write> undecided: array<atomic<u32>>;

const ONE_LOOP: u32 = 0x80000000u;

// Words of the head: four indirect dispatches, each with the number of its items behind it. The first is over records, the second
// over entries. `polygon_masks` makes entries of its own, for `cut_edges`: the third is over them. That lists cuts: the fourth is
// over groups of these, which are in the list of one light.
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

// Words of a record: the polygon, with the highest bit if a corner is not finite, and its undecided lights; then what is found for
// each of these lights. Then the lights for which a quadrilateral is L-twisted as `f32` tells, and those for which its turns at
// corners 0 and 1 are positive. In the end the second word has the lights for which `cut_edges` cuts it.
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

// Outlines up to this number of edges, of polygons up to as many triangles, are decided by an invocation for each edge and light,
// and larger ones by a workgroup.
const SMALL_OUTLINE: u32 = 32u;
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

// Room for entries, and workgroups for them.
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

// Lists what is to do for some lights of a record: of a small outline runs of edges and lights, of a large one each edge and light.
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

fn entry_at(number: u32) -> u32 {
  return UNDECIDED_HEAD + RECORD_WORDS * chunk.count + 2u * number;
}

// Edges of outlines at their places.

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

// The work of an invocation: an edge of an outline and a light, from an entry.

// The edge that an invocation decides, for a light. The invocations of a large outline share one.
struct Work {
  exists: bool,
  is_large: bool,
  edge: Edge,
  index: u32,
  place: u32,
}

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
