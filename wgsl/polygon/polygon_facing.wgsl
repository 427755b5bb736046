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

// Lists what is undecided: a record, and entries for all that is to do.
fn list(polygon: u32, outline: OutlineRange, lights: u32) {
  var not_finite = false;
  for (var edge = 0u; edge < outline.count; edge++) {
    not_finite = not_finite || !is_finite(vertex_of(outline.first + edge));
  }
  let number = atomicAdd(&undecided[RECORD_COUNT], 1u);
  let record = record_at(number);
  atomicStore(&undecided[record + POLYGON], polygon);
  atomicStore(&undecided[record + LIGHTS], select(lights, live_lights(), not_finite));
  for (var word = FITS; word < NOT_FINITE; word++) {
    atomicStore(&undecided[record + word], 0u);
  }
  atomicStore(&undecided[record + NOT_FINITE], select(0u, 1u, not_finite));
  if (not_finite) {
    return;
  }
  if (outline.count > SMALL_OUTLINE) {
    list_large(number, outline.count, lights);
    return;
  }
  let runs = (outline.count + ENTRY_EDGES - 1u) / ENTRY_EDGES;
  let halves = vec2<bool>((lights & 0xffffu) != 0u, lights > 0xffffu);
  let place = allot(runs * (select(0u, 1u, halves.x) + select(0u, 1u, halves.y)));
  for (var run = 0u; run < runs; run++) {
    if (halves.x) {
      write_entry(place + run, number, ENTRY_EDGES * run);
    }
    if (halves.y) {
      write_entry(place + select(0u, runs, halves.x) + run, number, (ENTRY_EDGES * run) | (1u << 16u));
    }
  }
}

// An entry for each light and edge.
fn list_large(number: u32, edges: u32, lights: u32) {
  var place = allot(edges * countOneBits(lights));
  for (var rest = lights; rest != 0u; rest &= rest - 1u) {
    for (var edge = 0u; edge < edges; edge++) {
      write_entry(place, number, edge | (firstTrailingBit(rest) << 16u));
      place++;
    }
  }
}

// Room for entries, and workgroups for them. Rows have as many as any device has.
fn allot(entries: u32) -> u32 {
  let place = atomicAdd(&undecided[ENTRY_COUNT], entries);
  let end = place + entries;
  atomicMax(&undecided[WORKGROUPS], min(end, ENTRY_ROW));
  atomicMax(&undecided[WORKGROUPS + 1u], (end + ENTRY_ROW - 1u) / ENTRY_ROW);
  return place;
}

fn write_entry(place: u32, number: u32, part: u32) {
  atomicStore(&undecided[entry_at(place)], number);
  atomicStore(&undecided[entry_at(place) + 1u], part);
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
  var turns = Turns(0u, 0u);
  if (outline.is_loop && outline.count <= MOST_CONVEX) {
    turns = convex_turns(outline);
  }
  for (var triangle = outline.first_triangle; triangle < outline.end_triangle; triangle++) {
    facing_masks[triangle] = turns.positive & live_lights();
  }
  let left = live_lights() & ~(turns.positive | turns.negative);
  if (left != 0u) {
    list(id.x, outline, left);
  }
}
