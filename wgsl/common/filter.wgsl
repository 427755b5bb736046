// Bounds on the error of the f32 determinant; NUMERICS.md, "Filter".

// Ten units in the last place, 10 * 2^-23, and the most that underflow adds, 2^-115.
const RELATIVE: f32 = 0x1.4p-20;
const UNDERFLOW: f32 = 0x1p-115;
// The exponent bits of 2^40. A coordinate of this size or more could overflow the determinant.
const LARGE: u32 = 0x53800000u;
// The bits of infinity. NaNs are above.
const INFINITE: u32 = 0x7f800000u;

// The bits of the largest absolute coordinate. It is found on bits, because WGSL allows to assume that floats are
// finite.
fn largest_magnitude(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>) -> u32 {
  let signless = vec3<u32>(0x7fffffffu);
  let magnitudes = max(max(a & signless, b & signless), c & signless);
  return max(max(magnitudes.x, magnitudes.y), magnitudes.z);
}

// The most that underflow adds for a face whose coordinates are up to `largest`, for a light of size 1.
fn underflow_bound(largest: f32) -> f32 {
  let reach = max(2.0 * largest, 1.0);
  return UNDERFLOW * reach * reach;
}

// One bound for all lights of a batch. `size` is |u|1 |v|1. `largest` bounds the coordinates of the face. `reach` is
// the largest |x|, |y| or |z| of the lights, and their largest |w| or `inexact_w`.
fn face_bound(size: f32, largest: f32, reach: vec2<f32>) -> f32 {
  let to_light = reach.x + largest * reach.y;
  return (RELATIVE * to_light) * size + underflow_bound(largest) * (1.0 + to_light);
}
