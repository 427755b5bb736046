// Outlines of polygons, and the lists of those that `f32` leaves undecided. NUMERICS.md, "Outlines".

// For each polygon, and once more at the end, where its outline begins and where its triangles begin; then the directed
// edges of all outlines. The highest bit of the first word is set if the outline is one loop, whose edges follow each other.
@group(0) @binding(6) var<storage, read> outlines: array<vec2<u32>>;
// The head, a record for each undecided polygon, and the entries that are decided by a workgroup each.
@group(0) @binding(7) var<storage, read_write> undecided: array<atomic<u32>>;

const ONE_LOOP: u32 = 0x80000000u;

// Words of the head: the workgroups of the indirect dispatch, the number of entries, the number of records.
const WORKGROUPS: u32 = 0u;
const ENTRY_COUNT: u32 = 3u;
const RECORD_COUNT: u32 = 4u;
const UNDECIDED_HEAD: u32 = 8u;

// Words of a record: the polygon and its undecided lights; then what is found for each of these lights. The last word is 1 if a
// corner is not finite.
const RECORD_WORDS: u32 = 8u;
const POLYGON: u32 = 0u;
const LIGHTS: u32 = 1u;
const FITS: u32 = 2u;
const IS_NOT_SIMPLE: u32 = 3u;
const WINDS_ONCE: u32 = 4u;
const WINDS_NEVER: u32 = 5u;
const OFF_PLANE: u32 = 6u;
const NOT_FINITE: u32 = 7u;

// Outlines up to this number of edges are decided by an invocation for each edge and light, and larger ones by a workgroup.
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

fn record_at(number: u32) -> u32 {
  return UNDECIDED_HEAD + RECORD_WORDS * number;
}

fn entry_at(number: u32) -> u32 {
  return UNDECIDED_HEAD + RECORD_WORDS * chunk.count + 2u * number;
}
