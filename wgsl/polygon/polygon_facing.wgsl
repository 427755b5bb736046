// Facing of polygons, from the turns of their corners. A turn is 1 if the light sees three corners counter-clockwise, -1
// if clockwise, 0 if they and the light are in one plane. Here are three of the four stages that replace `facing`, for
// each batch of up to 32 lights. `polygon_facing`, an invocation a polygon, decides convex triangles and quadrilaterals.
// `polygon_turns`, an invocation a record of `undecided`, decides other simple cases. `polygon_masks` runs after
// `polygon_pairs`, which decides the others exactly. All triangles of a polygon have the same bits. All bits are those of
// exact arithmetic, or silhouettes would not close: bounds must not shrink. The facing masks are complete after
// `polygon_masks`; then `edges` and others read them. `Turns:` above a loop is its most iterations. Claim:
// docs/numerics/polygons.md, "Four turns".

#import common/determinant
#import common/extraction
#import common/positions
#import extract/one_caster
#import polygon/boundaries

// f32 determinants at the four corners of a quadrilateral or triangle, for four lights at once, with a bound on their
// errors. The turn at a corner is the sign of the determinant of the previous corner, it and the next. It is certain only if
// |determinant| exceeds `bound` and `is_certain` holds.

// The position bits of the first vertex of an edge of `boundaries`.
fn vertex_of(edge: u32) -> vec3<u32> {
  return position_bits(boundaries[edge].x, position_offset(), position_stride());
}

// A quadrilateral a, b, c, d: for each corner the normal of it and its neighbours.
struct Quad {
  a: vec3<f32>,
  c: vec3<f32>, // Equal to a for a triangle.
  normals: mat4x3<f32>,
  bound: f32, // Bounds the errors of all determinants for all lights.
  // Whether the coordinates are small enough for f32 to decide.
  is_certain: bool,
}

