// Facing of polygons, by the turns of their corners: a turn is 1 if the light sees three corners counter-clockwise, -1 if
// clockwise, 0 if they and the light are in one plane. Three stages, dispatched for each batch of up to 32 lights; they
// stand where `facing` does for triangles. `polygon_facing`, an invocation a polygon, decides convex triangles and
// quadrilaterals; `polygon_turns`, an invocation a record of `undecided`, decides other simple cases; `polygon_masks` runs
// after `outline`, which decided the rest exactly. Every triangle of a polygon has the same bits, and all bits are those of
// exact arithmetic, or silhouettes would not close: bounds must not shrink. Facing masks are complete after `polygon_masks`;
// `edges` and others read them then. A comment `Turns:` is about the loop below it, not about corners.
// docs/numerics/polygons.md, "Four turns".

#import common/determinant
#import common/extraction
#import common/positions
#import extract/one_caster
#import polygon/outlines

// The turns at the four corners of a quadrilateral or triangle as `f32` computes them, for four lights at once, and a bound
// on their errors. The turn at a corner is the sign of the determinant of the corner before, it and the one after. It counts
// only where its size is above `bound` and `is_certain` holds.

// Where edge `edge` of `outlines` begins.
fn vertex_of(edge: u32) -> vec3<u32> {
  return position_bits(outlines[edge].x, position_offset(), position_stride());
}

// A quadrilateral a, b, c, d: for each corner the normal of it and its neighbours, from which its turns follow.
struct Quad {
  a: vec3<f32>,
  c: vec3<f32>, // For a triangle a.
  normals: mat4x3<f32>,
  bound: f32, // On the errors of all turns for all lights.
  // Whether f32 may decide.
  is_certain: bool,
}

// The outline must be one loop of three or four edges. A triangle has the same turn at all corners.
fn quad_of(outline: OutlineRange) -> Quad {
  let is_triangle = outline.count == 3u;
  let a_bits = vertex_of(outline.first);
  let b_bits = vertex_of(outline.first + 1u);
  let c_bits = vertex_of(outline.first + 2u);
  let d_bits = vertex_of(outline.first + select(3u, 2u, is_triangle));
  let magnitude = max(largest_magnitude(a_bits, b_bits, c_bits), largest_magnitude(d_bits, d_bits, d_bits));
  let a = bitcast<vec3<f32>>(a_bits);
  let c = bitcast<vec3<f32>>(c_bits);
  let ab = bitcast<vec3<f32>>(b_bits) - a;
  let ac = c - a;
  let ad = bitcast<vec3<f32>>(d_bits) - a;
  let cd = bitcast<vec3<f32>>(d_bits) - c;
  let cb = bitcast<vec3<f32>>(b_bits) - c;
  // At corner 0 the turn of d, a, b; at 1 that of a, b, c; at 2 that of b, c, d; at 3 that of c, d, a.
  let n_1 = cross_product(ab, ac);
  let n_0 = cross_product(ab, ad);
  let n_2 = select(cross_product(cd, cb), n_1, is_triangle);
  let n_3 = select(cross_product(ac, ad), n_1, is_triangle);
  let sizes = vec4<f32>(sum_of_sizes(ab) * sum_of_sizes(ad), sum_of_sizes(ab) * sum_of_sizes(ac),
    sum_of_sizes(cd) * sum_of_sizes(cb), sum_of_sizes(ac) * sum_of_sizes(ad));
  let size = max(max(sizes.x, sizes.y), max(sizes.z, sizes.w));
  let bound = face_bound(size, bitcast<f32>(magnitude), light_magnitudes());
  return Quad(a, select(c, a, is_triangle), mat4x3<f32>(n_0, n_1, n_2, n_3), bound, magnitude < LARGE);
}

// The determinants at the four corners (columns) for the lights `place` to `place + 3` (rows).
fn turns_of(quad: Quad, place: u32) -> mat4x4<f32> {
  let lights = transpose(
    mat4x4<f32>(scaled_light(place), scaled_light(place + 1u), scaled_light(place + 2u), scaled_light(place + 3u)));
  let a = quad.a;
  let c = quad.c;
  let n = quad.normals;
  let from_a = mat3x4<f32>(lights[0] - lights[3] * a.x, lights[1] - lights[3] * a.y, lights[2] - lights[3] * a.z);
  let from_c = mat3x4<f32>(lights[0] - lights[3] * c.x, lights[1] - lights[3] * c.y, lights[2] - lights[3] * c.z);
  return mat4x4<f32>(
    n[0].x * from_a[0] + n[0].y * from_a[1] + n[0].z * from_a[2],
    n[1].x * from_a[0] + n[1].y * from_a[1] + n[1].z * from_a[2],
    n[2].x * from_c[0] + n[2].y * from_c[1] + n[2].z * from_c[2],
    n[3].x * from_a[0] + n[3].y * from_a[1] + n[3].z * from_a[2],
  );
}

