// Cuts: where an edge of a twisted boundary is crossed by another as seen from light L. First the records of cuts, then
// their order along the edge that they cut. Only the passes of cut_edges.wgsl import this file. `Turns:` above a loop is its
// most iterations. Claim: docs/numerics/twisted-polygons.md, "Order of cuts".

#import common/order_keys
#import extract/one_caster
#import polygon/list_pieces
#import polygon/boundaries
#import polygon/corner_turn

// Records. For each edge `cut_edges` writes to `pieces` a row: its cuts, in no particular order, then its end.
// `cut_edges_list` replaces each record with the piece that ends at the cut, so a record must fit in the words of a piece.
// If the list has no room for all of a row, its records have NO_POLYGON, and no pass may use the row.

// A cut of an edge, or the edge's end.
struct Cut {
  // The index in the boundary of the edge that cuts it, or `CORNER` for its end, in PREVIOUS_CUT for its begin.
  cutting_edge: u32,
  // The cutting edge has an end on it, in space.
  has_touching_end: bool,
  // If it touches: the end is the second one of the cutting edge.
  is_second_end: bool,
  // If it does not touch: the light that decides where it cuts, 0 the given one, 1 to 3 an axis.
  tie: u32,
}

const CORNER: u32 = 0xffffu; // Boundaries have at most 1,024 edges, so 16 bits hold their indices.
const TIE_SHIFT: u32 = 16u;
const HAS_TOUCHING_END: u32 = 0x40000000u;
const IS_SECOND_END: u32 = 0x80000000u;

fn pack_cut(cut: Cut) -> u32 {
  return cut.cutting_edge | (cut.tie << TIE_SHIFT) | select(0u, HAS_TOUCHING_END, cut.has_touching_end) |
    select(0u, IS_SECOND_END, cut.is_second_end);
}

fn unpack_cut(word: u32) -> Cut {
  return Cut(word & 0xffffu, (word & HAS_TOUCHING_END) != 0u, (word & IS_SECOND_END) != 0u, (word >> TIE_SHIFT) & 3u);
}

// Words of a record. `cut_edges` writes the first five.
// * CUT_POLYGON: the polygon, or NO_POLYGON if there was no room for the row.
// * CUT_EDGE: the index of the edge that is cut. IS_ODD_AT_END: an odd number of triangles and overlapping edges lie, as
//   seen from the light, beside its end on its left. HOLDS_TURNS: fixed point holds the boundary's turns for the light.
// * CUT_WORD: the packed cut.
// * ROW_FIRST, ROW_CUTS: the index in the light's list of the row's first record, and the number of its cuts without the
//   end.
const CUT_POLYGON: u32 = 0u;
const CUT_EDGE: u32 = 1u;
const CUT_WORD: u32 = 2u;
const ROW_FIRST: u32 = 3u;
const ROW_CUTS: u32 = 4u;
// `cut_edges_rank` writes RANK, the number of cuts of the row before this one by `is_before`, or 0 if there are more than
// MOST_ORDERED. It also writes FRACTION, the rounded fraction of the edge at which the cut is, from 0 to 1. The end has
// neither. `cut_edges_before` writes PREVIOUS_CUT, the packed cut right before it, and EARLIER_COUNT, the number of cuts
// before it. It sorts by RANK if all ranks of the row differ, else by FRACTION.
const RANK: u32 = 5u;
const FRACTION: u32 = 6u;
const PREVIOUS_CUT: u32 = 7u;
const EARLIER_COUNT: u32 = 8u;
const NO_POLYGON: u32 = 0xffffffffu;
const IS_ODD_AT_END: u32 = 0x80000000u;
const HOLDS_TURNS: u32 = 0x40000000u;

// The values that all cuts of an edge have in common.
struct Row {
  polygon: u32,
  edge: u32,
  light: u32,
  first: u32,
  cut_count: u32,
  is_odd_at_end: bool,
  holds_turns: bool,
}