// The boundary must be one loop of three or four edges. A triangle has the same turn at all corners.
fn quad_of(boundary: PolygonBoundary) -> Quad {
  let is_triangle = boundary.count == 3u;
  let a_bits = vertex_of(boundary.first);
  let b_bits = vertex_of(boundary.first + 1u);
  let c_bits = vertex_of(boundary.first + 2u);
  let d_bits = vertex_of(boundary.first + select(3u, 2u, is_triangle));
  let magnitude = max(largest_magnitude(a_bits, b_bits, c_bits), largest_magnitude(d_bits, d_bits, d_bits));
  let a = bitcast<vec3<f32>>(a_bits);
  let c = bitcast<vec3<f32>>(c_bits);
  let ab = bitcast<vec3<f32>>(b_bits) - a;
  let ac = c - a;
  let ad = bitcast<vec3<f32>>(d_bits) - a;
  let cd = bitcast<vec3<f32>>(d_bits) - c;
  let cb = bitcast<vec3<f32>>(b_bits) - c;
  // Corner 0 has the turn of d, a, b; corner 1 of a, b, c; corner 2 of b, c, d; corner 3 of c, d, a.
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

// The determinants at the four corners (columns) for four lights (rows), from `light_index` on.
fn corner_determinants(quad: Quad, light_index: u32) -> mat4x4<f32> {
  let lights = transpose(
    mat4x4<f32>(
      scaled_light(light_index),
      scaled_light(light_index + 1u),
      scaled_light(light_index + 2u),
      scaled_light(light_index + 3u),
    ));
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

// A bit for each of four lights.
const FOUR_BITS: vec4<u32> = vec4<u32>(1u, 2u, 4u, 8u);

fn light_bits(lights: vec4<bool>) -> vec4<u32> {
  return select(vec4<u32>(0u), FOUR_BITS, lights);
}

// Four bits in one word.
fn combined_bits(bits: vec4<u32>) -> u32 {
  return bits.x | bits.y | bits.z | bits.w;
}

// Stage `polygon_facing`: dispatched after the head of `undecided` is reset. A triangle or quadrilateral faces the light if
// all turns are certain and 1, and is back-facing if all are certain and -1. It writes these bits, 0 for undecided lights,
// to the masks of all triangles of the polygon. A polygon with an undecided light gets a record in `undecided`, in any
// order, for `polygon_turns`, which computes all its bits again.

// The facing masks of all triangles (in a scene, of all face slots), then as many twisted masks, which `polygon_masks`
// writes.
@group(0) @binding(8) var<storage, read_write> facing_masks: array<u32>;

// Lights for which all turns are certain and 1, and lights for which all are certain and -1. Bits past the last light may
// be set.
struct Convex {
  facing: u32,
  back_facing: u32,
}

// Decides a triangle or quadrilateral. Decides nothing if the coordinates are too large for f32; this is tested last, so
// that the loop is the same for all invocations.
fn convex_quad(boundary: PolygonBoundary) -> Convex {
  var convex = Convex(0u, 0u);
  let quad = quad_of(boundary);
  let bound = vec4<f32>(quad.bound);
  // Turns: 8.
  for (var light_index = 0u; light_index < light_count(); light_index += 4u) {
    let turns = corner_determinants(quad, light_index);
    let low = min(min(turns[0], turns[1]), min(turns[2], turns[3]));
    let high = max(max(turns[0], turns[1]), max(turns[2], turns[3]));
    convex.facing |= combined_bits(light_bits(low > bound)) << light_index;
    convex.back_facing |= combined_bits(light_bits(high < -bound)) << light_index;
  }
  if (!quad.is_certain) {
    return Convex(0u, 0u);
  }
  return convex;
}

// Decides polygon `polygon`, or makes a record of it.
fn decide_polygon(polygon: u32) {
  let boundary = boundary_of(polygon);
  // The polygon walks each edge both ways. It has no triangles, so no masks, and no edge record names it.
  if (boundary.count == 0u) {
    return;
  }
  var convex = Convex(0u, 0u);
  if (boundary.is_loop && (boundary.count == 3u || boundary.count == 4u)) {
    convex = convex_quad(boundary);
  }
  // Turns: POLYGON_TRIANGLES.
  for (var triangle = boundary.first_triangle; triangle < boundary.end_triangle; triangle++) {
    facing_masks[triangle] = convex.facing & active_bits();
  }
  if ((active_bits() & ~(convex.facing | convex.back_facing)) != 0u) {
    // There is room for a record of every polygon. `polygon_turns` writes the other words.
    let record_index = atomicAdd(&undecided[RECORD_COUNT], 1u);
    atomicStore(&undecided[record_offset(record_index) + POLYGON], polygon);
    // `polygon_turns` has an invocation a record. Its workgroups lie in rows (x) of at most ENTRY_ROW; y is the number of
    // rows. The reset wrote 1 to z.
    let workgroup = record_index / BOUNDARY_LANES;
    atomicMax(&undecided[RECORD_WORKGROUPS], min(workgroup + 1u, ENTRY_ROW));
    atomicMax(&undecided[RECORD_WORKGROUPS + 1u], workgroup / ENTRY_ROW + 1u);
  }
}

// `chunk.count` is the number of polygons. An invocation takes several only where the device does not allow one for each.
@compute @workgroup_size(256)
fn polygon_facing(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let row = 256u * groups.x;
  // Turns: 1.
  for (var polygon = row * id.y + id.x; polygon < chunk.count; polygon += row * groups.y) {
    decide_polygon(polygon);
  }
}

// Stage `polygon_turns`: dispatched indirectly, by the words that `polygon_facing` wrote to the head of `undecided`. It
// decides a quadrilateral of two triangles if f32 is certain of all four turns and these do not alternate. It is
// front-facing, back-facing, or twisted: its boundary crosses itself as seen from light L. It decides another loop, of at
// most 256 edges, if it is strictly convex. It overwrites the polygon's facing masks, and all words of the record: the
// undecided lights (LIGHTS), and TWISTED_QUAD, TURN_0 and TURN_1 of a twisted quadrilateral. For LIGHTS it lists entries,
// parts of the work, for `polygon_pairs`, the next stage, but not if a corner is not finite. `polygon_masks` reads records,
// and `cut_quads` those of twisted quadrilaterals.

// Loops of more edges are not tried here, so that an invocation ends soon.
const MOST_CONVEX: u32 = 256u;

// Lights for which the turns at some corners are certainly all 1, and lights for which they are certainly all -1.
struct Turns {
  positive: u32,
  negative: u32,
}

// Removes the lights from `turns` for which the turn of three points is not certainly the same. `largest` bounds the
// coordinates. Tests four lights at a time.
fn narrowed_turns(turns: Turns, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, largest: f32) -> Turns {
  let u = b - a;
  let v = c - a;
  let n = cross_product(u, v);
  let size = (abs(u.x) + abs(u.y) + abs(u.z)) * (abs(v.x) + abs(v.y) + abs(v.z));
  let bound = vec4<f32>(face_bound(size, largest, light_magnitudes()));
  var positive = 0u;
  var negative = 0u;
  // Turns: 8.
  for (var light_index = 0u; light_index < light_count(); light_index += 4u) {
    let d = vec4<f32>(
      local_form(n, a, scaled_light(light_index)),
      local_form(n, a, scaled_light(light_index + 1u)),
      local_form(n, a, scaled_light(light_index + 2u)),
      local_form(n, a, scaled_light(light_index + 3u)),
    );
    let above = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), d > bound);
    let below = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), d < -bound);
    positive |= (above.x | above.y | above.z | above.w) << light_index;
    negative |= (below.x | below.y | below.z | below.w) << light_index;
  }
  return Turns(turns.positive & positive, turns.negative & negative);
}

