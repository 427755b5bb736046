// Computes the vertices of a side, as it is and clipped at the near plane. A side is the quad from an edge away from
// the light.

// A strip of four vertices: the first and the second, then their far vertices.
fn side_vertex(view: ShadowView, light: ShadowLight, first: vec3<f32>, second: vec3<f32>, vertex: u32) -> vec4<f32> {
  let position = select(first, second, (vertex & 1u) != 0u);
  if (vertex < 2u) {
    return to_clip(view, position);
  }
  return far_end(view, light, position);
}

// A strip of five vertices. `is_ordered`: the first end has the lower vertex index.
fn clipped_side_vertex(
  view: ShadowView,
  light: ShadowLight,
  first: vec3<f32>,
  second: vec3<f32>,
  is_ordered: bool,
  vertex: u32,
) -> vec4<f32> {
  let p = corner(view, light, first);
  let q = corner(view, light, second);
  let p_near = p.height >= 0.0;
  let q_near = q.height >= 0.0;
  let p_far = p.far_height >= 0.0;
  let q_far = q.far_height >= 0.0;
  var picked = pick(vertex);
  picked = offer(picked, behind_near_plane(view, p.near), p_near);
  if (p_near != q_near) {
    if (is_ordered) {
      picked = offer(picked, on_near_plane(view, p, q), true);
    } else {
      picked = offer(picked, on_near_plane(view, q, p), true);
    }
  }
  picked = offer(picked, behind_near_plane(view, q.near), q_near);
  picked = offer(picked, project_to_near_plane(view, light, q), q_near != q_far);
  picked = offer(picked, q.far, q_far);
  if (p_far != q_far) {
    if (is_ordered) {
      picked = offer(picked, parallel_to_near_plane(p, q), true);
    } else {
      picked = offer(picked, parallel_to_near_plane(q, p), true);
    }
  }
  picked = offer(picked, p.far, p_far);
  picked = offer(picked, project_to_near_plane(view, light, p), p_near != p_far);
  return picked.clip;
}
