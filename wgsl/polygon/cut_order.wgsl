// The order of two cuts along the edge that they cut, for the passes of cut_edges.wgsl: `cut_edges_rank` counts by `is_before`
// how many cuts are before each. A cut is where an edge of an outline crosses another as seen from a light. Turns decide wherever
// one cut is on one side of the other's edge: a turn is 1 if the light sees three points counter-clockwise, -1 if clockwise, with
// ties broken by a light that is moved a little (polygon/turn.wgsl). Where three edges cross each other, how far along the edge
// the cuts are decides, which is rounded. Each of the three must get an order that fits the other two, or pieces leave gaps: so
// all take it from the same numbers, and a rule may be changed only with its proof. `Turns:` comments are about loops.
// docs/numerics/twisted-polygons.md, "Order of cuts".

#import extract/one_caster
#import polygon/cuts
#import polygon/list_pieces
#import polygon/outlines
#import polygon/turn

// The edge that is cut, and what sees it.
struct CutEdge {
  outline: OutlineRange,
  edge: Edge,
  index: u32,
  light: u32,
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

// The side of an edge on which two points are, by their turns: 0 if they are on different sides. A point on the edge's line is on
// either side.
fn common_side(signs: vec2<i32>) -> i32 {
  return select(select(signs.x, signs.y, signs.x == 0), 0, signs.x * signs.y < 0);
}

// The sign of the turns to points on the right of an edge, seen in the direction in which coordinates grow.
fn right_of(e: Edge) -> i32 {
  return select(1, -1, is_below(e.a, e.b));
}

// The side of an edge on which another, whose ends have these sides there, cuts the edge that is cut: one of its ends is on that.
// If it is on both in space, it is on the right of both, and farther from the one that precedes.
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

// How far along each of three edges the two others cut it: along edge 0 those of 1 and 2, along 1 of 0 and 2, along 2 of 0 and 1.
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

// Which of three edges comes before the others. Edges that are seen in line cross nobody knows where, so it is one of these, if
// there are any: 0 and 1, 0 and 2, or 1 and 2.
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

// Whether cut j is before cut i on the edge that both cut. Turns decide where the one cut is on one side of the other's edge.
// Otherwise all three edges cross each other. If they seem to do so in one point, each is moved to its left a little, and the
// foremost one farther than the others, out of their crossing. Else how far along the earliest of the three the others cut it
// decides for all three. Rounded distances also decide where edges cross each other's opposite directions; nothing has to fit
// there.
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
      let is_of = vec3<bool>(test == 6u || test == 7u, test >= 8u, test < 4u);
      in_line &= !is_of | vec3<bool>(found.given == 0);
    }
  }
  if (!crosses) {
    let places = vec2<f32>(place_along(own, cut_j), place_along(own, cut_i));
    return places.x < places.y || (places.x == places.y && j < i);
  }
  let three = Three(array<Edge, 3>(e, g, f), vec3<u32>(own.index, j, i));
  let places = places_of(three, own.light);
  if (are_in_one_point(places)) {
    switch (foremost(three, in_line)) {
      case 2u: { return right_of(f) != signs[0]; }
      case 1u: { return right_of(g) == signs[1]; }
      // It is cut where the others have left their crossing: by the end of g on its left.
      default: { return select(signs[2], signs[3], signs[6] == right_of(e)) != signs[0]; }
    }
  }
  let earliest = min(own.index, min(i, j));
  if (earliest == own.index) {
    return places[0].x < places[0].y;
  }
  // The sign of the product of what the earliest tells of e and the other one, and of the sides of its end there and of the end
  // of e here.
  let is_of_f = earliest == i;
  let along = select(places[1], places[2], is_of_f);
  let of_end = select(vec2<i32>(signs[7], signs[3]), vec2<i32>(signs[9], -signs[5]), is_of_f);
  return signs[0] * signs[1] * of_end.x * of_end.y * select(-1, 1, along.x > along.y) > 0;
}

// How far along the edge a cut is, rounded.
fn place_along(own: CutEdge, cut: Cut) -> f32 {
  let touch = touch_of(own.outline, cut);
  let crossing = cut_at(edge_at(own.outline.first + cut.by), own.edge, own.light);
  return select(crossing, along_edge(own.edge, touch.xyz), touch.w == 1u);
}
