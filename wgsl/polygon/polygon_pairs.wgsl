// Polygon pairs: tests all pairs of edges of the boundaries that `polygon_turns` left undecided, for each undecided light.
// `undecided` has their records, and entries, parts of the work of a record (polygon/boundaries.wgsl).
// Dispatched indirectly after `polygon_turns`, a workgroup an entry. For a small boundary an entry has up to 4 edges and 16
// lights, an invocation each; for a large one it has an edge and a light, which all invocations share. It sets bits of the
// record, in any order: edges meet; winding numbers on the left of edges; all corners lie in a half-space; something is off
// a plane with the light. `polygon_masks` decides from them. All turns are exact: 1 if the light sees three points
// counter-clockwise, -1 if clockwise. A tie is broken by moving the light, in the same way for all pairs and stages.
// `Turns:` above a loop is its most iterations, with `in all` for all times that it is reached. Claims:
// docs/numerics/polygons.md.

#import polygon/boundaries
#import polygon/corner_turn

// The results for an edge and a light: the winding number on the edge's left, and the bits below. For a small boundary each
// invocation has an element, for a large one all share the first. A workgroup has one entry and starts with zeros.
var<workgroup> windings: array<atomic<i32>, 64>;
var<workgroup> results: array<atomic<u32>, 64>;
// The rightmost corner that each invocation saw, seen from the edge's first corner; w: 1 if it saw any.
var<workgroup> rightmost: array<vec4<u32>, 64>;

// Bits of `results`: the edge crosses or touches another; an edge and a corner are not in one plane with the given light; a
// corner is on the left, or on the right, of the line from the edge's first corner to the rightmost corner seen from there.
const HAS_CONTACT: u32 = 1u;
const LEAVES_PLANE: u32 = 2u;
const IS_ANY_LEFT: u32 = 4u;
const IS_ANY_RIGHT: u32 = 8u;

// The change by an edge (c, d) of the winding number on the left of an edge (a, b). It is counted along the line through a
// and b, from just before b on. `sides` are the turns (a, b, c) and (a, b, d); `turn_of_b` is (c, d, b), the side of b seen
// from (c, d).
fn winding_change(sides: vec2<i32>, turn_of_b: i32) -> i32 {
  if (sides.x <= 0 && sides.y > 0) {
    return select(0, 1, turn_of_b >= 0);
  }
  if (sides.x > 0 && sides.y <= 0) {
    return select(0, -1, turn_of_b <= 0);
  }
  return 0;
}

// The turns of two edges e and f, for the moved light.
struct PairTurns {
  // Tests 0 and 1: from e to both ends of f.
  at_e: vec2<i32>,
  // Tests 2 and 3: from f to both ends of e.
  at_f: vec2<i32>,
}

// Whether two edges cross, or touch elsewhere than at a common end.
fn has_contact(e: Edge, f: Edge, turns: PairTurns) -> bool {
  let in_line = all(turns.at_e == vec2<i32>(0)) && all(turns.at_f == vec2<i32>(0));
  let shares = vec4<bool>(all(e.a == f.a), all(e.a == f.b), all(e.b == f.a), all(e.b == f.b));
  if (any(shares)) {
    // The edges share `from_end`; `end` and `other` are their other ends. Edges in line overlap unless `from_end` lies
    // between these.
    let shares_a = shares.x || shares.y;
    let end = select(e.a, e.b, shares_a);
    let from_end = select(e.b, e.a, shares_a);
    let other = select(f.a, f.b, select(shares.z, shares.x, shares_a));
    return in_line && !is_between(end, from_end, other);
  }
  if (in_line) {
    return is_between(e.a, f.a, e.b) || is_between(e.a, f.b, e.b) || is_between(f.a, e.a, f.b);
  }
  let sides_at_e = turns.at_e.x * turns.at_e.y;
  let sides_at_f = turns.at_f.x * turns.at_f.y;
  if (sides_at_e < 0 && sides_at_f < 0) {
    // If not, each crosses the opposite directions of the other.
    return turns.at_e.x == turns.at_f.y;
  }
  return (sides_at_e == 0 && sides_at_f < 0) || (sides_at_e < 0 && sides_at_f == 0);
}

