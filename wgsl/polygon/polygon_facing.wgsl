// Polygon facing: computes one bit for each polygon and light, set if the polygon faces the light. Outlines that are strictly
// convex as seen from a light need the turns at their corners only (NUMERICS.md, "Outlines", "The cheap way"). The others, and
// those whose turns `f32` leaves undecided, are listed for outline.wgsl. Each triangle of a polygon has the polygon's bits.

// Facing masks of all triangles, and after them their twisted masks.
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

fn vertex_of(edge: u32) -> vec3<u32> {
  return position_bits(outlines[edge].x, position_offset(), position_stride());
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

// What is certain of a quadrilateral.
struct Quad {
  facing: u32,
  averted: u32,
  // The lights for which two neighbouring turns are positive and the others are negative.
  twisted: u32,
  // The lights for which the turns at corners 0 and 1 are positive.
  turn_0: u32,
  turn_1: u32,
}

// The turns at the corners of a quadrilateral, four lights at a time. If three are alike, the fourth corner is in their triangle or
// beyond one of its sides, and the outline is simple. If not, it is L-twisted.
fn quad_turns(outline: OutlineRange) -> Quad {
  var quad = Quad(0u, 0u, 0u, 0u, 0u);
  let a_bits = vertex_of(outline.first);
  let b_bits = vertex_of(outline.first + 1u);
  let c_bits = vertex_of(outline.first + 2u);
  let d_bits = vertex_of(outline.first + 3u);
  let magnitude = max(largest_magnitude(a_bits, b_bits, c_bits), largest_magnitude(d_bits, d_bits, d_bits));
  if (magnitude >= LARGE) {
    return quad;
  }
  let a = bitcast<vec3<f32>>(a_bits);
  let c = bitcast<vec3<f32>>(c_bits);
  let ab = bitcast<vec3<f32>>(b_bits) - a;
  let ac = c - a;
  let ad = bitcast<vec3<f32>>(d_bits) - a;
  let cd = bitcast<vec3<f32>>(d_bits) - c;
  let cb = bitcast<vec3<f32>>(b_bits) - c;
  // At corner 0 the turn of d, a, b; at 1 that of a, b, c; at 2 that of b, c, d; at 3 that of c, d, a.
  let n_0 = cross_product(ab, ad);
  let n_1 = cross_product(ab, ac);
  let n_2 = cross_product(cd, cb);
  let n_3 = cross_product(ac, ad);
  let sizes = vec4<f32>(sum_of_sizes(ab) * sum_of_sizes(ad), sum_of_sizes(ab) * sum_of_sizes(ac),
    sum_of_sizes(cd) * sum_of_sizes(cb), sum_of_sizes(ac) * sum_of_sizes(ad));
  let size = max(max(sizes.x, sizes.y), max(sizes.z, sizes.w));
  let bound = vec4<f32>(face_bound(size, bitcast<f32>(magnitude), lights_reach()));
  let bits = vec4<u32>(1u, 2u, 4u, 8u);
  let none = vec4<u32>(0u);
  for (var place = 0u; place < light_places(); place += 4u) {
    let lights = transpose(
      mat4x4<f32>(scaled_light(place), scaled_light(place + 1u), scaled_light(place + 2u), scaled_light(place + 3u)));
    let from_a = mat3x4<f32>(lights[0] - lights[3] * a.x, lights[1] - lights[3] * a.y, lights[2] - lights[3] * a.z);
    let from_c = mat3x4<f32>(lights[0] - lights[3] * c.x, lights[1] - lights[3] * c.y, lights[2] - lights[3] * c.z);
    let d_0 = n_0.x * from_a[0] + n_0.y * from_a[1] + n_0.z * from_a[2];
    let d_1 = n_1.x * from_a[0] + n_1.y * from_a[1] + n_1.z * from_a[2];
    let d_2 = n_2.x * from_c[0] + n_2.y * from_c[1] + n_2.z * from_c[2];
    let d_3 = n_3.x * from_a[0] + n_3.y * from_a[1] + n_3.z * from_a[2];
    // Most are convex as seen from most lights.
    let low = min(min(d_0, d_1), min(d_2, d_3));
    let high = max(max(d_0, d_1), max(d_2, d_3));
    let all_up = select(none, bits, low > bound);
    let all_down = select(none, bits, high < -bound);
    quad.facing |= together(all_up) << place;
    quad.averted |= together(all_down) << place;
    if (all((all_up | all_down) != none)) {
      continue;
    }
    let up_0 = select(none, bits, d_0 > bound);
    let up_1 = select(none, bits, d_1 > bound);
    let up_2 = select(none, bits, d_2 > bound);
    let up_3 = select(none, bits, d_3 > bound);
    let down_0 = select(none, bits, d_0 < -bound);
    let down_1 = select(none, bits, d_1 < -bound);
    let down_2 = select(none, bits, d_2 < -bound);
    let down_3 = select(none, bits, d_3 < -bound);
    let certain = (up_0 | down_0) & (up_1 | down_1) & (up_2 | down_2) & (up_3 | down_3);
    let facing = certain & ((up_0 & up_1 & (up_2 | up_3)) | (up_2 & up_3 & (up_0 | up_1)));
    let averted = certain & ((down_0 & down_1 & (down_2 | down_3)) | (down_2 & down_3 & (down_0 | down_1)));
    quad.facing |= together(facing) << place;
    quad.averted |= together(averted) << place;
    // Where turns alternate, the outline goes around the light. Its pairs of edges are left to tell what it darkens.
    let around = (up_0 & up_2) | (down_0 & down_2);
    quad.twisted |= together(certain & ~facing & ~averted & ~around) << place;
    quad.turn_0 |= together(up_0) << place;
    quad.turn_1 |= together(up_1) << place;
  }
  quad.twisted &= live_lights();
  return quad;
}

fn sum_of_sizes(v: vec3<f32>) -> f32 {
  return abs(v.x) + abs(v.y) + abs(v.z);
}

fn together(bits: vec4<u32>) -> u32 {
  return bits.x | bits.y | bits.z | bits.w;
}

// Lists what is undecided, or cut: a record, and entries for all that is to do.
fn list(polygon: u32, outline: OutlineRange, lights: u32, quad: Quad) {
  var not_finite = false;
  for (var edge = 0u; edge < outline.count; edge++) {
    not_finite = not_finite || !is_finite(vertex_of(outline.first + edge));
  }
  let number = atomicAdd(&undecided[RECORD_COUNT], 1u);
  let record = record_at(number);
  atomicStore(&undecided[record + POLYGON], polygon | select(0u, NOT_FINITE, not_finite));
  atomicStore(&undecided[record + LIGHTS], select(lights, live_lights(), not_finite));
  for (var word = FITS; word < TWISTED_QUAD; word++) {
    atomicStore(&undecided[record + word], 0u);
  }
  atomicStore(&undecided[record + TWISTED_QUAD], quad.twisted);
  atomicStore(&undecided[record + TURN_0], quad.turn_0);
  atomicStore(&undecided[record + TURN_1], quad.turn_1);
  if (!not_finite && lights != 0u) {
    list_work(number, outline.count, lights, ENTRY_COUNT, WORKGROUPS);
  }
}

@compute @workgroup_size(256)
fn polygon_facing(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x >= chunk.count) {
    return;
  }
  let outline = outline_of(id.x);
  if (outline.count == 0u) {
    return;
  }
  var quad = Quad(0u, 0u, 0u, 0u, 0u);
  // With more triangles it has edges that it walks both ways, and where its surface is between light and shadow is another matter.
  if (outline.is_loop && outline.count == 4u && outline.end_triangle - outline.first_triangle == 2u) {
    quad = quad_turns(outline);
  } else if (outline.is_loop && outline.count <= MOST_CONVEX) {
    let turns = convex_turns(outline);
    quad.facing = turns.positive;
    quad.averted = turns.negative;
  }
  for (var triangle = outline.first_triangle; triangle < outline.end_triangle; triangle++) {
    facing_masks[triangle] = quad.facing & live_lights();
  }
  let left = live_lights() & ~(quad.facing | quad.averted | quad.twisted);
  if ((left | quad.twisted) != 0u) {
    list(id.x, outline, left, quad);
  }
}
