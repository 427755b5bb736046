// Stage `zp_plus_2005_cases`, only for ZP+ as published in 2005: finds casters with sides of the paper's case D. The near
// plane cuts both finite edges of such a side. The published method leaves such a caster and light to z-fail.
// Dispatched between `counting_methods` and `caps` for each group of casters, light batch (up to 32 lights) and view. A
// row of workgroups shares the silhouettes of a light, or all edges if its list overflowed. Reads: silhouettes,
// positions, lights, choices. Writes: it clears CHOICE_NEAR_CAP of these casters, for `caps` and later stages.

#import common/extraction
#import shadow/caster
#import shadow/choices
#import shadow/shadow
#import shadow/vertices

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> view_lights: array<ViewLight>; // For each view all lights.
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> silhouettes: array<u32>;
@group(0) @binding(7) var<storage, read> silhouette_counts: array<u32>;
@group(0) @binding(8) var<storage, read_write> choices: array<atomic<u32>>;

// Whether the near plane cuts both finite edges of the side from a to b: the edge itself, and the edge between the far
// vertices.
fn is_case_d(view: ShadowView, light: ShadowLight, a: vec3<f32>, b: vec3<f32>) -> bool {
  let is_edge_cut = is_before_near_plane(view, to_clip(view, a)) != is_before_near_plane(view, to_clip(view, b));
  let a_far = direction_to_clip(view, extrusion(view, light, a));
  let b_far = direction_to_clip(view, extrusion(view, light, b));
  return is_edge_cut && is_before_near_plane(view, a_far) != is_before_near_plane(view, b_far);
}

// Whether the side of the edge in a slot is case D.
fn is_slot_case_d(caster: u32, slot: u32, light_and_view: ViewLight, light_index: u32) -> bool {
  let range = edge_range(caster);
  let edge = slot - range.x;
  if (edge >= range.y) {
    return false;
  }
  let ends = edge_vertices[range.z + edge];
  let view = view_for_caster(caster, light_and_view.view);
  let light = light_for_caster(caster, light_and_view.light, light_index);
  return is_case_d(view, light, vertex_position(caster, ends.x), vertex_position(caster, ends.y));
}

@compute @workgroup_size(64)
fn zp_plus_2005_cases(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  let light_index = draw.first_light + bit;
  let light_and_view = view_lights[draw.view * shape.lights + light_index];
  let count = silhouette_counts[bit];
  // If the list overflowed, all edges are tested. Case D at an edge that is no silhouette then leaves the caster to z-fail,
  // too, which is right for every caster.
  let is_overflowed = count > shape.capacity;
  let edges = select(count, shape.edges, is_overflowed);
  // Turns: LISTED_ITEMS.
  for (var entry = group.x * 64u + thread; entry < edges; entry += 64u * groups.x) {
    var slot = entry;
    if (!is_overflowed) {
      slot = silhouettes[bit * shape.capacity + entry] & ~WINDING;
    }
    let caster = caster_of_slot(shape.edge_chunks_offset, slot);
    let offset = CHOICE_WORDS * choice_index(caster, draw.first_light / 32u, draw.view) + CHOICE_NEAR_CAP;
    if (((atomicLoad(&choices[offset]) >> bit) & 1u) != 0u && is_slot_case_d(caster, slot, light_and_view, light_index)) {
      atomicAnd(&choices[offset], ~(1u << bit));
    }
  }
}
