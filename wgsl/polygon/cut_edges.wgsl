// Cut edges: lists the pieces of L-twisted polygons, whose outlines cross themselves as seen from light L. A piece is a part
// of an edge between cuts, wound so that what the polygon darkens is on its left. Four passes for each batch, after
// `polygon_masks` and only with lists; each reads in `pieces` what the one before wrote. `cut_edges`: a workgroup an entry,
// edges and lights that `polygon_masks` listed; finds what cuts each edge. `cut_edges_rank`: a workgroup for 8 cuts; counts
// how many cuts of its edge come before each. `cut_edges_before`: an invocation a cut; finds the one right before.
// `cut_edges_list`: the same; writes the piece between both. Pieces come in any order; polygon/list_pieces.wgsl names their
// readers. Cutting edges and dark sides are exact; orders are, but for those that `is_before` rounds. The same number of
// pieces begin at a point as end there, bit for bit, so edges that cross must agree on order and point. `turn` is that of
// three points (polygon/turn.wgsl); `Turns:` is the most turns of the loop below it. docs/numerics/twisted-polygons.md.

#import common/exact_sign
#import extract/one_caster
#import polygon/cuts
#import polygon/list_pieces
#import polygon/outlines
#import polygon/turn

@group(0) @binding(8) var<storage, read> faces: array<u32>;

// Bit 0: an odd number of the polygon's triangles are, as the light sees them, next to the edge's end on its left. An
// element an invocation; with a large outline, whose invocations share an edge, the first.
var<workgroup> odd: array<atomic<u32>, 64>;
// The window of bits of the outline's corners: its begin, as how far it is below `EXPONENT_LIMIT`, and its end. An element
// as for `odd`.
var<workgroup> below_far: array<atomic<i32>, 64>;
var<workgroup> above: array<atomic<i32>, 64>;
// How many cuts each invocation found, and the place in the light's list where the row of cuts of its edge begins.
var<workgroup> found_counts: array<u32, 64>;
var<workgroup> rows: array<u32, 64>;
// For each of 8 cuts of a workgroup of `cut_edges_rank` how many are before it.
var<workgroup> ranks: array<atomic<u32>, 8>;
// Invocations that share the orders of a cut with all others.
const RANK_LANES: u32 = 8u;
// With more cuts, those of an edge are ordered by how far along they are, which is rounded.
const MOST_ORDERED: u32 = 256u;

// How an edge lies on another that is on the same line. Sides and ends are those seen in the direction in which coordinates
// grow.
struct InLine {
  // It ends within the other, which it cuts there.
  cuts: bool,
  // It lies beside the end of the other, on the left of the other's own direction.
  is_left_at_end: bool,
  // Its upper end.
  end: vec3<u32>,
}

// Finds how edge `f`, number `item` of the outline, overlaps edge `e`, number `index`, on the same line in space.
fn in_line(f: Edge, item: u32, e: Edge, index: u32) -> InLine {
  let own = in_space(e);
  let theirs = in_space(f);
  let is_before = precedes(theirs, item, own, index);
  let is_up = all(own.a == e.a);
  let cuts = is_before && is_below(own.a, theirs.b) && is_below(theirs.b, own.b);
  let is_left = select(
    !is_before && all(theirs.a == own.a),
    is_before && !is_below(theirs.b, own.b),
    is_up,
  );
  return InLine(cuts, is_left, theirs.b);
}

// Whether edges (p, q) and (a, b), which must be on one line in space, have the same direction.
fn runs_alike(p: vec3<u32>, q: vec3<u32>, a: vec3<u32>, b: vec3<u32>) -> bool {
  let up = ordered(p) < ordered(q);
  return any((p != q) & (a != b) & (up == (ordered(a) < ordered(b))));
}

// The edges that an invocation finds to cut its edge, a bit for each. With a large outline it takes every 64th edge: bit n
// is edge 64 n + lane.
struct Found {
  cuts: u32,
  // The cuts that have an end on it, in space, and the cuts of which it is the second end.
  touches: u32,
  touches_second: u32,
  // The two bits of `tie` of each cut.
  ties: vec2<u32>,
  // The window of bits of the corners of the edges it took: begin and end.
  span: vec2<i32>,
}

