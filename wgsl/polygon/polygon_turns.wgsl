// Polygon turns: decides what polygon_facing.wgsl left. Quadrilaterals are decided by the turns at their corners wherever `f32` is
// certain of all four, twisted ones, too. Outlines that are strictly convex as seen from a light need the turns at their corners
// only. The others are listed for outline.wgsl. polygon_masks.wgsl makes masks of what both find, and cut_quads.wgsl reads the turns
// of twisted quadrilaterals, whose outlines cross themselves as seen from a light. docs/numerics/polygons.md, "Four turns".

#import common/determinant
#import common/positions
#import extract/one_caster
#import polygon/outlines
#import polygon/quads

@group(0) @binding(8) var<storage, read_write> facing_masks: array<u32>;

// Larger outlines are not tried.
const MOST_CONVEX: u32 = 256u;

// What is certain of the turns at some corners: the lights for which all are positive, and those for which all are negative.
struct Turns {
  positive: u32,
  negative: u32,
}

// The turns of three points for all lights, added to those of before. As in facing.wgsl, four lights at a time.
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

// The corners of the turn of a number, by their places: those of `convex_turns` in src/cpu/polygon/convex.rs.
fn turn_corners(number: u32, count: u32) -> vec3<u32> {
  if (number < count) {
    let next = select(number + 1u, 0u, number + 1u == count);
    return vec3<u32>(number, next, select(next + 1u, 0u, next + 1u == count));
  }
  let corner = 3u + (number - count) / 2u;
  return select(vec3<u32>(0u, corner - 1u, corner), vec3<u32>(0u, 1u, corner), (number - count) % 2u == 0u);
}

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

// What is certain of an outline.
struct Decided {
  facing: u32,
  averted: u32,
  // The lights for which two neighbouring turns of a quadrilateral are positive and the others are negative.
  twisted: u32,
  // The lights for which its turns at corners 0 and 1 are positive.
  turn_0: u32,
  turn_1: u32,
}

// The turns at the corners of a quadrilateral, four lights at a time. If three are alike, the fourth corner is in their triangle or
// beyond one of its sides, and the outline is simple. If not, it is L-twisted.
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
    // Where turns alternate, the outline goes around the light. Its pairs of edges are left to tell what it darkens.
    let around = (up_0 & up_2) | (down_0 & down_2);
    decided.twisted |= together(certain & ~facing & ~averted & ~around) << place;
    decided.turn_0 |= together(up_0) << place;
    decided.turn_1 |= together(up_1) << place;
  }
  decided.twisted &= live_lights();
  return decided;
}

fn decided_outline(outline: OutlineRange) -> Decided {
  // With more triangles it has edges that it walks both ways, and where its surface is between light and shadow is another matter.
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
    let is_left = (left | decided.twisted) != 0u;
    let is_finite = !is_left || is_outline_finite(outline);
    atomicStore(&undecided[at + POLYGON], polygon | select(NOT_FINITE, 0u, is_finite));
    atomicStore(&undecided[at + LIGHTS], select(live_lights(), left, is_finite));
    for (var word = FITS; word < TWISTED_QUAD; word++) {
      atomicStore(&undecided[at + word], 0u);
    }
    atomicStore(&undecided[at + TWISTED_QUAD], decided.twisted);
    atomicStore(&undecided[at + TURN_0], decided.turn_0);
    atomicStore(&undecided[at + TURN_1], decided.turn_1);
    if (is_finite && left != 0u) {
      list_work(number, outline, left, ENTRY_COUNT, WORKGROUPS);
    }
  }
}
