// Results: the public include (`include_wgsl`) by which a caller's shaders read an extraction for a batch of up to 32
// lights. It reads silhouette edges by instance of the light's indirect draw, facing bits and positions. The stage
// `outline_edges` imports it, too. A light is given by its index among all lights of the extraction, as in
// `Extraction::draw`. A light of another batch has no edge. GROUP is the index of the bind group that
// `Extraction::bind_group` makes. If a light's list overflowed, its draw has an instance for every edge record, and `valid`
// marks the silhouettes; `rimline_edge_vertex` draws nothing for the others. Callers and src/gpu/extract/include.rs use the
// names and bindings: they must not change. Callers get this file as it is, so it has no `#import` and no `#if`.

struct RimlineInfo {
  edges: u32,
  capacity: u32, // Entries that the list of each light has room for.
  // The index of the batch's first light among all lights, and the number of its lights.
  first_light: u32,
  lights: u32,
  // The word of vertex 0 in the bound positions, and the words from one vertex to the next.
  position_offset: u32,
  position_stride: u32,
  // The offset of the twisted masks behind the facing masks: for each face the lights for which its polygon is
  // twisted. 0: there are none.
  twisted_offset: u32,
  // Vertices of the draw for each edge, by `ListOptions::topology`.
  vertices_per_edge: u32,
}

// An edge for one light.
struct RimlineSilhouette {
  // False: no silhouette, so draw none. The draw of a list that overflowed has such edges, and so has a light of another
  // batch. `winding` has no meaning then. The rest holds, for creases and marks (interface/outlined.wgsl).
  valid: bool,
  // The index of the edge record, and its vertices. Face 0 traverses the edge a -> b.
  edge: u32,
  a: u32,
  b: u32,
  // The facing bit of face 0 or, if face 0 is twisted, that of face 1 for the direction of face 0. If set, (b, a, far a,
  // far b) is counter-clockwise as seen from outside the shadow volume.
  winding: bool,
  kind: u32, // 0 consistent, 1 inconsistent, 2 boundary.
}

@group(GROUP) @binding(0) var<uniform> rimline_info: RimlineInfo;
@group(GROUP) @binding(1) var<storage, read> rimline_positions: array<u32>;
@group(GROUP) @binding(2) var<storage, read> rimline_edge_vertices: array<vec2<u32>>;
@group(GROUP) @binding(3) var<storage, read> rimline_edge_faces: array<vec2<u32>>;
@group(GROUP) @binding(4) var<storage, read> rimline_facing: array<u32>;
@group(GROUP) @binding(5) var<storage, read> rimline_list: array<u32>;
@group(GROUP) @binding(6) var<storage, read> rimline_counts: array<u32>;

// The position of a vertex, in the space of the extracted positions.
fn rimline_position(vertex: u32) -> vec3<f32> {
  let word = rimline_info.position_offset + vertex * rimline_info.position_stride;
  return bitcast<vec3<f32>>(
    vec3<u32>(rimline_positions[word], rimline_positions[word + 1u], rimline_positions[word + 2u]));
}

// A position of world space in clip space. z-fail needs a depth pass that has the same bits as light caps. It has them if
// it computes positions in this way, from the matrix and origin of the `ShadowCamera`, and its position is `@invariant`.
// Volumes of moved rigid casters round otherwise (`CasterPositions::Rigid`).
fn rimline_clip(view_projection: mat4x4<f32>, origin: vec3<f32>, position: vec3<f32>) -> vec4<f32> {
  let q = position - origin;
  return view_projection[0] * q.x + view_projection[1] * q.y + view_projection[2] * q.z + view_projection[3];
}

// Whether the bound batch has this light.
fn rimline_has_light(light: u32) -> bool {
  return light - rimline_info.first_light < rimline_info.lights;
}

// The bit of a light in the masks of its batch.
fn rimline_light_bit(light: u32) -> u32 {
  return 1u << ((light - rimline_info.first_light) & 31u);
}

// Whether a face faces a light.
fn rimline_faces_light(face: u32, light: u32) -> bool {
  return rimline_has_light(light) && (rimline_facing[face] & rimline_light_bit(light)) != 0u;
}

