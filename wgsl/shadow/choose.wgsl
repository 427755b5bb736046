// Choose: chooses for each light the faces of the caster that cast and the counting method, from the caster's box
// alone. This is cheap and settles most casters. Casters that may need caps go on to `caps`, whose dispatches are
// written here.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> view: ShadowView;
@group(0) @binding(2) var<storage, read> box: array<u32, 7>;
@group(0) @binding(3) var<storage, read_write> shadow_lights: array<ShadowLight>;
// Three workgroup counts for each batch of lights.
@group(0) @binding(4) var<storage, read_write> cap_dispatches: array<u32>;
// `ExtractionStatistics` of the extraction. The last tells how many lights lie in planes of faces.
@group(0) @binding(5) var<storage, read> extraction_statistics: array<u32, 4>;

fn unordered(bits: vec3<u32>) -> vec3<f32> {
  return bitcast<vec3<f32>>(select(~bits, bits & vec3<u32>(0x7fffffffu), bits >= vec3<u32>(0x80000000u)));
}

fn box_corner(low: vec3<f32>, high: vec3<f32>, number: u32) -> vec3<f32> {
  return select(low, high, (vec3<u32>(number) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
}

// Whether the whole box is beyond the light's range.
fn out_of_range(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  if (light.range <= 0.0 || light.light.w <= 0.0) {
    return false;
  }
  let place = light.light.xyz / light.light.w;
  let d = max(max(low - place, place - high), vec3<f32>(0.0));
  // The largest side is factored out, because squares may overflow.
  let size = max(max(d.x, d.y), max(d.z, light.range));
  let r = light.range / size;
  let e = d / size;
  return dot_3(e, e) > r * r * (1.0 + SLACK);
}

// Whether two boxes meet, with slack.
fn boxes_meet(low: vec3<f32>, high: vec3<f32>) -> bool {
  let slack = SLACK * max(max(abs(low), abs(high)), max(abs(view.near_min), abs(view.near_max)));
  return all(low - slack <= view.near_max) && all(high + slack >= view.near_min);
}

// Whether the light may be in the box, with slack. A light at infinity is not. Values are multiplied by w, so that
// nothing overflows.
fn light_meets(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  let w = light.light.w;
  let slack = SLACK * max(max(abs(w * low), abs(w * high)), abs(light.light.xyz));
  return w > 0.0 && all(w * low - slack <= light.light.xyz) && all(w * high + slack >= light.light.xyz);
}

// Whether the whole volume of the box is outside the left, right, bottom, top or near plane of the camera.
fn is_unseen(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  var out = vec4<bool>(true);
  var before = true;
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    let v = corner(view, light, position);
    let q = abs(position - view.origin);
    let size = clip_size(view, q);
    let far_size = clip_size(view, abs(light.light.w * position) + abs(light.light.xyz));
    let near_x = size.w + size.x;
    let near_y = size.w + size.y;
    let far_x = far_size.w + far_size.x;
    let far_y = far_size.w + far_size.y;
    out = vec4<bool>(
      out.x && is_out(v.near.w + v.near.x, near_x) && is_out(v.far.w + v.far.x, far_x),
      out.y && is_out(v.near.w - v.near.x, near_x) && is_out(v.far.w - v.far.x, far_x),
      out.z && is_out(v.near.w + v.near.y, near_y) && is_out(v.far.w + v.far.y, far_y),
      out.w && is_out(v.near.w - v.near.y, near_y) && is_out(v.far.w - v.far.y, far_y));
    before = before && is_out(v.height, height_size(view, q)) &&
      is_out(v.far_height, far_size.w + dot_3(abs(view.near_plane.xyz), abs(light.light.w * position) + abs(light.light.xyz)));
  }
  return any(out) || before;
}

// Whether the whole box is outside the pyramid of light and near rectangle.
fn misses_pyramid(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  var out = vec4<bool>(true);
  var beyond = true;
  for (var number = 0u; number < 8u; number++) {
    let planes = pyramid_planes(view, light, box_corner(low, high, number));
    out = vec4<bool>(
      out.x && is_out(planes.value.x, planes.size.x),
      out.y && is_out(planes.value.y, planes.size.y),
      out.z && is_out(planes.value.z, planes.size.z),
      out.w && is_out(planes.value.w, planes.size.w));
    beyond = beyond && is_out(planes.depth, planes.depth_size);
  }
  return any(out) || beyond;
}

// A lower bound of the distance from the light to the box.
fn distance_below(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> f32 {
  let place = light.light.xyz / light.light.w;
  let slack = SLACK * max(max(abs(low), abs(high)), abs(place));
  let d = max(max(low - place, place - high) - slack, vec3<f32>(0.0));
  return length_of(d) * (1.0 - SLACK);
}

// The largest side is factored out, because squares may overflow.
fn length_of(d: vec3<f32>) -> f32 {
  let size = max(max(d.x, d.y), d.z);
  if (size <= 0.0) {
    return 0.0;
  }
  let e = d / size;
  return size * sqrt(dot_3(e, e));
}

// The near end of the light's frustum in ZP+ as published. Nothing of the caster lies before it. For a point light it
// is the caster's distance from the light over that of the near rectangle's farthest point. For a light at infinity it
// is the caster's height.
fn frustum_near(light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> f32 {
  if (light.light.w > 0.0) {
    let place = light.light.xyz / light.light.w;
    let farthest = length_of(max(abs(view.near_min - place), abs(view.near_max - place)));
    // It is below 1 for casters beyond the near rectangle, which have nothing in the frustum. It is above 0 for lights
    // in the box, which the paper does not treat: with 0 or less nothing would be clipped at the near plane.
    return clamp(distance_below(light, low, high) / farthest, 0.001, 0.99);
  }
  var highest = 0.0;
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    let height = dot_3(view.near_plane.xyz, position - view.origin) + view.near_plane.w;
    highest = max(highest, light_side(light) * height + SLACK * height_size(view, abs(position) + abs(view.origin)));
  }
  return select(1.0, highest, highest > 0.0);
}

fn choose_light(index: u32) {
  var light = shadow_lights[index];
  light.casting = CAST_NOTHING;
  light.counting = COUNT_Z_PASS;
  light.end = 0.0;
  light.excludes = 0u;
  let low = unordered(vec3<u32>(box[0], box[1], box[2]));
  let high = unordered(vec3<u32>(box[3], box[4], box[5]));
  let is_empty = box[0] > box[3];
  if (!is_empty && !out_of_range(light, low, high) && !(shape.skip_unseen != 0u && is_unseen(light, low, high))) {
    let has_holes = box[6] != 0u;
    let light_is_inside = light_meets(light, low, high);
    light.excludes = select(0u, 1u, has_holes || (light_is_inside && extraction_statistics[3] != 0u));
    // A caster with holes is not closed. Averted faces suffice if light and eye are outside the caster: NUMERICS.md,
    // "Which faces cast".
    let is_outside = !boxes_meet(low, high) && !light_is_inside;
    light.casting = select(CAST_EVERY, CAST_AVERTED, shape.averted != 0u && !has_holes && is_outside);
    light.counting = shape.counting;
    if (shape.counting == COUNT_ZP_PLUS_2005) {
      light.frustum_near = frustum_near(light, low, high);
      // What was published knows no excluded faces.
      light.counting = select(COUNT_ZP_PLUS_2005, COUNT_Z_FAIL, light.excludes != 0u);
    }
    if (shape.counting == COUNT_AUTO) {
      light.counting = select(COUNT_ZP_PLUS, COUNT_Z_PASS, misses_pyramid(light, low, high));
    }
  }
  // Near caps belong to volumes that do not end, so volumes that ZP+ counts do not end.
  let may_end = light.counting == COUNT_Z_PASS || light.counting == COUNT_Z_FAIL;
  if (light.casting != CAST_NOTHING && may_end && shape.end_at_range != 0u && light.range > 0.0 && light.light.w > 0.0) {
    light.end = min(distance_below(light, low, high) / light.range, 1.0);
  }
  let needs_caps = light.counting != COUNT_Z_PASS || light.end > 0.0;
  if (light.casting != CAST_NOTHING && needs_caps) {
    cap_dispatches[3u * (index / 32u)] = shape.cap_groups;
  }
  shadow_lights[index] = light;
}

@compute @workgroup_size(64)
fn choose(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  for (var light = id.x; light < shape.lights; light += 64u * groups.x) {
    choose_light(light);
  }
}
