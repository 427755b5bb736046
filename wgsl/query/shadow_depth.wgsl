// Shadow depth: counts for each pair of point and light the faces strictly between them. Runs after `shadow_boxes`;
// dispatched for each run of points and clusters, batch of up to 32 lights and range of faces, one invocation a pair. Faces
// that `f32` with its bounds decides are counted here, into `depths`, which the caller reads in the end. Others are noted
// for `exact_shadow_depth`, which runs right after: up to three. With more, nothing of the range is counted, and the pair is
// listed, in any order, for `depth_arguments` and `exact_shadow_depth_recount`. Depths are exact: the same on every device
// and on the CPU, so bounds must not shrink. The triangles of a polygon (they follow each other) count 1 and -1 in turn, so
// that it counts once if an odd number of them lie between. Ranges come one after another, and the bit of a polygon that
// goes on behind a range is handed on by `state`, or by `face_0` if the pair was listed. A point that is not finite has
// depth -1. docs/numerics/query.md.

#import common/determinant
#import common/positions
#import query/records
#import query/shadow_pairs
#import query/shadow_segments

// The number of undecided faces, the first three of them, and where their polygons begin.
var<private> undecided: u32;
var<private> noted: vec3<u32>;
var<private> noted_heads: vec3<u32>;
// For each of these faces, whether an odd number of the decided triangles of its polygon are between so far.
var<private> noted_odd: vec3<bool>;
// The polygon at hand, by where it begins, and the same of it. Faces come in order, so one polygon is at hand at a time.
var<private> head: u32;
var<private> is_odd: bool;

// Makes the polygon of a face the one at hand.
fn go_to(face: u32) {
  let own = head_of(face);
  is_odd = is_odd && own == head;
  head = own;
}

// Notes an undecided face, with the bit of its polygon as the decided triangles up to here leave it.
fn note(face: u32) {
  let is_own = vec3<bool>(undecided == 0u, undecided == 1u, undecided == 2u);
  noted = select(noted, vec3<u32>(face), is_own);
  if (POLYGONS) {
    go_to(face);
    noted_heads = select(noted_heads, vec3<u32>(head), is_own);
    noted_odd = select(noted_odd, vec3<bool>(is_odd), is_own);
  }
  undecided++;
}

// The amount that a face that lies between adds to the depth: 1, or -1 after an odd number of triangles of the same polygon.
// Undecided ones do not count here: exact_shadow_depth.wgsl adds what they change.
fn turn_of(face: u32) -> i32 {
  if (!POLYGONS) {
    return 1;
  }
  go_to(face);
  let turn = select(1, -1, is_odd);
  is_odd = !is_odd;
  noted_odd = select(noted_odd, !noted_odd, noted_heads == vec3<u32>(head));
  return turn;
}

// Counts the faces of a cluster that lie between.
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
    if (decision == NOT_BETWEEN || is_named(segment, CLUSTER * cluster + at)) {
      continue;
    }
    if (decision == BETWEEN) {
      count += turn_of(CLUSTER * cluster + at);
    } else {
      note(CLUSTER * cluster + at);
    }
  }
  return count;
}

// Counts the faces of the range that lie between. Ends early once too many are undecided.
fn count_range(segment: Segment) -> i32 {
  var count = 0;
  // Turns: QUERY_GROUPS.
  for (var group = range.first; group < range.end; group += CLUSTER) {
    if (misses(segment, clusters[group].group_low, clusters[group].group_high)) {
      continue;
    }
    // Turns: CLUSTER.
    for (var cluster = group; cluster < min(group + CLUSTER, range.end); cluster++) {
      count += count_cluster(segment, cluster);
    }
    if (undecided > MOST_UNDECIDED) {
      break;
    }
  }
  return count;
}

// Lists a pair whose faces are all to be decided anew.
fn list(pair: u32) {
  let place = atomicAdd(&undecided_pairs.listed, 1u);
  undecided_pairs.pairs[place].recount = pair;
}

// Whether an odd number of triangles in earlier ranges are between, of the polygon that goes on in this range, if one does.
fn was_odd(pair: u32) -> bool {
  let begins = head_of(CLUSTER * range.first);
  if (range.before == range.first || begins == CLUSTER * range.first) {
    return false;
  }
  let state = undecided_pairs.pairs[pair].state;
  let bits = atomicLoad(&undecided_pairs.pairs[pair].face_0);
  let was_counted_again = (state & COUNT_MASK) > MOST_UNDECIDED;
  return select(state & ODD_AT_END, bits & odd_bit(begins, range.before), was_counted_again) != 0u;
}

@compute @workgroup_size(64)
fn shadow_depth(@builtin(global_invocation_id) id: vec3<u32>) {
  let pair = id.x;
  if (pair >= chunk.count * batch.count) {
    return;
  }
  let query = query_of(pair);
  var counted = 0;
  var state = 0u;
  if (is_finite(query.p_bits)) {
    var begins_odd = false;
    if (POLYGONS) {
      head = head_of(CLUSTER * range.first);
      is_odd = was_odd(pair);
      begins_odd = is_odd;
      noted_heads = vec3<u32>(0xffffffffu);
    }
    counted = count_range(segment_of(query));
    state = min(undecided, MOST_UNDECIDED + 1u);
    if (undecided > MOST_UNDECIDED) {
      counted = 0;
      noted.x = select(0u, 1u, begins_odd);
      list(pair);
    } else if (POLYGONS) {
      // Only the polygon of the last face may go on.
      go_to(CLUSTER * range.end - 1u);
      let bits = select(vec3<u32>(0u), vec3<u32>(1u, 2u, 4u), noted_odd);
      state |= ((bits.x | bits.y | bits.z) << ODD_FACES) | select(0u, ODD_AT_END, is_odd);
    }
    if (range.is_first == 0u) {
      counted += atomicLoad(&depths[query.at]);
    }
  } else {
    counted = -1;
  }
  atomicStore(&depths[query.at], counted);
  undecided_pairs.pairs[pair].state = state;
  atomicStore(&undecided_pairs.pairs[pair].face_0, noted.x);
  undecided_pairs.pairs[pair].face_1 = noted.y;
  undecided_pairs.pairs[pair].face_2 = noted.z;
}
