// Polygon turns: decides polygons that `polygon_facing` left, by turns of three corners: 1 if the light sees them
// counter-clockwise, -1 if clockwise, 0 if they and the light are in one plane. `Turns:` is the most turns of the loop below it;
// a loop between constants needs none. Dispatched indirectly, by the words that `polygon_facing` wrote to the head of
// `undecided`, one invocation a record. A quadrilateral of two triangles is decided where `f32` is certain of all four turns and
// these do not alternate: it faces the light, is averted, or is L-twisted (its outline crosses itself as seen from light L).
// Another loop, of at most 256 edges, is decided where it is strictly convex. It overwrites the polygon's words of
// `facing_masks`, and writes to the record the lights that are left (LIGHTS), and of a twisted quadrilateral TWISTED_QUAD, TURN_0
// and TURN_1. For LIGHTS it lists entries, parts of the work, for `outline`, the next stage. `polygon_masks` reads records, and
// `cut_quads` those of twisted quadrilaterals. What it decides equals exact arithmetic: bounds must not shrink.
// docs/numerics/polygons.md, "Four turns".

#import common/determinant
#import common/positions
#import extract/one_caster
#import polygon/outlines
#import polygon/quads

@group(0) @binding(8) var<storage, read_write> facing_masks: array<u32>;

// Outlines of more edges are not tried here, so that an invocation ends soon.
const MOST_CONVEX: u32 = 256u;

// The lights for which the turns at some corners are certainly all 1, and those for which they are certainly all -1.
struct Turns {
  positive: u32,
  negative: u32,
}

// `turns`, as far as the turn of three points agrees with them. `largest` bounds the coordinates. Takes four lights at a time.
fn with_turns(turns: Turns, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, largest: f32) -> Turns {
  let u = b - a;
  let v = c - a;
  let n = cross_product(u, v);
  let size = (abs(u.x) + abs(u.y) + abs(u.z)) * (abs(v.x) + abs(v.y) + abs(v.z));
  let bound = vec4<f32>(face_bound(size, largest, lights_reach()));
  var positive = 0u;
  var negative = 0u;
  // Turns: 8.
  for (var place = 0u; place < light_places(); place += 4u) {
    let d = vec4<f32>(
      local_form(n, a, scaled_light(place)),
      local_form(n, a, scaled_light(place + 1u)),
      local_form(n, a, scaled_light(place + 2u)),
      local_form(n, a, scaled_light(place + 3u)),
    );
    let above = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), d > bound);
    let below = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), d < -bound);
    positive |= (above.x | above.y | above.z | above.w) << place;
    negative |= (below.x | below.y | below.z | below.w) << place;
  }
  return Turns(turns.positive & positive, turns.negative & negative);
}

// The three corners of turn `number` of a loop of `count` corners: first (i, i + 1, i + 2) for each i, which is the turn at
// corner i + 1 (`turns_of` instead counts a turn by its corner); then (0, 1, i) and (0, i - 1, i) for each i from 3 to count - 2.
// If all are equal, corner 0 sees the others one after the other within a half-turn, so the loop goes around once; the first
// alone may be equal although it goes around twice.
fn turn_corners(number: u32, count: u32) -> vec3<u32> {
  if (number < count) {
    let next = select(number + 1u, 0u, number + 1u == count);
    return vec3<u32>(number, next, select(next + 1u, 0u, next + 1u == count));
  }
  let corner = 3u + (number - count) / 2u;
  return select(vec3<u32>(0u, corner - 1u, corner), vec3<u32>(0u, 1u, corner), (number - count) % 2u == 0u);
}

// The lights that see a loop of at most MOST_CONVEX corners as strictly convex, by its sense. Bits past the last light may be
// set.
fn convex_turns(outline: OutlineRange) -> Turns {
  var turns = Turns(0xffffffffu, 0xffffffffu);
  var turn_count = outline.count;
  if (outline.count == 3u) {
    turn_count = 1u;
  } else if (outline.count > 4u) {
    turn_count = outline.count + 2u * (outline.count - 4u);
  }
  // Turns: 3 * MOST_CONVEX.
  for (var number = 0u; number < turn_count && (turns.positive | turns.negative) != 0u; number++) {
    let corners = turn_corners(number, outline.count);
    let a = vertex_of(outline.first + corners.x);
    let b = vertex_of(outline.first + corners.y);
    let c = vertex_of(outline.first + corners.z);
    let magnitude = largest_magnitude(a, b, c);
    if (magnitude >= LARGE) {
      return Turns(0u, 0u);
    }
    turns = with_turns(turns, bitcast<vec3<f32>>(a), bitcast<vec3<f32>>(b), bitcast<vec3<f32>>(c), bitcast<f32>(magnitude));
  }
  return turns;
}

// The findings of this stage about an outline, a bit for each light. A light is decided if its bit is in `facing`, `averted` or
// `twisted`. Bits past the last light may be set, except in `twisted`.
struct Decided {
  facing: u32,
  averted: u32,
  // The lights for which two neighbouring turns of a quadrilateral are certainly 1 and the others certainly -1.
  twisted: u32,
  // The lights for which its turns at corner 0 and at corner 1 are certainly 1. Only lights of `twisted` count.
  turn_0: u32,
  turn_1: u32,
}

