// Stage `shadow_depth`: computes occluder counts, the number of faces strictly between each point and light. Dispatched
// after `shadow_boxes` for each range of points, batch of up to 32 lights and range of clusters; an invocation a pair of
// point and light. It adds the faces that f32 decides within its error bounds to `depths`, the counts that the caller reads.
// Up to three others are stored for `exact_shadow_depth`, which runs next. A pair with more counts nothing of this range; it
// is listed, in any order, for `depth_arguments` and `exact_shadow_depth_recount`. After these, counts are exact, the same
// on every device and on the CPU, so bounds must not shrink. The triangles of a polygon follow each other, and those between
// count 1 and -1 alternately: an odd number counts once. The ranges of clusters of a binding run one after another, all
// before the next batch: a polygon that continues after a range leaves its parity with the pair, in `state`, or in `face_0`
// if the pair was listed. A point that is not finite has the count -1.
// Claim: docs/numerics/query.md.

#import common/determinant
#import common/positions
#import query/records
#import query/shadow_pairs
#import query/shadow_segments

// The number of undecided faces so far, the face indices of the first three, and those of their polygons (`polygon_of`).
var<private> undecided: u32;
var<private> undecided_faces: vec3<u32>;
var<private> undecided_polygons: vec3<u32>;
// For each of these faces, whether an odd number of decided triangles of its polygon lie between so far.
var<private> is_undecided_odd: vec3<bool>;
// The current polygon, and whether an odd number of its decided triangles lie between so far. Faces come in order, so there
// is one current polygon at a time.
var<private> current_polygon: u32;
var<private> is_current_odd: bool;

// Makes the polygon of a face the current one. The parity begins anew if another polygon was current.
fn enter_polygon(face: u32) {
  let polygon = polygon_of(face);
  is_current_odd = is_current_odd && polygon == current_polygon;
  current_polygon = polygon;
}

// Stores an undecided face, with the parity of its polygon's decided triangles up to here. After the third, faces are only
// counted.
fn store_undecided(face: u32) {
  let is_next_slot = vec3<bool>(undecided == 0u, undecided == 1u, undecided == 2u);
  undecided_faces = select(undecided_faces, vec3<u32>(face), is_next_slot);
  if (POLYGONS) {
    enter_polygon(face);
    undecided_polygons = select(undecided_polygons, vec3<u32>(current_polygon), is_next_slot);
    is_undecided_odd = select(is_undecided_odd, vec3<bool>(is_current_odd), is_next_slot);
  }
  undecided++;
}

// The change of the count for a face that lies between: 1, or -1 if an odd number of triangles of its polygon did before. It
// ignores undecided triangles: exact_shadow_depth.wgsl adds the changes due to these.
fn count_change(face: u32) -> i32 {
  if (!POLYGONS) {
    return 1;
  }
  enter_polygon(face);
  let change = select(1, -1, is_current_odd);
  is_current_odd = !is_current_odd;
  is_undecided_odd = select(is_undecided_odd, !is_undecided_odd, undecided_polygons == vec3<u32>(current_polygon));
  return change;
}

