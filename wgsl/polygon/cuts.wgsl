// Cuts: where an edge of an L-twisted outline (one that crosses itself as seen from light L) is crossed by another as seen
// from the light. First the records of cuts, then their order along the edge that they cut. Only the passes of
// cut_edges.wgsl import this. A comment `Turns:` is about the loop below it. docs/numerics/twisted-polygons.md, "Order of
// cuts".

#import extract/one_caster
#import polygon/list_pieces
#import polygon/outlines
#import polygon/turn

// Records. `cut_edges` writes the cuts of an edge as a row, in no particular order, and the edge's end behind them, into
// `pieces`: one record for each piece of the edge. `cut_edges_list` overwrites each record with the piece that ends at that
// cut. So a record must fit in the words of a piece. If a row does not fit the list, the records that do have NO_POLYGON,
// and no pass may use the row.

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

// Words of a cut: the polygon, or NO_POLYGON if there was no room for the row; the edge that is cut, with the highest bit
// if, as the light sees it, an odd number of triangles are next to its end on its left, and the next one if fixed point
// holds the outline's turns; the cut; the place in the light's list of the first of its row, and how many cuts that has,
// without the end.
const OF_POLYGON: u32 = 0u;
const OF_EDGE: u32 = 1u;
const CUT: u32 = 2u;
const ROW: u32 = 3u;
const ROW_CUTS: u32 = 4u;
// Then what `cut_edges_rank` writes: how many cuts of the row are before it by `is_before`; and how far along the edge it
// is, from 0 to 1, the bits of a rounded f32. Last what `cut_edges_before` finds: the cut right before it; and how many are
// before it, by RANK if all ranks of the row differ, else by ALONG.
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

// Takes room in a light's list for the cuts of an edge and for its end, and workgroups of the next passes for those that
// fit. A group is GROUP_CUTS places from a multiple of it on. Rooms follow each other in the list (`take_room`), so each
// group is counted once, by the row that has its first place.
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

// The order of two cuts. `cut_edges_rank` counts by `is_before` how many cuts are before each. Turns decide wherever one cut
// is on one side of the other's edge: a turn is 1 if the light sees three points counter-clockwise, -1 if clockwise, with
// ties broken by a light that is moved a little (polygon/turn.wgsl). Where three edges cross each other, how far along the
// edge the cuts are decides, which is rounded. Each of the three must get an order that fits the other two, or pieces leave
// gaps: so all take it from the same numbers, and a rule may be changed only with its proof.

// The edge that is cut, and what sees it.
struct CutEdge {
  outline: OutlineRange,
  edge: Edge,
  index: u32,
  light: u32,
  // Fixed point holds the outline's turns. If not, nothing tells where edges that are seen in line cut each other, and cuts
  // have no `tie`.
  holds_turns: bool,
}

// Whether a point comes before another on a line, in the direction in which coordinates grow: the first that differs.
fn is_below(p: vec3<u32>, q: vec3<u32>) -> bool {
  let lower = ordered(p);
  let upper = ordered(q);
  if (lower.x != upper.x) {
    return lower.x < upper.x;
  }
  if (lower.y != upper.y) {
    return lower.y < upper.y;
  }
  return lower.z < upper.z;
}

// An edge in the direction in which coordinates grow.
fn in_space(e: Edge) -> Edge {
  if (is_below(e.a, e.b)) {
    return e;
  }
  return Edge(e.b, e.a, e.has_length);
}

// Whether one of two edges on a line is on the left of the other, seen in the direction in which coordinates grow, in which
// both run: it begins before it, or ends behind it.
fn precedes(f: Edge, item: u32, e: Edge, index: u32) -> bool {
  if (any(f.a != e.a)) {
    return is_below(f.a, e.a);
  }
  if (any(f.b != e.b)) {
    return is_below(e.b, f.b);
  }
  return item < index;
}

// The end of an edge that is on the edge it cuts, in space, and 1; or 0 if that is not how it cuts.
fn touch_of(outline: OutlineRange, cut: Cut) -> vec4<u32> {
  if (!cut.touches) {
    return vec4<u32>(0u);
  }
  let f = edge_at(outline.first + cut.by);
  return vec4<u32>(select(f.a, f.b, cut.is_second), 1u);
}

// How far along an edge a point on it is, from 0 to 1, rounded.
fn along_edge(e: Edge, point: vec3<u32>) -> f32 {
  let a = bitcast<vec3<f32>>(e.a);
  let along = bitcast<vec3<f32>>(e.b) - a;
  let from_a = bitcast<vec3<f32>>(point) - a;
  let size = abs(along);
  if (size.x >= size.y && size.x >= size.z) {
    return from_a.x / along.x;
  }
  return select(from_a.z / along.z, from_a.y / along.y, size.y >= size.z);
}