// Reserves records in a light's list for the cuts of an edge and its end, and workgroups of the next passes for those with
// room. Returns the index of the first record. A group is GROUP_CUTS records from a multiple of it on. Rows follow each
// other in the list, so each group is counted once, by the row with its first record.
fn reserve_row(light: u32, cuts: u32) -> u32 {
  let first = reserve_pieces(light, cuts + 1u);
  let listed = min(vec2<u32>(first, first + cuts + 1u), vec2<u32>(chunk.capacity));
  let groups = (listed + GROUP_CUTS - 1u) / GROUP_CUTS;
  if (groups.y > groups.x) {
    reserve_entries(CUT_GROUP_WORKGROUPS, groups.y - groups.x);
  }
  return first;
}

// Writes cut `index` of a row; the end is cut `row.cut_count`. Past the end of the list it writes nothing.
fn write_cut(row: Row, index: u32, cut: Cut) {
  let list_index = row.first + index;
  if (list_index >= chunk.capacity) {
    return;
  }
  let offset = piece_offset(row.light, list_index);
  let fits = row.first + row.cut_count < chunk.capacity;
  pieces.words[offset + CUT_POLYGON] = select(NO_POLYGON, row.polygon, fits);
  pieces.words[offset + CUT_EDGE] = row.edge | select(0u, IS_ODD_AT_END, row.is_odd_at_end)
    | select(0u, HOLDS_TURNS, row.holds_turns);
  pieces.words[offset + CUT_WORD] = pack_cut(cut);
  pieces.words[offset + ROW_FIRST] = row.first;
  pieces.words[offset + ROW_CUTS] = row.cut_count;
}

// A record as loaded.
struct StoredCut {
  exists: bool, // The list has a record of this index. If not, all else but `index` is 0.
  has_row: bool, // There was room for the whole row. If not, `row` and `cut` have no meaning but for `row.light`.
  index: u32, // Its index in the light's list.
  // The offset of its words.
  offset: u32,
  row: Row,
  cut: Cut,
}

// Record `index` of a workgroup. Workgroups count through the groups of light 0, then those of light 1, and so on.
fn load_cut(workgroup: u32, index: u32) -> StoredCut {
  var stored: StoredCut;
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
  stored.index = GROUP_CUTS * group + index;
  stored.exists = stored.index < count;
  if (!stored.exists) {
    return stored;
  }
  stored.offset = piece_offset(light, stored.index);
  let polygon = pieces.words[stored.offset + CUT_POLYGON];
  stored.has_row = polygon != NO_POLYGON;
  let edge = pieces.words[stored.offset + CUT_EDGE];
  let first = pieces.words[stored.offset + ROW_FIRST];
  let cuts = pieces.words[stored.offset + ROW_CUTS];
  let holds = (edge & HOLDS_TURNS) != 0u;
  stored.row = Row(polygon, edge & 0xffffu, light, first, cuts, edge >= IS_ODD_AT_END, holds);
  stored.cut = unpack_cut(pieces.words[stored.offset + CUT_WORD]);
  return stored;
}

// The order of two cuts. `cut_edges_rank` counts by `is_before` how many cuts are before each. Turns decide if one cut is on
// one side of the other's edge (polygon/corner_turn.wgsl). If three edges cross each other, the fractions of the edge at
// which the cuts lie decide; these are rounded. All three edges must get orders that fit each other, or pieces leave gaps.
// So all compute the order from the same numbers; change a rule only with its proof.

// The edge that is cut, and the light.
struct CutEdge {
  boundary: PolygonBoundary,
  edge: Edge,
  index: u32,
  light: u32,
  // Fixed point holds the boundary's turns. If not, it is unknown where edges seen in line cut each other, and cuts have no
  // `tie`.
  holds_turns: bool,
}

// Whether a point comes before another on a line, in ascending order: by the first coordinate that differs.
fn is_below(p: vec3<u32>, q: vec3<u32>) -> bool {
  let lower = order_keys(p);
  let upper = order_keys(q);
  if (lower.x != upper.x) {
    return lower.x < upper.x;
  }
  if (lower.y != upper.y) {
    return lower.y < upper.y;
  }
  return lower.z < upper.z;
}

// The edge in ascending direction.
fn ascending(e: Edge) -> Edge {
  if (is_below(e.a, e.b)) {
    return e;
  }
  return Edge(e.b, e.a, e.has_length);
}