// Decides a quadrilateral by the turns at its corners, four lights at a time, where all four are certain. If three are equal, the
// outline is simple and has their sense. If two neighbours differ from the other two, two edges cross: it is L-twisted. If turns
// alternate, it goes around the light; nothing is decided.
fn decided_quad(outline: OutlineRange) -> Decided {
  var decided = Decided(0u, 0u, 0u, 0u, 0u);
  let quad = quad_of(outline);
  if (!quad.is_certain) {
    return decided;
  }
  let bound = vec4<f32>(quad.bound);
  // Turns: 8.
  for (var place = 0u; place < light_places(); place += 4u) {
    let turns = turns_of(quad, place);
    let up_0 = bits_of(turns[0] > bound);
    let up_1 = bits_of(turns[1] > bound);
    let up_2 = bits_of(turns[2] > bound);
    let up_3 = bits_of(turns[3] > bound);
    let down_0 = bits_of(turns[0] < -bound);
    let down_1 = bits_of(turns[1] < -bound);
    let down_2 = bits_of(turns[2] < -bound);
    let down_3 = bits_of(turns[3] < -bound);
    let certain = (up_0 | down_0) & (up_1 | down_1) & (up_2 | down_2) & (up_3 | down_3);
    let facing = certain & ((up_0 & up_1 & (up_2 | up_3)) | (up_2 & up_3 & (up_0 | up_1)));
    let averted = certain & ((down_0 & down_1 & (down_2 | down_3)) | (down_2 & down_3 & (down_0 | down_1)));
    decided.facing |= together(facing) << place;
    decided.averted |= together(averted) << place;
    // Turns alternate. Such an outline is left to `outline`, and what it darkens to `cut_edges`, not to `cut_quads`.
    let around = (up_0 & up_2) | (down_0 & down_2);
    decided.twisted |= together(certain & ~facing & ~averted & ~around) << place;
    decided.turn_0 |= together(up_0) << place;
    decided.turn_1 |= together(up_1) << place;
  }
  decided.twisted &= live_lights();
  return decided;
}

// Decides what can be decided here. Nothing is twisted but quadrilaterals of two triangles.
fn decided_outline(outline: OutlineRange) -> Decided {
  // With more triangles than two it has edges that it walks both ways, and four turns do not tell where its surface is dark.
  if (outline.is_loop && outline.count == 4u && outline.end_triangle - outline.first_triangle == 2u) {
    return decided_quad(outline);
  }
  if (outline.is_loop && outline.count <= MOST_CONVEX) {
    let turns = convex_turns(outline);
    return Decided(turns.positive, turns.negative, 0u, 0u, 0u);
  }
  return Decided(0u, 0u, 0u, 0u, 0u);
}

fn is_outline_finite(outline: OutlineRange) -> bool {
  // Turns: OUTLINE_EDGES.
  for (var edge = 0u; edge < outline.count; edge++) {
    if (!is_finite(vertex_of(outline.first + edge))) {
      return false;
    }
  }
  return true;
}

// 64 is OUTLINE_LANES, by which `polygon_facing` counts workgroups. So there is an invocation for each record, and it takes one.
@compute @workgroup_size(64)
fn polygon_turns(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let records = atomicLoad(&undecided[RECORD_COUNT]);
  let row = OUTLINE_LANES * groups.x;
  // Turns: 1.
  for (var number = id.y * row + id.x; number < records; number += groups.y * row) {
    let at = record_at(number);
    let polygon = atomicLoad(&undecided[at + POLYGON]);
    let outline = outline_of(polygon);
    let decided = decided_outline(outline);
    // Turns: POLYGON_TRIANGLES.
    for (var triangle = outline.first_triangle; triangle < outline.end_triangle; triangle++) {
      facing_masks[triangle] = decided.facing & live_lights();
    }
    let left = live_lights() & ~(decided.facing | decided.averted | decided.twisted);
    // If f32 decides all lights, all corners are finite. If a corner is not finite, f32 decides no light: LIGHTS are then all
    // lights, for `polygon_masks`.
    let is_left = (left | decided.twisted) != 0u;
    let has_finite_corners = !is_left || is_outline_finite(outline);
    atomicStore(&undecided[at + POLYGON], polygon | select(NOT_FINITE, 0u, has_finite_corners));
    atomicStore(&undecided[at + LIGHTS], select(live_lights(), left, has_finite_corners));
    // The words that `outline` sets bits in, from FITS to OFF_PLANE, which TWISTED_QUAD follows.
    for (var word = FITS; word < TWISTED_QUAD; word++) {
      atomicStore(&undecided[at + word], 0u);
    }
    atomicStore(&undecided[at + TWISTED_QUAD], decided.twisted);
    atomicStore(&undecided[at + TURN_0], decided.turn_0);
    atomicStore(&undecided[at + TURN_1], decided.turn_1);
    if (has_finite_corners && left != 0u) {
      list_work(number, outline, left, ENTRY_COUNT, WORKGROUPS);
    }
  }
}
