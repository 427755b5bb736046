// What can be told of a box and its shadow before anything is computed: whether a light reaches it, and whether a camera may
// see it or its shadow. NUMERICS.md, "What is skipped".

// Whether the whole box is beyond the light's range.
fn out_of_range(light: ShadowLight, scale: f32, low: vec3<f32>, high: vec3<f32>) -> bool {
  if (light.range <= 0.0 || light.light.w <= 0.0) {
    return false;
  }
  let place = light.light.xyz / light.light.w;
  let d = scale * max(max(low - place, place - high), vec3<f32>(0.0));
  // The largest side is factored out, because squares may overflow.
  let size = max(max(d.x, d.y), max(d.z, light.range));
  let r = light.range / size;
  let e = d / size;
  return dot_3(e, e) > r * r * (1.0 + SLACK);
}

// Bounds on the terms whose sums are the vector from the light to a position.
fn extrusion_size(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec3<f32> {
  let terms = abs(light.light.w * position) + abs(light.light.xyz);
  return vec3<f32>(
    dot_3(abs(view.placement[0].xyz), terms), dot_3(abs(view.placement[1].xyz), terms), dot_3(abs(view.placement[2].xyz), terms));
}

// Whether the whole volume of the box is outside the left, right, bottom, top or near plane of the camera.
fn is_unseen(view: ShadowView, light: ShadowLight, low: vec3<f32>, high: vec3<f32>) -> bool {
  var out = vec4<bool>(true);
  var before = true;
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    let v = corner(view, light, position);
    let q = abs(placed(view, position));
    let size = clip_size(view, q);
    let away = extrusion_size(view, light, position);
    let far_size = clip_size(view, away);
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
      is_out(v.far_height, far_size.w + dot_3(abs(view.near_plane.xyz), away));
  }
  return any(out) || before;
}

// Whether the whole box is outside the left, right, bottom, top or near plane of the camera.
fn box_is_unseen(view: ShadowView, low: vec3<f32>, high: vec3<f32>) -> bool {
  var out = vec4<bool>(true);
  var before = true;
  for (var number = 0u; number < 8u; number++) {
    let position = box_corner(low, high, number);
    let q = placed(view, position);
    let size = clip_size(view, abs(q));
    let clip = to_clip(view, position);
    out = vec4<bool>(
      out.x && is_out(clip.w + clip.x, size.w + size.x),
      out.y && is_out(clip.w - clip.x, size.w + size.x),
      out.z && is_out(clip.w + clip.y, size.w + size.y),
      out.w && is_out(clip.w - clip.y, size.w + size.y));
    before = before && is_out(dot_3(view.near_plane.xyz, q) + view.near_plane.w, height_size(view, abs(q)));
  }
  return any(out) || before;
}