// Whether edge `f` is on the left of edge `e` on the same line, both in ascending direction. It is if it begins before `e`,
// or begins with it and ends behind it. Equal edges have the order of their indices. For edges on different lines it is an
// order without a meaning (`foremost`).
fn precedes(f: Edge, f_index: u32, e: Edge, e_index: u32) -> bool {
  if (any(f.a != e.a)) {
    return is_below(f.a, e.a);
  }
  if (any(f.b != e.b)) {
    return is_below(e.b, f.b);
  }
  return f_index < e_index;
}

// xyz: the end of the cutting edge that is on the edge, w: 1; or 0 if the cut does not touch.
fn touching_end(boundary: PolygonBoundary, cut: Cut) -> vec4<u32> {
  if (!cut.has_touching_end) {
    return vec4<u32>(0u);
  }
  let f = load_edge(boundary.first + cut.cutting_edge);
  return vec4<u32>(select(f.a, f.b, cut.is_second_end), 1u);
}

// The fraction of an edge at which a point on it lies, rounded.
fn fraction_of_point(e: Edge, point: vec3<u32>) -> f32 {
  let a = bitcast<vec3<f32>>(e.a);
  let along = bitcast<vec3<f32>>(e.b) - a;
  let from_a = bitcast<vec3<f32>>(point) - a;
  let size = abs(along);
  if (size.x >= size.y && size.x >= size.z) {
    return from_a.x / along.x;
  }
  return select(from_a.z / along.z, from_a.y / along.y, size.y >= size.z);
}

// The side of an edge on which two points are, by their turns, or 0 if they are on different sides. A point on the edge's
// line is on both sides.
fn common_side(signs: vec2<i32>) -> i32 {
  return select(select(signs.x, signs.y, signs.x == 0), 0, signs.x * signs.y < 0);
}

// The sign of the turns to points on the right of an edge, in ascending direction.
fn right_sign(e: Edge) -> i32 {
  return select(1, -1, is_below(e.a, e.b));
}

// The side of an edge `other` on which an edge with the end turns `sides` cuts by touching: the side of the end that
// touches. If this end is on the line of `other`, too, the cut is on the right where `other` precedes the edge that is cut
// or this edge is in line with the cutting one (`is_on_right`), else on the side of the cutting edge's other end.
fn touching_side(sides: vec2<i32>, is_second_end: bool, other: Edge, is_on_right: bool) -> i32 {
  let side = select(sides.x, sides.y, is_second_end);
  return select(side, select(sides.x + sides.y, right_sign(other), is_on_right), side == 0);
}

// The fraction of edge `e` at which edge `f` cuts it, as seen from the light, or from the axis that breaks the tie.
fn cut_fraction_for_tie(f: Edge, e: Edge, light: u32, tie: u32) -> f32 {
  let axis = bitcast<vec4<f32>>(light_or_axis(light, tie));
  return cut_fraction(f, e, select(axis, scaled_light(light), tie == 0u));
}

// Cuts of an edge that are at most this fraction apart count as one point.
const SAME_POINT: f32 = 0x1p-18;

// An edge and two others that cut it.
struct EdgeTriple {
  edges: array<Edge, 3>,
  // Their indices in the boundary.
  indices: vec3<u32>,
  // For each edge, the `tie` of the cuts by the others, in their order.
  ties: array<vec2<u32>, 3>,
}

// The result of ordering the cuts of three edges.
struct CutOrder {
  // The edge along which the order is decided, or `NONE` if nothing decides: both cuts seem to lie in one point.
  deciding_edge: u32,
  // Whether the first of the two others comes after the second.
  is_after: bool,
}

const NONE: u32 = 3u;

// The order of three edges by the fractions at which the others cut each: 1 and 2 along edge 0, 0 and 2 along 1, 0 and 1
// along 2. The edge with the lowest index decides, or none if two cuts of any edge count as one point. If some are seen in
// line, others see these cross in one point, so the edge along which the others are farthest apart decides.
fn order_by_fractions(indices: vec3<u32>, ties: array<vec2<u32>, 3>, fractions: array<vec2<f32>, 3>) -> CutOrder {
  let difference = vec3<f32>(
    fractions[0].x - fractions[0].y, fractions[1].x - fractions[1].y, fractions[2].x - fractions[2].y);
  let size = abs(difference);
  var first = lowest_of(indices);
  if (all((ties[0] | ties[1] | ties[2]) == vec2<u32>(0u))) {
    first = select(first, NONE, any(size <= vec3<f32>(SAME_POINT)));
  } else {
    // Among equals the edge with the lowest index decides.
    for (var edge = 0u; edge < 3u; edge++) {
      let is_earlier = size[edge] == size[first] && indices[edge] < indices[first];
      first = select(first, edge, size[edge] > size[first] || is_earlier);
    }
    first = select(first, NONE, size[first] <= SAME_POINT);
  }
  return CutOrder(first, difference[min(first, 2u)] > 0.0);
}

