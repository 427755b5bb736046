// Cases of ZP+ as published: finds lights for which the near plane cuts both finite edges of a side (the paper's case
// D). The published method leaves such a caster and light to z-fail. A workgroup takes one light of the batch.

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> view: ShadowView;
// The first light of this batch.
@group(0) @binding(2) var<uniform> draw: ShadowDraw;
@group(0) @binding(3) var<storage, read> positions: array<u32>;
@group(0) @binding(4) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> list: array<u32>;
@group(0) @binding(6) var<storage, read> silhouette_counts: array<u32>;
@group(0) @binding(7) var<storage, read_write> shadow_lights: array<ShadowLight>;

var<workgroup> found: atomic<u32>;

fn is_case_d(light: ShadowLight, a: vec3<f32>, b: vec3<f32>) -> bool {
  let cuts_edge = is_cut(view, to_clip(view, a)) != is_cut(view, to_clip(view, b));
  let a_far = direction_to_clip(view, extrusion(light, a));
  let b_far = direction_to_clip(view, extrusion(light, b));
  return cuts_edge && is_cut(view, a_far) != is_cut(view, b_far);
}

@compute @workgroup_size(64)
fn zp_plus_2005_cases(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
  let number = draw.first_light + group.x;
  let light = shadow_lights[number];
  let count = silhouette_counts[number];
  // A list that overflowed does not say which edges are silhouettes, so any edge counts. z-fail is right for it, too.
  let overflowed = count > shape.capacity;
  var edges = select(count, shape.edges, overflowed);
  if (light.casting == CAST_NOTHING || light.counting != COUNT_ZP_PLUS_2005) {
    edges = 0u;
  }
  for (var entry = thread; entry < edges; entry += 64u) {
    var edge = entry;
    if (!overflowed) {
      edge = list[group.x * shape.capacity + entry] & 0x7fffffffu;
    }
    let ends = edge_vertices[edge];
    if (is_case_d(light, caster_position(ends.x), caster_position(ends.y))) {
      atomicStore(&found, 1u);
    }
  }
  workgroupBarrier();
  if (thread == 0u && atomicLoad(&found) != 0u) {
    shadow_lights[number].counting = COUNT_Z_FAIL;
  }
}