// The side of an edge on which two points are, by their turns: 0 if they are on different sides. A point on the edge's line
// is on either side.
fn common_side(signs: vec2<i32>) -> i32 {
  return select(select(signs.x, signs.y, signs.x == 0), 0, signs.x * signs.y < 0);
}

// The sign of the turns to points on the right of an edge, seen in the direction in which coordinates grow.
fn right_of(e: Edge) -> i32 {
  return select(1, -1, is_below(e.a, e.b));
}

// The side of an edge on which another, whose ends have these sides there, cuts the edge that is cut: one of its ends is on
// that. If it is on both in space, it is on the right of both, and farther from the one that precedes.
fn side_of_touch(sides: vec2<i32>, is_second: bool, other: Edge, is_nearest: bool) -> i32 {
  let own = select(sides.x, sides.y, is_second);
  return select(own, select(sides.x + sides.y, right_of(other), is_nearest), own == 0);
}

// How far along an edge another is, as the light sees it, or the axis that breaks the tie.
fn seen_cut_at(f: Edge, e: Edge, light: u32, tie: u32) -> f32 {
  let axis = bitcast<vec4<f32>>(light_or_axis(light, tie));
  return cut_at(f, e, select(axis, scaled_light(light), tie == 0u));
}

// Parts of an edge that are taken for one point of it.
const ONE_POINT: f32 = 0x1p-18;

// The edges of which the order of two cuts of the first is sought.
struct Three {
  edges: array<Edge, 3>,
  // Their places in the outline.
  indices: vec3<u32>,
  // The lights that tell where along each the others are, in their order, as `tie` of a cut.
  ties: array<vec2<u32>, 3>,
}

// The order of the cuts of three edges.
struct Told {
  // The edge along which the others come in an order, or `NONE`: all three seem to cross in one point.
  first: u32,
  // Whether the first of the others, in their order, comes after the second.
  is_after: bool,
}

const NONE: u32 = 3u;

// The order of three edges by how far along each the two others cut it: along edge 0 those of 1 and 2, along 1 of 0 and 2,
// along 2 of 0 and 1. The earliest edge tells it. If some are seen in line, others see these cross in one point, so the edge
// along which the others are farthest apart tells it.
fn told_by_places(indices: vec3<u32>, ties: array<vec2<u32>, 3>, places: array<vec2<f32>, 3>) -> Told {
  let apart = vec3<f32>(places[0].x - places[0].y, places[1].x - places[1].y, places[2].x - places[2].y);
  let size = abs(apart);
  var first = earliest_of(indices);
  if (all((ties[0] | ties[1] | ties[2]) == vec2<u32>(0u))) {
    first = select(first, NONE, any(size <= vec3<f32>(ONE_POINT)));
  } else {
    // The earliest of those that are equal.
    for (var edge = 0u; edge < 3u; edge++) {
      let is_earlier = size[edge] == size[first] && indices[edge] < indices[first];
      first = select(first, edge, size[edge] > size[first] || is_earlier);
    }
    first = select(first, NONE, size[first] <= ONE_POINT);
  }
  return Told(first, apart[min(first, 2u)] > 0.0);
}

fn earliest_of(indices: vec3<u32>) -> u32 {
  let is_earliest = indices == vec3<u32>(min(indices.x, min(indices.y, indices.z)));
  return select(select(2u, 1u, is_earliest.y), 0u, is_earliest.x);
}

// Turns of the ends of an edge at two others: of a and b at the one, and of a and b at the other, for the light as given and
// for the axes. Each is a value of at most 1 times a power of two.
struct EndTurns {
  values: array<vec4<f32>, 4>,
  exponents: array<vec4<i32>, 4>,
}

// The sign of how much farther along the edge the one is than the other, times the signs of the turns of its end at both,
// where the light as given sees no difference. If the moved light sees none either, or the given one does see it, it is 0.
fn sign_apart(turns: EndTurns) -> i32 {
  // Their places are t/(t - t'), where t and t' are polynomials in how far the light moves. So is what they differ by.
  for (var power = 0u; power < 7u; power++) {
    var exponent = -0x10000;
    var sum = 0.0;
    var size = 0.0;
    // First the largest exponent, then the sum.
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
    if (abs(sum) > SAME * size) {
      return select(0, select(-1, 1, sum > 0.0), power > 0u);
    }
  }
  return 0;
}

// Parts of a sum of products that may be rounding.
const SAME: f32 = 0x1p-20;

