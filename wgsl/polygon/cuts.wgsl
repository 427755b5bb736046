// Records of cuts, which only the passes of cut_edges.wgsl share. A cut is where an edge of an L-twisted outline is crossed by
// another as seen from the light. `cut_edges` writes the cuts of an edge as a row, in no particular order, and the edge's end
// behind them, into `pieces`: one record for each piece of the edge. `cut_edges_list` overwrites each record with the piece that
// ends at that cut. So a record must fit in the words of a piece. If a row does not fit the list, the records that do have
// NO_POLYGON, and no pass may use the row. `Turns:` is the most turns of the loop below it. docs/numerics/twisted-polygons.md.

#import extract/one_caster
#import polygon/list_pieces
#import polygon/outlines

// Where an edge is cut, or its end.
struct Cut {
  // The edge that cuts it, counted from the first of the outline, or `CORNER` for its end.
  by: u32,
  // The cutting edge has an end on it, in space.
  touches: bool,
  // If it touches: this is the cutting edge's second end.
  is_second: bool,
  // If it does not touch: the light that tells where it cuts, 0 as given, 1 to 3 an axis.
  tie: u32,
}

const CORNER: u32 = 0xffffu; // Outlines have at most 1,024 edges, so 16 bits hold them.
const TIE_SHIFT: u32 = 16u;
const TOUCHES: u32 = 0x40000000u;
const IS_SECOND: u32 = 0x80000000u;

fn packed_cut(cut: Cut) -> u32 {
  return cut.by | (cut.tie << TIE_SHIFT) | select(0u, TOUCHES, cut.touches) | select(0u, IS_SECOND, cut.is_second);
}

fn unpacked_cut(word: u32) -> Cut {
  return Cut(word & 0xffffu, (word & TOUCHES) != 0u, (word & IS_SECOND) != 0u, (word >> TIE_SHIFT) & 3u);
}

// Words of a cut: the polygon, or NO_POLYGON if there was no room for the row; the edge that is cut, with the highest bit if, as
// the light sees it, an odd number of triangles are next to its end on its left, and the next one if fixed point holds the
// outline's turns; the cut; the place in the light's list of the first of its row, and how many cuts that has, without the end.
const OF_POLYGON: u32 = 0u;
const OF_EDGE: u32 = 1u;
const CUT: u32 = 2u;
const ROW: u32 = 3u;
const ROW_CUTS: u32 = 4u;
// Then what `cut_edges_rank` writes: how many cuts of the row are before it by `is_before`; and how far along the edge it is,
// from 0 to 1, the bits of a rounded f32. Last what `cut_edges_before` finds: the cut right before it; and how many are before
// it, by RANK if all ranks of the row differ, else by ALONG.
const RANK: u32 = 5u;
const ALONG: u32 = 6u;
const CUT_BEFORE: u32 = 7u;
const EARLIER: u32 = 8u;
const NO_POLYGON: u32 = 0xffffffffu;
const IS_ODD_AT_END: u32 = 0x80000000u;
const HOLDS_TURNS: u32 = 0x40000000u;

// The part that all cuts of an edge have in common.
struct Row {
  polygon: u32,
  edge: u32,
  light: u32,
  first: u32,
  cuts: u32,
  is_odd_at_end: bool,
  holds_turns: bool,
}

// Takes room in a light's list for the cuts of an edge and for its end, and workgroups of the next passes for those that fit. A
// group is GROUP_CUTS places from a multiple of it on. Rooms follow each other in the list (`take_room`), so each group is
// counted once, by the row that has its first place.
fn take_row(light: u32, cuts: u32) -> u32 {
  let first = take_room(light, cuts + 1u);
  let listed = min(vec2<u32>(first, first + cuts + 1u), vec2<u32>(chunk.capacity));
  let groups = (listed + GROUP_CUTS - 1u) / GROUP_CUTS;
  if (groups.y > groups.x) {
    allot(ROW_COUNT, ROW_WORKGROUPS, groups.y - groups.x);
  }
  return first;
}

// Writes cut `number` of a row; the end is number `row.cuts`. Past the end of the list nothing is written.
fn write_cut(row: Row, number: u32, cut: Cut) {
  let place = row.first + number;
  if (place >= chunk.capacity) {
    return;
  }
  let at = piece_at(row.light, place);
  let fits = row.first + row.cuts < chunk.capacity;
  pieces.words[at + OF_POLYGON] = select(NO_POLYGON, row.polygon, fits);
  pieces.words[at + OF_EDGE] = row.edge | select(0u, IS_ODD_AT_END, row.is_odd_at_end)
    | select(0u, HOLDS_TURNS, row.holds_turns);
  pieces.words[at + CUT] = packed_cut(cut);
  pieces.words[at + ROW] = row.first;
  pieces.words[at + ROW_CUTS] = row.cuts;
}

// A record that is read.
struct Written {
  exists: bool, // The list has a place of this number. If not, all else but `place` is 0.
  has_row: bool, // There was room for the whole row. If not, `row` and `cut` mean nothing but for `row.light`.
  place: u32, // Its place in the light's list.
  // Where its words are.
  at: u32,
  row: Row,
  cut: Cut,
}

// Record `number` of a workgroup. Workgroups count through the groups of light 0, then those of light 1, and so on.
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
  let holds = (edge & HOLDS_TURNS) != 0u;
  written.row = Row(polygon, edge & 0xffffu, light, first, cuts, edge >= IS_ODD_AT_END, holds);
  written.cut = unpacked_cut(pieces.words[written.at + CUT]);
  return written;
}
