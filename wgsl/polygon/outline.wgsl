// Outline: looks at all pairs of edges of the outlines that `polygon_turns` left undecided, for each light that it left.
// `undecided` has a record for each such polygon, and entries, each a part of the work of one record
// (polygon/outlines.wgsl). Dispatched indirectly after `polygon_turns`, one workgroup an entry. An entry of a small outline
// has up to 4 edges and 16 lights, an invocation each; one of a large outline an edge and a light, which all invocations
// share. It sets bits of the record, in any order: whether edges meet, how often the outline winds around on the left of
// each edge, whether all corners lie within a half-space, whether anything is off a plane with the light. `polygon_masks`,
// the next stage, decides from them. All is exact, by turns: 1 if the light sees three points counter-clockwise, -1 if
// clockwise. A tie is broken by moving the light a little, the same way for all pairs and stages, so that what they find
// fits together. `Turns:` is the most turns of the loop below it, `in all` those of all times that the loop is reached; a
// loop between constants needs none. docs/numerics/polygons.md.

#import polygon/outlines
#import polygon/turn

// The findings for an edge and a light: the winding number on the edge's left, and the bits below. With a small outline each
// invocation has one, with a large one all share the first. WGSL sets workgroup variables to zero, and a workgroup takes one
// entry.
var<workgroup> windings: array<atomic<i32>, 64>;
var<workgroup> found: array<atomic<u32>, 64>;
// The rightmost corner among those that each invocation saw, as seen from the edge's first corner; w: 1 if it saw any.
var<workgroup> rightmost: array<vec4<u32>, 64>;

// Bits of `found`: the edge crosses or touches another; an edge and a corner are not in one plane with the light as given; a
// corner is on the left, or on the right, of the line from the edge's first corner to the rightmost corner seen from there.
const MEETS: u32 = 1u;
const LEAVES_PLANE: u32 = 2u;
const IS_ANY_LEFT: u32 = 4u;
const IS_ANY_RIGHT: u32 = 8u;

// The number that an edge (c, d) adds to the winding number on the left of an edge (a, b), which is counted along the line
// through a and b, from just before b on. `sides` are the turns (a, b, c) and (a, b, d), and `b_of_f` is the turn (c, d, b):
// the side of b as seen from the other edge.
fn passes(sides: vec2<i32>, b_of_f: i32) -> i32 {
  if (sides.x <= 0 && sides.y > 0) {
    return select(0, 1, b_of_f >= 0);
  }
  if (sides.x > 0 && sides.y <= 0) {
    return select(0, -1, b_of_f <= 0);
  }
  return 0;
}

// Whether two edges cross, or touch elsewhere than at an end that they share. `of_e` are the turns from `e` to both ends of
// `f`, and `of_f` those from `f` to both ends of `e`, for the moved light.
fn meets(e: Edge, f: Edge, of_e: vec2<i32>, of_f: vec2<i32>) -> bool {
  let in_line = all(of_e == vec2<i32>(0)) && all(of_f == vec2<i32>(0));
  let shares = vec4<bool>(all(e.a == f.a), all(e.a == f.b), all(e.b == f.a), all(e.b == f.b));
  if (any(shares)) {
    // The edges share `from_end`; `end` and `other` are their other ends. Edges in line overlap unless `from_end` is between
    // these. The second argument of `is_between` is the point in the middle.
    let shares_a = shares.x || shares.y;
    let end = select(e.a, e.b, shares_a);
    let from_end = select(e.b, e.a, shares_a);
    let other = select(f.a, f.b, select(shares.z, shares.x, shares_a));
    return in_line && !is_between(end, from_end, other);
  }
  if (in_line) {
    return is_between(e.a, f.a, e.b) || is_between(e.a, f.b, e.b) || is_between(f.a, e.a, f.b);
  }
  let apart_from_e = of_e.x * of_e.y;
  let apart_from_f = of_f.x * of_f.y;
  if (apart_from_e < 0 && apart_from_f < 0) {
    return of_e.x == of_f.y;
  }
  return (apart_from_e == 0 && apart_from_f < 0) || (apart_from_e < 0 && apart_from_f == 0);
}