// The order of the cuts of three edges, by turns of ends of edges at others: by where each is along each, and, if this does
// not tell, as the moved light sees them. If 1 and 2 do not cross each other, only that along 0. One loop, so that turns are
// compiled once.
fn told_by(three: Three, own: CutEdge, crosses: bool) -> Told {
  let light = own.light;
  var places: array<vec2<f32>, 3>;
  var before: TurnValue;
  var turns: EndTurns;
  // The earliest edge, and the others in their order.
  let first = select(0u, earliest_of(three.indices), crosses);
  var others = vec2<u32>(select(0u, 1u, first == 0u), select(2u, 1u, first == 2u));
  others = select(others, others.yx, three.indices[others.x] > three.indices[others.y]);
  // Turns: 28.
  for (var part = select(12u, 0u, crosses); part < 28u; part++) {
    if (part == 12u) {
      var told = Told(NONE, false);
      if (crosses) {
        told = told_by_places(three.indices, three.ties, places);
      }
      if (told.first != NONE || !own.holds_turns) {
        return told;
      }
    }
    let is_place = part < 12u;
    // A place takes both ends of an edge at another. Then come each end of the earliest edge at each other for each light.
    var cut = part / 4u;
    let number = select((part - 12u) / 8u, (part / 2u) % 2u, is_place);
    let end = select((part / 4u + 1u) % 2u, part % 2u, is_place);
    var by = select(number, number + 1u, number >= cut);
    var tie = part % 4u;
    if (is_place) {
      tie = three.ties[cut][number];
    } else {
      cut = first;
      by = others[number];
    }
    let f = three.edges[by];
    let point = select(three.edges[cut].a, three.edges[cut].b, vec3<bool>(end == 1u));
    let value = turn_value(f.a, f.b, point, light_or_axis(light, tie));
    if (!is_place) {
      let parts = frexp(value.value);
      turns.values[2u * number + end][tie] = parts.fract;
      turns.exponents[2u * number + end][tie] = parts.exp + value.exponent;
    } else if (end == 1u) {
      places[cut][number] = share_of_turns(before, value);
      if (!before.fits || !value.fits) {
        places[cut][number] = cut_at(f, three.edges[cut], scaled_light(light));
      }
    }
    before = value;
  }
  let side = sign_apart(turns) * moved_sign(turns.values[1]) * moved_sign(turns.values[3]);
  return Told(select(NONE, first, side != 0), (side > 0) == (others.x < others.y));
}

// The sign of a turn of the moved light, by the values for the light as given and for the axes.
fn moved_sign(values: vec4<f32>) -> i32 {
  let signs = vec4<i32>(sign(values));
  let of_axes = select(select(signs.w, signs.z, signs.z != 0), signs.y, signs.y != 0);
  return select(of_axes, signs.x, signs.x != 0);
}

// Which of two of three edges comes before the other in the order of `precedes`.
fn former(three: Three, one: u32, other: u32) -> u32 {
  let is_before = precedes(
    in_space(three.edges[one]),
    three.indices[one],
    in_space(three.edges[other]),
    three.indices[other],
  );
  return select(other, one, is_before);
}

// Which of three edges comes before the others. If nobody knows where edges that are seen in line cross, it is one of these:
// 0 and 1, 0 and 2, or 1 and 2.
fn foremost(three: Three, in_line: vec3<bool>) -> u32 {
  if (in_line.x) {
    return former(three, 0u, 1u);
  }
  if (in_line.y) {
    return former(three, 0u, 2u);
  }
  let of_others = former(three, 1u, 2u);
  return select(former(three, 0u, of_others), of_others, in_line.z);
}