// The change of the count for the faces of a cluster that f32 decides to lie between. Stores undecided ones.
fn count_cluster(segment: Segment, cluster: u32) -> i32 {
  let low = clusters[cluster].low;
  let high = clusters[cluster].high;
  if (misses_box(segment, low, high)) {
    return 0;
  }
  // One bound for all edges of faces that can count, because the box contains these. Others are never between.
  let to_low = bitcast<vec3<f32>>(low.xyz) - segment.p;
  let to_high = bitcast<vec3<f32>>(high.xyz) - segment.p;
  let edge = sum_of_sizes(bitcast<vec3<f32>>(high.xyz) - bitcast<vec3<f32>>(low.xyz));
  let extent = sum_of_sizes(max(abs(to_low), abs(to_high)));
  let underflow = underflow_bound(bitcast<f32>(max(low.w, segment.largest)));
  let bound = determinant_bound(edge * extent, segment.size, underflow);
  let is_certain = segment.is_certain && low.w < LARGE;
  var count = 0;
  for (var index = 0u; index < CLUSTER; index++) {
    let face = face_of(CLUSTER * cluster + index);
    let d = edge_determinants(
      segment,
      bitcast<vec3<f32>>(face.a),
      bitcast<vec3<f32>>(face.b),
      bitcast<vec3<f32>>(face.c),
    );
    if (is_certain && min(min(d.x, d.y), d.z) < -bound && max(max(d.x, d.y), d.z) > bound) {
      continue;
    }
    let decision = decide_face(segment, face);
    if (decision == NOT_BETWEEN || is_on_face(segment, CLUSTER * cluster + index)) {
      continue;
    }
    if (decision == BETWEEN) {
      count += count_change(CLUSTER * cluster + index);
    } else {
      store_undecided(CLUSTER * cluster + index);
    }
  }
  return count;
}

// The same for the range. Ends early if too many are undecided: the count then has no meaning.
fn count_range(segment: Segment) -> i32 {
  var count = 0;
  // Turns: QUERY_GROUPS.
  for (var group = range.first; group < range.end; group += CLUSTER) {
    if (misses_box(segment, clusters[group].group_low, clusters[group].group_high)) {
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

// Lists a pair for which all faces of the range must be decided again.
fn list_pair(pair: u32) {
  let index = atomicAdd(&undecided_pairs.listed, 1u);
  undecided_pairs.pairs[index].recount = pair;
}

// Whether a polygon continues from earlier ranges into this one, and an odd number of its triangles lie between so far.
fn is_odd_before(pair: u32) -> bool {
  let polygon = polygon_of(CLUSTER * range.first);
  if (range.before == range.first || polygon == CLUSTER * range.first) {
    return false;
  }
  let state = undecided_pairs.pairs[pair].state;
  let bits = atomicLoad(&undecided_pairs.pairs[pair].face_0);
  let was_listed = (state & COUNT_MASK) > MOST_UNDECIDED;
  return select(state & ODD_AT_END, bits & polygon_bit(polygon, range.before), was_listed) != 0u;
}

@compute @workgroup_size(64)
fn shadow_depth(@builtin(global_invocation_id) id: vec3<u32>) {
  let pair = id.x;
  if (pair >= chunk.count * batch.count) {
    return;
  }
  let point_light = point_and_light(pair);
  var counted = 0;
  var state = 0u;
  if (is_finite(point_light.p_bits)) {
    var begins_with_odd = false;
    if (POLYGONS) {
      current_polygon = polygon_of(CLUSTER * range.first);
      is_current_odd = is_odd_before(pair);
      begins_with_odd = is_current_odd;
      undecided_polygons = vec3<u32>(0xffffffffu);
    }
    counted = count_range(segment_of(point_light));
    state = min(undecided, MOST_UNDECIDED + 1u);
    if (undecided > MOST_UNDECIDED) {
      counted = 0;
      undecided_faces.x = select(0u, 1u, begins_with_odd);
      list_pair(pair);
    } else if (POLYGONS) {
      // Only the polygon of the last face may continue after the range.
      enter_polygon(CLUSTER * range.end - 1u);
      let bits = select(vec3<u32>(0u), vec3<u32>(1u, 2u, 4u), is_undecided_odd);
      state |= ((bits.x | bits.y | bits.z) << FIRST_ODD_BIT) | select(0u, ODD_AT_END, is_current_odd);
    }
    if (range.is_first == 0u) {
      counted += atomicLoad(&depths[point_light.count_index]);
    }
  } else {
    counted = -1;
  }
  atomicStore(&depths[point_light.count_index], counted);
  undecided_pairs.pairs[pair].state = state;
  atomicStore(&undecided_pairs.pairs[pair].face_0, undecided_faces.x);
  undecided_pairs.pairs[pair].face_1 = undecided_faces.y;
  undecided_pairs.pairs[pair].face_2 = undecided_faces.z;
}
