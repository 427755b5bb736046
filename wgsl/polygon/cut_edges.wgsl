// Cut edges: lists the pieces of twisted polygons. As seen from light L, the boundary of a twisted polygon crosses itself
// or goes around the light, or a hole is outside. A piece is a part of an edge between neighbouring cuts or ends, directed
// so that the polygon's shadow is on its left. Four passes for each batch, after `polygon_masks`, for shadow volumes only;
// the later ones read in `pieces` what earlier ones wrote. `cut_edges`, a workgroup for each entry that `polygon_masks`
// lists, finds the cuts of each edge. `cut_edges_rank`, a workgroup for 8 cuts, counts the cuts of the edge before each.
// `cut_edges_before`, an invocation for each cut, finds the cut right before. `cut_edges_list`, likewise, writes the piece
// between both. Pieces come in any order; polygon/list_pieces.wgsl names their readers. Cutting edges and dark sides are
// exact; orders are, except where `is_before` rounds, and where rounded fractions replace the ranks (`has_equal_ranks`). At
// each point as many pieces must begin as end, bit for bit, so crossing edges must agree on order and point. `Turns:` above
// a loop is its most iterations. Claims: docs/numerics/twisted-polygons.md.

#import common/exact_sign
#import common/order_keys
#import extract/one_caster
#import polygon/cuts
#import polygon/list_pieces
#import polygon/boundaries
#import polygon/corner_turn

@group(0) @binding(8) var<storage, read> faces: array<u32>;

// 1: as seen from the light, an odd number of the polygon's triangles and overlapping edges lie beside the end of the edge,
// on its left. An element for each invocation; for a large boundary, whose invocations share an edge, the first.
var<workgroup> parities: array<atomic<u32>, 64>;
// The window of bits of the boundary's corners: EXPONENT_LIMIT minus its begin, and its end, so that both
// are maxima. Elements as for `parities`.
var<workgroup> lowest_exponents: array<atomic<i32>, 64>;
var<workgroup> highest_exponents: array<atomic<i32>, 64>;
// The number of cuts that each invocation found, and the index in the light's list of the row of its edge.
var<workgroup> cut_counts: array<u32, 64>;
var<workgroup> row_starts: array<u32, 64>;
// For each of the 8 cuts of a workgroup of `cut_edges_rank` the number of cuts before it.
var<workgroup> ranks: array<atomic<u32>, 8>;
// Invocations that share the comparisons of a cut with all others.
const RANK_LANES: u32 = 8u;
// The most cuts of an edge that are compared pairwise. More have the order of their rounded fractions.
const MOST_ORDERED: u32 = 256u;

// How an edge f overlaps an edge e on the same line in space. Sides and ends are those in ascending direction (`is_below`).
struct Overlap {
  // The upper end of f is within e, and f cuts e there.
  is_cut: bool,
  // f lies beside the end of e, on the left in the direction of e.
  is_left_at_end: bool,
  // The upper end of f.
  end: vec3<u32>,
}

// Finds how edge `f` with index `f_index` overlaps edge `e` with index `e_index` on the same line in space.
fn overlap_in_line(f: Edge, f_index: u32, e: Edge, e_index: u32) -> Overlap {
  let upward_e = ascending(e);
  let upward_f = ascending(f);
  let is_before = precedes(upward_f, f_index, upward_e, e_index);
  let is_up = all(upward_e.a == e.a);
  let is_cut = is_before && is_below(upward_e.a, upward_f.b) && is_below(upward_f.b, upward_e.b);
  let is_left = select(
    !is_before && all(upward_f.a == upward_e.a),
    is_before && !is_below(upward_f.b, upward_e.b),
    is_up,
  );
  return Overlap(is_cut, is_left, upward_f.b);
}

// Whether the edge from p to q has the direction of edge `e`. Both must be on one line in space.
fn has_same_direction(p: vec3<u32>, q: vec3<u32>, e: Edge) -> bool {
  let is_ascending = order_keys(p) < order_keys(q);
  return any((p != q) & (e.a != e.b) & (is_ascending == (order_keys(e.a) < order_keys(e.b))));
}

