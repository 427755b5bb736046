// Vertices of sides and caps of shadow volumes, in clip space, for the vertex shaders `sides`, `cap_faces` and `pieces`. A side
// is the quad from an edge away from the light; a cap is a face at its place (light cap), at the far end of the volume (dark
// cap), or the part between light and near plane, projected from the light onto that plane (near cap). Anything clipped at the
// near plane is a polygon of up to five vertices, drawn as a strip. Volumes are watertight: shapes that meet at an edge have
// equal bits there, because both take its ends in the order of their vertex indices (`is_ordered`) and by the same functions of
// shadow/shadow.wgsl. No expression may differ between two shapes that meet. docs/numerics/shadow-volumes.md. If TRIM is set,
// polygons are cut at the frustum here, for drivers that clip slivers wrongly: "Triangles that leave the picture". ZP+ counts
// sides as z-pass does, and adds the near caps, since the near plane cuts volumes; the last part, also for `zp_plus_2005_cases`,
// is ZP+ as published in 2005. `Turns:` is the most turns of the loop below it; a loop between constants needs none.

#import common/casters
#import shadow/shadow

// The output of vertex shaders of volumes. Draws of one volume must agree in every bit, so it is invariant.
struct VolumeVertex {
  @invariant @builtin(position) clip: vec4<f32>,
}

// The position of all vertices of an instance that is not drawn: triangles without area.
const NOTHING = vec4<f32>(0.0, 0.0, 0.0, 1.0);

// Picks one vertex of a polygon. The vertices are offered one after another. A number past the last vertex gives the last one.
struct Picked {
  clip: vec4<f32>,
  wanted: u32, // Its number among the vertices that are there.
  offered: u32, // So many were there by now.
}

// Picks the vertex at `place` of the strip 0, 1, 4, 2, 3 of a polygon of up to five vertices.
fn pick(place: u32) -> Picked {
  let order = vec4<u32>(0u, 1u, 4u, 2u);
  return Picked(NOTHING, select(order[min(place, 3u)], 3u, place == 4u), 0u);
}

fn offer(picked: Picked, clip: vec4<f32>, is_there: bool) -> Picked {
  var next = picked;
  if (is_there) {
    if (picked.offered <= picked.wanted) {
      next.clip = clip;
    }
    next.offered++;
  }
  return next;
}

// Whether polygons are trimmed. A draw has as many vertices as without TRIM, so it takes a part of each polygon, and up to seven
// draws are made: in a strip corners 0 and 2 PART + 1 to 2 PART + 3, a convex quad; in a list of triangles 0, PART + 1, PART + 2.
override TRIM: bool = false;
override PART: u32 = 0u;
override UNCLIPPED: bool = false; // Whether near and far plane do not clip (depth is clamped).
// Five corners, and one more for each plane.
const MOST_CORNERS: u32 = 11u;

// A convex polygon in clip space.
struct Outline {
  corners: array<vec4<f32>, MOST_CORNERS>,
  count: u32,
}

// Drops a corner past MOST_CORNERS, which a convex polygon cannot have.
fn with_corner(outline: Outline, clip: vec4<f32>) -> Outline {
  var next = outline;
  if (next.count < MOST_CORNERS) {
    next.corners[next.count] = clip;
    next.count++;
  }
  return next;
}

// The place in a strip of corner `index`, 0 to 4, of a polygon: the inverse of the order in `pick`.
fn strip_place(index: u32) -> u32 {
  let order = vec4<u32>(0u, 1u, 3u, 4u);
  return select(order[min(index, 3u)], 2u, index == 4u);
}

// At least 0 on the inner side of plane 0 to 5 of the frustum: left, right, bottom, top, z = 0, z = w.
fn inner_height(plane: u32, clip: vec4<f32>) -> f32 {
  let along = clip[plane / 2u];
  if (plane == 4u) {
    return along;
  }
  return clip.w + select(along, -along, (plane & 1u) != 0u);
}

// Where an edge meets a plane: exactly on it, so that nothing is left for the driver to clip.
fn meet_plane(plane: u32, inner: vec4<f32>, outer: vec4<f32>) -> vec4<f32> {
  let height = inner_height(plane, inner);
  let depth = -inner_height(plane, outer);
  // Ends may differ by many orders of magnitude, since they are homogeneous. They are added with weights from 0 to 1, and not as
  // one end plus a share of the difference, in which the smaller would be lost.
  var meeting = inner * (depth / (height + depth)) + outer * (height / (height + depth));
  meeting[plane / 2u] = select(select(-meeting.w, 0.0, plane == 4u), meeting.w, (plane & 1u) != 0u);
  return meeting;
}

