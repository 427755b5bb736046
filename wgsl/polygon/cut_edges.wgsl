// Cut edges: the border of what L-twisted polygons darken, in pieces of their edges. A workgroup takes an entry, as in
// outline.wgsl. NUMERICS.md, "Shadows of twisted polygons".

#import extract/one_caster
#import polygon/list_pieces
#import polygon/outlines
#import polygon/turn

@group(0) @binding(8) var<storage, read> faces: array<u32>;
// The end of an edge, in the place of an edge that cuts it.
const CORNER: u32 = 0xffffffffu;

// The places in order of what cuts an edge: 32 words for each invocation of a small outline, and all for a large one.
var<workgroup> ranks: array<u32, 2048>;
// Whether some places in order are those of two.
var<workgroup> is_tangled: array<atomic<u32>, 64>;
var<workgroup> cut_counts: array<atomic<u32>, 64>;
// The edges that cut it, a bit for each. A large outline has a word for each invocation, which took every 64th edge.
var<workgroup> cutting: array<u32, 64>;
// Likewise: those that have an end on it, in space, and those of which it is the second end.
var<workgroup> touching: array<u32, 64>;
var<workgroup> touching_second: array<u32, 64>;
var<workgroup> odd: array<atomic<u32>, 64>;
// The edges that cut the edge of a large outline, one after another, and the places in order that are taken.
var<workgroup> listed: array<u32, OUTLINE_EDGES>;
var<workgroup> taken: array<atomic<u32>, 32>;
// Edges of the largest outline.
const OUTLINE_EDGES: u32 = 1024u;

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

// Whether one of two edges on a line is on the left of the other, seen in the direction in which coordinates grow, in which both
// run: it begins before it, or ends behind it.
fn precedes(f: Edge, item: u32, e: Edge, index: u32) -> bool {
  if (any(f.a != e.a)) {
    return is_below(f.a, e.a);
  }
  if (any(f.b != e.b)) {
    return is_below(e.b, f.b);
  }
  return item < index;
}

// What an edge on the line of another does to it.
struct InLine {
  // It ends within the other, which it cuts there.
  cuts: bool,
  // It overlaps the end of the other, on the left of that.
  is_left_at_end: bool,
  end: vec3<u32>,
}

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

// Whether two edges on one line have the same direction.
fn runs_alike(p: vec3<u32>, q: vec3<u32>, a: vec3<u32>, b: vec3<u32>) -> bool {
  let up = ordered(p) < ordered(q);
  return any((p != q) & (a != b) & (up == (ordered(a) < ordered(b))));
}

// Finds what cuts the edge, and whether an odd number of triangles have the directions next to its end, on its left. Both are
// in one loop, so that turns are compiled once.
fn take_cuts(outline: OutlineRange, work: Work, lane: u32) {
  let slot = select(lane, 0u, work.is_large);
  let step = select(1u, OUTLINE_LANES, work.is_large);
  let e = work.edge;
  var own = 0u;
  var touches = 0u;
  var touches_second = 0u;
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
      corners[0] = f.a;
      corners[1] = f.b;
    } else {
      let face = 3u * (outline.first_triangle + item - outline.count);
      corners = array<vec3<u32>, 3>(place_of(faces[face]), place_of(faces[face + 1u]), place_of(faces[face + 2u]));
    }
    // Of an edge, the sides of a and b, and those of its ends. Of a triangle its own turn, and the sides of b and a at its edges.
    var signs: array<i32, 7>;
    // Turns: 7.
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
      signs[test] = turn(p, q, r, work.place).moved;
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
        own |= bit;
        touches |= select(0u, bit, touch);
        touches_second |= select(0u, bit, touch && is_second);
        atomicAdd(&cut_counts[slot], 1u);
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
  cutting[lane] = own;
  touching[lane] = touches;
  touching_second[lane] = touches_second;
}

// Whether an edge that has an end on the work's edge, in space, has its second end there.
fn is_second_end(work: Work, lane: u32, index: u32) -> bool {
  let word = select(lane, index % OUTLINE_LANES, work.is_large);
  return ((touching_second[word] >> select(index, index / OUTLINE_LANES, work.is_large)) & 1u) != 0u;
}

// The end of an edge that is on the work's edge, in space, and 1; or 0 if that is not how it cuts.
fn touch_of(outline: OutlineRange, work: Work, lane: u32, index: u32) -> vec4<u32> {
  let word = select(lane, index % OUTLINE_LANES, work.is_large);
  let bit = 1u << select(index, index / OUTLINE_LANES, work.is_large);
  if ((touching[word] & bit) == 0u) {
    return vec4<u32>(0u);
  }
  let f = edge_at(outline.first + index);
  return vec4<u32>(select(f.a, f.b, is_second_end(work, lane, index)), 1u);
}