// Which of three edges has the lowest index.
fn lowest_of(indices: vec3<u32>) -> u32 {
  let is_lowest = indices == vec3<u32>(min(indices.x, min(indices.y, indices.z)));
  return select(select(2u, 1u, is_lowest.y), 0u, is_lowest.x);
}

// Determinants of the ends a and b of an edge, first at one other edge, then at another. Components: for the given light and
// for the axes. Each is a value of at most 1 times a power of two.
struct EndTurns {
  values: array<vec4<f32>, 4>,
  exponents: array<vec4<i32>, 4>,
}

// The sign of the distance along the edge from the cut of the second other edge to that of the first, times the signs of
// the turns of its end b at both. It is 0 if the given light sees a distance, or if the moved light sees none either.
fn order_for_moved_light(turns: EndTurns) -> i32 {
  // The cuts are at t/(t - t'), where t and t' are polynomials in the distance that the light moves. So is their difference.
  for (var power = 0u; power < 7u; power++) {
    var exponent = -0x10000;
    var sum = 0.0;
    var size = 0.0;
    // The first four steps find the largest exponent, the others add.
    for (var step = 0u; step < 8u; step++) {
      let i = step % 4u;
      let k = power - i;
      if (i > power || k > 3u) {
        continue;
      }
      let products = vec2<f32>(turns.values[2][i] * turns.values[1][k], turns.values[0][i] * turns.values[3][k]);
      let exponents = vec2<i32>(
        turns.exponents[2][i] + turns.exponents[1][k],
        turns.exponents[0][i] + turns.exponents[3][k],
      );
      if (step < 4u) {
        let used = select(vec2<i32>(exponent), exponents, products != vec2<f32>(0.0));
        exponent = max(exponent, max(used.x, used.y));
        continue;
      }
      let p = times_power(products.x, min(exponents.x - exponent, 0));
      let q = times_power(products.y, min(exponents.y - exponent, 0));
      sum += p - q;
      size += abs(p) + abs(q);
    }
    if (abs(sum) > ROUNDING * size) {
      return select(0, select(-1, 1, sum > 0.0), power > 0u);
    }
  }
  return 0;
}

// A sum below this part of the size of its products may be rounding.
const ROUNDING: f32 = 0x1p-20;

