// Three stages that make depth maps of a caller's depth maps: `depth_metric` converts distances; `depth_merge` takes the
// nearer of two maps of one camera; `depth_cube` puts the six maps around a light into one texture. An invocation makes a
// texel.
// They are dispatched before the stages and draws that read the result as `depth_texture`.
// Results have depths from 0 to 1, none subnormal or NaN, and the depth of the far end where nothing casts. samples.wgsl
// describes sizes and keys, which are integers that grow with the distance from the light.
// docs/numerics/depth-maps.md, "Maps of distances" and "Six maps".

#import depth_map/samples

// Stage `depth_metric`: makes a depth map of distances to a light, as ray marching and range images have them. Dispatched by
// `DepthMapTexture::convert`. Reads distances and `metric_view`. Writes a texture of `r32float` with device depths of the
// light's camera.
// It computes in floats. `metric_steps` in src/gpu/depth_map/metric.rs bounds their error, and the bias of draws includes
// it. Keep the operations of `distance_key` and `ray_length`, and their order: docs/numerics/depth-maps.md, "Maps of
// distances", derives the bound from them.

struct DepthMetricView {
  // x, y, z: how the ray through a texel changes for each step of half a texel across. w: how nearness changes at infinity.
  // Nearness is 1 at the near plane and 0 at the far end.
  across: vec4<f32>,
  // The same for each step down.
  down: vec4<f32>,
  // x, y, z: the ray in the middle, with a component of 1 along the light's axis. w: 0.
  middle: vec4<f32>,
  // The far distance is `far` + `far_remainder`. Without a far plane `far` is nearness times distance.
  far: f32,
  far_remainder: f32,
  // 1: there is a far plane.
  has_far: f32,
  // Nearness in the middle is `scale` times the distance to the far plane, or without one `scale` times `far`, divided by
  // the distance unless rays are parallel. `across.w` and `down.w` add to it.
  scale: f32,
  // Distances are clamped to the range from `min_distance`, half of the near one, to `max_distance`, twice the far one or
  // 2¹²⁰. From `max_distance` on, nothing casts. From the far plane on nothing does, either, by its depth.
  min_distance: f32,
  max_distance: f32,
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

// The length of the ray through a texel for each unit along the light's axis. `steps`: half texels from the middle of the
// map.
fn ray_length(steps: vec2<f32>) -> f32 {
  let ray = metric_view.across.xyz * steps.x + metric_view.down.xyz * steps.y + metric_view.middle.xyz;
  return sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z);
}

// The key (samples.wgsl) of a distance. Signs, infinity and NaN are found by bits, because a device may assume that there
// are no infinities and NaN.
fn distance_key(bits: u32, steps: vec2<f32>) -> u32 {
  let magnitude = bits & 0x7fffffffu;
  let is_negative = (bits >> 31u) == 1u;
  let is_nothing = (magnitude > INFINITE) | (!is_negative & (magnitude == INFINITE));
  var distance = bitcast<f32>(select(magnitude, 0u, is_nothing | is_negative));
  if (metric_view.metric == 2u) {
    distance = distance / ray_length(steps);
  }
  let is_far = is_nothing | (distance >= metric_view.max_distance);
  let clamped = clamp(distance, metric_view.min_distance, metric_view.max_distance);
  let to_far = (metric_view.far - metric_view.has_far * clamped) + metric_view.far_remainder;
  let scaled = metric_view.scale * to_far / select(clamped, 1.0, metric_view.is_parallel != 0u);
  let tilt = metric_view.across.w * steps.x + metric_view.down.w * steps.y;
  let nearness = scaled + tilt;
  let depth = select(1.0 - nearness, nearness, depth_map.is_reversed != 0u);
  return select(sample_key(bitcast<u32>(depth)), FAR_KEY, is_far);
}

// A workgroup takes more than one block only where the device does not allow a workgroup for each.
@compute @workgroup_size(BLOCK)
fn depth_metric(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  // Turns: 1.
  for (
    var block = workgroup.x + dispatch_size.x * workgroup.y;
    block < depth_map.blocks;
    block += dispatch_size.x * dispatch_size.y
  ) {
    let index = block * BLOCK + lane;
    let texel = vec2<u32>(index % depth_map.size.x, index / depth_map.size.x);
    if (texel.y < depth_map.size.y) {
      let bits = bitcast<u32>(textureLoad(depth_texture, texel, 0).x);
      let steps = vec2<f32>(2 * vec2<i32>(texel) + 1 - vec2<i32>(depth_map.size));
      var key = sample_key(bits);
      if (metric_view.metric != 0u) {
        key = distance_key(bits, steps);
      }
      textureStore(converted_texture, texel, vec4<f32>(bitcast<f32>(depth_bits_or_far(key)), 0.0, 0.0, 0.0));
    }
  }
}

