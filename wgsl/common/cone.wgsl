// The cones of spot lights. NUMERICS.md, "Cones of lights".

#import common/common

// What is larger or smaller may overflow or underflow, and nothing is said.
const CONE_LARGEST: f32 = 0x1p60;
const CONE_LEAST: f32 = 0x1p-30;
// 512 units in the last place of the largest coordinate. Less than a quarter is needed.
const CONE_SLACK: f32 = 0x1p-14;

fn cone_dot(a: vec3<f32>, b: vec3<f32>) -> f32 {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Of the length of a vector, the part across the axis, at length 1.
fn across_axis(v: vec3<f32>, axis: vec3<f32>) -> vec3<f32> {
  let across = v - cone_dot(v, axis) * axis;
  return across / sqrt(cone_dot(across, across));
}

// Whether a box may have a place in the cone. It is never false for one that has. No term of the box's ends is above `terms`.
fn may_be_in_cone(cone: LightCone, low: vec3<f32>, high: vec3<f32>, terms: f32) -> bool {
  let axis = cone.axis.xyz;
  let cosine = cone.axis.w;
  let sizes = max(max(abs(low), abs(high)), abs(cone.apex.xyz));
  let size = max(max(max(sizes.x, sizes.y), sizes.z), terms);
  if (cone.apex.w == 0.0 || low.x > high.x || !(size < CONE_LARGEST) || size < CONE_LEAST) {
    return true;
  }
  let begin = low - cone.apex.xyz;
  let end = high - cone.apex.xyz;
  if (cosine < 0.0) {
    // What is outside is convex, so it holds the box if it holds the corners.
    for (var number = 0u; number < 8u; number++) {
      let corner = select(begin, end, (vec3<u32>(number) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
      if (!(cone_dot(corner, axis) < cosine * sqrt(cone_dot(corner, corner)) - CONE_SLACK * size)) {
        return true;
      }
    }
    return false;
  }
  // A plane through the apex that has the cone on one side. It touches the cone where that is next to the middle of the box: along
  // a line, or at the apex.
  let middle = 0.5 * (begin + end);
  let along = cone_dot(middle, axis);
  let distance = sqrt(cone_dot(middle, middle));
  let sine = sqrt((1.0 - cosine) * (1.0 + cosine));
  let off = middle - along * axis;
  var guide = middle;
  if (!(cone_dot(off, off) > 0x1p-20 * cone_dot(middle, middle))) {
    // The middle is on the axis. Any plane will do.
    guide = select(vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(1.0, 0.0, 0.0), abs(axis.x) < 0.5);
  }
  let across = across_axis(across_axis(guide, axis), axis);
  let normal = select(cosine * across - sine * axis, middle / distance, along < -sine * distance);
  let least = min(normal * begin, normal * end);
  return !(least.x + least.y + least.z > CONE_SLACK * size);
}