// The part of a polygon in the frustum. It goes from one plane to the next, and cuts an edge from its inner to its outer end. So
// an edge that two polygons share is cut to the same bits.
fn trimmed(outline: Outline) -> Outline {
  var polygon = outline;
  let planes = select(6u, 4u, UNCLIPPED);
  // Turns: 6.
  for (var plane = 0u; plane < planes; plane++) {
    var next: Outline;
    // Turns: 11.
    for (var index = 0u; index < polygon.count; index++) {
      let here = polygon.corners[index];
      let there = polygon.corners[select(index + 1u, 0u, index + 1u == polygon.count)];
      let is_in = inner_height(plane, here) >= 0.0;
      if (is_in) {
        next = with_corner(next, here);
      }
      if (is_in != (inner_height(plane, there) >= 0.0)) {
        if (is_in) {
          next = with_corner(next, meet_plane(plane, here, there));
        } else {
          next = with_corner(next, meet_plane(plane, there, here));
        }
      }
    }
    polygon = next;
  }
  return polygon;
}

// A vertex of the part PART, in a list or strip. All are one point if the polygon has no such part.
fn vertex_of_part(polygon: Outline, is_list: bool, vertex: u32) -> vec4<f32> {
  let first = select(2u, 1u, is_list) * PART;
  if (first + 2u >= polygon.count) {
    return NOTHING;
  }
  if (vertex == 0u) {
    return polygon.corners[0];
  }
  // Corners 0, 1, 3, 2 of a quad are a strip. Its vertices from the fourth on are corner 2.
  let index = select(select(vertex, 3u, vertex == 2u), 2u, vertex > 2u);
  return polygon.corners[min(first + select(index, vertex, is_list), polygon.count - 1u)];
}

// The corners of a face, in the face's own order. `order`: a number for each, its vertex index; computations along an edge begin
// at the corner of the lower number, so that faces and sides that meet there have equal bits.
struct CapFace {
  a: vec3<f32>,
  b: vec3<f32>,
  c: vec3<f32>,
  order: vec3<u32>,
}

// Offers `a` if it is not before the near plane, then the point where the edge to `b` meets that. `is_ordered`: `a` has the lower
// vertex index.
fn offer_clipped(picked: Picked, view: ShadowView, a: Corner, b: Corner, is_ordered: bool) -> Picked {
  var next = offer(picked, behind_near_plane(view, a.near), a.height >= 0.0);
  let meets_plane = (a.height >= 0.0) != (b.height >= 0.0);
  if (is_ordered) {
    return offer(next, on_near_plane(view, a, b), meets_plane);
  }
  return offer(next, on_near_plane(view, b, a), meets_plane);
}

// The light cap of a caster that is not in the depth buffer, as a strip of four vertices. With ZP+ it is clipped at the near
// plane, where it has the bits of near cap and sides; else the hardware clips it.
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
// within the face as seen from the light, else nothing. docs/numerics/rasterisers.md, "Dark caps of orthographic cameras".
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
  // It has the orientation of the face on the screen, and the farthest depth: `near_z`, the depth of the near plane, is 1 with
  // reversed depth, else 0.
  let x = select(-1.0, 3.0, vertex == select(2u, 1u, left));
  let y = select(-1.0, 3.0, vertex == select(1u, 2u, left));
  return vec4<f32>(x, y, 1.0 - view.near_z, 1.0);
}