// The edges that cut the edge of an invocation, a bit each: bit n is edge n. For a large boundary the invocation tests every
// 64th edge, and bit n is edge 64 n + lane.
struct FoundCuts {
  cuts: u32,
  // The cutting edges with an end on the invocation's edge, in space, and those of them whose second end it is.
  touching: u32,
  touching_second_end: u32,
  // Bits 0 (x) and 1 (y) of the `tie` of each cut.
  ties: vec2<u32>,
  // The window of bits of the first ends of its own edge and the tested ones: begin and end. Each corner is one of these.
  span: vec2<i32>,
}

// The three points of a test of edge `e` against an item. For an edge f with ends corners[0] and corners[1], tests 0 and 1
// have the sides of e.a and e.b at f, tests 2 and 3 those of f's ends at e. For a triangle, test 0 is its own turn. Then,
// for each of its edges, a test has the side of e.b, and the next one that of e.a.
fn points_of_test(e: Edge, corners: array<vec3<u32>, 3>, is_edge: bool, test: u32) -> array<vec3<u32>, 3> {
  if (is_edge && test >= 2u) {
    return array<vec3<u32>, 3>(e.a, e.b, select(corners[0], corners[1], test == 3u));
  }
  if (is_edge) {
    return array<vec3<u32>, 3>(corners[0], corners[1], select(e.a, e.b, test == 1u));
  }
  if (test == 0u) {
    return corners;
  }
  let side = (test - 1u) / 2u;
  let end = select(e.b, e.a, test % 2u == 0u);
  if (side == 0u) {
    return array<vec3<u32>, 3>(corners[0], corners[1], end);
  }
  if (side == 1u) {
    return array<vec3<u32>, 3>(corners[1], corners[2], end);
  }
  return array<vec3<u32>, 3>(corners[2], corners[0], end);
}

// How an edge cuts another.
struct EdgeCut {
  is_cut: bool,
  // An end of the cutting edge is on the line of the other edge, in space.
  is_touching: bool,
  // If it touches: the end is the second one.
  is_second_end: bool,
  // For edges on the same line: `Overlap::is_left_at_end`.
  is_left_at_end: bool,
}

// How edge `f` cuts edge `e`. `signs` are those of tests 0 to 3.
fn cut_by_edge(f: Edge, f_index: u32, e: Edge, e_index: u32, signs: vec4<i32>) -> EdgeCut {
  if (signs.z == 0 && signs.w == 0) {
    let overlap = overlap_in_line(f, f_index, e, e_index);
    return EdgeCut(overlap.is_cut, true, all(overlap.end == f.b), overlap.is_left_at_end);
  }
  let is_touching = signs.z == 0 || signs.w == 0;
  // Points on the line of `e` count as right of it, in ascending direction.
  let left = select(vec2<bool>(signs.z >= 0, signs.w >= 0), vec2<bool>(signs.z > 0, signs.w > 0), is_below(e.a, e.b));
  let is_crossing = signs.x * signs.y < 0 && left.x != left.y && (is_touching || signs.z == signs.y);
  return EdgeCut(is_crossing, is_touching, signs.w == 0, false);
}

// Whether a triangle lies beside the end of edge `e`, on its left. `signs` are those of its tests.
fn is_triangle_beside_end(corners: array<vec3<u32>, 3>, e: Edge, signs: array<i32, 7>) -> bool {
  var sides = vec3<i32>(signs[1], signs[3], signs[5]);
  sides = select(sides, vec3<i32>(signs[2], signs[4], signs[6]), sides == vec3<i32>(0));
  let is_same = vec3<bool>(
    has_same_direction(corners[0], corners[1], e),
    has_same_direction(corners[1], corners[2], e),
    has_same_direction(corners[2], corners[0], e),
  );
  sides = select(sides, select(vec3<i32>(-1), vec3<i32>(1), is_same), sides == vec3<i32>(0));
  return signs[0] != 0 && all(sides == vec3<i32>(signs[0]));
}

