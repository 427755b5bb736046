// A cube of six maps: which samples of two or three maps lie on the same ray. Directions are integers, so this is exact.

#import depth_map/samples

// A face of the cube looks along an axis, and has one to its right and one up.
struct CubeFace {
  forward: vec3<i32>,
  right: vec3<i32>,
  up: vec3<i32>,
}

fn cube_face(face: u32) -> CubeFace {
  let sign = 1 - 2 * i32(face & 1u);
  switch face >> 1u {
    case 0u: {
      return CubeFace(vec3<i32>(sign, 0, 0), vec3<i32>(0, 0, sign), vec3<i32>(0, 1, 0));
    }
    case 1u: {
      return CubeFace(vec3<i32>(0, sign, 0), vec3<i32>(1, 0, 0), vec3<i32>(0, 0, sign));
    }
    default: {
      return CubeFace(vec3<i32>(0, 0, sign), vec3<i32>(-sign, 0, 0), vec3<i32>(0, 1, 0));
    }
  }
}

fn product(a: vec3<i32>, b: vec3<i32>) -> i32 {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The direction of a sample. Its largest component is the number of cells along a side, and a face has all samples whose
// component along it is as large.
fn direction_of(face: u32, at: vec2<u32>) -> vec3<i32> {
  let axes = cube_face(face);
  let most = i32(depth_map.size.x) - 1;
  return most * axes.forward + (2 * i32(at.x) - most) * axes.right + (most - 2 * i32(at.y)) * axes.up;
}

fn has_direction(face: u32, direction: vec3<i32>) -> bool {
  return product(cube_face(face).forward, direction) == i32(depth_map.size.x) - 1;
}

fn sample_of(face: u32, direction: vec3<i32>) -> vec2<u32> {
  let axes = cube_face(face);
  let most = i32(depth_map.size.x) - 1;
  return vec2<u32>(
    u32((most + product(direction, axes.right)) / 2), u32((most - product(direction, axes.up)) / 2));
}
