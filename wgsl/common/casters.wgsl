// Casters of a scene (meshes that throw shadows), cones of lights, and `dot_3`, for stages of scenes, shadow volumes and
// outlines. A page is the buffers with the topology of many meshes. A group is the casters of a page whose masks lie
// together, because they read one buffer of positions. A slot is the index of a face or edge in these masks. src/layout.rs
// has the same structs, and a test compares them, CHUNK and LANES, but not the flags. src/gpu/scene/table.rs writes the
// casters; each encode (the recording of a frame) uploads them. `may_be_in_cone` returns false only for a box without a point
// in the cone: `cull_lights` and `needs` cull by it. Claim: docs/numerics/scene.md, "Cones of lights".

// Slots of a chunk, which all belong to one caster.
const CHUNK: u32 = 64u;
// Invocations that share a chunk.
const LANES: u32 = 8u;
// Flags of a caster.
const CLOSED: u32 = 1u; // Closed and consistently oriented: each edge has two faces that traverse it in opposite directions.
const MIRRORED: u32 = 2u; // Rigid, and its matrix mirrors.
const RIGID: u32 = 4u; // Its lights are moved to its mesh space, and its box is known.
const NON_FINITE: u32 = 8u; // Rigid, and a face with three different vertices has one that is not finite.
const EXCLUDES: u32 = 16u; // Faces are excluded on the CPU: by the caller, or as occluded faces.
const UNCACHED: u32 = 32u; // Its bits are computed in each encode: its positions may have changed, or it has polygons.
// A caster of the group has EXCLUDES. Each encode then writes the group's excluded masks anew, from the CPU's or as 0, so no
// bits of the group are cached.
const GROUP_EXCLUDES: u32 = 64u;
const PROXY: u32 = 128u; // It is not drawn into the depth buffer.
const BOUNDED: u32 = 256u; // Deforming, with a box in world space, from the caller or a pose. Without it: see `low`.
// The word after a scene's counts of silhouettes for 32 lights: not 0 if a light was in the plane of a face whose bits are
// cached.
const CACHED_ZEROS: u32 = 32u;

// A caster in the table of casters. `first_face` and `first_edge` are indices in the bound buffers of faces and edge
// records.
struct SceneCaster {
  // Rows of the matrix from mesh space to world space.
  row_0: vec4<f32>,
  row_1: vec4<f32>,
  row_2: vec4<f32>,
  // The box of the finite faces in mesh space (RIGID), or the stated box (BOUNDED). Low is above high if it is empty, but
  // also if the caster has neither flag: such a caster may be anywhere.
  low: vec3<f32>,
  // At most the smallest factor by which the matrix scales a length.
  scale: f32,
  high: vec3<f32>,
  // The flags above.
  flags: u32,
  first_face_slot: u32,
  faces: u32,
  first_face: u32,
  // The word of vertex 0 in the bound positions.
  position_offset: u32,
  first_edge_slot: u32,
  edges: u32,
  first_edge: u32,
  position_stride: u32, // Words from one vertex to the next.
  // The first encode with the caster in its present state, and the caster's group.
  version: u32,
  group: u32,
  first_caster: u32, // The first caster of the group.
  // For a rigid caster the word of the page's clusters where those of its mesh begin, or NO_CLUSTERS. For a deforming caster
  // that a frame may not need: its index among such casters, from 1. Otherwise 0.
  clusters_or_deforming_index: u32,
}

// A light's cone, in world space. `apex`: xyz; w 1, or 0 if the light has no cone, is at infinity, or may not cull by it.
// `axis`: xyz of length 1; w the cosine of the angle from the axis to the border.
struct LightCone {
  apex: vec4<f32>,
  axis: vec4<f32>,
}

// Sizes outside this range may overflow or underflow. `may_be_in_cone` then returns true.
const CONE_LARGEST: f32 = 0x1p60;
const CONE_LEAST: f32 = 0x1p-30;
// 512 units in the last place of the largest coordinate. Rounding needs less than a quarter of it.
const CONE_SLACK: f32 = 0x1p-14;

// The part of a vector at right angles to the axis, scaled to length 1.
fn across_axis(v: vec3<f32>, axis: vec3<f32>) -> vec3<f32> {
  let across = v - dot_3(v, axis) * axis;
  return across / sqrt(dot_3(across, across));
}

// Whether a box may have a point in the cone; false only if it has none. `low` and `high` may be rounded sums: `term_bound`
// is at least the size of each term, so that CONE_SLACK covers their rounding.
fn may_be_in_cone(cone: LightCone, low: vec3<f32>, high: vec3<f32>, term_bound: f32) -> bool {
  let axis = cone.axis.xyz;
  let cosine = cone.axis.w;
  let sizes = max(max(abs(low), abs(high)), abs(cone.apex.xyz));
  let size = max(max(max(sizes.x, sizes.y), sizes.z), term_bound);
  if (cone.apex.w == 0.0 || low.x > high.x || !(size < CONE_LARGEST) || size < CONE_LEAST) {
    return true;
  }
  let low_from_apex = low - cone.apex.xyz;
  let high_from_apex = high - cone.apex.xyz;
  if (cosine < 0.0) {
    // A cone wider than a half-space. Its outside is convex: it contains the box if it contains the corners.
    for (var corner_index = 0u; corner_index < 8u; corner_index++) {
      let corner = select(low_from_apex, high_from_apex, (vec3<u32>(corner_index) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
      if (!(dot_3(corner, axis) < cosine * sqrt(dot_3(corner, corner)) - CONE_SLACK * size)) {
        return true;
      }
    }
    return false;
  }
  // Tests for a separating plane through the apex. It touches the cone along the line nearest to the middle of the box. If
  // the apex is nearest to the middle, the plane is perpendicular to the direction to the middle.
  let middle = 0.5 * (low_from_apex + high_from_apex);
  let along = dot_3(middle, axis);
  let distance = sqrt(dot_3(middle, middle));
  let sine = sqrt((1.0 - cosine) * (1.0 + cosine));
  let off_axis = middle - along * axis;
  var direction = middle;
  if (!(dot_3(off_axis, off_axis) > 0x1p-20 * dot_3(middle, middle))) {
    // The middle is on the axis, or nearly: any plane that touches the cone will do.
    direction = select(vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(1.0, 0.0, 0.0), abs(axis.x) < 0.5);
  }
  let across = across_axis(across_axis(direction, axis), axis);
  let normal = select(cosine * across - sine * axis, middle / distance, along < -sine * distance);
  let smallest = min(normal * low_from_apex, normal * high_from_apex);
  return !(smallest.x + smallest.y + smallest.z > CONE_SLACK * size);
}

// Written out, to add products from x to z as callers' depth passes do (`CasterPositions::Rigid`). Devices may still fuse.
fn dot_3(a: vec3<f32>, b: vec3<f32>) -> f32 { return a.x * b.x + a.y * b.y + a.z * b.z; }