// The three corners of test `index` of a loop of `count` corners. First (i, i + 1, i + 2) for each i, the turn at corner i +
// 1. Then (0, 1, i) and (0, i - 1, i) for each i from 3 to count - 2. If all turns are equal, corner 0 sees the others in
// order within a half-turn, so the loop goes around once. The first tests alone may agree although it goes around twice.
fn turn_corners(index: u32, count: u32) -> vec3<u32> {
  if (index < count) {
    let next = select(index + 1u, 0u, index + 1u == count);
    return vec3<u32>(index, next, select(next + 1u, 0u, next + 1u == count));
  }
  let corner = 3u + (index - count) / 2u;
  return select(vec3<u32>(0u, corner - 1u, corner), vec3<u32>(0u, 1u, corner), (index - count) % 2u == 0u);
}

// The lights that see a loop of at most MOST_CONVEX corners as strictly convex, by its sense. Bits past the last light may
// be set.
fn convex_turns(boundary: PolygonBoundary) -> Turns {
  var turns = Turns(0xffffffffu, 0xffffffffu);
  var turn_count = boundary.count;
  if (boundary.count == 3u) {
    turn_count = 1u;
  } else if (boundary.count > 4u) {
    turn_count = boundary.count + 2u * (boundary.count - 4u);
  }
  // Turns: 3 * MOST_CONVEX.
  for (var index = 0u; index < turn_count && (turns.positive | turns.negative) != 0u; index++) {
    let corners = turn_corners(index, boundary.count);
    let a = vertex_of(boundary.first + corners.x);
    let b = vertex_of(boundary.first + corners.y);
    let c = vertex_of(boundary.first + corners.z);
    let magnitude = largest_magnitude(a, b, c);
    if (magnitude >= LARGE) {
      return Turns(0u, 0u);
    }
    turns = narrowed_turns(
      turns, bitcast<vec3<f32>>(a), bitcast<vec3<f32>>(b), bitcast<vec3<f32>>(c), bitcast<f32>(magnitude));
  }
  return turns;
}

// The decisions of this stage about a boundary, a bit for each light. A light is decided if its bit is in `facing`,
// `back_facing` or `twisted`. Bits past the last light may be set, except in `twisted`.
struct Decided {
  facing: u32,
  back_facing: u32,
  // Lights for which two neighbouring turns of a quadrilateral are certainly 1 and the others certainly -1.
  twisted: u32,
  // Lights for which its turns at corner 0 and at corner 1 are certainly 1. They are valid only for lights of `twisted`.
  turn_0: u32,
  turn_1: u32,
}

// Decides a quadrilateral by the turns at its corners, four lights at a time, if all four are certain. If three are equal,
// the loop is simple and has their sense. If two neighbours differ from the other two, two edges cross: it is twisted. If
// turns alternate, it goes around the light, and nothing is decided.
fn decided_quad(boundary: PolygonBoundary) -> Decided {
  var decided = Decided(0u, 0u, 0u, 0u, 0u);
  let quad = quad_of(boundary);
  if (!quad.is_certain) {
    return decided;
  }
  let bound = vec4<f32>(quad.bound);
  // Turns: 8.
  for (var light_index = 0u; light_index < light_count(); light_index += 4u) {
    let turns = corner_determinants(quad, light_index);
    let positive_0 = light_bits(turns[0] > bound);
    let positive_1 = light_bits(turns[1] > bound);
    let positive_2 = light_bits(turns[2] > bound);
    let positive_3 = light_bits(turns[3] > bound);
    let negative_0 = light_bits(turns[0] < -bound);
    let negative_1 = light_bits(turns[1] < -bound);
    let negative_2 = light_bits(turns[2] < -bound);
    let negative_3 = light_bits(turns[3] < -bound);
    let certain = (positive_0 | negative_0) & (positive_1 | negative_1) & (positive_2 | negative_2) &
      (positive_3 | negative_3);
    let facing = certain & ((positive_0 & positive_1 & (positive_2 | positive_3)) |
      (positive_2 & positive_3 & (positive_0 | positive_1)));
    let back_facing = certain & ((negative_0 & negative_1 & (negative_2 | negative_3)) |
      (negative_2 & negative_3 & (negative_0 | negative_1)));
    decided.facing |= combined_bits(facing) << light_index;
    decided.back_facing |= combined_bits(back_facing) << light_index;
    // Turns alternate. `polygon_pairs` decides such a boundary, and `cut_edges`, not `cut_quads`, cuts it.
    let alternating = (positive_0 & positive_2) | (negative_0 & negative_2);
    decided.twisted |= combined_bits(certain & ~facing & ~back_facing & ~alternating) << light_index;
    decided.turn_0 |= combined_bits(positive_0) << light_index;
    decided.turn_1 |= combined_bits(positive_1) << light_index;
  }
  decided.twisted &= active_bits();
  return decided;
}

