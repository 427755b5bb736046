// The determinant det[b - a, c - a, l - w a] in f32, for a face (a, b, c) and a homogeneous light (l, w). It is positive if
// the light is on the counter-clockwise side of the face. The local form computes it from differences, the plane form from
// the face's plane. Stages of extraction, polygons and queries import it. Also a bound on the error of the local form. If
// |determinant| exceeds the bound, its sign is exact on every device; callers that need exact signs pass other cases to
// common/exact_sign.wgsl. The plane form has no bound here, and its signs are never exact. Bounds hold for exactly these
// operations and for coordinates below LARGE. Claims: docs/numerics/facing.md, "Error band", "Per edge" and "Filter".

// Whether `facing` and `per_edge` compute the plane form, as published in 2003, instead of the local form.
override PLANE: bool = false;

// u x v. For b - a and c - a it is the normal on the counter-clockwise side.
fn cross_product(u: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
  return vec3<f32>(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
}

fn sum_of_sizes(v: vec3<f32>) -> f32 { return abs(v.x) + abs(v.y) + abs(v.z); }

// The largest absolute component.
fn largest_of(v: vec3<f32>) -> f32 { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }

// n . (l - w a). The bounds below hold only if `light` is scaled as in LightBatch.
fn local_form(n: vec3<f32>, a: vec3<f32>, light: vec4<f32>) -> f32 {
  let to_light = light.xyz - light.w * a;
  return n.x * to_light.x + n.y * to_light.y + n.z * to_light.z;
}

// The plane through a with normal n.
fn plane_through(n: vec3<f32>, a: vec3<f32>) -> vec4<f32> {
  return vec4<f32>(n, -(n.x * a.x + n.y * a.y + n.z * a.z));
}

// n . l + w e, for the light as given.
fn plane_form(plane: vec4<f32>, light: vec4<f32>) -> f32 {
  return plane.x * light.x + plane.y * light.y + plane.z * light.z + plane.w * light.w;
}

// The bound has two parts: a share of the size of the terms, ten units in the last place, 10 * 2^-23; and what underflow
// adds, 2^-115 times the factors in `underflow_bound`.
const RELATIVE: f32 = 0x1.4p-20;
const UNDERFLOW: f32 = 0x1p-115;
// The bits of 2^40. A coordinate of this size or more could overflow the determinant.
const LARGE: u32 = 0x53800000u;
const INFINITE: u32 = 0x7f800000u; // The bits of infinity. NaNs are above.

// The bits of the largest absolute coordinate. It is found on bits, because WGSL allows to assume that floats are finite.
fn largest_magnitude(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>) -> u32 {
  let signless = vec3<u32>(0x7fffffffu);
  let magnitudes = max(max(a & signless, b & signless), c & signless);
  return max(max(magnitudes.x, magnitudes.y), magnitudes.z);
}

// The most that underflow adds to the error for a face with coordinates up to `largest`, but for a factor. Callers multiply
// it by 1 + s, where s is at least the largest component of |l - w a|.
fn underflow_bound(largest: f32) -> f32 {
  let span = max(2.0 * largest, 1.0);
  return UNDERFLOW * span * span;
}

// One bound for all lights of a batch. `size`: `sum_of_sizes` of b - a times that of c - a. `largest`: the largest absolute
// coordinate of the face. `light_magnitudes`: LightBatch.magnitudes, the largest |x|, |y| or |z|, and the largest |w| or
// inexact_w.
fn face_bound(size: f32, largest: f32, light_magnitudes: vec2<f32>) -> f32 {
  let to_light = light_magnitudes.x + largest * light_magnitudes.y;
  return (RELATIVE * to_light) * size + underflow_bound(largest) * (1.0 + to_light);
}