// Finds the edges that cut the invocation's edge. It also flips the element of `parities` for each triangle and overlapping
// edge beside the end of that edge, on its left. One loop runs over edges, then over triangles, so that `turn` is compiled
// once.
fn find_cuts(boundary: PolygonBoundary, work: Work, lane: u32) -> FoundCuts {
  let slot = select(lane, 0u, work.is_large);
  let step = select(1u, BOUNDARY_LANES, work.is_large);
  let e = work.edge;
  var result: FoundCuts;
  result.span = select(vec2<i32>(EXPONENT_LIMIT, -EXPONENT_LIMIT), bit_window_of(float_parts(e.a)), work.exists);
  let triangles = boundary.end_triangle - boundary.first_triangle;
  let end = select(0u, boundary.count + triangles, work.exists);
  // Turns: CUT_ITEMS.
  for (var item = select(0u, lane, work.is_large); item < end; item += step) {
    let is_edge = item < boundary.count;
    var corners: array<vec3<u32>, 3>;
    if (is_edge) {
      let f = load_edge(boundary.first + item);
      if (item == work.edge_index || !f.has_length) {
        continue;
      }
      result.span = hull(result.span, bit_window_of(float_parts(f.a)));
      corners[0] = f.a;
      corners[1] = f.b;
    } else {
      let face = 3u * (boundary.first_triangle + item - boundary.count);
      corners = array<vec3<u32>, 3>(position_of(faces[face]), position_of(faces[face + 1u]), position_of(faces[face + 2u]));
    }
    var signs: array<i32, 7>;
    var tie = IN_LINE;
    // Turns: CUT_TESTS in all.
    for (var test = 0u; test < select(7u, 4u, is_edge); test++) {
      // For a side of a triangle, e.a decides only if e.b is on the side's line.
      if (!is_edge && test > 0u && test % 2u == 0u && signs[test - 1u] != 0) {
        continue;
      }
      let points = points_of_test(e, corners, is_edge, test);
      let turn_result = turn(points[0], points[1], points[2], work.light_index);
      signs[test] = turn_result.sign;
      tie = select(tie, min(tie, turn_result.tie), test < 2u);
    }
    var is_beside_end = false;
    if (is_edge) {
      let f = Edge(corners[0], corners[1], true);
      let cut = cut_by_edge(f, item, e, work.edge_index, vec4<i32>(signs[0], signs[1], signs[2], signs[3]));
      is_beside_end = cut.is_left_at_end;
      let bit = select(0u, 1u << select(item, item / BOUNDARY_LANES, work.is_large), cut.is_cut);
      result.cuts |= bit;
      result.touching |= select(0u, bit, cut.is_touching);
      result.touching_second_end |= select(0u, bit, cut.is_touching && cut.is_second_end);
      result.ties |= select(vec2<u32>(0u), vec2<u32>(bit), (vec2<u32>(tie) & vec2<u32>(1u, 2u)) != vec2<u32>(0u));
    } else {
      is_beside_end = is_triangle_beside_end(corners, e, signs);
    }
    if (is_beside_end) {
      atomicXor(&parities[slot], 1u);
    }
  }
  return result;
}

