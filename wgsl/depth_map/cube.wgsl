// Six depth maps around a light: which samples of two or three of them lie on one ray. Imported by `depth_cube`, which gives such
// samples one depth, and by surface.wgsl (draws), which gives them one vertex, so the boundary of shadow closes across the maps.
// Maps 0 to 5 look along +x, -x, +y, -y, +z, -z. The middles of a map's outermost texels lie on the edges of the cube.
// Importers bind `depth_map` with six square maps. `at` is a sample within its map, from (0, 0) on.
// Directions are integers, so all is exact. Axes are those of src/gpu/depth_map/meeting.rs, which makes cameras: keep both alike.

#import depth_map/samples

// The axes of a map: along its view, to its right, and up.
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

// The direction of a sample from the light. The size of its largest component is the number of cells along a side of the map.
fn direction_of(face: u32, at: vec2<u32>) -> vec3<i32> {
  let axes = cube_face(face);
  let most = i32(depth_map.size.x) - 1;
  return most * axes.forward + (2 * i32(at.x) - most) * axes.right + (most - 2 * i32(at.y)) * axes.up;
}

// Whether a map has a sample in the direction of a sample: its component along the map's view is the largest possible.
fn has_direction(face: u32, direction: vec3<i32>) -> bool {
  return product(cube_face(face).forward, direction) == i32(depth_map.size.x) - 1;
}

// The sample that a map has in a direction. `has_direction` must hold.
fn sample_of(face: u32, direction: vec3<i32>) -> vec2<u32> {
  let axes = cube_face(face);
  let most = i32(depth_map.size.x) - 1;
  return vec2<u32>(
    u32((most + product(direction, axes.right)) / 2), u32((most - product(direction, axes.up)) / 2));
}
