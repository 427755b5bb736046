// Stage `exact_shadow_depth`: decides the faces that `shadow_depth` left undecided, and adds them to the occluder
// counts (`depths`) that the caller reads. Three stages, in this order, after each dispatch of `shadow_depth`.
// `exact_shadow_depth`: an invocation a pair of point and light, for its up to three stored faces. `depth_arguments`:
// writes the dispatch of the next stage. `exact_shadow_depth_recount`: a workgroup a listed pair (one with more) and a
// group of 1,024 faces. It decides all of them, since `shadow_depth` counted nothing of the range for the pair. Fixed
// point decides if the numbers fit, otherwise `exact_sign`, so counts are the same on every device. If the line meets
// an edge, the light moves by (e, e^2, e^3) for all faces, so that the line passes a shared edge on one side. Claim:
// docs/numerics/query.md.

#import common/exact_sign
#import query/records
#import query/shadow_pairs
#import query/shadow_segments

// The light, or for tie 1 to 3 the axis along which it moves, as a light at infinity.
fn light_or_axis(light: vec4<u32>, tie: u32) -> vec4<u32> {
  switch (tie) {
    case 0u: { return light; }
    case 1u: { return vec4<u32>(ONE, 0u, 0u, 0u); }
    case 2u: { return vec4<u32>(0u, ONE, 0u, 0u); }
    default: { return vec4<u32>(0u, 0u, ONE, 0u); }
  }
}

// Whether point and light are strictly on opposite sides of the face's plane, and the line between them passes through the
// face. It does if the sign for each edge with point and light is that of face and light. Only the signs for edges have ties
// broken. The face must be finite.
fn exactly_between(face: Face, p: vec3<u32>, light: vec4<u32>) -> bool {
  var light_side = 0;
  // Tests 0 and 1: the sides of the point and of the light at the plane. Tests 2 to 4: the three edges. One loop computes
  // them all, so that the integer code is compiled once.
  for (var test = 0u; test < 5u; test++) {
    var a = face.a;
    var b = face.b;
    var c = select(face.c, p, test >= 2u);
    if (test == 3u) {
      a = face.b;
      b = face.c;
    } else if (test == 4u) {
      a = face.c;
      b = face.a;
    }
    let fixed = fixed_face(a, b, c);
    let test_point = select(light, vec4<u32>(p, ONE), test == 0u);
    let ties = select(1u, 4u, test >= 2u);
    var sign = 0;
    // Turns: 4.
    for (var tie = 0u; tie < ties && sign == 0; tie++) {
      let moving_light = light_or_axis(test_point, tie);
      sign = fixed_sign(fixed, moving_light);
      if (sign == 2) {
        sign = exact_sign(a, b, c, moving_light);
      }
    }
    if (sign == 0) {
      return false;
    }
    if (test == 0u) {
      light_side = -sign;
    } else if (sign != light_side) {
      return false;
    }
  }
  return true;
}

// Whether a face lies between, decided by error bounds or exactly. The face that the point is on does not.
fn is_between(segment: Segment, index: u32) -> bool {
  let face = face_of(index);
  let decision = select(decide_face(segment, face), NOT_BETWEEN, is_on_face(segment, index));
  return decision == BETWEEN ||
    (decision == UNDECIDED && exactly_between(face, segment.p_bits, batch.light_bits[segment.light]));
}

// A bit for each of a group's 1,024 faces, for the polygon that begins with it and ends in the group. It is set if an odd
// number of triangles of the polygon lie between. The stage clears the bits, because SwiftShader was seen to keep those of
// an earlier workgroup.
var<workgroup> odd_polygons: array<atomic<u32>, CLUSTER>;

// The change of the count for a face that lies between, in the group that begins with cluster `first`: 1, or -1 after an odd
// number of triangles of the same polygon. The sum makes the count the parity, in any order of invocations.
fn count_change_in_group(pair: u32, index: u32, first: u32) -> i32 {
  if (!POLYGONS) {
    return 1;
  }
  let polygon = polygon_of(index);
  let begin = CLUSTER * first;
  let end = begin + CLUSTER * CLUSTER;
  var continues_after_group = false;
  if (first + CLUSTER < arrayLength(&clusters)) {
    continues_after_group = polygon_of(end) == polygon;
  }
  var bit = polygon_bit(polygon, range.first);
  var bits_before = 0u;
  // For a polygon with triangles in other groups the bit is stored with the pair: `face_0` of a listed pair holds such bits.
  if (polygon < begin || continues_after_group) {
    bits_before = atomicXor(&undecided_pairs.pairs[pair].face_0, bit);
  } else {
    bit = 1u << (polygon % CLUSTER);
    bits_before = atomicXor(&odd_polygons[(polygon - begin) / CLUSTER], bit);
  }
  return select(1, -1, (bits_before & bit) != 0u);
}