@compute @workgroup_size(64)
fn cut_edges(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let entry = group.y * ENTRY_ROW + group.x;
  var work: Work;
  var boundary: PolygonBoundary;
  var polygon = 0u;
  if (entry < atomicLoad(&undecided[CUT_COUNT])) {
    let record = record_offset(atomicLoad(&undecided[entry_offset(entry)]));
    polygon = polygon_of(record);
    boundary = boundary_of(polygon);
    // After `polygon_masks` LIGHTS are those for which the boundary is cut.
    work = work_of(
      boundary, atomicLoad(&undecided[entry_offset(entry) + 1u]), atomicLoad(&undecided[record + LIGHTS]), lane);
  }
  let found = find_cuts(boundary, work, lane);
  cut_counts[lane] = countOneBits(found.cuts);
  let slot = select(lane, 0u, work.is_large);
  atomicMax(&lowest_exponents[slot], EXPONENT_LIMIT - found.span.x);
  atomicMax(&highest_exponents[slot], found.span.y);
  workgroupBarrier();
  // The cuts of the row, and the index in it of the invocation's first cut.
  var cuts = 0u;
  var index = 0u;
  // Turns: BOUNDARY_LANES.
  for (var other = slot; other < select(lane + 1u, BOUNDARY_LANES, work.is_large); other++) {
    index = select(index, cuts, other == lane);
    cuts += cut_counts[other];
  }
  let has_row = work.exists && slot == lane;
  if (has_row) {
    row_starts[slot] = reserve_row(work.light_index, cuts);
  }
  workgroupBarrier();
  if (!work.exists) {
    return;
  }
  let span = vec2<i32>(EXPONENT_LIMIT - atomicLoad(&lowest_exponents[slot]), atomicLoad(&highest_exponents[slot]));
  let has_fixed_turns = holds_turns(span, given_light(work.light_index));
  let is_odd_at_end = (atomicLoad(&parities[slot]) & 1u) != 0u;
  let row = Row(polygon, work.edge_index, work.light_index, row_starts[slot], cuts, is_odd_at_end, has_fixed_turns);
  for (var remaining = found.cuts; remaining != 0u; remaining &= remaining - 1u) {
    let item = firstTrailingBit(remaining);
    let bit = 1u << item;
    let cutting_edge = select(item, BOUNDARY_LANES * item + lane, work.is_large);
    let tie = select(vec2<u32>(0u), vec2<u32>(1u, 2u), (found.ties & vec2<u32>(bit)) != vec2<u32>(0u));
    let cut = Cut(
      cutting_edge,
      (found.touching & bit) != 0u,
      (found.touching_second_end & bit) != 0u,
      select(0u, tie.x | tie.y, has_fixed_turns),
    );
    write_cut(row, index, cut);
    index++;
  }
  if (has_row) {
    write_cut(row, cuts, Cut(CORNER, false, false, 0u));
  }
}

// The edge that the cuts of a row cut.
fn edge_of(row: Row) -> CutEdge {
  let boundary = boundary_of(row.polygon);
  return CutEdge(boundary, load_edge(boundary.first + row.edge), row.edge, row.light, row.holds_turns);
}

@compute @workgroup_size(64)
fn cut_edges_rank(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let slot = lane / RANK_LANES;
  let stored = load_cut(group.y * ENTRY_ROW + group.x, slot);
  let is_cut = stored.has_row && stored.cut.cutting_edge != CORNER;
  var edge: CutEdge;
  if (is_cut) {
    edge = edge_of(stored.row);
  }
  let count = select(0u, stored.row.cut_count, is_cut && stored.row.cut_count <= MOST_ORDERED);
  var rank = 0u;
  // Turns: MOST_ORDERED / RANK_LANES.
  for (var index = lane % RANK_LANES; index < count; index += RANK_LANES) {
    let list_index = stored.row.first + index;
    let other = unpack_cut(pieces.words[piece_offset(stored.row.light, list_index) + CUT_WORD]);
    if (list_index != stored.index && is_before(edge, other, stored.cut)) {
      rank++;
    }
  }
  atomicAdd(&ranks[slot], rank);
  workgroupBarrier();
  if (is_cut && lane % RANK_LANES == 0u) {
    pieces.words[stored.offset + RANK] = atomicLoad(&ranks[slot]);
    // Bits of floats that are not negative sort like the floats, with infinity and NaN last.
    pieces.words[stored.offset + FRACTION] = bitcast<u32>(abs(fraction_along(edge, stored.cut)));
  }
}

