// Computes the vertices of a side, as it is and clipped at the near plane. A side is the quad from an edge away from
// the light.

// A light so near to an edge is on it, by the size of the coordinates.
const ON_EDGE: f32 = 0x1p-22;

fn largest_of(v: vec3<f32>) -> f32 {
  return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

// False where the light lies on the edge, between its ends or at one of them: then its far vertices are opposite to each
// other, or one has no direction, and the side has no extent, only what rounding makes of it. Both faces at the edge are
// excluded there. NUMERICS.md, "A light exactly on a face".
fn spans_side(light: ShadowLight, first: vec3<f32>, second: vec3<f32>) -> bool {
  if (light.excludes == 0u) {
    return true;
  }
  let a = extrusion(light, first);
  let b = extrusion(light, second);
  let a_size = largest_of(a);
  let b_size = largest_of(b);
  if (a_size == 0.0 || b_size == 0.0) {
    return false;
  }
  let p = a / a_size;
  let q = b / b_size;
  let across = vec3<f32>(p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x);
  let size = largest_of(light.light.w * abs(first) + light.light.w * abs(second) + abs(light.light.xyz));
  return largest_of(across) > ON_EDGE * (size / a_size + size / b_size) || dot_3(p, q) > 0.0;
}

// A strip of four vertices: the first and the second, then their far vertices.
fn side_vertex(light: ShadowLight, first: vec3<f32>, second: vec3<f32>, vertex: u32) -> vec4<f32> {
  let position = select(first, second, (vertex & 1u) != 0u);
  if (vertex < 2u) {
    return to_clip(view, position);
  }
  return far_end(view, light, position);
}

// Corrects a depth that rounding may have put in front of the near plane.
fn behind_near_plane(clip: vec4<f32>) -> vec4<f32> {
  return vec4<f32>(clip.xy, select(max(clip.z, 0.0), min(clip.z, clip.w), view.near_z != 0.0), clip.w);
}

// A strip of five vertices. `is_ordered`: the first end has the lower vertex index.
fn clipped_side_vertex(
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
  picked = offer(picked, behind_near_plane(p.near), p_near);
  if (p_near != q_near) {
    if (is_ordered) {
      picked = offer(picked, on_near_plane(view, p, q), true);
    } else {
      picked = offer(picked, on_near_plane(view, q, p), true);
    }
  }
  picked = offer(picked, behind_near_plane(q.near), q_near);
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