// Decides simple cases. Only quadrilaterals of two triangles can be twisted here.
fn decided_boundary(boundary: PolygonBoundary) -> Decided {
  // With more than two triangles it has edges that it walks both ways. Four turns then do not decide where its surface is
  // dark.
  if (boundary.is_loop && boundary.count == 4u && boundary.end_triangle - boundary.first_triangle == 2u) {
    return decided_quad(boundary);
  }
  if (boundary.is_loop && boundary.count <= MOST_CONVEX) {
    let turns = convex_turns(boundary);
    return Decided(turns.positive, turns.negative, 0u, 0u, 0u);
  }
  return Decided(0u, 0u, 0u, 0u, 0u);
}

fn is_boundary_finite(boundary: PolygonBoundary) -> bool {
  // Turns: BOUNDARY_EDGES.
  for (var edge = 0u; edge < boundary.count; edge++) {
    if (!is_finite(vertex_of(boundary.first + edge))) {
      return false;
    }
  }
  return true;
}

// The workgroup size is BOUNDARY_LANES, by which `polygon_facing` counts workgroups: an invocation has at most one record.
@compute @workgroup_size(64)
fn polygon_turns(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let record_count = atomicLoad(&undecided[RECORD_COUNT]);
  let row = BOUNDARY_LANES * groups.x;
  // Turns: 1.
  for (var index = id.y * row + id.x; index < record_count; index += groups.y * row) {
    let offset = record_offset(index);
    let polygon = atomicLoad(&undecided[offset + POLYGON]);
    let boundary = boundary_of(polygon);
    let decided = decided_boundary(boundary);
    // Turns: POLYGON_TRIANGLES.
    for (var triangle = boundary.first_triangle; triangle < boundary.end_triangle; triangle++) {
      facing_masks[triangle] = decided.facing & active_bits();
    }
    let undecided_lights = active_bits() & ~(decided.facing | decided.back_facing | decided.twisted);
    // If f32 decides all lights, all corners are finite. If a corner is not finite, f32 decides no light: LIGHTS are then
    // all active lights, for `polygon_masks`.
    let is_undecided = (undecided_lights | decided.twisted) != 0u;
    let has_finite_corners = !is_undecided || is_boundary_finite(boundary);
    atomicStore(&undecided[offset + POLYGON], polygon | select(NOT_FINITE, 0u, has_finite_corners));
    atomicStore(&undecided[offset + LIGHTS], select(active_bits(), undecided_lights, has_finite_corners));
    // The words that `polygon_pairs` sets bits in, from IN_HALF_SPACE to OFF_PLANE, before TWISTED_QUAD.
    for (var word = IN_HALF_SPACE; word < TWISTED_QUAD; word++) {
      atomicStore(&undecided[offset + word], 0u);
    }
    atomicStore(&undecided[offset + TWISTED_QUAD], decided.twisted);
    atomicStore(&undecided[offset + TURN_0], decided.turn_0);
    atomicStore(&undecided[offset + TURN_1], decided.turn_1);
    if (has_finite_corners && undecided_lights != 0u) {
      list_entries(index, boundary, undecided_lights, WORKGROUPS);
    }
  }
}