// Whether the ranks do not order the row: two are equal, or they were not computed.
fn has_equal_ranks(row: Row) -> bool {
  if (row.cut_count > MOST_ORDERED) {
    return true;
  }
  // A bit for each rank that occurred.
  var occurred: array<u32, MOST_ORDERED / 32u>;
  var is_twice = false;
  // Turns: MOST_ORDERED.
  for (var index = 0u; index < row.cut_count; index++) {
    let rank = pieces.words[piece_offset(row.light, row.first + index) + RANK];
    let bit = 1u << (rank % 32u);
    is_twice = is_twice || (occurred[(rank / 32u) % 8u] & bit) != 0u;
    occurred[(rank / 32u) % 8u] |= bit;
  }
  return is_twice;
}

// The sort key of a cut in its row: the rank, or the bits of the fraction, which is not negative; then the edge that cuts.
// The end comes last.
fn order_key(row: Row, list_index: u32, by_rank: bool) -> vec2<u32> {
  let offset = piece_offset(row.light, list_index);
  let cut = unpack_cut(pieces.words[offset + CUT_WORD]);
  if (cut.cutting_edge == CORNER) {
    return vec2<u32>(0xffffffffu);
  }
  return vec2<u32>(pieces.words[offset + select(FRACTION, RANK, by_rank)], cut.cutting_edge);
}

fn is_less(p: vec2<u32>, q: vec2<u32>) -> bool {
  return p.x < q.x || (p.x == q.x && p.y < q.y);
}

@compute @workgroup_size(8)
fn cut_edges_before(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let stored = load_cut(group.y * ENTRY_ROW + group.x, lane);
  if (!stored.has_row) {
    return;
  }
  let by_rank = !has_equal_ranks(stored.row);
  let stored_key = order_key(stored.row, stored.index, by_rank);
  var earlier = 0u;
  var last = vec2<u32>(0u);
  var before = pack_cut(Cut(CORNER, false, false, 0u));
  // Turns: BOUNDARY_EDGES.
  for (var index = 0u; index < stored.row.cut_count; index++) {
    let list_index = stored.row.first + index;
    let key = order_key(stored.row, list_index, by_rank);
    if (is_less(key, stored_key)) {
      if (earlier == 0u || is_less(last, key)) {
        last = key;
        before = pieces.words[piece_offset(stored.row.light, list_index) + CUT_WORD];
      }
      earlier++;
    }
  }
  pieces.words[stored.offset + PREVIOUS_CUT] = before;
  pieces.words[stored.offset + EARLIER_COUNT] = earlier;
}

// The point of a cut: the end that touches, or the point where both edges cross as seen from the light. `corner`: the end
// of the edge that stands for CORNER.
fn cut_point(edge: CutEdge, cut: Cut, corner: vec3<u32>) -> vec3<u32> {
  if (cut.cutting_edge == CORNER) {
    return corner;
  }
  let touching = touching_end(edge.boundary, cut);
  if (touching.w == 1u) {
    return touching.xyz;
  }
  return crossing_point(edge.boundary, edge.index, cut.cutting_edge, edge.light);
}

@compute @workgroup_size(8)
fn cut_edges_list(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let stored = load_cut(group.y * ENTRY_ROW + group.x, lane);
  if (!stored.exists) {
    return;
  }
  let light = stored.row.light;
  if (!stored.has_row) {
    // The list is too short for the row, which its count shows. A piece without length replaces the record.
    write_piece(light, stored.index, vec3<u32>(0u), vec3<u32>(0u), false, vec3<u32>(0u));
    return;
  }
  let edge = edge_of(stored.row);
  let before = unpack_cut(pieces.words[stored.offset + PREVIOUS_CUT]);
  // The last piece ends at the end of the edge, and the dark side changes at each cut.
  let later = stored.row.cut_count - pieces.words[stored.offset + EARLIER_COUNT];
  let is_odd = stored.row.is_odd_at_end == (later % 2u == 0u);
  let from_end = cut_point(edge, before, edge.edge.a);
  let to_end = cut_point(edge, stored.cut, edge.edge.b);
  write_piece(light, stored.index, from_end, to_end, !is_odd, middle_point(edge.boundary));
}
