// Depth maps that are made from a caller's: three stages, each one invocation a texel of the result, dispatched before the
// stages and draws that read the result as `depth_texture`. `depth_metric` converts distances; `depth_merge` takes the nearer
// of two maps of one camera; `depth_cube` puts the six maps around a light into one texture. Results have depths from 0 to 1,
// none subnormal or NaN, and the far end where nothing casts. Sizes and keys (integers that grow with the distance from the
// light): samples.wgsl.

#import depth_map/samples

// Stage `depth_metric`: makes a depth map from distances to a light, as ray marching and range images have them. Dispatched by
// `DepthMapConversion::encode`. Reads distances and `metric_view`. Writes a texture of `r32float` with the device depths of
// the light's camera.
// It computes in floats, within a bound: `metric_steps` in src/gpu/depth_map/metric.rs, by which draws move the boundary of
// shadow. Keep the operations of `distance_key` and their order: docs/numerics/depth-maps.md, "Maps of distances", derives the
// bound from them.

struct DepthMetricView {
  // How the ray through a texel changes for each step across, and for each step down: a step is half a texel. Its component
  // along the light's axis is 1. w: how much the nearness at infinity changes (1 at the near plane, 0 at the far end).
  across: vec4<f32>,
  down: vec4<f32>,
  // The ray in the middle. w is 0.
  middle: vec4<f32>,
  // The far distance in two parts. Without a far plane, what nearness times distance is.
  head: f32,
  rest: f32,
  // 1: there is a far plane.
  has_far: f32,
  scale: f32,
  // Distances are clamped to this range. From the larger one on, nothing casts.
  least: f32,
  most: f32,
  // 0: texels hold device depths. 1: distances along the axis of view, or along parallel rays. 2: distances along rays that
  // meet at the light.
  metric: u32,
  // 1: depth is linear in the distance.
  is_parallel: u32,
}

@group(0) @binding(2) var<uniform> metric_view: DepthMetricView;
@group(0) @binding(3) var converted_texture: texture_storage_2d<r32float, write>;

const BLOCK: u32 = 256u;
const INFINITE: u32 = 0x7f800000u;

// The length of the ray through a texel for each unit along the light's axis. `steps`: half texels from the middle of the map.
fn ray_length(steps: vec2<f32>) -> f32 {
  let ray = metric_view.across.xyz * steps.x + metric_view.down.xyz * steps.y + metric_view.middle.xyz;
  return sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z);
}

// The key (samples.wgsl) of a distance. Signs, infinity and NaN are told by bits, because a device may assume that there are
// none.
fn distance_key(bits: u32, steps: vec2<f32>) -> u32 {
  let size = bits & 0x7fffffffu;
  let is_behind = (bits >> 31u) == 1u;
  let is_nothing = (size > INFINITE) | (!is_behind & (size == INFINITE));
  var distance = bitcast<f32>(select(size, 0u, is_nothing | is_behind));
  if (metric_view.metric == 2u) {
    distance = distance / ray_length(steps);
  }
  let is_far = is_nothing | (distance >= metric_view.most);
  let along = clamp(distance, metric_view.least, metric_view.most);
  let to_far = (metric_view.head - metric_view.has_far * along) + metric_view.rest;
  let scaled = metric_view.scale * to_far / select(along, 1.0, metric_view.is_parallel != 0u);
  let tilt = metric_view.across.w * steps.x + metric_view.down.w * steps.y;
  // 1 at the near plane and 0 at the far end.
  let nearness = scaled + tilt;
  let depth = select(1.0 - nearness, nearness, depth_map.is_reversed != 0u);
  return select(sample_key(bitcast<u32>(depth)), FAR_KEY, is_far);
}

// A workgroup takes further blocks only where the device may not have a workgroup for each.
@compute @workgroup_size(BLOCK)
fn depth_metric(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  // Turns: 1.
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let texel = block * BLOCK + local;
    let at = vec2<u32>(texel % depth_map.size.x, texel / depth_map.size.x);
    if (at.y < depth_map.size.y) {
      let bits = bitcast<u32>(textureLoad(depth_texture, at, 0).x);
      let steps = vec2<f32>(2 * vec2<i32>(at) + 1 - vec2<i32>(depth_map.size));
      var key = sample_key(bits);
      if (metric_view.metric != 0u) {
        key = distance_key(bits, steps);
      }
      textureStore(converted_texture, at, vec4<f32>(bitcast<f32>(depth_bits_or_far(key)), 0.0, 0.0, 0.0));
    }
  }
}

// Stage `depth_merge`: for each texel the nearer of two depths, of two maps that one camera of a light made. Dispatched by
// `DepthMapMerge::encode`. Reads both maps, of any depth format. Writes a texture of `r32float` with the depth of the smaller
// key, and the far end where nothing casts in either map.
// Integers decide, so the choice is exact. A texel of the result has the very key that it was made from.

@group(0) @binding(2) var second_texture: texture_2d<f32>;
@group(0) @binding(3) var merged_texture: texture_storage_2d<r32float, write>;