// Stage `polygon_masks`: decides from the records whether a polygon faces each light that `polygon_turns` left undecided, is
// in a plane with it, or is twisted. Dispatched after `polygon_pairs`, an invocation a record. It adds facing bits of the
// polygon's triangles (first half of `facing_masks`), writes their twisted masks (second half), and adds to their excluded
// masks. Twisted and excluded masks are cleared before each batch: callers exclude no polygons. It also adds to statistics. A
// polygon that is twisted or in a plane counts as absent; the shadow of a twisted one is cut into pieces. `edges` reads
// facing and twisted masks next; stages of shadow volumes read facing and excluded ones. It lists entries of twisted
// boundaries for `cut_edges`, except for the quadrilaterals of `cut_quads`.

@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;
// The statistics; not a record of `undecided`.
@group(0) @binding(2) var<storage, read_write> record: FacingRecord;

// Bits of lights among LIGHTS. `twisted` and `excluded` also have those for which `polygon_turns` found a quadrilateral
// twisted.
struct PolygonMasks {
  facing: u32,
  twisted: u32,
  excluded: u32, // Twisted, in a plane or not finite, so without a cap or side of its own.
}

// The bits of the record at word `offset` of `undecided`. A polygon with a corner that is not finite faces no light and is
// excluded for all: LIGHTS has them. `polygon_pairs` found bits over all edges (polygon/boundaries.wgsl). If winding numbers
// 1 and 0 both occur on the left of edges, the boundary is not simple.
fn masks_of_record(offset: u32) -> PolygonMasks {
  let lights = atomicLoad(&undecided[offset + LIGHTS]);
  if (atomicLoad(&undecided[offset + POLYGON]) >= NOT_FINITE) {
    return PolygonMasks(0u, 0u, lights);
  }
  let winds_once = atomicLoad(&undecided[offset + WINDS_ONCE]);
  let winds_never = atomicLoad(&undecided[offset + WINDS_NEVER]);
  let in_plane = lights & ~atomicLoad(&undecided[offset + OFF_PLANE]);
  let simple = atomicLoad(&undecided[offset + IN_HALF_SPACE]) & ~atomicLoad(&undecided[offset + IS_NOT_SIMPLE]) &
    ~(winds_once & winds_never);
  let twisted = (lights & ~in_plane & ~simple) | atomicLoad(&undecided[offset + TWISTED_QUAD]);
  return PolygonMasks(lights & ~in_plane & simple & winds_once, twisted, twisted | in_plane);
}

// The workgroup size is BOUNDARY_LANES, by which `polygon_facing` counts workgroups: an invocation has at most one record.
@compute @workgroup_size(64)
fn polygon_masks(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let record_count = atomicLoad(&undecided[RECORD_COUNT]);
  let row = BOUNDARY_LANES * groups.x;
  // Turns: 1.
  for (var index = id.y * row + id.x; index < record_count; index += groups.y * row) {
    let offset = record_offset(index);
    let masks = masks_of_record(offset);
    let boundary = boundary_of(polygon_of(offset));
    let triangles = arrayLength(&facing_masks) / 2u;
    // Turns: POLYGON_TRIANGLES.
    for (var triangle = boundary.first_triangle; triangle < boundary.end_triangle; triangle++) {
      facing_masks[triangle] |= masks.facing;
      facing_masks[triangles + triangle] = masks.twisted;
      // An extractor that is not for volumes binds a short buffer, and nobody reads the words written to it.
      if (triangle < arrayLength(&excluded_masks)) {
        excluded_masks[triangle] |= masks.excluded;
      }
    }
    // `undecided_pairs` does not count the pairs that `polygon_turns` found twisted. `non_finite_faces` counts polygons
    // here, in the first batch only, since every batch finds the same.
    if (atomicLoad(&undecided[offset + POLYGON]) < NOT_FINITE) {
      let lights = atomicLoad(&undecided[offset + LIGHTS]);
      atomicAdd(&record.statistics.undecided_pairs, countOneBits(lights));
      atomicAdd(&record.statistics.exact_zeros, countOneBits(masks.excluded & ~masks.twisted));
      atomicOr(&record.statistics.twisted_lights, masks.twisted);
    } else if (chunk.first_light == 0u) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
    // `cut_quads` cuts for the lights of `quad`, and `cut_edges` for the other twisted ones. From here on LIGHTS are those
    // of `cut_edges`.
    let quad = atomicLoad(&undecided[offset + TWISTED_QUAD]);
    let cut = masks.twisted & ~quad;
    atomicStore(&undecided[offset + LIGHTS], cut);
    if (cut != 0u) {
      list_entries(index, boundary, cut, CUT_WORKGROUPS);
    }
  }
}