// Takes the pairs of the invocation's edge and every other; with a large outline every 64th, so of at most 1,024 edges 16,
// fewer than the SMALL_OUTLINE that `Turns:` counts. All invocations must call it, for its barriers. One loop has eight
// phases, so that `turn` is compiled once: all pairs, and the rightmost corner among those that the invocation sees; six
// steps in which 64 invocations of a large outline find the rightmost of all, by halves; and whether all corners are on the
// left of the line to it.
fn seen_by_pairs(outline: OutlineRange, work: Work, lane: u32) {
  let slot = select(lane, 0u, work.is_large);
  let step = select(1u, OUTLINE_LANES, work.is_large);
  var best = vec4<u32>(0u);
  for (var phase = 0u; phase < 8u; phase++) {
    let is_pairs = phase == 0u;
    let is_check = phase == 7u;
    let half = OUTLINE_LANES >> phase;
    if (is_check && work.is_large) {
      best = rightmost[0];
    }
    var first = select(0u, lane, work.is_large);
    var end = outline.count;
    if (!is_pairs && !is_check) {
      first = 0u;
      end = select(0u, 1u, work.is_large && lane < half);
    }
    end = select(0u, end, work.exists);
    // Turns: 2 * SMALL_OUTLINE + 6 in all.
    for (var other = first; other < end; other += step) {
      var f: Edge;
      var is_corner = true;
      if (is_pairs || is_check) {
        f = edge_at(outline.first + other);
        is_corner = f.has_length && other != work.index;
      } else {
        let theirs = rightmost[lane + half];
        f.a = theirs.xyz;
        is_corner = theirs.w != 0u;
      }
      if (!is_corner) {
        continue;
      }
      var of_e = vec2<i32>(0);
      var of_f = vec2<i32>(0);
      // Turns: 6 * SMALL_OUTLINE + 6 in all.
      for (var test = select(4u, 0u, is_pairs); test < 5u; test++) {
        var p = work.edge.a;
        var q = work.edge.b;
        var r = f.a;
        switch (test) {
          case 0u: {}
          case 1u: { r = f.b; }
          case 2u: { p = f.a; q = f.b; r = work.edge.a; }
          case 3u: { p = f.a; q = f.b; r = work.edge.b; }
          default: { q = best.xyz; }
        }
        // A corner at the position of the edge's first corner does not count.
        if (test == 4u && (best.w == 0u || all(r == p))) {
          if (best.w == 0u && any(r != p) && !is_check) {
            best = vec4<u32>(r, 1u);
          }
          continue;
        }
        let found_turn = turn(p, q, r, work.place);
        let sign = found_turn.moved;
        switch (test) {
          case 0u: { of_e.x = sign; }
          case 1u: { of_e.y = sign; }
          case 2u: { of_f.x = sign; }
          case 3u: { of_f.y = sign; }
          default: {}
        }
        if (test < 4u && found_turn.tie == 0u) {
          atomicOr(&found[slot], LEAVES_PLANE);
        }
        if (test == 4u) {
          if (is_check) {
            atomicOr(&found[slot], select(0u, IS_ANY_LEFT, sign > 0) | select(0u, IS_ANY_RIGHT, sign < 0));
          } else if (sign < 0) {
            best = vec4<u32>(r, 1u);
          }
        }
      }
      if (is_pairs) {
        atomicAdd(&windings[slot], passes(of_e, of_f.y));
        if (meets(work.edge, f, of_e, of_f)) {
          atomicOr(&found[slot], MEETS);
        }
      }
    }
    // Each step reads what the half behind it left.
    if (is_pairs || (!is_check && lane < half)) {
      rightmost[lane] = best;
    }
    workgroupBarrier();
  }
}

// Adds what was found for an edge to the record of its polygon.
fn note(record: u32, slot: u32, place: u32) {
  let bit = 1u << place;
  let winding = atomicLoad(&windings[slot]);
  let seen = atomicLoad(&found[slot]);
  if ((seen & IS_ANY_LEFT) != 0u && (seen & IS_ANY_RIGHT) == 0u) {
    atomicOr(&undecided[record + FITS], bit);
  }
  if ((seen & MEETS) != 0u || (winding != 0 && winding != 1)) {
    atomicOr(&undecided[record + IS_NOT_SIMPLE], bit);
  }
  if (winding == 1) {
    atomicOr(&undecided[record + WINDS_ONCE], bit);
  }
  if (winding == 0) {
    atomicOr(&undecided[record + WINDS_NEVER], bit);
  }
  if ((seen & LEAVES_PLANE) != 0u) {
    atomicOr(&undecided[record + OFF_PLANE], bit);
  }
}

@compute @workgroup_size(64)
fn outline(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let number = group.y * ENTRY_ROW + group.x;
  // The last row is not full.
  let exists = number < atomicLoad(&undecided[ENTRY_COUNT]);
  var record = UNDECIDED_HEAD;
  var work: Work;
  var own: OutlineRange;
  if (exists) {
    record = record_at(atomicLoad(&undecided[entry_at(number)]));
    own = outline_of(polygon_of(record));
    let part = atomicLoad(&undecided[entry_at(number) + 1u]);
    work = work_of(own, part, atomicLoad(&undecided[record + LIGHTS]), lane);
  }
  seen_by_pairs(own, work, lane);
  if (work.exists && (!work.is_large || lane == 0u)) {
    note(record, select(lane, 0u, work.is_large), work.place);
  }
}
