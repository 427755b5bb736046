// Exact shadow depth: decides the faces that `shadow_depth` left undecided, and adds them to `depths`, the number of faces
// between each point and light (polygons, where a mesh has them), which the caller reads in the end. Three stages, right
// after `shadow_depth` and in this order, for each range of faces. `exact_shadow_depth`: an invocation a pair of point and
// light, for the up to three faces that are noted for it. `depth_arguments`: says how many workgroups the next has.
// `exact_shadow_depth_recount`: a workgroup a listed pair, which has more, and 1,024 faces. It decides all of these, since
// `shadow_depth` counted nothing of the range for such a pair. Fixed point decides where the numbers fit, else integers, so
// depths are the same on every device. Where the line to the light meets an edge, the tie is broken as if the light were
// moved by (e, e^2, e^3), the same for all faces, so that a line through a shared edge passes one side of it. Counts are
// added by atomics, in any order. docs/numerics/query.md.

#import common/exact_sign
#import query/records
#import query/shadow_pairs
#import query/shadow_segments

// The light, or the axis along which it moves in a tie.
fn light_at(light: vec4<u32>, tie: u32) -> vec4<u32> {
  switch (tie) {
    case 0u: { return light; }
    case 1u: { return vec4<u32>(ONE, 0u, 0u, 0u); }
    case 2u: { return vec4<u32>(0u, ONE, 0u, 0u); }
    default: { return vec4<u32>(0u, 0u, ONE, 0u); }
  }
}

