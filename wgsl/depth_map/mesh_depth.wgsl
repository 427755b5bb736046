// Stage `mesh_depth`: vertex shaders that draw meshes into the depth map of a light, in a render pass of the caller's before the
// stages that read the map. There is no fragment shader: the depth attachment becomes their `depth_texture`.
// `mesh_depth`: one mesh, an indexed draw of all faces (`MeshDepth::draw`). `scene_depth`: casters of a scene, three vertices a
// face, an instance for each chunk, which is 64 faces of a caster (`SceneDepth::draw`). Both draw front and back faces.
// Read: positions in the caller's buffer or the scene's pages, transforms, faces, the light's matrix.
// The same positions have the same depth bits in both draws: `light_position` makes all vertices, and they are invariant. Keep
// its operations and their order; docs/numerics/depth-maps.md, "Depth of scenes", bounds their rounding.

struct MeshDepthView {
  // The light's matrix, by columns.
  columns: array<vec4<f32>, 4>,
}

struct MeshDepthCaster {
  // Rows that place positions, less the light's origin.
  row_0: vec4<f32>,
  row_1: vec4<f32>,
  row_2: vec4<f32>,
  // Offset of vertex 0 in `positions` and stride, both in words; the first face in `faces`, and the count of faces.
  place: vec4<u32>,
}

// One element. It is an array so that its binding has no dynamic offset.
@group(0) @binding(0) var<storage, read> views: array<MeshDepthView>;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> casters: array<MeshDepthCaster>;
// Three vertices a face, of all casters that are drawn together. Only `scene_depth` reads it.
@group(0) @binding(3) var<storage, read> faces: array<u32>;
// The caster of each chunk of faces, and the number of its first face among those of the caster.
@group(0) @binding(4) var<storage, read> chunks: array<vec2<u32>>;

// The clip position of a vertex of a caster. With rows of the unit matrix every product and sum of a row but the last is exact,
// so a caster with that transform has the depths of one without.
fn light_position(caster: MeshDepthCaster, vertex: u32) -> vec4<f32> {
  let word = caster.place.x + vertex * caster.place.y;
  let own = vec3<f32>(positions[word], positions[word + 1u], positions[word + 2u]);
  let offset = vec3<f32>(
    caster.row_0.x * own.x + caster.row_0.y * own.y + caster.row_0.z * own.z + caster.row_0.w,
    caster.row_1.x * own.x + caster.row_1.y * own.y + caster.row_1.z * own.z + caster.row_1.w,
    caster.row_2.x * own.x + caster.row_2.y * own.y + caster.row_2.z * own.z + caster.row_2.w);
  let columns = views[0].columns;
  return columns[0] * offset.x + columns[1] * offset.y + columns[2] * offset.z + columns[3];
}

@vertex
fn mesh_depth(@builtin(vertex_index) vertex: u32) -> @builtin(position) @invariant vec4<f32> {
  return light_position(casters[0], vertex);
}

// The last chunk of a caster may have less than 64 faces. Vertices behind them all lie in one point, which draws nothing.
@vertex
fn scene_depth(
  @builtin(vertex_index) corner: u32,
  @builtin(instance_index) number: u32,
) -> @builtin(position) @invariant vec4<f32> {
  let chunk = chunks[number];
  let caster = casters[chunk.x];
  let face = chunk.y + corner / 3u;
  if (face >= caster.place.w) {
    return vec4<f32>(0.0, 0.0, 0.0, 1.0);
  }
  return light_position(caster, faces[3u * (caster.place.z + face) + corner % 3u]);
}