// Stage `depth_merge`: takes for each texel the nearer of two depths, of two maps that one camera of a light made.
// Dispatched by `DepthMapTexture::merge`. Reads both maps, of any depth format. Writes a texture of `r32float` with the depth
// of the smaller key, and the far end where nothing casts in either map.
// Keys are integers, so the choice is exact, and a texel of the result has the key that it was made from.

@group(0) @binding(2) var second_texture: texture_2d<f32>;
@group(0) @binding(3) var merged_texture: texture_storage_2d<r32float, write>;

// A workgroup takes more than one block only where the device does not allow a workgroup for each.
@compute @workgroup_size(BLOCK)
fn depth_merge(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  // Turns: 1.
  for (
    var block = workgroup.x + dispatch_size.x * workgroup.y;
    block < depth_map.blocks;
    block += dispatch_size.x * dispatch_size.y
  ) {
    let index = block * BLOCK + lane;
    let texel = vec2<u32>(index % depth_map.size.x, index / depth_map.size.x);
    if (texel.y < depth_map.size.y) {
      let first = load_key(texel + 1u);
      let second = sample_key(bitcast<u32>(textureLoad(second_texture, texel, 0).x));
      textureStore(merged_texture, texel, vec4<f32>(bitcast<f32>(depth_bits_or_far(min(first, second))), 0.0, 0.0, 0.0));
    }
  }
}

// Stage `depth_cube`: puts the six depth maps around a light into one texture, three in a row. First dispatch of each encode
// of `DepthMapCube`. Reads six depth textures and, with OBJECTS, six of objects. Writes `cube_texture` and, with OBJECTS,
// `cube_objects`, which all later stages and draws have as `depth_texture` and `object_texture`. No object is written where
// nothing casts: the one of an earlier encode stays.
// A texture of another size, such as one texel, stands for a map that is missing: nothing casts in it.
// Samples of maps that lie on one ray (samples.wgsl) get the nearest of their depths, and the object of the first map with
// that depth. So cells on both sides of an edge of the cube decide from the same samples. Keys, which are integers, decide.

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

// Whether maps have objects.
override OBJECTS: bool = true;

// The key of a texel of a map.
fn load_map_key(map: texture_2d<f32>, texel: vec2<u32>) -> u32 {
  if (any(textureDimensions(map) != depth_map.size)) {
    return FAR_KEY;
  }
  return sample_key(bitcast<u32>(textureLoad(map, texel, 0).x));
}

fn load_face_key(face: u32, texel: vec2<u32>) -> u32 {
  switch face {
    case 0u: {
      return load_map_key(depth_texture, texel);
    }
    case 1u: {
      return load_map_key(texture_1, texel);
    }
    case 2u: {
      return load_map_key(texture_2, texel);
    }
    case 3u: {
      return load_map_key(texture_3, texel);
    }
    case 4u: {
      return load_map_key(texture_4, texel);
    }
    default: {
      return load_map_key(texture_5, texel);
    }
  }
}

fn load_face_object(face: u32, texel: vec2<u32>) -> u32 {
  switch face {
    case 0u: {
      return textureLoad(objects_0, texel, 0).x;
    }
    case 1u: {
      return textureLoad(objects_1, texel, 0).x;
    }
    case 2u: {
      return textureLoad(objects_2, texel, 0).x;
    }
    case 3u: {
      return textureLoad(objects_3, texel, 0).x;
    }
    case 4u: {
      return textureLoad(objects_4, texel, 0).x;
    }
    default: {
      return textureLoad(objects_5, texel, 0).x;
    }
  }
}

// A workgroup takes more than one block only where the device does not allow a workgroup for each.
@compute @workgroup_size(BLOCK)
fn depth_cube(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) dispatch_size: vec3<u32>,
  @builtin(local_invocation_index) lane: u32,
) {
  let side = depth_map.size.x;
  // Turns: 1.
  for (
    var block = workgroup.x + dispatch_size.x * workgroup.y;
    block < depth_map.blocks;
    block += dispatch_size.x * dispatch_size.y
  ) {
    let index = block * BLOCK + lane;
    let texel = vec2<u32>(index % (3u * side), index / (3u * side));
    if (texel.y < 2u * side) {
      let direction = sample_direction(texel.x / side + 3u * (texel.y / side), texel % side);
      var key = FAR_KEY;
      // The first map with the nearest depth; 6: none.
      var nearest = 6u;
      for (var face = 0u; face < 6u; face++) {
        if (has_direction(face, direction)) {
          let face_key = load_face_key(face, sample_in_direction(face, direction));
          nearest = select(nearest, face, face_key < key);
          key = min(key, face_key);
        }
      }
      textureStore(cube_texture, texel, vec4<f32>(bitcast<f32>(depth_bits_or_far(key)), 0.0, 0.0, 0.0));
      if (OBJECTS && nearest < 6u) {
        textureStore(
          cube_objects, texel, vec4<u32>(load_face_object(nearest, sample_in_direction(nearest, direction)), 0u, 0u, 0u));
      }
    }
  }
}