// Finds the edges that cut the edge, and whether an odd number of triangles have the directions next to its end, on its
// left: it flips `odd` for each. Both are in one loop, first over edges, then over triangles, so that `turn` is compiled
// once.
fn take_cuts(outline: OutlineRange, work: Work, lane: u32) -> Found {
  let slot = select(lane, 0u, work.is_large);
  let step = select(1u, OUTLINE_LANES, work.is_large);
  let e = work.edge;
  var found_cuts: Found;
  found_cuts.span = select(vec2<i32>(EXPONENT_LIMIT, -EXPONENT_LIMIT), bit_window_of(float_parts(e.a)), work.exists);
  let is_up = is_below(e.a, e.b);
  let triangles = outline.end_triangle - outline.first_triangle;
  let end = select(0u, outline.count + triangles, work.exists);
  // Turns: CUT_ITEMS.
  for (var item = select(0u, lane, work.is_large); item < end; item += step) {
    let is_edge = item < outline.count;
    var corners: array<vec3<u32>, 3>;
    if (is_edge) {
      let f = edge_at(outline.first + item);
      if (item == work.index || !f.has_length) {
        continue;
      }
      found_cuts.span = hull(found_cuts.span, bit_window_of(float_parts(f.a)));
      corners[0] = f.a;
      corners[1] = f.b;
    } else {
      let face = 3u * (outline.first_triangle + item - outline.count);
      corners = array<vec3<u32>, 3>(place_of(faces[face]), place_of(faces[face + 1u]), place_of(faces[face + 2u]));
    }
    // For an edge f the sides of e.a and e.b at f, then those of f's ends at e. For a triangle its own turn, then for each
    // of its edges the sides of e.b and e.a.
    var signs: array<i32, 7>;
    var tie = IN_LINE;
    // Turns: CUT_TESTS in all.
    for (var test = 0u; test < select(7u, 4u, is_edge); test++) {
      var p = corners[0];
      var q = corners[1];
      var r = e.a;
      if (is_edge) {
        if (test >= 2u) {
          p = e.a;
          q = e.b;
          r = corners[test - 2u];
        } else if (test == 1u) {
          r = e.b;
        }
      } else if (test == 0u) {
        r = corners[2];
      } else {
        let side = (test - 1u) / 2u;
        if (test % 2u == 0u && signs[test - 1u] != 0) {
          continue;
        }
        p = corners[side];
        q = corners[(side + 1u) % 3u];
        r = e.b;
        if (test % 2u == 0u) {
          r = e.a;
        }
      }
      let found = turn(p, q, r, work.place);
      signs[test] = found.moved;
      tie = select(tie, min(tie, found.tie), test < 2u);
    }
    if (is_edge) {
      let bit = 1u << select(item, item / OUTLINE_LANES, work.is_large);
      var touch = signs[2] == 0 || signs[3] == 0;
      var is_second = signs[3] == 0;
      // Points on the line of the edge are on the right of the direction in which coordinates grow.
      let left = select(vec2<bool>(signs[2] >= 0, signs[3] >= 0), vec2<bool>(signs[2] > 0, signs[3] > 0), is_up);
      var crosses = signs[0] * signs[1] < 0 && left.x != left.y && (touch || signs[2] == signs[1]);
      if (signs[2] == 0 && signs[3] == 0) {
        let f = Edge(corners[0], corners[1], true);
        let found = in_line(f, item, e, work.index);
        crosses = found.cuts;
        is_second = all(found.end == f.b);
        if (found.is_left_at_end) {
          atomicXor(&odd[slot], 1u);
        }
      }
      if (crosses) {
        found_cuts.cuts |= bit;
        found_cuts.touches |= select(0u, bit, touch);
        found_cuts.touches_second |= select(0u, bit, touch && is_second);
        found_cuts.ties |= select(vec2<u32>(0u), vec2<u32>(bit), (vec2<u32>(tie) & vec2<u32>(1u, 2u)) != vec2<u32>(0u));
      }
      continue;
    }
    var holds = signs[0] != 0;
    for (var side = 0u; side < 3u; side++) {
      var sign = signs[2u * side + 1u];
      if (sign == 0) {
        sign = signs[2u * side + 2u];
      }
      if (sign == 0) {
        sign = select(-1, 1, runs_alike(corners[side], corners[(side + 1u) % 3u], e.a, e.b));
      }
      holds = holds && sign == signs[0];
    }
    if (holds) {
      atomicXor(&odd[slot], 1u);
    }
  }
  return found_cuts;
}

