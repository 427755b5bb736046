// Decides with `f32` bounds whether a face lies between a point and a light, and finds the polygon of a face. For
// `shadow_depth`, `exact_shadow_depth` and `exact_shadow_depth_recount`. `decide` says BETWEEN or NOT_BETWEEN only where
// exact arithmetic must agree; callers must settle UNDECIDED faces exactly. The polygon of a face is told by its head, the
// place of its first triangle. A place is 32 times the cluster plus the face's number in it, and counts from the first
// cluster that is bound. docs/numerics/query.md.

#import common/determinant
#import common/positions
#import query/records
#import query/shadow_segments

// The largest number of undecided faces that are noted for a pair of point and light.
const MOST_UNDECIDED: u32 = 3u;
// Parts of `UndecidedFaces.state`: the mask of the count, the number of the first of three bits, the mask of the last bit.
const COUNT_MASK: u32 = 7u;
const ODD_FACES: u32 = 3u;
const ODD_AT_END: u32 = 64u;

// The sign of d = det[u, v, t], given `uv`, the product of the sums of sizes of u and v, and `t`, the largest size in t. 0
// if the sign is not certain.
fn certain_sign(d: f32, uv: f32, t: f32, underflow: f32) -> i32 {
  let bound = (RELATIVE * t) * uv + underflow * (1.0 + 3.0 * t);
  return select(0, 1, d > bound) - select(0, 1, d < -bound);
}

// The vertices of a face and the bits of their positions.
struct Face {
  corners: vec3<u32>,
  a: vec3<u32>,
  b: vec3<u32>,
  c: vec3<u32>,
}

// The face at a place.
fn face_of(index: u32) -> Face {
  let cluster = index / CLUSTER;
  let first = 3u * (index % CLUSTER);
  var face: Face;
  face.corners = vec3<u32>(
    clusters[cluster].corners[first],
    clusters[cluster].corners[first + 1u],
    clusters[cluster].corners[first + 2u],
  );
  face.a = position_bits(face.corners.x, batch.position_offset, batch.position_stride);
  face.b = position_bits(face.corners.y, batch.position_offset, batch.position_stride);
  face.c = position_bits(face.corners.z, batch.position_offset, batch.position_stride);
  return face;
}

// Whether the point names this face as the one that it is on. It does not count then.
fn is_named(segment: Segment, index: u32) -> bool {
  return NAMES_FACES && clusters[index / CLUSTER].first_face + index % CLUSTER == segment.on_face;
}

// Whether a polygon of the mesh has several triangles. The triangles of a polygon that are between count 1 and -1 in turn,
// so that it counts once if they are odd in number.
override POLYGONS: bool = false;

// The place of the first triangle of the polygon of a face. It has no loop: a polygon may have any number of triangles.
fn head_of(index: u32) -> u32 {
  let cluster = index / CLUSTER;
  // The faces of the cluster, up to this one, with which a polygon begins.
  let begins = ~clusters[cluster].continues & (0xffffffffu >> (CLUSTER - 1u - index % CLUSTER));
  if (begins == 0u) {
    return clusters[cluster].head;
  }
  return CLUSTER * cluster + firstLeadingBit(begins);
}

// The mask, in `UndecidedFaces.face_0`, of the polygon that begins at `head` and goes on behind its group of clusters. At
// most one polygon that begins in a group does. `first` is the first cluster of the range; bit 0 is for a polygon that
// begins before it.
fn odd_bit(head: u32, first: u32) -> u32 {
  let begin = CLUSTER * first;
  return select(1u, 2u << ((max(head, begin) - begin) / (CLUSTER * CLUSTER)), head >= begin);
}

const NOT_BETWEEN: u32 = 0u;
const BETWEEN: u32 = 1u;
const UNDECIDED: u32 = 2u;

