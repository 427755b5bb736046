// ZP+ as published (Hornus et al. 2005), for comparison: the light's frustum, whose far rectangle is the near
// rectangle, and the vertices that the near plane clips.

#import shadow/shadow

// A position transformed by the matrix of the light's frustum: x, y and w.
fn in_frustum(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec3<f32> {
  let q = placed(view, position);
  return vec3<f32>(
    dot_3(light.frustum_x.xyz, q) + light.frustum_x.w,
    dot_3(light.frustum_y.xyz, q) + light.frustum_y.w,
    dot_3(light.frustum_w.xyz, q) + light.frustum_w.w,
  );
}

// The same position in clip space, with a depth by which the hardware clips: 1 on the near plane, 0 in front of the
// caster (section 3.2). A light at infinity has parallel rays and the same w everywhere, so the height replaces the
// distance from the light.
fn frustum_to_clip(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
  let p = in_frustum(view, light, position);
  let near_w = view.near_w * abs(light.height);
  var z = (p.z - light.frustum_near * near_w) / (1.0 - light.frustum_near);
  if (light.light.w == 0.0) {
    let height = dot_3(view.near_plane.xyz, placed(view, position)) + view.near_plane.w;
    z = p.z * (1.0 - light_side(light) * height / light.frustum_near);
  }
  return vec4<f32>(p.xy, z, p.z);
}

// The vertex of the near cap that corresponds to a vertex.
fn counterpart(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
  let p = in_frustum(view, light, position);
  return vec4<f32>(p.xy, p.z * view.near_z, p.z);
}

// Whether a vertex is on the eye's side of the near plane.
fn is_cut(view: ShadowView, clip: vec4<f32>) -> bool {
  return clip.w <= 0.0 || select((clip.z < 0.0), (clip.z > clip.w), view.near_z != 0.0);
}
