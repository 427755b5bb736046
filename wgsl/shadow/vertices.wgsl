// Vertices of sides and caps of shadow volumes, in clip space, for the vertex shaders `sides`, `cap_faces` and
// `piece_volumes`; `zp_plus_2005_cases` takes one test from here.
// A side is the quad from an edge away from the light. A light cap is a face, a dark cap is the same face at the far end
// of the volume. A near cap is the part of a face between light and near plane, projected from the light onto that plane.
// Shapes clipped at the near plane are polygons of up to five vertices, drawn as strips.
// Shapes that meet at an edge have equal bits there, so volumes are watertight. Both take the ends of the edge in the
// order of their vertex indices (`is_ordered`), and both call the functions of shadow/shadow.wgsl. No expression may
// differ between them. docs/numerics/shadow-volumes.md, "Closed volumes".
// If TRIM is set, polygons are cut at the frustum, for drivers that clip slivers wrongly. docs/numerics/rasterisers.md,
// "Clipped slivers". The last part of the file is ZP+ as published in 2005. A comment `Turns:` says how many iterations
// the loop below it has at most.

#import common/casters
#import common/order_keys
#import shadow/shadow

// The output of the vertex shaders of volumes. Draws of one volume must agree in every bit, so the position is invariant.
struct VolumeVertex {
  @invariant @builtin(position) clip: vec4<f32>,
}

// The position of every vertex of an instance that is not drawn. Its triangles have no area.
const NOT_DRAWN = vec4<f32>(0.0, 0.0, 0.0, 1.0);

// One vertex of a polygon, selected while the vertices are emitted one after another. If the polygon has fewer vertices, it
// is the last one.
struct SelectedVertex {
  clip: vec4<f32>,
  index: u32, // The index of the selected vertex in the polygon.
  emitted: u32, // The count of vertices emitted so far.
}

// Selects a vertex of a polygon of up to five vertices by its index in the strip. The strip is vertices 0, 1, 4, 2, 3.
fn select_strip_vertex(strip_index: u32) -> SelectedVertex {
  let order = vec4<u32>(0u, 1u, 4u, 2u);
  return SelectedVertex(NOT_DRAWN, select(order[min(strip_index, 3u)], 3u, strip_index == 4u), 0u);
}

// Emits the next vertex of the polygon, if the polygon has it.
fn emit_vertex(selected: SelectedVertex, clip: vec4<f32>, is_present: bool) -> SelectedVertex {
  var next = selected;
  if (is_present) {
    if (selected.emitted <= selected.index) {
      next.clip = clip;
    }
    next.emitted++;
  }
  return next;
}

// Whether polygons are trimmed: cut at the frustum. A trimmed polygon has up to eleven corners, and a draw has as many
// vertices an instance as without TRIM. So up to seven draws are made, one for each part of the polygons. Part p is in a
// strip the convex quad of corners 0 and 2 p + 1 to 2 p + 3, in a list the triangle of corners 0, p + 1 and p + 2.
override TRIM: bool = false;
// x: the part that is drawn. A constant would need a pipeline for each part, and these shaders compile slowly.
@group(0) @binding(4) var<uniform> drawn_part: vec4<u32>;
override UNCLIPPED: bool = false; // Whether near and far plane do not clip, since depth is clamped.
const MOST_CORNERS: u32 = 11u; // Five, and one more for each plane.

// A convex polygon in clip space.
struct ClipPolygon {
  corners: array<vec4<f32>, MOST_CORNERS>,
  count: u32,
}

// Appends a corner. It drops corners past MOST_CORNERS, which a convex polygon cannot have.
fn append_corner(polygon: ClipPolygon, clip: vec4<f32>) -> ClipPolygon {
  var next = polygon;
  if (next.count < MOST_CORNERS) {
    next.corners[next.count] = clip;
    next.count++;
  }
  return next;
}

// The strip index of corner 0 to 4 of a polygon: the inverse of the order in `select_strip_vertex`.
fn strip_index_of(corner_index: u32) -> u32 {
  let order = vec4<u32>(0u, 1u, 3u, 4u);
  return select(order[min(corner_index, 3u)], 2u, corner_index == 4u);
}

// The height over plane 0 to 5 of the frustum: left, right, bottom, top, z = 0, z = w. It is at least 0 within the frustum.
fn height_over_plane(plane: u32, clip: vec4<f32>) -> f32 {
  let along = clip[plane / 2u];
  if (plane == 4u) {
    return along;
  }
  return clip.w + select(along, -along, (plane & 1u) != 0u);
}

