// Cap faces: computes the vertices of caps. A light cap is a face at its place. A dark cap is
// the face at the far end of the volume. A near cap is the part of a face between the light and the near plane,
// projected from the light onto that plane. z-fail has light and dark caps. z-pass and ZP+ have light caps of casters that
// are not in the depth buffer, and dark caps where volumes end; their lists are the same.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
// Those of the draw.
@group(0) @binding(2) var<storage, read> seen: SeenLight;
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read> positions: array<u32>;
@group(1) @binding(1) var<storage, read> faces: array<u32>;
@group(1) @binding(2) var<storage, read> facing_masks: array<u32>;
@group(1) @binding(3) var<storage, read> excluded_masks: array<u32>;
@group(1) @binding(4) var<storage, read> caps_listed: array<u32>;

// The list of cap faces that is drawn.
override CAP_KIND: u32 = 0u;

struct CapVertex {
  @invariant @builtin(position) clip: vec4<f32>,
}

// A face, and what its caster sees.
struct Cap {
  valid: bool,
  corners: vec3<u32>,
  caster: u32,
  view: ShadowView,
  light: ShadowLight,
}

// An instance is an entry of the list. If the lists overflowed, every face is an instance.
fn cap_of(instance: u32) -> Cap {
  let bit = draw.light - draw.first_light;
  let pair = CAP_KIND & FAR;
  let overflowed = caps_listed[4u * bit + pair] + caps_listed[4u * bit + pair + 1u] > cap_capacity(CAP_KIND);
  var slot = instance;
  if (!overflowed) {
    slot = caps_listed[cap_place(bit, CAP_KIND, instance)];
  }
  var own: Cap;
  own.caster = caster_of(shape.face_chunks_at, slot);
  own.view = view_of(own.caster, seen.view);
  own.light = light_of(own.caster, seen.light, draw.light);
  own.valid = is_counted(own.caster, draw.count_batch);
  let run = face_run(own.caster);
  let face = run.z + slot - run.x;
  own.corners = vec3<u32>(faces[3u * face], faces[3u * face + 1u], faces[3u * face + 2u]);
  if (overflowed || has_measures() || shape.proxies != 0u) {
    own.light = chosen_light(own.caster, own.light, draw.light, draw.view);
  }
  if (overflowed) {
    let corners = own.corners;
    let facing = ((facing_masks[slot] >> bit) & 1u) != 0u;
    let flags = caster_flags(own.caster);
    let mirrored = (flags & MIRRORED) != 0u;
    let is_excluded = own.light.excludes != 0u && ((excluded_masks[slot] >> bit) & 1u) != 0u;
    var is_of_kind = has_near_cap(own.light) && near_kind(own.light, facing, mirrored) == CAP_KIND;
    if (CAP_KIND >= FAR) {
      is_of_kind = has_far_caps(own.light, flags) && far_kind(facing, mirrored) == CAP_KIND;
    }
    own.valid = own.valid && slot - run.x < run.y && casts(own.light, facing) && !is_excluded && is_of_kind &&
      corners.x != corners.y && corners.y != corners.z && corners.z != corners.x &&
      is_finite(vertex_position(own.caster, corners.x)) && is_finite(vertex_position(own.caster, corners.y)) &&
      is_finite(vertex_position(own.caster, corners.z));
  }
  return own;
}

@vertex fn light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let own = cap_of(instance);
  if (!own.valid) {
    return CapVertex(NOTHING);
  }
  return CapVertex(to_clip(own.view, vertex_position(own.caster, own.corners[vertex])));
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
@vertex fn seen_light_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let own = cap_of(instance);
  if (!own.valid || (caster_flags(own.caster) & PROXY) == 0u) {
    return CapVertex(NOTHING);
  }
  let view = own.view;
  let p = vertex_position(own.caster, own.corners.x);
  let q = vertex_position(own.caster, own.corners.y);
  let r = vertex_position(own.caster, own.corners.z);
  var picked = pick(vertex);
  if (has_near_cap(own.light)) {
    let a = corner(view, own.light, p);
    let b = corner(view, own.light, q);
    let c = corner(view, own.light, r);
    picked = offer_clipped(picked, view, a, b, own.corners.x < own.corners.y);
    picked = offer_clipped(picked, view, b, c, own.corners.y < own.corners.z);
    picked = offer_clipped(picked, view, c, a, own.corners.z < own.corners.x);
  } else {
    picked = offer(picked, to_clip(view, p), true);
    picked = offer(picked, to_clip(view, q), true);
    picked = offer(picked, to_clip(view, r), true);
  }
  return CapVertex(picked.clip);
}

@vertex fn dark_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let own = cap_of(instance);
  // Of casters that are not in the depth buffer there are faces whose volume does not end.
  let is_endless = shape.proxies != 0u && own.light.counting != COUNT_Z_FAIL && own.light.end == 0.0;
  if (!own.valid || is_endless) {
    return CapVertex(NOTHING);
  }
  if (is_orthographic(own.view) && own.light.end == 0.0) {
    return CapVertex(all_or_nothing(own, vertex));
  }
  return CapVertex(far_end(own.view, own.light, vertex_position(own.caster, own.corners[vertex])));
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
fn all_or_nothing(own: Cap, vertex: u32) -> vec4<f32> {
  let view = own.view;
  let a = extrusion(view, own.light, vertex_position(own.caster, own.corners.x));
  let b = extrusion(view, own.light, vertex_position(own.caster, own.corners.y));
  let c = extrusion(view, own.light, vertex_position(own.caster, own.corners.z));
  let p = direction_to_clip(view, a).xy;
  let q = direction_to_clip(view, b).xy;
  let r = direction_to_clip(view, c).xy;
  let left = is_left(p, q, own.corners.x < own.corners.y);
  let left_of_second = is_left(q, r, own.corners.y < own.corners.z);
  let left_of_third = is_left(r, p, own.corners.z < own.corners.x);
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

@vertex fn near_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let own = cap_of(instance);
  if (!own.valid) {
    return CapVertex(NOTHING);
  }
  let view = own.view;
  let light = own.light;
  let a = corner(view, light, vertex_position(own.caster, own.corners.x));
  let b = corner(view, light, vertex_position(own.caster, own.corners.y));
  let c = corner(view, light, vertex_position(own.caster, own.corners.z));
  var picked = pick(vertex);
  picked = offer_edge(picked, view, light, a, b, own.corners.x < own.corners.y);
  picked = offer_edge(picked, view, light, b, c, own.corners.y < own.corners.z);
  picked = offer_edge(picked, view, light, c, a, own.corners.z < own.corners.x);
  return CapVertex(picked.clip);
}

// The near cap as published: the face transformed by the matrix of the light's frustum. The hardware clips it.
@vertex fn zp_plus_2005_cap(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> CapVertex {
  let own = cap_of(instance);
  if (!own.valid) {
    return CapVertex(NOTHING);
  }
  return CapVertex(frustum_to_clip(own.view, own.light, vertex_position(own.caster, own.corners[vertex])));
}

// For passes with colour attachments, which are not changed.
@fragment fn nothing() {}