// Vertex 0, 1 or 2 of a face at the far end of the volume, which is at infinity if `light.end` is 0.
fn dark_cap_vertex(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> vec4<f32> {
  if (is_orthographic(view) && light.end == 0.0) {
    return all_or_nothing(view, light, face, vertex);
  }
  return far_end(view, light, select(select(face.a, face.b, vertex == 1u), face.c, vertex == 2u));
}

// Offers the vertices of a near cap from `a` on, before `b`. The slab is what lies between the near plane and the plane parallel
// to it through the light. `a` is projected if it is in the slab; `meeting` is where the edge crosses the near plane, `turning`
// where it crosses the other plane, projected to infinity.
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
  // Whether an edge that crosses the whole slab comes to the light's plane first.
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

// A side that is not clipped, as a strip of four vertices: the first and the second, then their far vertices.
fn side_vertex(view: ShadowView, light: ShadowLight, first: vec3<f32>, second: vec3<f32>, vertex: u32) -> vec4<f32> {
  let position = select(first, second, (vertex & 1u) != 0u);
  if (vertex < 2u) {
    return to_clip(view, position);
  }
  return far_end(view, light, position);
}

// A side clipped at the near plane, as a strip of five vertices. `is_ordered`: the first end has the lower vertex index.
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

// The vertices of caps and sides as they are drawn. If TRIM is set, each invocation makes the whole polygon, trims it and takes
// its own vertex.
fn drawn_light_cap(view: ShadowView, light: ShadowLight, face: CapFace, ends_at_near_plane: bool, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(seen_light_cap_vertex(view, light, face, ends_at_near_plane, vertex));
  }
  var outline: Outline;
  for (var index = 0u; index < 5u; index++) {
    outline = with_corner(outline, seen_light_cap_vertex(view, light, face, ends_at_near_plane, strip_place(index)));
  }
  return VolumeVertex(vertex_of_part(trimmed(outline), false, vertex));
}

fn drawn_dark_cap(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(dark_cap_vertex(view, light, face, vertex));
  }
  var outline: Outline;
  for (var index = 0u; index < 3u; index++) {
    outline = with_corner(outline, dark_cap_vertex(view, light, face, index));
  }
  return VolumeVertex(vertex_of_part(trimmed(outline), true, vertex));
}

fn drawn_near_cap(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(near_cap_vertex(view, light, face, vertex));
  }
  var outline: Outline;
  for (var index = 0u; index < 5u; index++) {
    outline = with_corner(outline, near_cap_vertex(view, light, face, strip_place(index)));
  }
  return VolumeVertex(vertex_of_part(trimmed(outline), false, vertex));
}

fn drawn_side(view: ShadowView, light: ShadowLight, first: vec3<f32>, second: vec3<f32>, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(side_vertex(view, light, first, second, vertex));
  }
  var outline: Outline;
  for (var index = 0u; index < 4u; index++) {
    outline = with_corner(outline, side_vertex(view, light, first, second, index ^ (index >> 1u)));
  }
  return VolumeVertex(vertex_of_part(trimmed(outline), false, vertex));
}

fn drawn_clipped_side(view: ShadowView, light: ShadowLight, first: vec3<f32>, second: vec3<f32>, is_ordered: bool, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(clipped_side_vertex(view, light, first, second, is_ordered, vertex));
  }
  var outline: Outline;
  for (var index = 0u; index < 5u; index++) {
    outline = with_corner(outline, clipped_side_vertex(view, light, first, second, is_ordered, strip_place(index)));
  }
  return VolumeVertex(vertex_of_part(trimmed(outline), false, vertex));
}

// ZP+ as published (Hornus et al. 2005): the light's frustum has the near rectangle as its far rectangle.

// A position transformed by the matrix of that frustum, which has no row for z: `.x` and `.y` are x and y, and `.z` is w.
fn in_frustum(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec3<f32> {
  let q = placed(view, position);
  return vec3<f32>(
    dot_3(light.frustum_x.xyz, q) + light.frustum_x.w,
    dot_3(light.frustum_y.xyz, q) + light.frustum_y.w,
    dot_3(light.frustum_w.xyz, q) + light.frustum_w.w,
  );
}

// The same position in clip space, with a depth that only clips, since near caps pass every depth test: z / w is 1 on the near
// plane and 0 in front of the caster (section 3.2), also with reversed depth. For a point light `frustum_near` is the distance of
// the frustum's near end from the light over that of its far end. A light at infinity has parallel rays and the same w
// everywhere, so the height over the near plane replaces the distance from the light, and `frustum_near` is a height.
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

// A vertex projected from the light onto the near plane, as its near cap has it.
fn counterpart(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
  let p = in_frustum(view, light, position);
  return vec4<f32>(p.xy, p.z * view.near_z, p.z);
}

// Whether a vertex is on the eye's side of the near plane.
fn is_cut(view: ShadowView, clip: vec4<f32>) -> bool {
  return clip.w <= 0.0 || select((clip.z < 0.0), (clip.z > clip.w), view.near_z != 0.0);
}