// How far along the work's edge a point on it is.
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

// With more cuts, those of an edge are ordered by how far along they are, which is rounded.
const MOST_ORDERED: u32 = 256u;

// The sides of an edge's plane on which two points are: their own if it is one, or 0 if they are apart.
fn common_side(signs: vec2<i32>) -> i32 {
  return select(select(signs.x, signs.y, signs.x == 0), 0, signs.x * signs.y < 0);
}

// The sign of the turns to points on the right of an edge, seen in the direction in which coordinates grow.
fn right_of(e: Edge) -> i32 {
  return select(1, -1, is_below(e.a, e.b));
}

// The side of an edge on which another, whose ends have these sides there, cuts the work's edge: one of its ends is on that. If it
// is on both in space, it is on the right of both, and farther from the one that precedes.
fn side_of_touch(sides: vec2<i32>, is_second: bool, other: Edge, is_nearest: bool) -> i32 {
  let own = select(sides.x, sides.y, is_second);
  return select(own, select(sides.x + sides.y, right_of(other), is_nearest), own == 0);
}

// Parts of an edge that are taken for one point of it.
const ONE_POINT: f32 = 0x1p-18;

// The edges of which the order of two cuts of the first is sought.
struct Three {
  edges: array<Edge, 3>,
  // Their places in the outline.
  indices: vec3<u32>,
}

// How far along each of three edges the two others cut it, in their order: along edge 0 by 1 and 2, along 1 by 0 and 2, along 2 by 0 and 1.
fn places_of(three: Three, light: u32) -> array<vec2<f32>, 3> {
  var places: array<vec2<f32>, 3>;
  var before: TurnValue;
  // One loop over both ends of both parts of each edge.
  for (var part = 0u; part < 12u; part++) {
    let cut = part / 4u;
    let number = (part / 2u) % 2u;
    let is_second = part % 2u == 1u;
    let f = three.edges[select(number, number + 1u, number >= cut)];
    let point = select(three.edges[cut].a, three.edges[cut].b, vec3<bool>(is_second));
    let own = turn_value(f.a, f.b, point, given_light(light));
    if (is_second) {
      places[cut][number] = share_of_turns(before, own);
      if (!before.fits || !own.fits) {
        places[cut][number] = cut_at(f, three.edges[cut], light);
      }
    }
    before = own;
  }
  return places;
}

// Whether all three cross each other in one point, as it seems.
fn are_in_one_point(places: array<vec2<f32>, 3>) -> bool {
  let apart = vec3<f32>(places[0].x - places[0].y, places[1].x - places[1].y, places[2].x - places[2].y);
  return any(abs(apart) <= vec3<f32>(ONE_POINT));
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

// Which of three edges comes before the others. Edges that are seen in line cross nobody knows where, so it is one of these, if there
// are any: 0 and 1, 0 and 2, or 1 and 2.
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

// Whether edge j cuts edge e before edge i does. Turns decide where the one cut is on one side of the other edge. Otherwise all
// three cross each other. If they seem to do so in one point, each is moved to its left a little, and the foremost one farther than
// the others, out of their crossing. Else how far along the earliest of the three the others cut it decides for all three, so that
// what is found for them fits together. NUMERICS.md, "Shadows of twisted polygons", "Order".
fn is_before(outline: OutlineRange, work: Work, lane: u32, j: u32, i: u32) -> bool {
  let e = work.edge;
  let touch_j = touch_of(outline, work, lane, j);
  let touch_i = touch_of(outline, work, lane, i);
  let is_up = is_below(e.a, e.b);
  if (touch_j.w + touch_i.w == 2u && any(touch_j != touch_i)) {
    return is_below(touch_j.xyz, touch_i.xyz) == is_up;
  }
  let f = edge_at(outline.first + i);
  let g = edge_at(outline.first + j);
  // The sides of the end of e at f and g; those of the ends of g at f, and of f at g; those of the ends of g and f at e.
  var signs: array<i32, 10>;
  // Whether e and g, e and f, and g and f are seen in line.
  var in_line = vec3<bool>(true);
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
        let is_nearest = signs[1] == 0 || precedes(in_space(f), i, in_space(e), work.index);
        return side_of_touch(of_g, is_second_end(work, lane, j), f, is_nearest) != signs[0];
      }
      if (touch_i.w == 1u) {
        let is_nearest = signs[0] == 0 || precedes(in_space(g), j, in_space(e), work.index);
        return side_of_touch(of_f, is_second_end(work, lane, i), g, is_nearest) == signs[1];
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
    let found = turn(p.a, p.b, r, work.place);
    signs[test] = found.moved;
    if (test >= 2u) {
      let is_of = vec3<bool>(test == 6u || test == 7u, test >= 8u, test < 4u);
      in_line &= !is_of | vec3<bool>(found.given == 0);
    }
  }
  if (!crosses) {
    let places = vec2<f32>(place_along(outline, work, lane, j), place_along(outline, work, lane, i));
    return places.x < places.y || (places.x == places.y && j < i);
  }
  let three = Three(array<Edge, 3>(e, g, f), vec3<u32>(work.index, j, i));
  let places = places_of(three, work.place);
  if (are_in_one_point(places)) {
    switch (foremost(three, in_line)) {
      case 2u: { return right_of(f) != signs[0]; }
      case 1u: { return right_of(g) == signs[1]; }
      // It is cut where the others have left their crossing: by the end of g on its left.
      default: { return select(signs[2], signs[3], signs[6] == right_of(e)) != signs[0]; }
    }
  }
  let earliest = min(work.index, min(i, j));
  if (earliest == work.index) {
    return places[0].x < places[0].y;
  }
  // The sign of the product of what the earliest tells of e and the other one, and of the sides of its end there and of the end
  // of e here.
  let is_of_f = earliest == i;
  let along = select(places[1], places[2], is_of_f);
  let of_end = select(vec2<i32>(signs[7], signs[3]), vec2<i32>(signs[9], -signs[5]), is_of_f);
  return signs[0] * signs[1] * of_end.x * of_end.y * select(-1, 1, along.x > along.y) > 0;
}