// Whether a face is twisted for a light. Such a face counts as absent: its neighbours' edges to it are boundaries.
fn rimline_is_twisted(face: u32, light: u32) -> bool {
  return rimline_info.twisted_offset != 0u && rimline_has_light(light)
    && (rimline_facing[rimline_info.twisted_offset + face] & rimline_light_bit(light)) != 0u;
}

// The number of silhouette edges of a light of any batch, including those that its list has no room for.
fn rimline_silhouettes(light: u32) -> u32 {
  return rimline_counts[light];
}

// Edge record `edge` for a light, decided by the facing bits of its faces. `valid`: it is a silhouette edge.
fn rimline_edge(light: u32, edge: u32) -> RimlineSilhouette {
  let vertices = rimline_edge_vertices[edge];
  let faces = rimline_edge_faces[edge];
  let face_0 = faces.x & 0x7fffffffu;
  let is_boundary = faces.y == 0xffffffffu;
  let kind = select(faces.x >> 31u, 2u, is_boundary);
  // `is_present_…`: the face exists and is not twisted. `aligned_facing_1`: the facing of face 1 for the direction of face
  // 0.
  let is_present_0 = !rimline_is_twisted(face_0, light);
  let faces_0 = rimline_faces_light(face_0, light);
  var is_present_1 = false;
  var aligned_facing_1 = false;
  if (!is_boundary) {
    is_present_1 = !rimline_is_twisted(faces.y, light);
    aligned_facing_1 = rimline_faces_light(faces.y, light) == (kind == 1u);
  }
  let is_silhouette = is_present_0 != is_present_1 || (is_present_0 && faces_0 == aligned_facing_1);
  let valid = rimline_has_light(light) && is_silhouette;
  // The winding is the facing of a present face, for the direction of face 0.
  return RimlineSilhouette(valid, edge, vertices.x, vertices.y, select(aligned_facing_1, faces_0, is_present_0), kind);
}

// The silhouette edge of instance `instance` of a light's indirect draw.
fn rimline_silhouette(light: u32, instance: u32) -> RimlineSilhouette {
  if (!rimline_has_light(light) || rimline_silhouettes(light) > rimline_info.capacity) {
    return rimline_edge(light, instance);
  }
  let entry = rimline_list[(light - rimline_info.first_light) * rimline_info.capacity + instance];
  let edge = entry & 0x7fffffffu;
  let vertices = rimline_edge_vertices[edge];
  let faces = rimline_edge_faces[edge];
  let kind = select(faces.x >> 31u, 2u, faces.y == 0xffffffffu);
  return RimlineSilhouette(true, edge, vertices.x, vertices.y, entry >= 0x80000000u, kind);
}

// The corner of an edge's quad at vertex `vertex` of the draw, in the order of a triangle strip. Bit 0: which end of the
// edge; bit 1: which side of the quad. A line has the corners 0 and 1.
fn rimline_corner(vertex: u32) -> u32 {
  // Two triangles share the corners 1 and 2. The constant has a hexadecimal digit for each vertex, the first one last.
  return select(vertex, (0x312210u >> (4u * vertex)) & 3u, rimline_info.vertices_per_edge == 6u);
}

// The end of a silhouette edge at vertex `vertex` of the draw: its position, with w = 1. A caller multiplies it by its
// camera's matrix. Seen from the light, the edge's faces lie to the left from the first end to the second. If the instance
// is no silhouette, all components are 0 for all its vertices. They stay 0 under each matrix, so nothing is drawn. Both
// sides of a quad have these ends, so it has no area until the caller moves its corners apart (`rimline_corner`).
fn rimline_edge_vertex(light: u32, instance: u32, vertex: u32) -> vec4<f32> {
  let edge = rimline_silhouette(light, instance);
  if (!edge.valid) {
    return vec4<f32>();
  }
  let is_second = (rimline_corner(vertex) & 1u) == 1u;
  return vec4<f32>(rimline_position(select(edge.a, edge.b, is_second == edge.winding)), 1.0);
}
