// Stage `depth_metric`: makes a depth map from distances to a light, as ray marching and range images have them. Dispatched by
// `DepthMapConversion::encode`, before the encode that reads the result as `depth_texture`. One invocation a texel.
// Reads distances and `metric_view`. Writes a texture of `r32float` with the device depths of the light's camera: from 0 to 1,
// none subnormal or NaN, and the far end where nothing casts.
// It computes in floats, within a bound: `metric_steps` in src/gpu/depth_map/metric.rs, by which draws move the boundary of
// shadow. Keep the operations of `distance_key` and their order: docs/numerics/depth-maps.md, "Maps of distances", derives the
// bound from them.

#import depth_map/samples

struct DepthMetricView {
  // How the ray through a texel changes for each step across, and for each step down: a step is half a texel. Its component along
  // the light's axis is 1. w: how much the depth at infinity changes.
  across: vec4<f32>,
  down: vec4<f32>,
  // The ray in the middle. w is 0.
  middle: vec4<f32>,
  // The far distance in two parts. Without a far plane, what depth times distance is.
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
      textureStore(converted_texture, at, vec4<f32>(bitcast<f32>(bits_of_key(key)), 0.0, 0.0, 0.0));
    }
  }
}
