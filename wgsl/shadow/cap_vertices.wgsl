// Computes the vertices of caps from a face, in clip space.

// The corners of a face. Of two corners the one of lower order comes first, so that what meets at an edge has equal bits.
struct CapFace {
  a: vec3<f32>,
  b: vec3<f32>,
  c: vec3<f32>,
  order: vec3<u32>,
}

// Offers the vertices from `a` on, up to where the edge to `b` meets the near plane.
fn offer_clipped(picked: Picked, view: ShadowView, a: Corner, b: Corner, is_ordered: bool) -> Picked {
  var next = offer(picked, behind_near_plane(view, a.near), a.height >= 0.0);
  let meets_plane = (a.height >= 0.0) != (b.height >= 0.0);
  if (is_ordered) {
    return offer(next, on_near_plane(view, a, b), meets_plane);
  }
  return offer(next, on_near_plane(view, b, a), meets_plane);
}

// The light cap of a caster that is not in the depth buffer, as a strip of four vertices. With ZP+ it ends on the near plane
// with the bits of near cap and sides.
fn seen_light_cap_vertex(view: ShadowView, light: ShadowLight, face: CapFace, ends_at_near_plane: bool, vertex: u32) -> vec4<f32> {
  var picked = pick(vertex);
  if (ends_at_near_plane) {
    let a = corner(view, light, face.a);
    let b = corner(view, light, face.b);
    let c = corner(view, light, face.c);
    picked = offer_clipped(picked, view, a, b, face.order.x < face.order.y);
    picked = offer_clipped(picked, view, b, c, face.order.y < face.order.z);
    picked = offer_clipped(picked, view, c, a, face.order.z < face.order.x);
  } else {
    picked = offer(picked, to_clip(view, face.a), true);
    picked = offer(picked, to_clip(view, face.b), true);
    picked = offer(picked, to_clip(view, face.c), true);
  }
  return picked.clip;
}

// Whether the camera's direction is left of the edge between two far vertices, as seen from the light. The vertex of
// lower index comes first, so that the faces on both sides of the edge agree.
fn is_left(a: vec2<f32>, b: vec2<f32>, is_ordered: bool) -> bool {
  if (is_ordered) {
    return a.x * b.y - a.y * b.x >= 0.0;
  }
  return !(b.x * a.y - b.y * a.x >= 0.0);
}

// A face at infinity, as an orthographic camera sees it. It covers the whole picture if the camera's direction is
// within the face as seen from the light, else nothing. NUMERICS.md, "Dark caps of orthographic cameras".
fn all_or_nothing(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> vec4<f32> {
  let a = extrusion(view, light, face.a);
  let b = extrusion(view, light, face.b);
  let c = extrusion(view, light, face.c);
  let p = direction_to_clip(view, a).xy;
  let q = direction_to_clip(view, b).xy;
  let r = direction_to_clip(view, c).xy;
  let left = is_left(p, q, face.order.x < face.order.y);
  let left_of_second = is_left(q, r, face.order.y < face.order.z);
  let left_of_third = is_left(r, p, face.order.z < face.order.x);
  if (left != left_of_second || left != left_of_third) {
    return NOTHING;
  }
  // The direction, or its opposite, is this sum of the three vectors.
  let along = a * (q.x * r.y - q.y * r.x) + b * (r.x * p.y - r.y * p.x) + c * (p.x * q.y - p.y * q.x);
  if ((dot_3(view.near_plane.xyz, along) > 0.0) != left) {
    return NOTHING;
  }
  // It has the orientation of the face on the screen.
  let x = select(-1.0, 3.0, vertex == select(2u, 1u, left));
  let y = select(-1.0, 3.0, vertex == select(1u, 2u, left));
  return vec4<f32>(x, y, 1.0 - view.near_z, 1.0);
}

fn dark_cap_vertex(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> vec4<f32> {
  if (is_orthographic(view) && light.end == 0.0) {
    return all_or_nothing(view, light, face, vertex);
  }
  return far_end(view, light, select(select(face.a, face.b, vertex == 1u), face.c, vertex == 2u));
}

// Offers the vertices from `a` on, up to where the edge to `b` leaves or enters the slab between light and near plane.
fn offer_edge(picked: Picked, view: ShadowView, light: ShadowLight, a: Corner, b: Corner, is_ordered: bool) -> Picked {
  let a_above = a.height >= 0.0;
  let a_rises = a.far_height >= 0.0;
  let meets_plane = a_above != (b.height >= 0.0);
  let turns = a_rises != (b.far_height >= 0.0);
  var meeting = NOTHING;
  var turning = NOTHING;
  if (is_ordered) {
    meeting = on_near_plane(view, a, b);
    turning = parallel_to_near_plane(a, b);
  } else {
    meeting = on_near_plane(view, b, a);
    turning = parallel_to_near_plane(b, a);
  }
  let turns_first = a_above == (light_side(light) > 0.0);
  var next = offer(picked, project_to_near_plane(view, light, a), a_above != a_rises);
  next = offer(next, turning, turns && turns_first);
  next = offer(next, meeting, meets_plane);
  return offer(next, turning, turns && !turns_first);
}

// The near cap as a strip of five vertices.
fn near_cap_vertex(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> vec4<f32> {
  let a = corner(view, light, face.a);
  let b = corner(view, light, face.b);
  let c = corner(view, light, face.c);
  var picked = pick(vertex);
  picked = offer_edge(picked, view, light, a, b, face.order.x < face.order.y);
  picked = offer_edge(picked, view, light, b, c, face.order.y < face.order.z);
  picked = offer_edge(picked, view, light, c, a, face.order.z < face.order.x);
  return picked.clip;
}