// Whether point and light are strictly on opposite sides of the face's plane, and the line between them passes through the
// face: for each edge the sign of edge, point and light is that of face and light. Ties are broken for edges only.
fn exactly_between(face: Face, p: vec3<u32>, light: vec4<u32>) -> bool {
  var light_side = 0;
  // The sides of the point, of the light, and of three edges. One loop computes them, so that the integers are compiled
  // once.
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
    let towards = select(light, vec4<u32>(p, ONE), test == 0u);
    let ties = select(1u, 4u, test >= 2u);
    var sign = 0;
    // Turns: 4.
    for (var tie = 0u; tie < ties && sign == 0; tie++) {
      let at = light_at(towards, tie);
      sign = fixed_sign(fixed, at);
      if (sign == 2) {
        sign = exact_sign(a, b, c, at);
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

// Whether a face is between, by bounds or exactly. The face that the point is on is not.
fn is_between(segment: Segment, index: u32) -> bool {
  let face = face_of(index);
  let decision = select(decide(segment, face), NOT_BETWEEN, is_named(segment, index));
  return decision == BETWEEN ||
    (decision == UNDECIDED && exactly_between(face, segment.p_bits, batch.light_bits[segment.light]));
}

// A bit for each of a group's 1,024 faces: whether an odd number of triangles are between, of the polygon that begins with
// it and ends in the group. It is cleared before use: SwiftShader was seen to leave the words of an earlier workgroup in it.
var<workgroup> odd_polygons: array<atomic<u32>, CLUSTER>;

// The amount that a face that is between adds to the depth, among the faces of the group that begins with cluster `first`:
// 1, or -1 after an odd number of triangles of the same polygon. In any order of invocations the sum is 1 for an odd number
// and 0 for an even one.
fn turn_in_group(pair: u32, index: u32, first: u32) -> i32 {
  if (!POLYGONS) {
    return 1;
  }
  let head = head_of(index);
  let begin = CLUSTER * first;
  let end = begin + CLUSTER * CLUSTER;
  var goes_on = false;
  if (first + CLUSTER < arrayLength(&clusters)) {
    goes_on = head_of(end) == head;
  }
  var bit = odd_bit(head, range.first);
  var before = 0u;
  // A polygon with triangles in other groups has its bit with the pair: a listed pair has bits in place of its first face.
  if (head < begin || goes_on) {
    before = atomicXor(&undecided_pairs.pairs[pair].face_0, bit);
  } else {
    bit = 1u << (head % CLUSTER);
    before = atomicXor(&odd_polygons[(head - begin) / CLUSTER], bit);
  }
  return select(1, -1, (before & bit) != 0u);
}

// Settles the noted faces of each pair of point and light.
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
  let query = query_of(pair);
  let segment = segment_of(query);
  let face_0 = atomicLoad(&undecided_pairs.pairs[pair].face_0);
  let face_1 = undecided_pairs.pairs[pair].face_1;
  let face_2 = undecided_pairs.pairs[pair].face_2;
  // Turns: MOST_UNDECIDED.
  for (var at = 0u; at < count; at++) {
    let face = select(select(face_2, face_1, at == 1u), face_0, at == 0u);
    if (!is_between(segment, face)) {
      continue;
    }
    var turn = 1;
    if (POLYGONS) {
      turn = select(1, -1, ((state >> (ODD_FACES + at)) & 1u) != 0u);
      // The other noted faces of the polygon come after one more, and so does what the next range has of it.
      let head = head_of(face);
      state ^= select(0u, 2u << ODD_FACES, head_of(face_1) == head) | select(0u, 4u << ODD_FACES, head_of(face_2) == head) |
        select(0u, ODD_AT_END, head_of(CLUSTER * range.end - 1u) == head);
    }
    atomicAdd(&depths[query.at], turn);
  }
  if (POLYGONS) {
    undecided_pairs.pairs[pair].state = state;
  }
}

// Counts the pairs with more faces. A workgroup takes a pair and a group of faces, so no invocation has many to settle.
@compute @workgroup_size(64)
fn exact_shadow_depth_recount(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  if (POLYGONS) {
    if (local < CLUSTER) {
      atomicStore(&odd_polygons[local], 0u);
    }
    workgroupBarrier();
  }
  let range_groups = (range.end - range.first + CLUSTER - 1u) / CLUSTER;
  let item = group.y * groups.x + group.x;
  if (item / range_groups >= undecided_pairs.recounts) {
    return;
  }
  let pair = undecided_pairs.pairs[item / range_groups].recount;
  let query = query_of(pair);
  let segment = segment_of(query);
  let first = range.first + CLUSTER * (item % range_groups);
  if (misses(segment, clusters[first].group_low, clusters[first].group_high)) {
    return;
  }
  let end = min(first + CLUSTER, range.end) * CLUSTER;
  // Turns: CLUSTER * CLUSTER / 64.
  for (var at = first * CLUSTER + local; at < end; at += 64u) {
    if (misses(segment, clusters[at / CLUSTER].low, clusters[at / CLUSTER].high)) {
      continue;
    }
    if (is_between(segment, at)) {
      atomicAdd(&depths[query.at], turn_in_group(pair, at, first));
    }
  }
}

// Stage `depth_arguments`: makes the indirect dispatch of `exact_shadow_depth_recount` from the number of pairs of point and
// light that `shadow_depth` listed: a workgroup for each pair and each group of 1,024 faces of the range. Then it empties
// the list for the next range; the entries stay, and `recounts` says how many. Dispatched as one invocation, after
// `exact_shadow_depth` for each range.

@group(0) @binding(2) var<storage, read_write> dispatch: array<u32, 3>;

// The largest number of workgroups of a dispatch along x or y.
override MOST_WORKGROUPS: u32 = 65535u;

@compute @workgroup_size(1)
fn depth_arguments() {
  let recounts = atomicExchange(&undecided_pairs.listed, 0u);
  undecided_pairs.recounts = recounts;
  let groups = recounts * ((range.end - range.first + CLUSTER - 1u) / CLUSTER);
  dispatch[0] = min(groups, MOST_WORKGROUPS);
  dispatch[1] = (groups + MOST_WORKGROUPS - 1u) / MOST_WORKGROUPS;
  dispatch[2] = 1u;
}