// The intersection of an edge with a plane of the frustum. It lies exactly on the plane, so that the driver clips nothing.
fn intersect_plane(plane: u32, inner: vec4<f32>, outer: vec4<f32>) -> vec4<f32> {
  let height = height_over_plane(plane, inner);
  let depth = -height_over_plane(plane, outer);
  // Ends are homogeneous and may differ by many orders of magnitude. Weights from 0 to 1 keep both. One end plus a part of
  // the difference would lose the smaller end.
  var meeting = inner * (depth / (height + depth)) + outer * (height / (height + depth));
  meeting[plane / 2u] = select(select(-meeting.w, 0.0, plane == 4u), meeting.w, (plane & 1u) != 0u);
  return meeting;
}

// The part of a polygon in the frustum. It is cut plane by plane, each edge from its inner to its outer end. So an edge that
// two polygons share is cut to the same bits.
fn trim_to_frustum(untrimmed: ClipPolygon) -> ClipPolygon {
  var polygon = untrimmed;
  let planes = select(6u, 4u, UNCLIPPED);
  // Turns: 6.
  for (var plane = 0u; plane < planes; plane++) {
    var next: ClipPolygon;
    // Turns: 11.
    for (var index = 0u; index < polygon.count; index++) {
      let here = polygon.corners[index];
      let there = polygon.corners[select(index + 1u, 0u, index + 1u == polygon.count)];
      let is_inside = height_over_plane(plane, here) >= 0.0;
      if (is_inside) {
        next = append_corner(next, here);
      }
      if (is_inside != (height_over_plane(plane, there) >= 0.0)) {
        if (is_inside) {
          next = append_corner(next, intersect_plane(plane, here, there));
        } else {
          next = append_corner(next, intersect_plane(plane, there, here));
        }
      }
    }
    polygon = next;
  }
  return polygon;
}

// A vertex of the drawn part of a polygon, in a list of triangles or a strip. All vertices are equal if the polygon does not
// have the part.
fn vertex_of_part(polygon: ClipPolygon, is_list: bool, vertex: u32) -> vec4<f32> {
  let first = select(2u, 1u, is_list) * drawn_part.x;
  if (first + 2u >= polygon.count) {
    return NOT_DRAWN;
  }
  if (vertex == 0u) {
    return polygon.corners[0];
  }
  // The strip of a quad is corners 0, 1, 3, 2. Vertices from 4 on repeat corner 2.
  let index = select(select(vertex, 3u, vertex == 2u), 2u, vertex > 2u);
  return polygon.corners[min(first + select(index, vertex, is_list), polygon.count - 1u)];
}

// The corners of a face, in the order of the face. `ranks` are their vertex indices. All computations along an edge begin at
// the corner of lower rank, so that faces and sides that meet there have equal bits.
struct CapFace {
  a: vec3<f32>,
  b: vec3<f32>,
  c: vec3<f32>,
  ranks: vec3<u32>,
}

// Emits what the edge from `a` to `b` adds to a polygon clipped at the near plane: `a` if it is not before the plane, then
// the intersection. `is_ordered`: `a` has the lower rank.
fn emit_clipped_edge(selected: SelectedVertex, view: ShadowView, a: Corner, b: Corner, is_ordered: bool) -> SelectedVertex {
  var next = emit_vertex(selected, behind_near_plane(view, a.near), a.height >= 0.0);
  let crosses_plane = (a.height >= 0.0) != (b.height >= 0.0);
  if (is_ordered) {
    return emit_vertex(next, on_near_plane(view, a, b), crosses_plane);
  }
  return emit_vertex(next, on_near_plane(view, b, a), crosses_plane);
}

// The light cap of a piece, or of a caster that is not in the depth buffer, as a strip of four vertices. With ZP+ it is
// clipped at the near plane, where near cap and sides have the same bits. Else the hardware clips it.
fn seen_light_cap_vertex(
  view: ShadowView,
  light: ShadowLight,
  face: CapFace,
  ends_at_near_plane: bool,
  vertex: u32,
) -> vec4<f32> {
  var selected = select_strip_vertex(vertex);
  if (ends_at_near_plane) {
    let a = corner(view, light, face.a);
    let b = corner(view, light, face.b);
    let c = corner(view, light, face.c);
    selected = emit_clipped_edge(selected, view, a, b, face.ranks.x < face.ranks.y);
    selected = emit_clipped_edge(selected, view, b, c, face.ranks.y < face.ranks.z);
    selected = emit_clipped_edge(selected, view, c, a, face.ranks.z < face.ranks.x);
  } else {
    selected = emit_vertex(selected, to_clip(view, face.a), true);
    selected = emit_vertex(selected, to_clip(view, face.b), true);
    selected = emit_vertex(selected, to_clip(view, face.c), true);
  }
  return selected.clip;
}

