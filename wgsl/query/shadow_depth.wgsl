// Shadow depth: counts the faces strictly between each point and each light. The triangles of a polygon count 1 and -1 in turn, so
// that it counts once if an odd number of them lie between. One invocation takes one pair of point and light. It notes undecided faces for exact_shadow_depth.wgsl. A pair with too many of them is listed, and
// exact_shadow_depth.wgsl counts it again.

var<private> undecided: UndecidedFaces;

fn note(face: u32) {
  switch (undecided.count) {
    case 0u: { undecided.face_0 = face; }
    case 1u: { undecided.face_1 = face; }
    case 2u: { undecided.face_2 = face; }
    default: {}
  }
  undecided.count++;
}

// What a face that lies between counts: 1, or -1 after an odd number of triangles of the same polygon. It is 0 where one of those is
// undecided.
fn turn_of(segment: Segment, index: u32) -> i32 {
  var turn = 1;
  var at = index;
  // Loops in loops, because llvmpipe silently ends a loop after 65,535 turns.
  while (continues(at) && turn != 0) {
    for (var run = 0u; run < 1024u && continues(at) && turn != 0; run++) {
      at--;
      let decision = decide(segment, face_of(at));
      if (decision == BETWEEN) {
        turn = -turn;
      } else if (decision == UNDECIDED) {
        turn = 0;
      }
    }
  }
  return turn;
}

// What the faces of a cluster that lie between count.
fn count_cluster(segment: Segment, cluster: u32) -> i32 {
  let low = clusters[cluster].low;
  let high = clusters[cluster].high;
  if (misses(segment, low, high)) {
    return 0;
  }
  // One bound for all edges, because the box holds them all.
  let to_low = bitcast<vec3<f32>>(low.xyz) - segment.p;
  let to_high = bitcast<vec3<f32>>(high.xyz) - segment.p;
  let edge = sum_of_sizes(bitcast<vec3<f32>>(high.xyz) - bitcast<vec3<f32>>(low.xyz));
  let reach = sum_of_sizes(max(abs(to_low), abs(to_high)));
  let underflow = underflow_bound(bitcast<f32>(max(low.w, segment.largest)));
  let bound = (RELATIVE * segment.size) * (edge * reach) + underflow * (1.0 + 3.0 * segment.size);
  let is_certain = segment.is_certain && low.w < LARGE;
  var count = 0;
  for (var at = 0u; at < CLUSTER; at++) {
    let face = face_of(CLUSTER * cluster + at);
    let d = edge_determinants(
      segment,
      bitcast<vec3<f32>>(face.a),
      bitcast<vec3<f32>>(face.b),
      bitcast<vec3<f32>>(face.c),
    );
    if (is_certain && min(min(d.x, d.y), d.z) < -bound && max(max(d.x, d.y), d.z) > bound) {
      continue;
    }
    let decision = decide(segment, face);
    if (decision == NOT_BETWEEN) {
      continue;
    }
    var turn = 0;
    if (decision == BETWEEN) {
      turn = turn_of(segment, CLUSTER * cluster + at);
      count += turn;
    }
    if (turn == 0) {
      note(CLUSTER * cluster + at);
    }
  }
  return count;
}

// What the faces of the range that lie between count.
fn count_range(segment: Segment) -> i32 {
  var count = 0;
  for (var group = range.first; group < range.end; group += CLUSTER) {
    if (misses(segment, clusters[group].group_low, clusters[group].group_high)) {
      continue;
    }
    for (var cluster = group; cluster < min(group + CLUSTER, range.end); cluster++) {
      count += count_cluster(segment, cluster);
    }
    if (undecided.count > MOST_UNDECIDED) {
      break;
    }
  }
  return count;
}

fn list(pair: u32) {
  let place = atomicAdd(&undecided_pairs.listed, 1u);
  undecided_pairs.pairs[place].recount = pair;
}

@compute @workgroup_size(64)
fn shadow_depth(@builtin(global_invocation_id) id: vec3<u32>) {
  let pair = id.x;
  if (pair >= chunk.count * batch.count) {
    return;
  }
  let query = query_of(pair);
  var counted = 0;
  if (is_finite(query.p_bits)) {
    counted = count_range(segment_of(query));
    if (undecided.count > MOST_UNDECIDED) {
      counted = 0;
      list(pair);
    }
    if (range.is_first == 0u) {
      counted += atomicLoad(&depths[query.at]);
    }
  } else {
    counted = -1;
  }
  atomicStore(&depths[query.at], counted);
  undecided_pairs.pairs[pair].count = undecided.count;
  undecided_pairs.pairs[pair].face_0 = undecided.face_0;
  undecided_pairs.pairs[pair].face_1 = undecided.face_1;
  undecided_pairs.pairs[pair].face_2 = undecided.face_2;
}
