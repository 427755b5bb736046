// Edges: computes the silhouette and winding mask of each edge record from the facing masks of its faces. It writes the
// masks, appends silhouette edges to the lists of the lights in no particular order, or does both. One text serves a
// single mesh and a scene; `facing_mask` and `emit` are in facing_windows.wgsl and emit.wgsl, or in
// scene/scene_lists.wgsl.

@group(0) @binding(6) var<storage, read> edge_faces: array<vec2<u32>>;

// Decides an edge record. `slot` is its place in masks and lists, `index` that in the topology.
fn take_item(slot: u32, index: u32) {
  let faces = edge_faces[index];
  let winding = facing_mask(faces.x & ~INCONSISTENT);
  var silhouette = live_lights();
  if (faces.y != NO_FACE) {
    silhouette = winding ^ facing_mask(faces.y);
    if ((faces.x & INCONSISTENT) != 0u) {
      silhouette = ~silhouette;
    }
    silhouette &= live_lights();
  }
  emit(slot, silhouette, winding);
}

@compute @workgroup_size(256)
fn edges(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  take_items(id.x, 256u * groups.x);
}