// For each edge the determinant whose sign says on which side of it the line to the light passes, as f32 computes it.
fn edge_determinants(segment: Segment, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
  let at_a = cross_product(segment.p - a, segment.d);
  let at_b = cross_product(segment.p - b, segment.d);
  let at_c = cross_product(segment.p - c, segment.d);
  let u = b - a;
  let v = c - b;
  let t = a - c;
  return vec3<f32>(
    u.x * at_a.x + u.y * at_a.y + u.z * at_a.z,
    v.x * at_b.x + v.y * at_b.y + v.z * at_b.z,
    t.x * at_c.x + t.y * at_c.y + t.z * at_c.z,
  );
}

// Decides by the bound of each determinant.
fn decide_by_bounds(segment: Segment, face: Face, largest: u32) -> u32 {
  let a = bitcast<vec3<f32>>(face.a);
  let b = bitcast<vec3<f32>>(face.b);
  let c = bitcast<vec3<f32>>(face.c);
  let underflow = underflow_bound(bitcast<f32>(largest));
  let d = edge_determinants(segment, a, b, c);
  let ab = certain_sign(d.x, sum_of_sizes(b - a) * sum_of_sizes(segment.p - a), segment.size, underflow);
  let bc = certain_sign(d.y, sum_of_sizes(c - b) * sum_of_sizes(segment.p - b), segment.size, underflow);
  let ca = certain_sign(d.z, sum_of_sizes(a - c) * sum_of_sizes(segment.p - c), segment.size, underflow);
  let highest = max(max(ab, bc), ca);
  let lowest = min(min(ab, bc), ca);
  if (highest > 0 && lowest < 0) {
    return NOT_BETWEEN;
  }
  let u = b - a;
  let v = c - a;
  let n = cross_product(u, v);
  let uv = sum_of_sizes(u) * sum_of_sizes(v);
  let t = segment.p - a;
  let point_side = certain_sign(n.x * t.x + n.y * t.y + n.z * t.z, uv, largest_of(t), underflow);
  let light = batch.lights[segment.light];
  let s = light.xyz - light.w * a;
  let inexact_w = batch.inexact_w[segment.light / 4u][segment.light % 4u];
  let s_size = largest_of(abs(s) + inexact_w * abs(a));
  let light_side = certain_sign(n.x * s.x + n.y * s.y + n.z * s.z, uv, s_size, underflow);
  if (point_side * light_side > 0) {
    return NOT_BETWEEN;
  }
  if (point_side * light_side < 0 && highest == lowest && highest == light_side) {
    return BETWEEN;
  }
  return UNDECIDED;
}

// The bits of 1.0.
const ONE: u32 = 0x3f800000u;

// Whether point or light is in the plane of the face, without arithmetic: at a corner, or with a face that is flat
// along an axis.
fn is_coplanar(segment: Segment, face: Face) -> bool {
  if (all(segment.p_bits == face.a) || all(segment.p_bits == face.b) || all(segment.p_bits == face.c)) {
    return true;
  }
  let flat = (face.a == face.b) & (face.a == face.c);
  let light = batch.light_bits[segment.light];
  let is_level = (light.xyz & vec3<u32>(0x7fffffffu)) == vec3<u32>(0u);
  let light_at = select(vec3<bool>(false), is_level, (light.w & 0x7fffffffu) == 0u) |
    select(vec3<bool>(false), light.xyz == face.a, light.w == ONE);
  return any(flat & ((segment.p_bits == face.a) | light_at));
}

// Decides about a face as far as bounds can.
fn decide(segment: Segment, face: Face) -> u32 {
  let largest = largest_magnitude(face.a, face.b, face.c);
  let is_degenerate =
    face.corners.x == face.corners.y || face.corners.y == face.corners.z || face.corners.z == face.corners.x;
  if (is_degenerate || largest >= INFINITE) {
    return NOT_BETWEEN;
  }
  var decision = UNDECIDED;
  if (segment.is_certain && largest < LARGE) {
    decision = decide_by_bounds(segment, face, max(largest, segment.largest));
  }
  if (decision == UNDECIDED && is_coplanar(segment, face)) {
    return NOT_BETWEEN;
  }
  return decision;
}
