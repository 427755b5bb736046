// The turns at the four corners of a quadrilateral or triangle as `f32` computes them, for four lights at once, and a bound on
// their errors. For `polygon_facing` and `polygon_turns`. The turn at a corner is the sign of the determinant of the corner
// before, it and the one after, as a light sees them: positive for counter-clockwise. A turn counts only where its size is above
// `bound` and `is_certain` holds; callers must leave the others to exact stages. docs/numerics/polygons.md, "Four turns".

#import common/determinant
#import common/positions
#import extract/one_caster
#import polygon/outlines

// Where edge `edge` of `outlines` begins.
fn vertex_of(edge: u32) -> vec3<u32> {
  return position_bits(outlines[edge].x, position_offset(), position_stride());
}

// A quadrilateral a, b, c, d: for each corner the normal of it and its neighbours, from which its turns follow.
struct Quad {
  a: vec3<f32>,
  c: vec3<f32>, // For a triangle a.
  normals: mat4x3<f32>,
  bound: f32, // On the errors of all turns for all lights.
  // Whether f32 may decide.
  is_certain: bool,
}

// The outline must be one loop of three or four edges. A triangle has the same turn at all corners.
fn quad_of(outline: OutlineRange) -> Quad {
  let is_triangle = outline.count == 3u;
  let a_bits = vertex_of(outline.first);
  let b_bits = vertex_of(outline.first + 1u);
  let c_bits = vertex_of(outline.first + 2u);
  let d_bits = vertex_of(outline.first + select(3u, 2u, is_triangle));
  let magnitude = max(largest_magnitude(a_bits, b_bits, c_bits), largest_magnitude(d_bits, d_bits, d_bits));
  let a = bitcast<vec3<f32>>(a_bits);
  let c = bitcast<vec3<f32>>(c_bits);
  let ab = bitcast<vec3<f32>>(b_bits) - a;
  let ac = c - a;
  let ad = bitcast<vec3<f32>>(d_bits) - a;
  let cd = bitcast<vec3<f32>>(d_bits) - c;
  let cb = bitcast<vec3<f32>>(b_bits) - c;
  // At corner 0 the turn of d, a, b; at 1 that of a, b, c; at 2 that of b, c, d; at 3 that of c, d, a.
  let n_1 = cross_product(ab, ac);
  let n_0 = cross_product(ab, ad);
  let n_2 = select(cross_product(cd, cb), n_1, is_triangle);
  let n_3 = select(cross_product(ac, ad), n_1, is_triangle);
  let sizes = vec4<f32>(sum_of_sizes(ab) * sum_of_sizes(ad), sum_of_sizes(ab) * sum_of_sizes(ac),
    sum_of_sizes(cd) * sum_of_sizes(cb), sum_of_sizes(ac) * sum_of_sizes(ad));
  let size = max(max(sizes.x, sizes.y), max(sizes.z, sizes.w));
  let bound = face_bound(size, bitcast<f32>(magnitude), lights_reach());
  return Quad(a, select(c, a, is_triangle), mat4x3<f32>(n_0, n_1, n_2, n_3), bound, magnitude < LARGE);
}

// The determinants at the four corners (columns) for the lights `place` to `place + 3` (rows).
fn turns_of(quad: Quad, place: u32) -> mat4x4<f32> {
  let lights = transpose(
    mat4x4<f32>(scaled_light(place), scaled_light(place + 1u), scaled_light(place + 2u), scaled_light(place + 3u)));
  let a = quad.a;
  let c = quad.c;
  let n = quad.normals;
  let from_a = mat3x4<f32>(lights[0] - lights[3] * a.x, lights[1] - lights[3] * a.y, lights[2] - lights[3] * a.z);
  let from_c = mat3x4<f32>(lights[0] - lights[3] * c.x, lights[1] - lights[3] * c.y, lights[2] - lights[3] * c.z);
  return mat4x4<f32>(
    n[0].x * from_a[0] + n[0].y * from_a[1] + n[0].z * from_a[2],
    n[1].x * from_a[0] + n[1].y * from_a[1] + n[1].z * from_a[2],
    n[2].x * from_c[0] + n[2].y * from_c[1] + n[2].z * from_c[2],
    n[3].x * from_a[0] + n[3].y * from_a[1] + n[3].z * from_a[2],
  );
}

// One bit for each of four lights.
const FOUR_BITS: vec4<u32> = vec4<u32>(1u, 2u, 4u, 8u);

fn bits_of(lights: vec4<bool>) -> vec4<u32> {
  return select(vec4<u32>(0u), FOUR_BITS, lights);
}

// The four bits as one number.
fn together(bits: vec4<u32>) -> u32 {
  return bits.x | bits.y | bits.z | bits.w;
}