// The order of the cuts of three edges: by fractions, and, if these do not decide, as the moved light sees them. If 1 and 2
// do not cross each other, only as the moved light sees the cuts of edge 0: the caller compared fractions. One loop, so that
// turns are compiled once.
fn order_by_turns(triple: EdgeTriple, cut_edge: CutEdge, is_crossing: bool) -> CutOrder {
  let light = cut_edge.light;
  var fractions: array<vec2<f32>, 3>;
  var previous: TurnValue;
  var turns: EndTurns;
  // The edge with the lowest index, and the others in their order.
  let first = select(0u, lowest_of(triple.indices), is_crossing);
  var others = vec2<u32>(select(0u, 1u, first == 0u), select(2u, 1u, first == 2u));
  others = select(others, others.yx, triple.indices[others.x] > triple.indices[others.y]);
  // Turns: 28.
  for (var iteration = select(12u, 0u, is_crossing); iteration < 28u; iteration++) {
    if (iteration == 12u) {
      var order = CutOrder(NONE, false);
      if (is_crossing) {
        order = order_by_fractions(triple.indices, triple.ties, fractions);
      }
      if (order.deciding_edge != NONE || !cut_edge.holds_turns) {
        return order;
      }
    }
    let is_fraction = iteration < 12u;
    // The first 12 iterations: for a fraction both ends of an edge at another. Then each end of the first edge at each
    // other, for each light.
    var cut = iteration / 4u;
    let other = select((iteration - 12u) / 8u, (iteration / 2u) % 2u, is_fraction);
    let end = select((iteration / 4u + 1u) % 2u, iteration % 2u, is_fraction);
    var cutting_edge = select(other, other + 1u, other >= cut);
    var tie = iteration % 4u;
    if (is_fraction) {
      tie = triple.ties[cut][other];
    } else {
      cut = first;
      cutting_edge = others[other];
    }
    let f = triple.edges[cutting_edge];
    let point = select(triple.edges[cut].a, triple.edges[cut].b, vec3<bool>(end == 1u));
    let value = turn_value(f.a, f.b, point, light_or_axis(light, tie));
    if (!is_fraction) {
      let parts = frexp(value.value);
      turns.values[2u * other + end][tie] = parts.fract;
      turns.exponents[2u * other + end][tie] = parts.exp + value.exponent;
    } else if (end == 1u) {
      fractions[cut][other] = fraction_from_turns(previous, value);
      if (!previous.fits || !value.fits) {
        fractions[cut][other] = cut_fraction(f, triple.edges[cut], scaled_light(light));
      }
    }
    previous = value;
  }
  let side = order_for_moved_light(turns) * sign_for_moved_light(turns.values[1]) * sign_for_moved_light(turns.values[3]);
  return CutOrder(select(NONE, first, side != 0), (side > 0) == (others.x < others.y));
}

// The sign of a turn for the moved light, by the values for the given light and for the axes.
fn sign_for_moved_light(values: vec4<f32>) -> i32 {
  let signs = vec4<i32>(sign(values));
  let sign_for_axes = select(select(signs.w, signs.z, signs.z != 0), signs.y, signs.y != 0);
  return select(sign_for_axes, signs.x, signs.x != 0);
}

// The one of two edges that precedes the other.
fn preceding(triple: EdgeTriple, one: u32, other: u32) -> u32 {
  let is_before = precedes(
    ascending(triple.edges[one]),
    triple.indices[one],
    ascending(triple.edges[other]),
    triple.indices[other],
  );
  return select(other, one, is_before);
}

// The edge that precedes the others. If it is unknown where two edges seen in line cross, one of these: 0 and 1, 0 and 2, or
// 1 and 2.
fn foremost(triple: EdgeTriple, in_line: vec3<bool>) -> u32 {
  if (in_line.x) {
    return preceding(triple, 0u, 1u);
  }
  if (in_line.y) {
    return preceding(triple, 0u, 2u);
  }
  let first_of_others = preceding(triple, 1u, 2u);
  return select(preceding(triple, 0u, first_of_others), first_of_others, in_line.z);
}

// Two cuts of an edge e: cut j by edge g, and cut i by edge f.
struct CutPair {
  cut_j: Cut,
  cut_i: Cut,
  g: Edge,
  f: Edge,
}

// The turns of the edges e, f and g of a `CutPair`.
struct PairTurns {
  // Tests 0 and 1: the sides of the end of e at f and at g. 2 and 3: of the ends of g at f. 4 and 5: of the ends of f at g.
  // 6 to 9: of the ends of g, then of f, at e.
  signs: array<i32, 10>,
  // The `tie` of the cuts of g and of f by the two others.
  ties: array<vec2<u32>, 2>,
}

// The three points of a test of `PairTurns`: the side of the third at the edge from the first to the second.
fn points_of_pair_test(e: Edge, pair: CutPair, test: u32) -> array<vec3<u32>, 3> {
  var p = pair.f;
  if (test == 1u || test == 4u || test == 5u) {
    p = pair.g;
  } else if (test >= 6u) {
    p = e;
  }
  var r = e.b;
  switch (test) {
    case 2u, 6u: { r = pair.g.a; }
    case 3u, 7u: { r = pair.g.b; }
    case 4u, 8u: { r = pair.f.a; }
    case 5u, 9u: { r = pair.f.b; }
    default: {}
  }
  return array<vec3<u32>, 3>(p.a, p.b, r);
}

// The order of two cuts by sides.
struct SideOrder {
  is_decided: bool,
  // Whether cut j is before cut i, if so.
  is_before: bool,
}

