// Pairs of point and light as segments, and whether a segment misses a box, for `shadow_depth`, `exact_shadow_depth` and
// `exact_shadow_depth_recount`, which share these bindings; `depth_arguments` uses `range` and `undecided_pairs`. The index
// of a pair is the point's index in the dispatch times the lights of the batch, plus the light's. `misses_box` returns true
// only if certainly no face in the box lies between point and light: its margins must not shrink. docs/numerics/query.md.

#import common/determinant
#import common/extraction
#import query/records

@group(0) @binding(0) var<uniform> batch: LightBatch;
// The points of this dispatch. (It has nothing to do with the chunks of scenes.)
@group(0) @binding(1) var<uniform> chunk: PointChunk;
@group(0) @binding(6) var<uniform> range: FaceRange;
@group(0) @binding(7) var<storage, read> clusters: array<FaceCluster>;
@group(0) @binding(8) var<storage, read> points: array<u32>;
// The occluder counts, one for each light, point after point.
@group(0) @binding(9) var<storage, read_write> depths: array<atomic<i32>>;
@group(0) @binding(10) var<storage, read_write> undecided_pairs: UndecidedPairs;

// Whether to cull groups and clusters whose box the segment misses. Empty boxes are always culled. It changes no count.
override SKIP: bool = true;

// Whether points name the face that they are on.
override NAMES_FACES: bool = false;

// The segment from a point to a light, or the ray if the light is at infinity.
struct Segment {
  p_bits: vec3<u32>,
  // The index of the light in the batch.
  light: u32,
  p: vec3<f32>,
  // The bits of the largest absolute coordinate of p.
  largest: u32,
  // The direction to the light, l - w p, of the scaled light.
  d: vec3<f32>,
  // The largest component of `sizes`.
  size: f32,
  // |d| + inexact_w |p|, for bounds of errors (LightBatch).
  sizes: vec3<f32>,
  // Whether the coordinates of p are small enough for f32 to decide. Boxes and faces are tested, too.
  is_certain: bool,
  // |w|, or inexact_w if that is larger.
  w_size: f32,
  // The index in the mesh of the face that the point is on, which does not count, or NO_FACE.
  on_face: u32,
}

// A pair of point and light.
struct PointAndLight {
  // The index of its occluder count.
  count_index: u32,
  p_bits: vec3<u32>,
  light: u32,
  // The index in the mesh of the face that the point is on, or NO_FACE.
  on_face: u32,
}

// The pair of point and light with this index, which must be below `chunk.count * batch.count`.
fn point_and_light(index: u32) -> PointAndLight {
  let point = index / batch.count;
  let light = index % batch.count;
  let word = chunk.offset + point * chunk.stride;
  let bits = vec3<u32>(points[word], points[word + 1u], points[word + 2u]);
  var on_face = NO_FACE;
  if (NAMES_FACES) {
    on_face = points[word + chunk.on_face];
  }
  return PointAndLight(point * chunk.lights + chunk.first_light + light, bits, light, on_face);
}

fn segment_of(pair: PointAndLight) -> Segment {
  let p = bitcast<vec3<f32>>(pair.p_bits);
  let light = batch.lights[pair.light];
  let inexact_w = batch.inexact_w[pair.light / 4u][pair.light % 4u];
  let d = light.xyz - light.w * p;
  let sizes = abs(d) + inexact_w * abs(p);
  let largest = largest_magnitude(pair.p_bits, pair.p_bits, pair.p_bits);
  let size = max(max(sizes.x, sizes.y), sizes.z);
  let w_size = max(abs(light.w), inexact_w);
  return Segment(pair.p_bits, pair.light, p, largest, d, size, sizes, largest < LARGE, w_size, pair.on_face);
}

// Bounds of what rounding adds in a box test, relative to the size of the terms, and of what underflow adds.
const MARGIN: f32 = 0x1p-18;
const TINY: f32 = 0x1p-100;

// Whether certainly no face in a box lies between point and light. The words are those of FaceCluster. `low_bits.w`: the
// largest absolute coordinate; `high_bits.w`: whether any face can count.
fn misses_box(segment: Segment, low_bits: vec4<u32>, high_bits: vec4<u32>) -> bool {
  if (high_bits.w == 0u) {
    return true;
  }
  if (!SKIP || !segment.is_certain || low_bits.w >= LARGE) {
    return false;
  }
  let low = bitcast<vec3<f32>>(low_bits.xyz);
  let high = bitcast<vec3<f32>>(high_bits.xyz);
  // The box is before both ends along an axis, or beyond both (w is not negative). Rounding keeps the signs of `to_low` and
  // `to_high`, but a device may flush one operand and not the other.
  let light = batch.lights[segment.light];
  let to_low = low - segment.p;
  let to_high = high - segment.p;
  let light_low = light.w * low;
  let light_high = light.w * high;
  let low_margin = MARGIN * (segment.w_size * abs(low) + abs(light.xyz)) + TINY;
  let high_margin = MARGIN * (segment.w_size * abs(high) + abs(light.xyz)) + TINY;
  let is_before = (to_high < vec3<f32>(-TINY)) & (light_high - light.xyz < -high_margin);
  let is_beyond = (to_low > vec3<f32>(TINY)) & (light_low - light.xyz > low_margin);
  if (any(is_before | is_beyond)) {
    return true;
  }
  // The line passes beside the box, seen along an axis.
  let middle = 0.5 * (to_low + to_high);
  let half_size = 0.5 * (to_high - to_low);
  let extent = half_size + MARGIN * (half_size + abs(middle)) + TINY;
  let size = segment.sizes + TINY;
  let distance = abs(middle.yzx * segment.d.zxy - middle.zxy * segment.d.yzx);
  return any(distance > extent.yzx * size.zxy + extent.zxy * size.yzx + UNDERFLOW);
}