// Whether cut j is before cut i on the edge that both cut. Turns decide where the one cut is on one side of the other's
// edge. Otherwise all three edges cross each other. How far along one of the three the others cut it decides for all three.
// If they seem to cross in one point, the moved light tells them apart. If it sees them in one point, too, each is moved to
// its left a little, and the foremost one farther than the others, out of their crossing. Rounded distances also decide
// where edges cross each other's opposite directions; nothing has to fit there.
fn is_before(own: CutEdge, cut_j: Cut, cut_i: Cut) -> bool {
  let e = own.edge;
  let j = cut_j.by;
  let i = cut_i.by;
  let touch_j = touch_of(own.outline, cut_j);
  let touch_i = touch_of(own.outline, cut_i);
  let is_up = is_below(e.a, e.b);
  if (touch_j.w + touch_i.w == 2u && any(touch_j != touch_i)) {
    return is_below(touch_j.xyz, touch_i.xyz) == is_up;
  }
  let f = edge_at(own.outline.first + i);
  let g = edge_at(own.outline.first + j);
  // The sides of the end of e at f and g; those of the ends of g at f, and of f at g; those of the ends of g and f at e.
  var signs: array<i32, 10>;
  // The lights that tell where along g and f the two others are.
  var ties = array<vec2<u32>, 2>(vec2<u32>(IN_LINE), vec2<u32>(IN_LINE));
  var crosses = false;
  for (var test = 0u; test < 10u; test++) {
    if (test == 6u) {
      let of_g = vec2<i32>(signs[2], signs[3]);
      let of_f = vec2<i32>(signs[4], signs[5]);
      if (all(of_g == vec2<i32>(0))) {
        // All in one line: what is nearer cuts first upwards.
        let is_first = precedes(in_space(g), j, in_space(f), i);
        return select(is_first == (signs[0] == right_of(f)), is_first != is_up, signs[0] == 0);
      }
      if (touch_j.w + touch_i.w == 2u) {
        // Both from one point on e. One that is in line with e says nothing of the other.
        return select(of_g.x + of_g.y != signs[0], of_f.x + of_f.y == signs[1], signs[0] == 0);
      }
      if (touch_j.w == 1u) {
        let is_nearest = signs[1] == 0 || precedes(in_space(f), i, in_space(e), own.index);
        return side_of_touch(of_g, cut_j.is_second, f, is_nearest) != signs[0];
      }
      if (touch_i.w == 1u) {
        let is_nearest = signs[0] == 0 || precedes(in_space(g), j, in_space(e), own.index);
        return side_of_touch(of_f, cut_i.is_second, g, is_nearest) == signs[1];
      }
      // The cut of g is on this side of f, or that of f on this side of g.
      if (common_side(of_g) != 0) {
        return common_side(of_g) != signs[0];
      }
      if (common_side(of_f) != 0) {
        return common_side(of_f) == signs[1];
      }
      // Where they cross each other's opposite directions, nothing has to fit.
      crosses = signs[2] == signs[5];
      if (!crosses) {
        break;
      }
    }
    var p = f;
    if (test == 1u || test == 4u || test == 5u) {
      p = g;
    } else if (test >= 6u) {
      p = e;
    }
    var r = e.b;
    switch (test) {
      case 2u, 6u: { r = g.a; }
      case 3u, 7u: { r = g.b; }
      case 4u, 8u: { r = f.a; }
      case 5u, 9u: { r = f.b; }
      default: {}
    }
    let found = turn(p.a, p.b, r, own.light);
    signs[test] = found.moved;
    if (test >= 2u) {
      let of_f = (test / 2u) % 2u == 0u;
      let is_of = vec2<bool>(test >= 6u, test < 6u);
      ties[select(0u, 1u, of_f)] = min(ties[select(0u, 1u, of_f)], select(vec2<u32>(IN_LINE), vec2<u32>(found.tie), is_of));
    }
  }
  var is_nearer = false;
  if (!crosses) {
    let places = vec2<f32>(place_along(own, cut_j), place_along(own, cut_i));
    is_nearer = places.x < places.y || (places.x == places.y && j < i);
    if (abs(places.x - places.y) > ONE_POINT) {
      return is_nearer;
    }
  }
  // Whether e and g, e and f, and g and f are seen in line, and nobody knows where they cross.
  let in_line = vec3<bool>(!own.holds_turns) & (vec3<u32>(ties[0].x, ties[1].x, ties[0].y) > vec3<u32>(0u));
  let known = select(vec2<u32>(0u), vec2<u32>(0xffffffffu), own.holds_turns);
  let three = Three(
    array<Edge, 3>(e, g, f),
    vec3<u32>(own.index, j, i),
    array<vec2<u32>, 3>(vec2<u32>(cut_j.tie, cut_i.tie), ties[0] & known, ties[1] & known),
  );
  let told = told_by(three, own, crosses);
  if (told.first == NONE) {
    if (!crosses) {
      return is_nearer;
    }
    switch (foremost(three, in_line)) {
      case 2u: { return right_of(f) != signs[0]; }
      case 1u: { return right_of(g) == signs[1]; }
      // It is cut where the others have left their crossing: by the end of g on its left.
      default: { return select(signs[2], signs[3], signs[6] == right_of(e)) != signs[0]; }
    }
  }
  if (told.first == 0u) {
    return !told.is_after;
  }
  // The sign of the product of what the first tells of e and the other one, and of the sides of its end there and of the end
  // of e here.
  let is_of_f = told.first == 2u;
  let of_end = select(vec2<i32>(signs[7], signs[3]), vec2<i32>(signs[9], -signs[5]), is_of_f);
  return signs[0] * signs[1] * of_end.x * of_end.y * select(-1, 1, told.is_after) > 0;
}

// How far along the edge a cut is, rounded.
fn place_along(own: CutEdge, cut: Cut) -> f32 {
  let touch = touch_of(own.outline, cut);
  let crossing = seen_cut_at(edge_at(own.outline.first + cut.by), own.edge, own.light, cut.tie);
  return select(crossing, along_edge(own.edge, touch.xyz), touch.w == 1u);
}