// The test that compares the first corner of f with the rightmost corner.
const RIGHTMOST_TEST: u32 = 4u;

// The three points of a test.
fn points_of_pair_test(e: Edge, f: Edge, best: vec4<u32>, test: u32) -> array<vec3<u32>, 3> {
  switch (test) {
    case 0u: { return array<vec3<u32>, 3>(e.a, e.b, f.a); }
    case 1u: { return array<vec3<u32>, 3>(e.a, e.b, f.b); }
    case 2u: { return array<vec3<u32>, 3>(f.a, f.b, e.a); }
    case 3u: { return array<vec3<u32>, 3>(f.a, f.b, e.b); }
    default: { return array<vec3<u32>, 3>(e.a, best.xyz, f.a); }
  }
}

// The turns with the sign of a test from 0 to 3.
fn with_turn(turns: PairTurns, test: u32, sign: i32) -> PairTurns {
  var result = turns;
  switch (test) {
    case 0u: { result.at_e.x = sign; }
    case 1u: { result.at_e.y = sign; }
    case 2u: { result.at_f.x = sign; }
    case 3u: { result.at_f.y = sign; }
    default: {}
  }
  return result;
}

// A phase of `orientation_by_pairs` for an invocation.
struct Phase {
  // Phase 0: all pairs, and the rightmost corner that the invocation sees.
  is_pairs: bool,
  // Phase 7: whether all corners are left of the line to the rightmost corner of all.
  is_check: bool,
  // Phases 1 to 6: 64 invocations of a large boundary reduce to the rightmost corner of all. The first `half` of them take
  // that of the other half.
  half: u32,
  // The edges that the invocation goes over. While it reduces, it has one item or none.
  first: u32,
  end: u32,
}

fn phase_of(number: u32, edge_count: u32, work: Work, lane: u32) -> Phase {
  var phase = Phase(number == 0u, number == 7u, BOUNDARY_LANES >> number, select(0u, lane, work.is_large), edge_count);
  if (!phase.is_pairs && !phase.is_check) {
    phase.first = 0u;
    phase.end = select(0u, 1u, work.is_large && lane < phase.half);
  }
  phase.end = select(0u, phase.end, work.exists);
  return phase;
}

// An edge with which an invocation compares its edge.
struct OtherEdge {
  // If false, it does not count.
  is_corner: bool,
  // While invocations reduce: only the first corner, the rightmost one of another invocation.
  edge: Edge,
}

// Edge `index` of the boundary, or, while invocations reduce, the rightmost corner of the other half.
fn other_edge(boundary: PolygonBoundary, phase: Phase, work: Work, index: u32, lane: u32) -> OtherEdge {
  var other: OtherEdge;
  if (phase.is_pairs || phase.is_check) {
    other.edge = load_edge(boundary.first + index);
    other.is_corner = other.edge.has_length && index != work.edge_index;
  } else {
    let other_best = rightmost[lane + phase.half];
    other.edge.a = other_best.xyz;
    other.is_corner = other_best.w != 0u;
  }
  return other;
}