// Whether the camera's direction is left of the edge between two far vertices, as seen from the light. The vertex of lower
// rank comes first, so that the faces on both sides of the edge agree.
fn is_direction_left(a: vec2<f32>, b: vec2<f32>, is_ordered: bool) -> bool {
  if (is_ordered) {
    return a.x * b.y - a.y * b.x >= 0.0;
  }
  return !(b.x * a.y - b.y * a.x >= 0.0);
}

// A vertex of a dark cap at infinity for an orthographic camera. The cap covers the whole picture if the camera's direction
// is within the face as seen from the light, else nothing. docs/numerics/rasterisers.md, "Dark caps of orthographic
// cameras".
fn orthographic_dark_cap_vertex(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> vec4<f32> {
  let a = extrusion(view, light, face.a);
  let b = extrusion(view, light, face.b);
  let c = extrusion(view, light, face.c);
  let p = direction_to_clip(view, a).xy;
  let q = direction_to_clip(view, b).xy;
  let r = direction_to_clip(view, c).xy;
  let left_of_first = is_direction_left(p, q, face.ranks.x < face.ranks.y);
  let left_of_second = is_direction_left(q, r, face.ranks.y < face.ranks.z);
  let left_of_third = is_direction_left(r, p, face.ranks.z < face.ranks.x);
  if (left_of_first != left_of_second || left_of_first != left_of_third) {
    return NOT_DRAWN;
  }
  // This weighted sum of the three vectors is the camera's direction or its opposite.
  let along = a * (q.x * r.y - q.y * r.x) + b * (r.x * p.y - r.y * p.x) + c * (p.x * q.y - p.y * q.x);
  if ((dot_3(view.near_plane.xyz, along) > 0.0) != left_of_first) {
    return NOT_DRAWN;
  }
  // A triangle around the picture, with the orientation of the face on the screen, at the farthest depth.
  let x = select(-1.0, 3.0, vertex == select(2u, 1u, left_of_first));
  let y = select(-1.0, 3.0, vertex == select(1u, 2u, left_of_first));
  return vec4<f32>(x, y, 1.0 - view.near_z, 1.0);
}

// Vertex 0, 1 or 2 of a dark cap: a face at the far end of the volume, which is at infinity if `light.end` is 0.
fn dark_cap_vertex(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> vec4<f32> {
  if (is_orthographic(view) && light.end == 0.0) {
    return orthographic_dark_cap_vertex(view, light, face, vertex);
  }
  return far_vertex(view, light, select(select(face.a, face.b, vertex == 1u), face.c, vertex == 2u));
}

// Emits what the edge from `a` to `b` adds to a near cap. A near cap is the face within a slab, projected onto the near
// plane. The slab is between the near plane and the parallel plane through the light. The edge adds `a` if it is in the
// slab, the intersection with the near plane, and the intersection with the light's plane, which is projected to infinity.
fn emit_near_cap_edge(
  selected: SelectedVertex,
  view: ShadowView,
  light: ShadowLight,
  a: Corner,
  b: Corner,
  is_ordered: bool,
) -> SelectedVertex {
  let is_above = a.height >= 0.0;
  let is_rising = a.far_height >= 0.0;
  let crosses_near_plane = is_above != (b.height >= 0.0);
  let crosses_light_plane = is_rising != (b.far_height >= 0.0);
  var on_near = NOT_DRAWN;
  var at_infinity = NOT_DRAWN;
  if (is_ordered) {
    on_near = on_near_plane(view, a, b);
    at_infinity = parallel_to_near_plane(a, b);
  } else {
    on_near = on_near_plane(view, b, a);
    at_infinity = parallel_to_near_plane(b, a);
  }
  // Whether an edge that crosses both planes crosses the light's plane first.
  let is_light_plane_first = is_above == (light_side(light) > 0.0);
  var next = emit_vertex(selected, project_to_near_plane(view, light, a), is_above != is_rising);
  next = emit_vertex(next, at_infinity, crosses_light_plane && is_light_plane_first);
  next = emit_vertex(next, on_near, crosses_near_plane);
  return emit_vertex(next, at_infinity, crosses_light_plane && !is_light_plane_first);
}

// A near cap, as a strip of five vertices.
fn near_cap_vertex(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> vec4<f32> {
  let a = corner(view, light, face.a);
  let b = corner(view, light, face.b);
  let c = corner(view, light, face.c);
  var selected = select_strip_vertex(vertex);
  selected = emit_near_cap_edge(selected, view, light, a, b, face.ranks.x < face.ranks.y);
  selected = emit_near_cap_edge(selected, view, light, b, c, face.ranks.y < face.ranks.z);
  selected = emit_near_cap_edge(selected, view, light, c, a, face.ranks.z < face.ranks.x);
  return selected.clip;
}

// Whether a position comes before another. Sides of equal edges with opposite directions cancel, so that they must have the
// same triangles, or a driver could round their depths differently. docs/numerics/shadow-volumes.md, "Sides that cancel".
fn precedes(p: vec3<f32>, q: vec3<f32>) -> bool {
  let a = order_keys(bitcast<vec3<u32>>(p));
  let b = order_keys(bitcast<vec3<u32>>(q));
  if (a.x != b.x) {
    return a.x < b.x;
  }
  return a.y < b.y || (a.y == b.y && a.z < b.z);
}

// A side that the hardware clips, as a strip of four vertices that begins at the end that comes first: both ends of the
// edge, then their far vertices, or each end with its far vertex.
fn side_vertex(view: ShadowView, light: ShadowLight, first: vec3<f32>, second: vec3<f32>, vertex: u32) -> vec4<f32> {
  let is_along = precedes(first, second);
  let bits = vec2<bool>((vertex & 1u) != 0u, vertex >= 2u);
  let is_second = select(!bits.y, bits.x, is_along);
  let is_far = select(bits.x, bits.y, is_along);
  let position = select(first, second, is_second);
  if (!is_far) {
    return to_clip(view, position);
  }
  return far_vertex(view, light, position);
}

// A side clipped at the near plane, as a strip of five vertices. It ignores `light.end`, since volumes that ZP+ counts do not
// end. `is_ordered`: the first end has the lower vertex index. Its vertices follow the boundary of the quad: from the end
// that comes first to the other, then back along the far vertices. If this is not the direction of the side, the strip is
// reversed.
fn clipped_side_vertex(
  view: ShadowView,
  light: ShadowLight,
  first: vec3<f32>,
  second: vec3<f32>,
  is_ordered: bool,
  vertex: u32,
) -> vec4<f32> {
  let is_along = precedes(first, second);
  let p = corner(view, light, select(second, first, is_along));
  let q = corner(view, light, select(first, second, is_along));
  let is_p_lower = is_ordered == is_along;
  let has_first = p.height >= 0.0;
  let has_second = q.height >= 0.0;
  let has_first_far = p.far_height >= 0.0;
  let has_second_far = q.far_height >= 0.0;
  var selected = select_strip_vertex(select(4u - vertex, vertex, is_along));
  selected = emit_vertex(selected, behind_near_plane(view, p.near), has_first);
  if (has_first != has_second) {
    if (is_p_lower) {
      selected = emit_vertex(selected, on_near_plane(view, p, q), true);
    } else {
      selected = emit_vertex(selected, on_near_plane(view, q, p), true);
    }
  }
  selected = emit_vertex(selected, behind_near_plane(view, q.near), has_second);
  selected = emit_vertex(selected, project_to_near_plane(view, light, q), has_second != has_second_far);
  selected = emit_vertex(selected, q.far, has_second_far);
  if (has_first_far != has_second_far) {
    if (is_p_lower) {
      selected = emit_vertex(selected, parallel_to_near_plane(p, q), true);
    } else {
      selected = emit_vertex(selected, parallel_to_near_plane(q, p), true);
    }
  }
  selected = emit_vertex(selected, p.far, has_first_far);
  selected = emit_vertex(selected, project_to_near_plane(view, light, p), has_first != has_first_far);
  return selected.clip;
}

// The functions `drawn_…` return the vertices of caps and sides as they are drawn. If TRIM is set, each invocation makes the
// whole polygon, trims it and takes one vertex of the drawn part.
fn drawn_light_cap(view: ShadowView, light: ShadowLight, face: CapFace, ends_at_near_plane: bool, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(seen_light_cap_vertex(view, light, face, ends_at_near_plane, vertex));
  }
  var polygon: ClipPolygon;
  for (var index = 0u; index < 5u; index++) {
    polygon = append_corner(
      polygon, seen_light_cap_vertex(view, light, face, ends_at_near_plane, strip_index_of(index)));
  }
  return VolumeVertex(vertex_of_part(trim_to_frustum(polygon), false, vertex));
}

fn drawn_dark_cap(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(dark_cap_vertex(view, light, face, vertex));
  }
  var polygon: ClipPolygon;
  for (var index = 0u; index < 3u; index++) {
    polygon = append_corner(polygon, dark_cap_vertex(view, light, face, index));
  }
  return VolumeVertex(vertex_of_part(trim_to_frustum(polygon), true, vertex));
}

fn drawn_near_cap(view: ShadowView, light: ShadowLight, face: CapFace, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(near_cap_vertex(view, light, face, vertex));
  }
  var polygon: ClipPolygon;
  for (var index = 0u; index < 5u; index++) {
    polygon = append_corner(polygon, near_cap_vertex(view, light, face, strip_index_of(index)));
  }
  return VolumeVertex(vertex_of_part(trim_to_frustum(polygon), false, vertex));
}