@compute @workgroup_size(64)
fn cut_edges(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let number = group.y * ENTRY_ROW + group.x;
  var work: Work;
  var own: OutlineRange;
  var polygon = 0u;
  if (number < atomicLoad(&undecided[CUT_COUNT])) {
    let record = record_at(atomicLoad(&undecided[entry_at(number)]));
    polygon = polygon_of(record);
    own = outline_of(polygon);
    // Its lights are those for which it is cut by now.
    work = work_of(own, atomicLoad(&undecided[entry_at(number) + 1u]), atomicLoad(&undecided[record + LIGHTS]), lane);
  }
  let found = take_cuts(own, work, lane);
  found_counts[lane] = countOneBits(found.cuts);
  let slot = select(lane, 0u, work.is_large);
  atomicMax(&below_far[slot], EXPONENT_LIMIT - found.span.x);
  atomicMax(&above[slot], found.span.y);
  workgroupBarrier();
  var cuts = 0u;
  var place = 0u;
  // Turns: OUTLINE_LANES.
  for (var other = slot; other < select(lane + 1u, OUTLINE_LANES, work.is_large); other++) {
    place = select(place, cuts, other == lane);
    cuts += found_counts[other];
  }
  let has_row = work.exists && slot == lane;
  if (has_row) {
    rows[slot] = take_row(work.place, cuts);
  }
  workgroupBarrier();
  if (!work.exists) {
    return;
  }
  let span = vec2<i32>(EXPONENT_LIMIT - atomicLoad(&below_far[slot]), atomicLoad(&above[slot]));
  let holds = holds_turns(span, given_light(work.place));
  let is_odd_at_end = (atomicLoad(&odd[slot]) & 1u) != 0u;
  let row = Row(polygon, work.index, work.place, rows[slot], cuts, is_odd_at_end, holds);
  for (var rest = found.cuts; rest != 0u; rest &= rest - 1u) {
    let item = firstTrailingBit(rest);
    let bit = 1u << item;
    let by = select(item, OUTLINE_LANES * item + lane, work.is_large);
    let tie = select(vec2<u32>(0u), vec2<u32>(1u, 2u), (found.ties & vec2<u32>(bit)) != vec2<u32>(0u));
    let cut = Cut(
      by,
      (found.touches & bit) != 0u,
      (found.touches_second & bit) != 0u,
      select(0u, tie.x | tie.y, holds),
    );
    write_cut(row, place, cut);
    place++;
  }
  if (has_row) {
    write_cut(row, cuts, Cut(CORNER, false, false, 0u));
  }
}

// The edge that the cuts of a row cut.
fn edge_of(row: Row) -> CutEdge {
  let outline = outline_of(row.polygon);
  return CutEdge(outline, edge_at(outline.first + row.edge), row.edge, row.light, row.holds_turns);
}

@compute @workgroup_size(64)
fn cut_edges_rank(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let slot = lane / RANK_LANES;
  let own = written_cut(group.y * ENTRY_ROW + group.x, slot);
  let is_cut = own.has_row && own.cut.by != CORNER;
  var edge: CutEdge;
  if (is_cut) {
    edge = edge_of(own.row);
  }
  let count = select(0u, own.row.cuts, is_cut && own.row.cuts <= MOST_ORDERED);
  var rank = 0u;
  // Turns: MOST_ORDERED / RANK_LANES.
  for (var number = lane % RANK_LANES; number < count; number += RANK_LANES) {
    let place = own.row.first + number;
    let other = unpacked_cut(pieces.words[piece_at(own.row.light, place) + CUT]);
    if (place != own.place && is_before(edge, other, own.cut)) {
      rank++;
    }
  }
  atomicAdd(&ranks[slot], rank);
  workgroupBarrier();
  if (is_cut && lane % RANK_LANES == 0u) {
    pieces.words[own.at + RANK] = atomicLoad(&ranks[slot]);
    // Bits of numbers that are not negative have their order, and tell it of those that are none, too.
    pieces.words[own.at + ALONG] = bitcast<u32>(abs(place_along(edge, own.cut)));
  }
}