// A workgroup takes further blocks only where the device may not have a workgroup for each.
@compute @workgroup_size(BLOCK)
fn depth_merge(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  // Turns: 1.
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let texel = block * BLOCK + local;
    let at = vec2<u32>(texel % depth_map.size.x, texel / depth_map.size.x);
    if (at.y < depth_map.size.y) {
      let first = load_key(at + 1u);
      let second = sample_key(bitcast<u32>(textureLoad(second_texture, at, 0).x));
      textureStore(merged_texture, at, vec4<f32>(bitcast<f32>(depth_bits_or_far(min(first, second))), 0.0, 0.0, 0.0));
    }
  }
}

// Stage `depth_cube`: puts the six depth maps around a light into one texture, three in a row. First dispatch of each encode of
// `DepthMapCube`.
// Reads six depth textures, and six of objects if OBJECTS. A map of another size, such as one texel, is not there and casts
// nothing. Writes `cube_texture` and `cube_objects`, which all later stages and draws have as `depth_texture` and
// `object_texture`; no object is written where nothing casts.
// Samples of maps that lie on one ray (samples.wgsl) get the nearest of their depths and the object of the first map that has
// it, so cells of both maps at an edge of the cube decide from the same samples. Keys, which are integers, decide.

@group(0) @binding(2) var texture_1: texture_2d<f32>;
@group(0) @binding(3) var texture_2: texture_2d<f32>;
@group(0) @binding(4) var texture_3: texture_2d<f32>;
@group(0) @binding(5) var texture_4: texture_2d<f32>;
@group(0) @binding(6) var texture_5: texture_2d<f32>;
@group(0) @binding(7) var cube_texture: texture_storage_2d<r32float, write>;

@group(0) @binding(8) var objects_0: texture_2d<u32>;
@group(0) @binding(9) var objects_1: texture_2d<u32>;
@group(0) @binding(10) var objects_2: texture_2d<u32>;
@group(0) @binding(11) var objects_3: texture_2d<u32>;
@group(0) @binding(12) var objects_4: texture_2d<u32>;
@group(0) @binding(13) var objects_5: texture_2d<u32>;
@group(0) @binding(14) var cube_objects: texture_storage_2d<r32uint, write>;

// Whether there are objects.
override OBJECTS: bool = true;

// The key of a texel of a map: an integer that grows with the distance from the light.
fn loaded(map: texture_2d<f32>, at: vec2<u32>) -> u32 {
  if (any(textureDimensions(map) != depth_map.size)) {
    return FAR_KEY;
  }
  return sample_key(bitcast<u32>(textureLoad(map, at, 0).x));
}

fn key_of_face(face: u32, at: vec2<u32>) -> u32 {
  switch face {
    case 0u: {
      return loaded(depth_texture, at);
    }
    case 1u: {
      return loaded(texture_1, at);
    }
    case 2u: {
      return loaded(texture_2, at);
    }
    case 3u: {
      return loaded(texture_3, at);
    }
    case 4u: {
      return loaded(texture_4, at);
    }
    default: {
      return loaded(texture_5, at);
    }
  }
}

fn object_of_face(face: u32, at: vec2<u32>) -> u32 {
  switch face {
    case 0u: {
      return textureLoad(objects_0, at, 0).x;
    }
    case 1u: {
      return textureLoad(objects_1, at, 0).x;
    }
    case 2u: {
      return textureLoad(objects_2, at, 0).x;
    }
    case 3u: {
      return textureLoad(objects_3, at, 0).x;
    }
    case 4u: {
      return textureLoad(objects_4, at, 0).x;
    }
    default: {
      return textureLoad(objects_5, at, 0).x;
    }
  }
}

// A workgroup takes further blocks only where the device may not have a workgroup for each.
@compute @workgroup_size(BLOCK)
fn depth_cube(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let side = depth_map.size.x;
  // Turns: 1.
  for (var block = group.x + groups.x * group.y; block < depth_map.blocks; block += groups.x * groups.y) {
    let texel = block * BLOCK + local;
    let at = vec2<u32>(texel % (3u * side), texel / (3u * side));
    if (at.y < 2u * side) {
      let direction = sample_direction(at.x / side + 3u * (at.y / side), at % side);
      var key = FAR_KEY;
      var nearest = 6u;
      for (var face = 0u; face < 6u; face++) {
        if (has_direction(face, direction)) {
          let own = key_of_face(face, sample_in_direction(face, direction));
          nearest = select(nearest, face, own < key);
          key = min(key, own);
        }
      }
      textureStore(cube_texture, at, vec4<f32>(bitcast<f32>(depth_bits_or_far(key)), 0.0, 0.0, 0.0));
      if (OBJECTS && nearest < 6u) {
        textureStore(cube_objects, at, vec4<u32>(object_of_face(nearest, sample_in_direction(nearest, direction)), 0u, 0u, 0u));
      }
    }
  }
}