fn drawn_side(view: ShadowView, light: ShadowLight, first: vec3<f32>, second: vec3<f32>, vertex: u32) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(side_vertex(view, light, first, second, vertex));
  }
  var polygon: ClipPolygon;
  for (var index = 0u; index < 4u; index++) {
    // The boundary of the quad is strip vertices 0, 1, 3, 2.
    polygon = append_corner(polygon, side_vertex(view, light, first, second, index ^ (index >> 1u)));
  }
  return VolumeVertex(vertex_of_part(trim_to_frustum(polygon), false, vertex));
}

fn drawn_clipped_side(
  view: ShadowView,
  light: ShadowLight,
  first: vec3<f32>,
  second: vec3<f32>,
  is_ordered: bool,
  vertex: u32,
) -> VolumeVertex {
  if (!TRIM) {
    return VolumeVertex(clipped_side_vertex(view, light, first, second, is_ordered, vertex));
  }
  var polygon: ClipPolygon;
  for (var index = 0u; index < 5u; index++) {
    polygon = append_corner(
      polygon, clipped_side_vertex(view, light, first, second, is_ordered, strip_index_of(index)));
  }
  return VolumeVertex(vertex_of_part(trim_to_frustum(polygon), false, vertex));
}

// ZP+ as published (Hornus et al. 2005). A frustum of the light has the near rectangle as its far rectangle, and near caps
// are faces transformed by the matrix of this frustum. The near rectangle is what the camera sees of the near plane.

