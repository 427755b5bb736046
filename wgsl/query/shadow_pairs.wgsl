// Decides with f32 and error bounds whether a face lies between a point and a light, and finds the polygon of a face. For
// `shadow_depth`, `exact_shadow_depth` and `exact_shadow_depth_recount`. `decide_face` returns BETWEEN or NOT_BETWEEN only
// if exact arithmetic agrees; callers must decide UNDECIDED faces exactly. A polygon is identified by the face index of its
// first triangle (query/records.wgsl). Claim: docs/numerics/query.md.

#import common/determinant
#import common/positions
#import query/records
#import query/shadow_segments

// The most undecided faces that are stored for a pair of point and light.
const MOST_UNDECIDED: u32 = 3u;
// Parts of `UndecidedFaces.state`: the mask of the count, the index of the first of three bits, the mask of the last bit.
const COUNT_MASK: u32 = 7u;
const FIRST_ODD_BIT: u32 = 3u;
const ODD_AT_END: u32 = 64u;

// A bound on the error of det[u, v, t] in f32. `uv`: the product of `sum_of_sizes` of u and v. `t`: the largest absolute
// component of t; for t = l - w x that of |t| + inexact_w |x|. `underflow`: `underflow_bound` of the coordinates of face and
// point.
fn determinant_bound(uv: f32, t: f32, underflow: f32) -> f32 {
  return (RELATIVE * t) * uv + underflow * (1.0 + 3.0 * t);
}

// The sign of a value with an error of up to `bound`, or 0 if the sign is not certain.
fn certain_sign(d: f32, bound: f32) -> i32 {
  return select(0, 1, d > bound) - select(0, 1, d < -bound);
}

// The vertices of a face and the bits of their positions.
struct Face {
  corners: vec3<u32>,
  a: vec3<u32>,
  b: vec3<u32>,
  c: vec3<u32>,
}

// The face with a face index.
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

// Whether the point names this face as the one that it is on. Such a face does not count.
fn is_on_face(segment: Segment, index: u32) -> bool {
  return NAMES_FACES && clusters[index / CLUSTER].first_face + index % CLUSTER == segment.on_face;
}

// Whether any polygon of the mesh has several triangles. Those of a polygon that lie between count 1 and -1 alternately, so
// that the polygon counts once if their number is odd.
override POLYGONS: bool = false;

// The face index of the first triangle of a face's polygon. It has no loop: a polygon may have any number of triangles.
fn polygon_of(index: u32) -> u32 {
  let cluster = index / CLUSTER;
  // The faces of the cluster that begin a polygon, up to this one.
  let begins = ~clusters[cluster].continues & (0xffffffffu >> (CLUSTER - 1u - index % CLUSTER));
  if (begins == 0u) {
    return clusters[cluster].head;
  }
  return CLUSTER * cluster + firstLeadingBit(begins);
}

// The mask, in `UndecidedFaces.face_0`, of the polygon that begins at `polygon` and continues after its group. Only the last
// polygon that begins in a group can do so. `first` is the first cluster of the range. Bit 0 is for a polygon that begins
// before the range.
fn polygon_bit(polygon: u32, first: u32) -> u32 {
  let begin = CLUSTER * first;
  return select(1u, 2u << ((max(polygon, begin) - begin) / (CLUSTER * CLUSTER)), polygon >= begin);
}

const NOT_BETWEEN: u32 = 0u;
const BETWEEN: u32 = 1u;
const UNDECIDED: u32 = 2u;

// For each edge the f32 determinant whose sign tells on which side of the edge the line to the light passes.
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

// Decides a face, or returns UNDECIDED if too few determinants exceed their bounds. `largest`: the bits of the largest
// absolute coordinate of face and point, below LARGE.
fn decide_by_bounds(segment: Segment, face: Face, largest: u32) -> u32 {
  let a = bitcast<vec3<f32>>(face.a);
  let b = bitcast<vec3<f32>>(face.b);
  let c = bitcast<vec3<f32>>(face.c);
  let underflow = underflow_bound(bitcast<f32>(largest));
  let d = edge_determinants(segment, a, b, c);
  let ab_bound = determinant_bound(sum_of_sizes(b - a) * sum_of_sizes(segment.p - a), segment.size, underflow);
  let bc_bound = determinant_bound(sum_of_sizes(c - b) * sum_of_sizes(segment.p - b), segment.size, underflow);
  let ca_bound = determinant_bound(sum_of_sizes(a - c) * sum_of_sizes(segment.p - c), segment.size, underflow);
  let ab = certain_sign(d.x, ab_bound);
  let bc = certain_sign(d.y, bc_bound);
  let ca = certain_sign(d.z, ca_bound);
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
  let point_side = certain_sign(n.x * t.x + n.y * t.y + n.z * t.z, determinant_bound(uv, largest_of(t), underflow));
  let light = batch.lights[segment.light];
  let to_light = light.xyz - light.w * a;
  let inexact_w = batch.inexact_w[segment.light / 4u][segment.light % 4u];
  let light_size = largest_of(abs(to_light) + inexact_w * abs(a));
  let light_bound = determinant_bound(uv, light_size, underflow);
  let light_side = certain_sign(n.x * to_light.x + n.y * to_light.y + n.z * to_light.z, light_bound);
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

// Whether the bits alone show that the point or the light is in the plane of the face. They do for a point at a corner, for
// a point or light at w = 1 with one coordinate in common with all corners, and for a light at infinity that is 0 along an
// axis on which all corners agree. If it returns false, either may still be in the plane.
fn is_plainly_coplanar(segment: Segment, face: Face) -> bool {
  if (all(segment.p_bits == face.a) || all(segment.p_bits == face.b) || all(segment.p_bits == face.c)) {
    return true;
  }
  let is_flat = (face.a == face.b) & (face.a == face.c);
  let light = batch.light_bits[segment.light];
  let is_zero = (light.xyz & vec3<u32>(0x7fffffffu)) == vec3<u32>(0u);
  let is_light_level = select(vec3<bool>(false), is_zero, (light.w & 0x7fffffffu) == 0u) |
    select(vec3<bool>(false), light.xyz == face.a, light.w == ONE);
  return any(is_flat & ((segment.p_bits == face.a) | is_light_level));
}

// Decides a face, or returns UNDECIDED if exact arithmetic is needed. Callers also test `is_on_face`.
fn decide_face(segment: Segment, face: Face) -> u32 {
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
  if (decision == UNDECIDED && is_plainly_coplanar(segment, face)) {
    return NOT_BETWEEN;
  }
  return decision;
}