// Whether the ranks of a row are no order: two are equal, or they were not computed.
fn is_tangled(row: Row) -> bool {
  if (row.cuts > MOST_ORDERED) {
    return true;
  }
  // A bit for each rank.
  var taken: array<u32, 8>;
  var is_twice = false;
  // Turns: MOST_ORDERED.
  for (var number = 0u; number < row.cuts; number++) {
    let rank = pieces.words[piece_at(row.light, row.first + number) + RANK];
    let bit = 1u << (rank % 32u);
    is_twice = is_twice || (taken[(rank / 32u) % 8u] & bit) != 0u;
    taken[(rank / 32u) % 8u] |= bit;
  }
  return is_twice;
}

// The key by which cuts of a row are compared: the rank, or how far along the edge the cut is (bits of an f32 from 0 on,
// which have its order), and then the edge that cuts. The end comes last.
fn order_of(row: Row, place: u32, by_turns: bool) -> vec2<u32> {
  let at = piece_at(row.light, place);
  let cut = unpacked_cut(pieces.words[at + CUT]);
  if (cut.by == CORNER) {
    return vec2<u32>(0xffffffffu);
  }
  return vec2<u32>(pieces.words[at + select(ALONG, RANK, by_turns)], cut.by);
}

fn is_less(p: vec2<u32>, q: vec2<u32>) -> bool {
  return p.x < q.x || (p.x == q.x && p.y < q.y);
}

@compute @workgroup_size(8)
fn cut_edges_before(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let own = written_cut(group.y * ENTRY_ROW + group.x, lane);
  if (!own.has_row) {
    return;
  }
  let by_turns = !is_tangled(own.row);
  let end = order_of(own.row, own.place, by_turns);
  var earlier = 0u;
  var last = vec2<u32>(0u);
  var before = packed_cut(Cut(CORNER, false, false, 0u));
  // Turns: OUTLINE_EDGES.
  for (var number = 0u; number < own.row.cuts; number++) {
    let place = own.row.first + number;
    let order = order_of(own.row, place, by_turns);
    if (is_less(order, end)) {
      if (earlier == 0u || is_less(last, order)) {
        last = order;
        before = pieces.words[piece_at(own.row.light, place) + CUT];
      }
      earlier++;
    }
  }
  pieces.words[own.at + CUT_BEFORE] = before;
  pieces.words[own.at + EARLIER] = earlier;
}

// Where a cut is, in space: `corner` for the end, the end that touches, or the point where both edges cross as the light
// sees them.
fn place_of_cut(edge: CutEdge, cut: Cut, corner: vec3<u32>) -> vec3<u32> {
  if (cut.by == CORNER) {
    return corner;
  }
  let touch = touch_of(edge.outline, cut);
  if (touch.w == 1u) {
    return touch.xyz;
  }
  return crossing_point(edge.outline, edge.index, cut.by, edge.light);
}

@compute @workgroup_size(8)
fn cut_edges_list(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let own = written_cut(group.y * ENTRY_ROW + group.x, lane);
  if (!own.exists) {
    return;
  }
  let light = own.row.light;
  if (!own.has_row) {
    // The list is too short, as its count tells. Until it is made anew this is a piece without length.
    write_piece(light, own.place, vec3<u32>(0u), vec3<u32>(0u), false, vec3<u32>(0u));
    return;
  }
  let edge = edge_of(own.row);
  let before = unpacked_cut(pieces.words[own.at + CUT_BEFORE]);
  // The last piece ends at the end of the edge, and each cut exchanges the sides.
  let later = own.row.cuts - pieces.words[own.at + EARLIER];
  let is_odd = own.row.is_odd_at_end == (later % 2u == 0u);
  let from_end = place_of_cut(edge, before, edge.edge.a);
  let to_end = place_of_cut(edge, own.cut, edge.edge.b);
  write_piece(light, own.place, from_end, to_end, !is_odd, middle_of(edge.outline));
}