// The edge of a bit of a word of `cutting`.
fn cutting_edge(work: Work, word: u32, bit: u32) -> u32 {
  return select(bit, OUTLINE_LANES * bit + word, work.is_large);
}

// Lists the cuts of a large outline one after another, word by word, so that all invocations take as many.
fn list_cuts(work: Work, lane: u32) {
  var place = 0u;
  // Turns: OUTLINE_LANES.
  for (var word = 0u; word < select(0u, lane, work.is_large); word++) {
    place += countOneBits(cutting[word]);
  }
  for (var rest = select(0u, cutting[lane], work.is_large); rest != 0u; rest &= rest - 1u) {
    listed[place] = cutting_edge(work, lane, firstTrailingBit(rest));
    place++;
  }
}

// A cut by its number, where `rest` has the bits of those from it on in a small outline.
fn cut_of(work: Work, number: u32, rest: u32) -> u32 {
  return select(firstTrailingBit(rest), listed[number % OUTLINE_EDGES], work.is_large);
}

// How far along the work's edge another cuts it.
fn place_along(outline: OutlineRange, work: Work, lane: u32, index: u32) -> f32 {
  let touch = touch_of(outline, work, lane, index);
  let crossing = cut_at(edge_at(outline.first + index), work.edge, work.place);
  return select(crossing, along_edge(work.edge, touch.xyz), touch.w == 1u);
}

// Finds the places in order of the cuts of an invocation.
fn rank_cuts(outline: OutlineRange, work: Work, lane: u32, by_turns: bool) {
  let ranks_at = select(SMALL_OUTLINE * lane, 0u, work.is_large);
  let count = select(0u, atomicLoad(&cut_counts[select(lane, 0u, work.is_large)]), work.exists);
  let first = select(0u, lane, work.is_large);
  let step = select(1u, OUTLINE_LANES, work.is_large);
  let bits = cutting[lane];
  var own = bits;
  // Turns: SMALL_OUTLINE.
  for (var number = first; number < select(0u, count, by_turns); number += step) {
    let i = cut_of(work, number, own);
    own &= own - 1u;
    var rank = 0u;
    var rest = bits;
    // Turns: MOST_ORDERED.
    for (var other = 0u; other < count; other++) {
      let j = cut_of(work, other, rest);
      rest &= rest - 1u;
      if (j != i && is_before(outline, work, lane, j, i)) {
        rank++;
      }
    }
    ranks[ranks_at + i] = rank;
  }
  // Turns: OUTLINE_EDGES / OUTLINE_LANES.
  for (var number = first; number < select(count, 0u, by_turns); number += step) {
    let i = cut_of(work, number, own);
    own &= own - 1u;
    let place = place_along(outline, work, lane, i);
    var rank = 0u;
    var rest = bits;
    // Turns: OUTLINE_EDGES.
    for (var other = 0u; other < count; other++) {
      let j = cut_of(work, other, rest);
      rest &= rest - 1u;
      let there = place_along(outline, work, lane, j);
      if (j != i && (there < place || (there == place && j < i))) {
        rank++;
      }
    }
    ranks[ranks_at + i] = rank;
  }
}

