// Mesh depth: the vertices of a mesh, as the light of a depth map sees them.

struct MeshDepthView {
  // The light's matrix, by columns.
  columns: array<vec4<f32>, 4>,
  // The light's origin.
  origin: vec4<f32>,
  // The word of x of vertex 0, and the words from one vertex to the next.
  place: vec4<u32>,
}

// One element. It is an array so that its binding has no dynamic offset.
@group(0) @binding(0) var<storage, read> views: array<MeshDepthView>;
@group(0) @binding(1) var<storage, read> positions: array<f32>;

@vertex
fn mesh_depth(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  let word = views[0].place.x + vertex * views[0].place.y;
  let position = vec3<f32>(positions[word], positions[word + 1u], positions[word + 2u]) - views[0].origin.xyz;
  let columns = views[0].columns;
  return columns[0] * position.x + columns[1] * position.y + columns[2] * position.z + columns[3];
}
