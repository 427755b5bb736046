// Exact shadow depth: decides the faces that shadow_depth.wgsl left undecided. It computes in integers, and in fixed
// point where the numbers fit. Where the line from point to light meets an edge, the tie is broken as if the light were
// moved by (e, e^2, e^3). NUMERICS.md, "Shadow depth".

// The light, or the axis along which it moves in a tie.
fn light_at(light: vec4<u32>, tie: u32) -> vec4<u32> {
  switch (tie) {
    case 0u: { return light; }
    case 1u: { return vec4<u32>(ONE, 0u, 0u, 0u); }
    case 2u: { return vec4<u32>(0u, ONE, 0u, 0u); }
    default: { return vec4<u32>(0u, 0u, ONE, 0u); }
  }
}

// Whether point and light are strictly on opposite sides of the plane, and the line passes all edges on the light's
// side.
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

fn is_between(segment: Segment, index: u32) -> bool {
  let face = face_of(index);
  let decision = decide(segment, face);
  return decision == BETWEEN ||
    (decision == UNDECIDED && exactly_between(face, segment.p_bits, batch.light_bits[segment.light]));
}

// What a face counts: 0 if it is not between, else 1, or -1 after an odd number of triangles of the same polygon.
fn count_of(segment: Segment, index: u32) -> i32 {
  var count = 0;
  var at = index;
  var is_going = true;
  // Loops in loops, because llvmpipe silently ends a loop after 65,535 turns.
  while (is_going) {
    for (var run = 0u; run < 1024u && is_going; run++) {
      if (is_between(segment, at)) {
        count = select(-count, 1, at == index);
      }
      is_going = count != 0 && continues(at);
      at--;
    }
  }
  return count;
}

// A face of a pair, as it was noted.
fn noted_face(noted: UndecidedFaces, at: u32) -> u32 {
  return select(select(noted.face_2, noted.face_1, at == 1u), noted.face_0, at == 0u);
}

// Settles the noted faces of each pair of point and light.
@compute @workgroup_size(64)
fn exact_shadow_depth(@builtin(global_invocation_id) id: vec3<u32>) {
  let pair = id.x;
  if (pair >= chunk.count * batch.count) {
    return;
  }
  let noted = undecided_pairs.pairs[pair];
  if (noted.count > MOST_UNDECIDED) {
    return;
  }
  let query = query_of(pair);
  let segment = segment_of(query);
  for (var at = 0u; at < noted.count; at++) {
    let count = count_of(segment, noted_face(noted, at));
    if (count != 0) {
      atomicAdd(&depths[query.at], count);
    }
  }
}

// Counts the pairs with more faces. A workgroup takes a pair and a group of faces, so no invocation has many to settle.
@compute @workgroup_size(64)
fn exact_shadow_depth_recount(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let range_groups = (range.end - range.first + CLUSTER - 1u) / CLUSTER;
  let item = group.y * groups.x + group.x;
  if (item / range_groups >= undecided_pairs.recounts) {
    return;
  }
  let query = query_of(undecided_pairs.pairs[item / range_groups].recount);
  let segment = segment_of(query);
  let first = range.first + CLUSTER * (item % range_groups);
  if (misses(segment, clusters[first].group_low, clusters[first].group_high)) {
    return;
  }
  let end = min(first + CLUSTER, range.end) * CLUSTER;
  for (var at = first * CLUSTER + local; at < end; at += 64u) {
    if (misses(segment, clusters[at / CLUSTER].low, clusters[at / CLUSTER].high)) {
      continue;
    }
    let count = count_of(segment, at);
    if (count != 0) {
      atomicAdd(&depths[query.at], count);
    }
  }
}