// The order of two cuts if the edges are in line, a cut touches, or one is on one side of the other's edge. `signs` are
// those of tests 0 to 5. Touching cuts must touch at one point.
fn order_by_sides(cut_edge: CutEdge, pair: CutPair, signs: array<i32, 10>) -> SideOrder {
  let e = cut_edge.edge;
  let f = pair.f;
  let g = pair.g;
  let i = pair.cut_i.cutting_edge;
  let j = pair.cut_j.cutting_edge;
  let turns_of_g = vec2<i32>(signs[2], signs[3]);
  let turns_of_f = vec2<i32>(signs[4], signs[5]);
  if (all(turns_of_g == vec2<i32>(0))) {
    // f and g are in one line, which e passes from left to right or back. If e is on it, too (signs[0] is 0), the one
    // nearer to e cuts first in ascending direction.
    let is_first = precedes(ascending(g), j, ascending(f), i);
    return SideOrder(
      true, select(is_first == (signs[0] == right_sign(f)), is_first != is_below(e.a, e.b), signs[0] == 0));
  }
  if (pair.cut_j.has_touching_end && pair.cut_i.has_touching_end) {
    // Both touch at one point of e. The end of e has no side at an edge in line with e.
    return SideOrder(
      true, select(turns_of_g.x + turns_of_g.y != signs[0], turns_of_f.x + turns_of_f.y == signs[1], signs[0] == 0));
  }
  if (pair.cut_j.has_touching_end) {
    let is_on_right = signs[1] == 0 || precedes(ascending(f), i, ascending(e), cut_edge.index);
    return SideOrder(true, touching_side(turns_of_g, pair.cut_j.is_second_end, f, is_on_right) != signs[0]);
  }
  if (pair.cut_i.has_touching_end) {
    let is_on_right = signs[0] == 0 || precedes(ascending(g), j, ascending(e), cut_edge.index);
    return SideOrder(true, touching_side(turns_of_f, pair.cut_i.is_second_end, g, is_on_right) == signs[1]);
  }
  // The cut of g is on this side of f, or the cut of f on this side of g.
  if (common_side(turns_of_g) != 0) {
    return SideOrder(true, common_side(turns_of_g) != signs[0]);
  }
  return SideOrder(common_side(turns_of_f) != 0, common_side(turns_of_f) == signs[1]);
}

// Whether edges f and g cross each other, if no side decides. If they cross each other's opposite directions, they count
// as if they did not: no other order must fit.
fn is_pair_crossing(signs: array<i32, 10>) -> bool {
  return signs[2] == signs[5];
}

// Whether cut j is before cut i on the edge that both cut. Turns decide if one cut is on one side of the other's edge.
// Otherwise fractions decide, or the moved light. One loop, so that `turn` is compiled once.
fn is_before(cut_edge: CutEdge, cut_j: Cut, cut_i: Cut) -> bool {
  let e = cut_edge.edge;
  let touching_end_j = touching_end(cut_edge.boundary, cut_j);
  let touching_end_i = touching_end(cut_edge.boundary, cut_i);
  if (touching_end_j.w + touching_end_i.w == 2u && any(touching_end_j != touching_end_i)) {
    return is_below(touching_end_j.xyz, touching_end_i.xyz) == is_below(e.a, e.b);
  }
  let f = load_edge(cut_edge.boundary.first + cut_i.cutting_edge);
  let g = load_edge(cut_edge.boundary.first + cut_j.cutting_edge);
  let pair = CutPair(cut_j, cut_i, g, f);
  var turns: PairTurns;
  turns.ties = array<vec2<u32>, 2>(vec2<u32>(IN_LINE), vec2<u32>(IN_LINE));
  for (var test = 0u; test < 10u; test++) {
    if (test == 6u) {
      let order = order_by_sides(cut_edge, pair, turns.signs);
      if (order.is_decided) {
        return order.is_before;
      }
      if (!is_pair_crossing(turns.signs)) {
        break;
      }
    }
    let points = points_of_pair_test(e, pair, test);
    let result = turn(points[0], points[1], points[2], cut_edge.light);
    turns.signs[test] = result.sign;
    if (test >= 2u) {
      let is_end_of_f = (test / 2u) % 2u == 0u;
      let is_cut_by = vec2<bool>(test >= 6u, test < 6u);
      turns.ties[select(0u, 1u, is_end_of_f)] = min(
        turns.ties[select(0u, 1u, is_end_of_f)], select(vec2<u32>(IN_LINE), vec2<u32>(result.tie), is_cut_by));
    }
  }
  return is_before_by_fractions(cut_edge, pair, turns);
}

