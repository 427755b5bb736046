// Cap faces: computes the vertices of caps. A light cap is a face at its place. A dark cap is
// the face at the far end of the volume. A near cap is the part of a face between the light and the near plane,
// projected from the light onto that plane.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<storage, read> view: ShadowView;
@group(0) @binding(2) var<uniform> draw: ShadowDraw;
@group(0) @binding(3) var<storage, read> shadow_lights: array<ShadowLight>;
@group(1) @binding(0) var<storage, read> positions: array<u32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;
@group(1) @binding(2) var<storage, read> facing_masks: array<u32>;
@group(1) @binding(3) var<storage, read> cap_counts: array<u32>;
@group(1) @binding(4) var<storage, read> cap_list: array<u32>;
@group(1) @binding(5) var<storage, read> excluded_masks: array<u32>;

// The list of cap faces that is drawn.
override CAP_CLASS: u32 = 0u;

struct CapVertex {
  @invariant @builtin(position) clip: vec4<f32>,
}

struct CapFace {
  valid: bool,
  corners: vec3<u32>,
}

// Whether the face counts nowhere: the light is in its plane.
fn is_excluded(light: ShadowLight, face: u32) -> bool {
  return light.excludes != 0u && ((excluded_masks[face] >> (draw.light - draw.first_light)) & 1u) != 0u;
}

fn cap_face(light: ShadowLight, instance: u32) -> CapFace {
  let overflowed = cap_counts[LISTS * draw.light + CAP_CLASS] > shape.cap_capacity;
  var face = instance;
  if (!overflowed) {
    face = cap_list[list_begin(draw.light - draw.first_light, CAP_CLASS, shape.cap_capacity) + instance];
  }
  let corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
  var valid = true;
  if (overflowed) {
    let facing = ((facing_masks[face] >> (draw.light - draw.first_light)) & 1u) != 0u;
    valid = casts(light, facing) && cap_class(light, facing) == CAP_CLASS && !is_excluded(light, face) &&
      corners.x != corners.y && corners.y != corners.z && corners.z != corners.x &&
      is_finite(caster_position(corners.x)) && is_finite(caster_position(corners.y)) &&
      is_finite(caster_position(corners.z));
  }
  return CapFace(valid, corners);
}

@vertex fn light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let face = cap_face(shadow_lights[draw.light], instance);
  if (!face.valid) {
    return CapVertex(NOTHING);
  }
  return CapVertex(to_clip(view, caster_position(face.corners[vertex])));
}

@vertex fn dark_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let light = shadow_lights[draw.light];
  let face = cap_face(light, instance);
  if (!face.valid) {
    return CapVertex(NOTHING);
  }
  if (is_orthographic(view) && light.end == 0.0) {
    return CapVertex(all_or_nothing(light, face, vertex));
  }
  return CapVertex(far_end(view, light, caster_position(face.corners[vertex])));
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
fn all_or_nothing(light: ShadowLight, face: CapFace, vertex: u32) -> vec4<f32> {
  let a = extrusion(light, caster_position(face.corners.x));
  let b = extrusion(light, caster_position(face.corners.y));
  let c = extrusion(light, caster_position(face.corners.z));
  let p = direction_to_clip(view, a).xy;
  let q = direction_to_clip(view, b).xy;
  let r = direction_to_clip(view, c).xy;
  let left = is_left(p, q, face.corners.x < face.corners.y);
  let left_of_second = is_left(q, r, face.corners.y < face.corners.z);
  let left_of_third = is_left(r, p, face.corners.z < face.corners.x);
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

// Offers the vertices from `a` on, up to where the edge to `b` leaves or enters the slab between light and near plane.
fn offer_edge(picked: Picked, light: ShadowLight, a: Corner, b: Corner, is_ordered: bool) -> Picked {
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

@vertex fn near_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let light = shadow_lights[draw.light];
  let face = cap_face(light, instance);
  if (!face.valid) {
    return CapVertex(NOTHING);
  }
  let a = corner(view, light, caster_position(face.corners.x));
  let b = corner(view, light, caster_position(face.corners.y));
  let c = corner(view, light, caster_position(face.corners.z));
  var picked = pick(vertex);
  picked = offer_edge(picked, light, a, b, face.corners.x < face.corners.y);
  picked = offer_edge(picked, light, b, c, face.corners.y < face.corners.z);
  picked = offer_edge(picked, light, c, a, face.corners.z < face.corners.x);
  return CapVertex(picked.clip);
}

// The near cap as published: the face transformed by the matrix of the light's frustum. The hardware clips it.
@vertex fn zp_plus_2005_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let light = shadow_lights[draw.light];
  let face = cap_face(light, instance);
  if (!face.valid) {
    return CapVertex(NOTHING);
  }
  return CapVertex(frustum_to_clip(view, light, caster_position(face.corners[vertex])));
}

// For passes with colour attachments, which are not changed.
@fragment fn nothing() {}
