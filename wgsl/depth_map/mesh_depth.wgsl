// Stage `mesh_depth`: vertex shaders that draw meshes into the depth map of a light, in a render pass of the caller's. They
// have no fragment shader. Stages that read the map later have the depth attachment as `depth_texture`.
// `mesh_depth` draws one mesh: an indexed draw of all faces (`MeshDepth::draw`). `scene_depth` draws casters of a scene: an
// instance for each chunk, which is 64 faces of a caster, and three vertices a face (`SceneDepth::draw`). Both draw front
// and back faces. They read positions in the caller's buffer or the scene's pages, transforms, faces and the light's matrix.
// A vertex with one transform has the same depth bits in both draws, because `light_position` makes all, at invariant
// positions.
// Keep its operations and their order: docs/numerics/depth-maps.md, "Depth of scenes", bounds their rounding.

struct MeshDepthView {
  // The light's matrix, by columns.
  columns: array<vec4<f32>, 4>,
}

struct MeshDepthCaster {
  // Rows of the matrix from positions to world space, relative to `ShadowCamera::origin` of the light's camera.
  row_0: vec4<f32>,
  row_1: vec4<f32>,
  row_2: vec4<f32>,
  // The word of vertex 0 in `positions`, and the words from one vertex to the next.
  position_offset: u32,
  position_stride: u32,
  // Its faces in `faces`: the index of the first, and how many there are. Only `scene_depth` reads them.
  first_face: u32,
  face_count: u32,
}

// One element. It is an array because the test of required limits (src/gpu/common/requirements/tests.rs) counts a struct in
// a storage binding of a draw as one with a dynamic offset, and this binding has none.
@group(0) @binding(0) var<storage, read> views: array<MeshDepthView>;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> casters: array<MeshDepthCaster>;
// Three vertices a face, of all meshes of the page that the drawn casters have in common. Only `scene_depth` reads this
// binding and the next.
@group(0) @binding(3) var<storage, read> faces: array<u32>;
// x: the caster of each chunk. y: the index of the chunk's first face among those of the caster.
@group(0) @binding(4) var<storage, read> chunks: array<vec2<u32>>;

// The clip position of a vertex of a caster. With the unit matrix only the last sum of a row rounds. So a caster with that
// transform has the depths of a mesh without one.
fn light_position(caster: MeshDepthCaster, vertex: u32) -> vec4<f32> {
  let offset = caster.position_offset + vertex * caster.position_stride;
  let position = vec3<f32>(positions[offset], positions[offset + 1u], positions[offset + 2u]);
  let from_light = vec3<f32>(
    caster.row_0.x * position.x + caster.row_0.y * position.y + caster.row_0.z * position.z + caster.row_0.w,
    caster.row_1.x * position.x + caster.row_1.y * position.y + caster.row_1.z * position.z + caster.row_1.w,
    caster.row_2.x * position.x + caster.row_2.y * position.y + caster.row_2.z * position.z + caster.row_2.w);
  let columns = views[0].columns;
  return columns[0] * from_light.x + columns[1] * from_light.y + columns[2] * from_light.z + columns[3];
}

@vertex
fn mesh_depth(@builtin(vertex_index) vertex: u32) -> @builtin(position) @invariant vec4<f32> {
  return light_position(casters[0], vertex);
}

// The last chunk of a caster may have fewer than 64 faces. Further triangles are degenerate.
@vertex
fn scene_depth(
  @builtin(vertex_index) vertex: u32,
  @builtin(instance_index) chunk_index: u32,
) -> @builtin(position) @invariant vec4<f32> {
  let chunk = chunks[chunk_index];
  let caster = casters[chunk.x];
  let face = chunk.y + vertex / 3u;
  if (face >= caster.face_count) {
    return vec4<f32>(0.0, 0.0, 0.0, 1.0);
  }
  return light_position(caster, faces[3u * (caster.first_face + face) + vertex % 3u]);
}