// Whether cut j is before cut i if no side decides. If all three edges cross each other, the fractions along one of them
// decide for all three. If they seem to cross in one point, the moved light decides. Rounded fractions also decide if edges
// f and g cross each other's opposite directions.
fn is_before_by_fractions(cut_edge: CutEdge, pair: CutPair, turns: PairTurns) -> bool {
  let is_crossing = is_pair_crossing(turns.signs);
  let i = pair.cut_i.cutting_edge;
  let j = pair.cut_j.cutting_edge;
  var is_nearer = false;
  if (!is_crossing) {
    let fractions = vec2<f32>(fraction_along(cut_edge, pair.cut_j), fraction_along(cut_edge, pair.cut_i));
    is_nearer = fractions.x < fractions.y || (fractions.x == fractions.y && j < i);
    if (abs(fractions.x - fractions.y) > SAME_POINT) {
      return is_nearer;
    }
  }
  let known = select(vec2<u32>(0u), vec2<u32>(0xffffffffu), cut_edge.holds_turns);
  let triple = EdgeTriple(
    array<Edge, 3>(cut_edge.edge, pair.g, pair.f),
    vec3<u32>(cut_edge.index, j, i),
    array<vec2<u32>, 3>(vec2<u32>(pair.cut_j.tie, pair.cut_i.tie), turns.ties[0] & known, turns.ties[1] & known),
  );
  let order = order_by_turns(triple, cut_edge, is_crossing);
  if (order.deciding_edge == NONE) {
    if (!is_crossing) {
      return is_nearer;
    }
    return is_before_at_one_point(cut_edge, triple, turns);
  }
  if (order.deciding_edge == 0u) {
    return !order.is_after;
  }
  // The product of: the order along the deciding edge; the sides of its end at e and at the other; the sides of the end of e
  // here. It changes its sign if f decides.
  let signs = turns.signs;
  let is_at_f = order.deciding_edge == 2u;
  let end_turns = select(vec2<i32>(signs[7], signs[3]), vec2<i32>(signs[9], -signs[5]), is_at_f);
  return signs[0] * signs[1] * end_turns.x * end_turns.y * select(-1, 1, order.is_after) > 0;
}

// Whether cut j is before cut i if the moved light, too, sees three edges cross in one point: e, g and f are edges 0 to 2.
// Each edge is moved to its left a little, and the foremost one farther, out of the others' crossing.
fn is_before_at_one_point(cut_edge: CutEdge, triple: EdgeTriple, turns: PairTurns) -> bool {
  let signs = turns.signs;
  // Whether e and g, e and f, and g and f are seen in line, and it is unknown where they cross.
  let in_line =
    vec3<bool>(!cut_edge.holds_turns) & (vec3<u32>(turns.ties[0].x, turns.ties[1].x, turns.ties[0].y) > vec3<u32>(0u));
  switch (foremost(triple, in_line)) {
    case 2u: { return right_sign(triple.edges[2]) != signs[0]; }
    case 1u: { return right_sign(triple.edges[1]) == signs[1]; }
    // e is cut after the others have left their crossing: by the end of g on its left.
    default: { return select(signs[2], signs[3], signs[6] == right_sign(triple.edges[0])) != signs[0]; }
  }
}

// The fraction of the edge at which a cut lies, rounded.
fn fraction_along(cut_edge: CutEdge, cut: Cut) -> f32 {
  let touching = touching_end(cut_edge.boundary, cut);
  let cutting_edge = load_edge(cut_edge.boundary.first + cut.cutting_edge);
  let crossing = cut_fraction_for_tie(cutting_edge, cut_edge.edge, cut_edge.light, cut.tie);
  return select(crossing, fraction_of_point(cut_edge.edge, touching.xyz), touching.w == 1u);
}
