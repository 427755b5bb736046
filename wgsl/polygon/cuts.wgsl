// Cuts of edges. Until a piece is listed, its place has the cut at which it ends. The cuts of an edge are in a row, with its end
// behind them. The passes of cut_edges.wgsl share these records; no other stage reads them. docs/numerics/twisted-polygons.md.

#import extract/one_caster
#import polygon/list_pieces
#import polygon/outlines

// Where an edge is cut, or its end.
struct Cut {
  // The edge that cuts it, or `CORNER` for its end.
  by: u32,
  // The cutting edge has an end on it, in space, and this is its second end.
  touches: bool,
  is_second: bool,
}

const CORNER: u32 = 0xffffu;
const TOUCHES: u32 = 0x40000000u;
const IS_SECOND: u32 = 0x80000000u;

fn packed_cut(cut: Cut) -> u32 {
  return cut.by | select(0u, TOUCHES, cut.touches) | select(0u, IS_SECOND, cut.is_second);
}

fn unpacked_cut(word: u32) -> Cut {
  return Cut(word & 0xffffu, (word & TOUCHES) != 0u, (word & IS_SECOND) != 0u);
}

// Words of a cut: the polygon, or none if there was no room for the row; the edge that is cut, with the highest bit if an odd number
// of triangles are on its left at its end; the cut; the place of the first of the row, and how many cuts it has, without the end.
const OF_POLYGON: u32 = 0u;
const OF_EDGE: u32 = 1u;
const CUT: u32 = 2u;
const ROW: u32 = 3u;
const ROW_CUTS: u32 = 4u;
// Then how many of the row are before it as turns tell, and how far along the edge it is; and what follows from those of the row: the
// cut before it, and how many are.
const RANK: u32 = 5u;
const ALONG: u32 = 6u;
const CUT_BEFORE: u32 = 7u;
const EARLIER: u32 = 8u;
const NO_POLYGON: u32 = 0xffffffffu;
const IS_ODD_AT_END: u32 = 0x80000000u;

// The part that all cuts of an edge have in common.
struct Row {
  polygon: u32,
  edge: u32,
  light: u32,
  first: u32,
  cuts: u32,
  is_odd_at_end: bool,
}

// Takes room for the cuts of an edge and for its end, and workgroups for those there is room for.
fn take_row(light: u32, cuts: u32) -> u32 {
  let first = take_room(light, cuts + 1u);
  let listed = min(vec2<u32>(first, first + cuts + 1u), vec2<u32>(chunk.capacity));
  let groups = (listed + GROUP_CUTS - 1u) / GROUP_CUTS;
  if (groups.y > groups.x) {
    allot(ROW_COUNT, ROW_WORKGROUPS, groups.y - groups.x);
  }
  return first;
}

fn write_cut(row: Row, number: u32, cut: Cut) {
  let place = row.first + number;
  if (place >= chunk.capacity) {
    return;
  }
  let at = piece_at(row.light, place);
  let fits = row.first + row.cuts < chunk.capacity;
  pieces.words[at + OF_POLYGON] = select(NO_POLYGON, row.polygon, fits);
  pieces.words[at + OF_EDGE] = row.edge | select(0u, IS_ODD_AT_END, row.is_odd_at_end);
  pieces.words[at + CUT] = packed_cut(cut);
  pieces.words[at + ROW] = row.first;
  pieces.words[at + ROW_CUTS] = row.cuts;
}

// A cut that is written.
struct Written {
  // There is a place of this number. False for the row: there was no room for it.
  exists: bool,
  has_row: bool,
  place: u32,
  // Where its words are.
  at: u32,
  row: Row,
  cut: Cut,
}

// One of the cuts of a workgroup, which are in one light's list.
fn written_cut(workgroup: u32, number: u32) -> Written {
  var written: Written;
  var group = workgroup;
  var light = 0u;
  var count = 0u;
  // Turns: 32.
  for (; light < 32u; light++) {
    count = min(atomicLoad(&pieces.counts[light]), chunk.capacity);
    let groups = (count + GROUP_CUTS - 1u) / GROUP_CUTS;
    if (group < groups) {
      break;
    }
    group -= groups;
    count = 0u;
  }
  written.place = GROUP_CUTS * group + number;
  written.exists = written.place < count;
  if (!written.exists) {
    return written;
  }
  written.at = piece_at(light, written.place);
  let polygon = pieces.words[written.at + OF_POLYGON];
  written.has_row = polygon != NO_POLYGON;
  let edge = pieces.words[written.at + OF_EDGE];
  let first = pieces.words[written.at + ROW];
  let cuts = pieces.words[written.at + ROW_CUTS];
  written.row = Row(polygon, edge & ~IS_ODD_AT_END, light, first, cuts, edge >= IS_ODD_AT_END);
  written.cut = unpacked_cut(pieces.words[written.at + CUT]);
  return written;
}