// One bit for each of four lights.
const FOUR_BITS: vec4<u32> = vec4<u32>(1u, 2u, 4u, 8u);

fn bits_of(lights: vec4<bool>) -> vec4<u32> {
  return select(vec4<u32>(0u), FOUR_BITS, lights);
}

// The four bits as one number.
fn together(bits: vec4<u32>) -> u32 {
  return bits.x | bits.y | bits.z | bits.w;
}

// Stage `polygon_facing`: dispatched after the head of `undecided` is reset. A triangle or quadrilateral whose turns at all
// corners are certain and 1 faces the light, one whose turns are certain and -1 is averted. It writes a bit for each light,
// 0 where it is undecided, to the masks of all triangles of a polygon. A polygon with an undecided light gets a record in
// `undecided`, in any order, for `polygon_turns`, which computes all its bits anew.

// Facing masks of all triangles, and after them as many words in which `polygon_masks` writes for which lights they are
// twisted.
@group(0) @binding(8) var<storage, read_write> facing_masks: array<u32>;

// The lights for which all turns are certain and 1, and those for which they are certain and -1.
struct Convex {
  facing: u32,
  averted: u32,
}

// The outline must be a triangle or quadrilateral; a triangle has four equal turns. None if f32 is not
// certain of the positions, which is tested last: the loop is the same for all invocations.
fn convex_quad(outline: OutlineRange) -> Convex {
  var convex = Convex(0u, 0u);
  let quad = quad_of(outline);
  let bound = vec4<f32>(quad.bound);
  // Turns: 8.
  for (var place = 0u; place < light_count(); place += 4u) {
    let turns = turns_of(quad, place);
    let low = min(min(turns[0], turns[1]), min(turns[2], turns[3]));
    let high = max(max(turns[0], turns[1]), max(turns[2], turns[3]));
    convex.facing |= together(bits_of(low > bound)) << place;
    convex.averted |= together(bits_of(high < -bound)) << place;
  }
  if (!quad.is_certain) {
    return Convex(0u, 0u);
  }
  return convex;
}

// `chunk.count` is the number of polygons.
@compute @workgroup_size(256)
fn polygon_facing(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x >= chunk.count) {
    return;
  }
  let outline = outline_of(id.x);
  // The polygon walks each edge both ways, so none is left in its outline, and no edge record names it. No stage writes its
  // masks: they keep the zeros of a new buffer.
  if (outline.count == 0u) {
    return;
  }
  var convex = Convex(0u, 0u);
  if (outline.is_loop && (outline.count == 3u || outline.count == 4u)) {
    convex = convex_quad(outline);
  }
  // Turns: POLYGON_TRIANGLES.
  for (var triangle = outline.first_triangle; triangle < outline.end_triangle; triangle++) {
    facing_masks[triangle] = convex.facing & active_lights();
  }
  if ((active_lights() & ~(convex.facing | convex.averted)) != 0u) {
    // There is room for a record of every polygon. `polygon_turns` writes its other words.
    let number = atomicAdd(&undecided[RECORD_COUNT], 1u);
    atomicStore(&undecided[record_at(number) + POLYGON], id.x);
    // `polygon_turns` has an invocation a record. Its workgroups lie in rows (x) of at most ENTRY_ROW; y counts rows, and z
    // is 1 from the reset.
    let workgroup = number / OUTLINE_LANES;
    atomicMax(&undecided[RECORD_WORKGROUPS], min(workgroup + 1u, ENTRY_ROW));
    atomicMax(&undecided[RECORD_WORKGROUPS + 1u], workgroup / ENTRY_ROW + 1u);
  }
}

// Stage `polygon_turns`: dispatched indirectly, by the words that `polygon_facing` wrote to the head of `undecided`. A
// quadrilateral of two triangles is decided where `f32` is certain of all four turns and these do not alternate: it faces
// the light, is averted, or is L-twisted (its outline crosses itself as seen from light L). Another loop, of at most 256
// edges, is decided where it is strictly convex. It overwrites the polygon's words of `facing_masks`, and writes to the
// record the lights that are left (LIGHTS), and of a twisted quadrilateral TWISTED_QUAD, TURN_0 and TURN_1. For LIGHTS it
// lists entries, parts of the work, for `outline`, the next stage. `polygon_masks` reads records, and `cut_quads` those of
// twisted quadrilaterals.