// A position transformed by this matrix, which has no row for z. The result is x, y and w.
fn in_frustum(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec3<f32> {
  let q = to_camera_frame(view, position);
  return vec3<f32>(
    dot_3(light.frustum_x.xyz, q) + light.frustum_x.w,
    dot_3(light.frustum_y.xyz, q) + light.frustum_y.w,
    dot_3(light.frustum_w.xyz, q) + light.frustum_w.w,
  );
}

// The same position in clip space. Its depth only clips, since near caps pass every depth test: z / w is 1 on the near plane
// and 0 in front of the caster (section 3.2), with reversed depth, too. A light at infinity has the same w everywhere, so
// the height over the near plane replaces the distance from the light, and `frustum_near` is a height.
fn frustum_to_clip(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
  let p = in_frustum(view, light, position);
  let near_w = view.near_w * abs(light.height);
  var z = (p.z - light.frustum_near * near_w) / (1.0 - light.frustum_near);
  if (light.light.w == 0.0) {
    let height = dot_3(view.near_plane.xyz, to_camera_frame(view, position)) + view.near_plane.w;
    z = p.z * (1.0 - light_side(light) * height / light.frustum_near);
  }
  return vec4<f32>(p.xy, z, p.z);
}

// A position projected from the light onto the near plane, with the x, y and w that `frustum_to_clip` gives near caps.
fn counterpart_in_near_cap(view: ShadowView, light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
  let p = in_frustum(view, light, position);
  return vec4<f32>(p.xy, p.z * view.near_z, p.z);
}

// Whether a vertex is on the eye's side of the near plane.
fn is_before_near_plane(view: ShadowView, clip: vec4<f32>) -> bool {
  return clip.w <= 0.0 || select((clip.z < 0.0), (clip.z > clip.w), view.near_z != 0.0);
}