// Tests the pairs of the invocation's edge and every other; for a large boundary every 64th, so at most 16 of 1,024 edges,
// fewer than the SMALL_BOUNDARY that `Turns:` counts. All invocations must call it, for its barriers. One loop has eight
// phases, so that `turn` is compiled once.
fn orientation_by_pairs(boundary: PolygonBoundary, work: Work, lane: u32) {
  let slot = select(lane, 0u, work.is_large);
  let step = select(1u, BOUNDARY_LANES, work.is_large);
  var best = vec4<u32>(0u);
  for (var number = 0u; number < 8u; number++) {
    let phase = phase_of(number, boundary.count, work, lane);
    if (phase.is_check && work.is_large) {
      best = rightmost[0];
    }
    // Turns: 2 * SMALL_BOUNDARY + 6 in all.
    for (var index = phase.first; index < phase.end; index += step) {
      let other = other_edge(boundary, phase, work, index, lane);
      if (!other.is_corner) {
        continue;
      }
      var turns = PairTurns();
      // Turns: 6 * SMALL_BOUNDARY + 6 in all.
      for (var test = select(RIGHTMOST_TEST, 0u, phase.is_pairs); test <= RIGHTMOST_TEST; test++) {
        let points = points_of_pair_test(work.edge, other.edge, best, test);
        // A corner at the position of the edge's first corner does not count.
        let is_at_first = all(points[2] == points[0]);
        if (test == RIGHTMOST_TEST && (best.w == 0u || is_at_first)) {
          if (best.w == 0u && !is_at_first && !phase.is_check) {
            best = vec4<u32>(points[2], 1u);
          }
          continue;
        }
        let result = turn(points[0], points[1], points[2], work.light_index);
        turns = with_turn(turns, test, result.sign);
        if (test != RIGHTMOST_TEST && result.tie == 0u) {
          atomicOr(&results[slot], LEAVES_PLANE);
        }
        if (test == RIGHTMOST_TEST && phase.is_check) {
          atomicOr(&results[slot], select(0u, IS_ANY_LEFT, result.sign > 0) | select(0u, IS_ANY_RIGHT, result.sign < 0));
        } else if (test == RIGHTMOST_TEST && result.sign < 0) {
          best = vec4<u32>(points[2], 1u);
        }
      }
      if (phase.is_pairs) {
        add_pair(slot, work.edge, other.edge, turns);
      }
    }
    // The next phase reads it.
    if (phase.is_pairs || (!phase.is_check && lane < phase.half)) {
      rightmost[lane] = best;
    }
    workgroupBarrier();
  }
}

// Adds a pair of edges to the results of edge `e`.
fn add_pair(slot: u32, e: Edge, f: Edge, turns: PairTurns) {
  atomicAdd(&windings[slot], winding_change(turns.at_e, turns.at_f.y));
  if (has_contact(e, f, turns)) {
    atomicOr(&results[slot], HAS_CONTACT);
  }
}

// Adds the results for an edge to the record of its polygon.
fn add_to_record(record: u32, slot: u32, light_index: u32) {
  let bit = 1u << light_index;
  let winding = atomicLoad(&windings[slot]);
  let bits = atomicLoad(&results[slot]);
  if ((bits & IS_ANY_LEFT) != 0u && (bits & IS_ANY_RIGHT) == 0u) {
    atomicOr(&undecided[record + IN_HALF_SPACE], bit);
  }
  if ((bits & HAS_CONTACT) != 0u || (winding != 0 && winding != 1)) {
    atomicOr(&undecided[record + IS_NOT_SIMPLE], bit);
  }
  if (winding == 1) {
    atomicOr(&undecided[record + WINDS_ONCE], bit);
  }
  if (winding == 0) {
    atomicOr(&undecided[record + WINDS_NEVER], bit);
  }
  if ((bits & LEAVES_PLANE) != 0u) {
    atomicOr(&undecided[record + OFF_PLANE], bit);
  }
}

@compute @workgroup_size(64)
fn polygon_pairs(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let entry = group.y * ENTRY_ROW + group.x;
  // The last row is not full.
  let exists = entry < atomicLoad(&undecided[ENTRY_COUNT]);
  var record = UNDECIDED_HEAD;
  var work: Work;
  var boundary: PolygonBoundary;
  if (exists) {
    record = record_offset(atomicLoad(&undecided[entry_offset(entry)]));
    boundary = boundary_of(polygon_of(record));
    let part = atomicLoad(&undecided[entry_offset(entry) + 1u]);
    work = work_of(boundary, part, atomicLoad(&undecided[record + LIGHTS]), lane);
  }
  orientation_by_pairs(boundary, work, lane);
  if (work.exists && (!work.is_large || lane == 0u)) {
    add_to_record(record, select(lane, 0u, work.is_large), work.light_index);
  }
}