// Decides the stored faces of each pair of point and light.
@compute @workgroup_size(64)
fn exact_shadow_depth(@builtin(global_invocation_id) id: vec3<u32>) {
  let pair = id.x;
  if (pair >= chunk.count * batch.count) {
    return;
  }
  var state = undecided_pairs.pairs[pair].state;
  let count = state & COUNT_MASK;
  if (count > MOST_UNDECIDED) {
    return;
  }
  let point_light = point_and_light(pair);
  let segment = segment_of(point_light);
  let face_0 = atomicLoad(&undecided_pairs.pairs[pair].face_0);
  let face_1 = undecided_pairs.pairs[pair].face_1;
  let face_2 = undecided_pairs.pairs[pair].face_2;
  // Turns: MOST_UNDECIDED.
  for (var index = 0u; index < count; index++) {
    let face = select(select(face_2, face_1, index == 1u), face_0, index == 0u);
    if (!is_between(segment, face)) {
      continue;
    }
    var change = 1;
    if (POLYGONS) {
      change = select(1, -1, ((state >> (FIRST_ODD_BIT + index)) & 1u) != 0u);
      // The parity changes for the polygon's other stored faces, and for its part in the next range.
      let polygon = polygon_of(face);
      state ^= select(0u, 2u << FIRST_ODD_BIT, polygon_of(face_1) == polygon) |
        select(0u, 4u << FIRST_ODD_BIT, polygon_of(face_2) == polygon) |
        select(0u, ODD_AT_END, polygon_of(CLUSTER * range.end - 1u) == polygon);
    }
    atomicAdd(&depths[point_light.count_index], change);
  }
  if (POLYGONS) {
    undecided_pairs.pairs[pair].state = state;
  }
}

// Counts listed pairs again. A workgroup takes a pair and a group of faces, so that no invocation decides many.
@compute @workgroup_size(64)
fn exact_shadow_depth_recount(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  if (POLYGONS) {
    if (lane < CLUSTER) {
      atomicStore(&odd_polygons[lane], 0u);
    }
    workgroupBarrier();
  }
  let range_groups = (range.end - range.first + CLUSTER - 1u) / CLUSTER;
  let item = (group.z * groups.y + group.y) * groups.x + group.x;
  if (item / range_groups >= undecided_pairs.recounts) {
    return;
  }
  let pair = undecided_pairs.pairs[item / range_groups].recount;
  let point_light = point_and_light(pair);
  let segment = segment_of(point_light);
  let first = range.first + CLUSTER * (item % range_groups);
  if (misses_box(segment, clusters[first].group_low, clusters[first].group_high)) {
    return;
  }
  let end = min(first + CLUSTER, range.end) * CLUSTER;
  // Turns: CLUSTER * CLUSTER / 64.
  for (var face = first * CLUSTER + lane; face < end; face += 64u) {
    if (misses_box(segment, clusters[face / CLUSTER].low, clusters[face / CLUSTER].high)) {
      continue;
    }
    if (is_between(segment, face)) {
      atomicAdd(&depths[point_light.count_index], count_change_in_group(pair, face, first));
    }
  }
}

// Stage `depth_arguments`: writes the indirect dispatch of `exact_shadow_depth_recount`, a workgroup for each listed pair of
// point and light and each group of the range. It moves the number of listed pairs to `recounts` and empties the list for
// the next range. Dispatched as one invocation, after `exact_shadow_depth`, for each range.

@group(0) @binding(2) var<storage, read_write> dispatch: array<u32, 3>;

// The largest number of workgroups of a dispatch along an axis. A device without a limit has 2^32 - 1.
override MOST_WORKGROUPS: u32 = 65535u;

@compute @workgroup_size(1)
fn depth_arguments() {
  let recounts = atomicExchange(&undecided_pairs.listed, 0u);
  undecided_pairs.recounts = recounts;
  let groups = recounts * ((range.end - range.first + CLUSTER - 1u) / CLUSTER);
  // Rounded up without a sum that could wrap. Few devices allow so few that z is not 1.
  let rows = groups / MOST_WORKGROUPS + min(groups % MOST_WORKGROUPS, 1u);
  dispatch[0] = min(groups, MOST_WORKGROUPS);
  dispatch[1] = min(rows, MOST_WORKGROUPS);
  dispatch[2] = rows / MOST_WORKGROUPS + min(rows % MOST_WORKGROUPS, 1u);
}