// Finds whether two cuts have one place.
fn note_tangles(work: Work, lane: u32) {
  let ranks_at = select(SMALL_OUTLINE * lane, 0u, work.is_large);
  var of_small = 0u;
  for (var own = select(0u, cutting[lane], work.exists); own != 0u; own &= own - 1u) {
    let rank = ranks[ranks_at + cutting_edge(work, lane, firstTrailingBit(own))];
    let bit = 1u << (rank % 32u);
    var before = of_small;
    if (work.is_large) {
      before = atomicOr(&taken[(rank / 32u) % 32u], bit);
    }
    of_small |= bit;
    if ((before & bit) != 0u) {
      atomicOr(&is_tangled[select(lane, 0u, work.is_large)], 1u);
    }
  }
}

// Lists the piece that ends at a cut, or at the end of the edge. `last` is the edge that cuts.
fn list_before(outline: OutlineRange, work: Work, lane: u32, last: u32) {
  let slot = select(lane, 0u, work.is_large);
  let ranks_at = select(SMALL_OUTLINE * lane, 0u, work.is_large);
  let cuts = atomicLoad(&cut_counts[slot]);
  var earlier = cuts;
  if (last != CORNER) {
    earlier = ranks[ranks_at + last];
  }
  var before = CORNER;
  var rest = cutting[lane];
  // Turns: OUTLINE_EDGES.
  for (var number = 0u; number < cuts; number++) {
    let edge = cut_of(work, number, rest);
    rest &= rest - 1u;
    if (ranks[ranks_at + edge] + 1u == earlier) {
      before = edge;
    }
  }
  // The last piece ends at the end of the edge, and each cut exchanges the sides.
  let is_odd_at_end = (atomicLoad(&odd[slot]) & 1u) != 0u;
  let is_odd = is_odd_at_end == ((cuts - earlier) % 2u == 0u);
  var ends = array<vec3<u32>, 2>(work.edge.a, work.edge.b);
  for (var end = 0u; end < 2u; end++) {
    let other = select(last, before, end == 0u);
    if (other != CORNER) {
      let touch = touch_of(outline, work, lane, other);
      ends[end] = touch.xyz;
      if (touch.w == 0u) {
        ends[end] = crossing_point(outline, work.index, other, work.place);
      }
    }
  }
  write_piece(work.place, take_room(work.place, 1u), ends[0], ends[1], !is_odd, middle_of(outline));
}

@compute @workgroup_size(64)
fn cut_edges(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let number = group.y * ENTRY_ROW + group.x;
  var work: Work;
  var own: OutlineRange;
  if (number < atomicLoad(&undecided[CUT_COUNT])) {
    let record = record_at(atomicLoad(&undecided[entry_at(number)]));
    own = outline_of(polygon_of(record));
    // Its lights are those for which it is cut by now.
    work = work_of(own, atomicLoad(&undecided[entry_at(number) + 1u]), atomicLoad(&undecided[record + LIGHTS]), lane);
  }
  take_cuts(own, work, lane);
  workgroupBarrier();
  list_cuts(work, lane);
  workgroupBarrier();
  let slot = select(lane, 0u, work.is_large);
  // By turns first, then by rounded places where these do not fit together.
  for (var attempt = 0u; attempt < 2u; attempt++) {
    let by_turns = attempt == 0u && atomicLoad(&cut_counts[slot]) <= MOST_ORDERED;
    if (attempt == 0u || atomicLoad(&is_tangled[slot]) != 0u) {
      rank_cuts(own, work, lane, by_turns);
    }
    workgroupBarrier();
    if (attempt == 0u) {
      note_tangles(work, lane);
    }
    workgroupBarrier();
  }
  if (!work.exists) {
    return;
  }
  // Each of its cuts ends a piece, and so does the end of the edge.
  var rest = cutting[lane];
  // Turns: 17.
  for (var left = countOneBits(rest) + select(0u, 1u, !work.is_large || lane == 0u); left > 0u; left--) {
    var last = CORNER;
    if (rest != 0u) {
      last = cutting_edge(work, lane, firstTrailingBit(rest));
      rest &= rest - 1u;
    }
    list_before(own, work, lane, last);
  }
}
