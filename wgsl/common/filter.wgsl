// Bounds on the error of the f32 determinant; NUMERICS.md, "Filter".

// Ten units of the last place, 10 * 2^-23, and what underflow may add, 2^-115.
const RELATIVE: f32 = 0x1.4p-20;
const UNDERFLOW: f32 = 0x1p-115;
// Exponent bits of 2^40: a coordinate from there on could overflow the determinant.
const LARGE: u32 = 0x53800000u;
// Bits of infinity; NaNs lie above.
const INFINITE: u32 = 0x7f800000u;

// The bits of the largest absolute coordinate: decided on bits, since WGSL lets floats be assumed finite.
fn largest_magnitude(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>) -> u32 {
  let signless = vec3<u32>(0x7fffffffu);
  let magnitudes = max(max(a & signless, b & signless), c & signless);
  return max(max(magnitudes.x, magnitudes.y), magnitudes.z);
}

// What underflow may add for a face whose coordinates are up to `largest`, a unit of the light.
fn underflow_bound(largest: f32) -> f32 {
  let reach = max(2.0 * largest, 1.0);
  return UNDERFLOW * reach * reach;
}

// One bound for all lights of a word: `size` is |u|1 |v|1, `largest` bounds the face's coordinates, `reach` is the
// largest |x|, |y|, |z| of the lights and their largest |w| or `inexact_w`.
fn face_bound(size: f32, largest: f32, reach: vec2<f32>) -> f32 {
  let to_light = reach.x + largest * reach.y;
  return (RELATIVE * to_light) * size + underflow_bound(largest) * (1.0 + to_light);
}