// Outlines of more edges are not tried here, so that an invocation ends soon.
const MOST_CONVEX: u32 = 256u;

// The lights for which the turns at some corners are certainly all 1, and those for which they are certainly all -1.
struct Turns {
  positive: u32,
  negative: u32,
}

// `turns`, as far as the turn of three points agrees with them. `largest` bounds the coordinates. Takes four lights at a
// time.
fn with_turns(turns: Turns, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, largest: f32) -> Turns {
  let u = b - a;
  let v = c - a;
  let n = cross_product(u, v);
  let size = (abs(u.x) + abs(u.y) + abs(u.z)) * (abs(v.x) + abs(v.y) + abs(v.z));
  let bound = vec4<f32>(face_bound(size, largest, light_magnitudes()));
  var positive = 0u;
  var negative = 0u;
  // Turns: 8.
  for (var place = 0u; place < light_count(); place += 4u) {
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
// corner i + 1 (`turns_of` instead counts a turn by its corner); then (0, 1, i) and (0, i - 1, i) for each i from 3 to count
// - 2. If all are equal, corner 0 sees the others one after the other within a half-turn, so the loop goes around once; the
// first alone may be equal although it goes around twice.
fn turn_corners(number: u32, count: u32) -> vec3<u32> {
  if (number < count) {
    let next = select(number + 1u, 0u, number + 1u == count);
    return vec3<u32>(number, next, select(next + 1u, 0u, next + 1u == count));
  }
  let corner = 3u + (number - count) / 2u;
  return select(vec3<u32>(0u, corner - 1u, corner), vec3<u32>(0u, 1u, corner), (number - count) % 2u == 0u);
}

// The lights that see a loop of at most MOST_CONVEX corners as strictly convex, by its sense. Bits past the last light may
// be set.
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

// The findings of this stage about an outline, a bit for each light. A light is decided if its bit is in `facing`, `averted`
// or `twisted`. Bits past the last light may be set, except in `twisted`.
struct Decided {
  facing: u32,
  averted: u32,
  // The lights for which two neighbouring turns of a quadrilateral are certainly 1 and the others certainly -1.
  twisted: u32,
  // The lights for which its turns at corner 0 and at corner 1 are certainly 1. Only lights of `twisted` count.
  turn_0: u32,
  turn_1: u32,
}

// Decides a quadrilateral by the turns at its corners, four lights at a time, where all four are certain. If three are
// equal, the outline is simple and has their sense. If two neighbours differ from the other two, two edges cross: it is
// L-twisted. If turns alternate, it goes around the light; nothing is decided.
fn decided_quad(outline: OutlineRange) -> Decided {
  var decided = Decided(0u, 0u, 0u, 0u, 0u);
  let quad = quad_of(outline);
  if (!quad.is_certain) {
    return decided;
  }
  let bound = vec4<f32>(quad.bound);
  // Turns: 8.
  for (var place = 0u; place < light_count(); place += 4u) {
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
  decided.twisted &= active_lights();
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

// 64 is OUTLINE_LANES, by which `polygon_facing` counts workgroups. So there is an invocation for each record, and it takes
// one.
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
      facing_masks[triangle] = decided.facing & active_lights();
    }
    let left = active_lights() & ~(decided.facing | decided.averted | decided.twisted);
    // If f32 decides all lights, all corners are finite. If a corner is not finite, f32 decides no light: LIGHTS are then
    // all lights, for `polygon_masks`.
    let is_left = (left | decided.twisted) != 0u;
    let has_finite_corners = !is_left || is_outline_finite(outline);
    atomicStore(&undecided[at + POLYGON], polygon | select(NOT_FINITE, 0u, has_finite_corners));
    atomicStore(&undecided[at + LIGHTS], select(active_lights(), left, has_finite_corners));
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

// Stage `polygon_masks`: decides from the records whether a polygon faces each light that `polygon_turns` left, is in a
// plane with it, or is L-twisted. Dispatched after `outline`, one invocation a record. It adds to statistics, and for the
// polygon's triangles to the facing masks, the first half of `facing_masks`; it writes their twisted masks, the second half,
// and their excluded masks. Twisted masks are cleared before, and excluded masks but for what a scene excludes. A polygon
// that is twisted or in a plane counts nowhere as a face; what a twisted one darkens is cut into pieces. `edges` reads
// facing and twisted masks next; stages of shadow volumes read facing and excluded ones. Outlines that are twisted are
// listed as entries for `cut_edges`, except the quadrilaterals that `cut_quads` takes.

@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;
// The statistics, not a record of `undecided`.
@group(0) @binding(2) var<storage, read_write> record: FacingRecord;

// Bits of lights. Lights that were decided before are in none of them, except those for which `polygon_turns` found a
// quadrilateral twisted: these are in `twisted` and `excluded`.
struct PolygonMasks {
  facing: u32,
  twisted: u32,
  excluded: u32, // Twisted or in a plane, so without a cap or side of its own.
}

// The bits of the record at word `at` of `undecided`. A polygon with a corner that is not finite (its word POLYGON has bit
// 31, NOT_FINITE) faces no light and is excluded for all: LIGHTS has them. `outline` found, over all edges of the outline:
// FITS, all corners are in one half-space; IS_NOT_SIMPLE, some edges meet, or the winding number beside one is neither 0 nor
// 1; WINDS_ONCE, beside one it is 1; WINDS_NEVER, beside one it is 0; OFF_PLANE, something is off the plane. If 1 and 0 both
// occur, the outline is not simple.
fn masks_of_record(at: u32) -> PolygonMasks {
  let lights = atomicLoad(&undecided[at + LIGHTS]);
  if (atomicLoad(&undecided[at + POLYGON]) >= NOT_FINITE) {
    return PolygonMasks(0u, 0u, lights);
  }
  let once = atomicLoad(&undecided[at + WINDS_ONCE]);
  let never = atomicLoad(&undecided[at + WINDS_NEVER]);
  let in_plane = lights & ~atomicLoad(&undecided[at + OFF_PLANE]);
  let simple = atomicLoad(&undecided[at + FITS]) & ~atomicLoad(&undecided[at + IS_NOT_SIMPLE]) & ~(once & never);
  let twisted = (lights & ~in_plane & ~simple) | atomicLoad(&undecided[at + TWISTED_QUAD]);
  return PolygonMasks(lights & ~in_plane & simple & once, twisted, twisted | in_plane);
}

// 64 is OUTLINE_LANES, by which `polygon_facing` counts workgroups. So there is an invocation for each record, and it takes
// one.
@compute @workgroup_size(64)
fn polygon_masks(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let records = atomicLoad(&undecided[RECORD_COUNT]);
  let row = OUTLINE_LANES * groups.x;
  // Turns: 1.
  for (var number = id.y * row + id.x; number < records; number += groups.y * row) {
    let at = record_at(number);
    let own = masks_of_record(at);
    let outline = outline_of(polygon_of(at));
    let triangles = arrayLength(&facing_masks) / 2u;
    // Turns: POLYGON_TRIANGLES.
    for (var triangle = outline.first_triangle; triangle < outline.end_triangle; triangle++) {
      facing_masks[triangle] |= own.facing;
      facing_masks[triangles + triangle] = own.twisted;
      // Without lists there is no buffer of excluded masks. A short buffer is bound, and what is written to it is not read.
      if (triangle < arrayLength(&excluded_masks)) {
        excluded_masks[triangle] |= own.excluded;
      }
    }
    // `undecided_pairs` lacks the pairs that `polygon_turns` found twisted: LIGHTS has none of them. `non_finite_faces`
    // counts polygons here, in the first batch only, since every batch finds the same.
    if (atomicLoad(&undecided[at + POLYGON]) < NOT_FINITE) {
      let lights = atomicLoad(&undecided[at + LIGHTS]);
      atomicAdd(&record.statistics.undecided_pairs, countOneBits(lights));
      atomicAdd(&record.statistics.exact_zeros, countOneBits(own.excluded & ~own.twisted));
      atomicOr(&record.statistics.twisted_lights, own.twisted);
    } else if (chunk.first_light == 0u) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
    // `cut_quads` cuts for the lights of `quad`, and `cut_edges` for the other twisted ones. Up to here LIGHTS were the
    // undecided lights; from here on they are those of `cut_edges`.
    let quad = atomicLoad(&undecided[at + TWISTED_QUAD]);
    let cut = own.twisted & ~quad;
    atomicStore(&undecided[at + LIGHTS], cut);
    if (cut != 0u) {
      list_work(number, outline, cut, CUT_COUNT, CUT_WORKGROUPS);
    }
  }
}
