// List sides: lists the edges whose sides are drawn, for each light, with the winding of the side. It goes over the light's
// silhouettes. Where their list overflowed, or faces may be excluded, it goes over all edges.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
// The first light of this batch.
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> silhouette_counts: array<u32>;
@group(0) @binding(3) var<storage, read> silhouettes: array<u32>;
@group(0) @binding(4) var<storage, read> edge_faces: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> facing_masks: array<u32>;
@group(0) @binding(6) var<storage, read> excluded_masks: array<u32>;
@group(0) @binding(7) var<storage, read> shadow_lights: array<ShadowLight>;
// For each light of the batch how many sides have weight 1, and how many weight 2; then the lists.
@group(0) @binding(8) var<storage, read_write> sides: array<atomic<u32>>;

// A workgroup takes a share of one light's edges.
@compute @workgroup_size(64)
fn list_sides(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  let light = shadow_lights[draw.first_light + bit];
  if (light.casting == CAST_NOTHING) {
    return;
  }
  let listed = silhouette_counts[draw.first_light + bit];
  let is_whole = listed <= shape.capacity && light.excludes == 0u;
  let items = select(shape.edges, listed, is_whole);
  for (var item = group.x * 64u + thread; item < items; item += 64u * groups.x) {
    var edge = item;
    if (is_whole) {
      edge = silhouettes[bit * shape.capacity + item] & ~WINDING;
    }
    let side = side_at(light, bit, edge);
    if (side.weight != 0u) {
      let place = atomicAdd(&sides[2u * bit + side.weight - 1u], 1u);
      if (place < shape.side_capacity) {
        let at = select(place, shape.side_capacity - 1u - place, side.weight == 2u);
        atomicStore(&sides[side_begin(bit, shape.side_capacity) + at], edge | select(0u, WINDING, side.winding));
      }
    }
  }
}
