// Cases of ZP+ as published in 2005, for comparison: a compute stage that finds lights for which the near plane cuts both finite
// edges of a side (the paper's case D). The published method leaves such a caster and light to z-fail, so their bit NEAR is taken
// from the choices, which `caps` and all later stages read. Dispatched between `choose` and `caps`, for each group of casters,
// batch of up to 32 lights and view; a row of workgroups takes the silhouettes of one light, or all edges if its list overflowed.

#import common/extraction
#import shadow/caster
#import shadow/choices
#import shadow/shadow
#import shadow/vertices

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> seen: array<SeenLight>;
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var<storage, read> edge_vertices: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> silhouettes: array<u32>;
@group(0) @binding(7) var<storage, read> silhouette_counts: array<u32>;
@group(0) @binding(8) var<storage, read_write> choices: array<atomic<u32>>;

// Whether the near plane cuts both finite edges of the side from a to b: the edge itself, and that between the far vertices.
fn is_case_d(view: ShadowView, light: ShadowLight, a: vec3<f32>, b: vec3<f32>) -> bool {
  let cuts_edge = is_cut(view, to_clip(view, a)) != is_cut(view, to_clip(view, b));
  let a_far = direction_to_clip(view, extrusion(view, light, a));
  let b_far = direction_to_clip(view, extrusion(view, light, b));
  return cuts_edge && is_cut(view, a_far) != is_cut(view, b_far);
}

// Whether the near plane cuts so the side of the edge in a slot.
fn is_cut_so(caster: u32, slot: u32, own: SeenLight, number: u32) -> bool {
  let run = edge_run(caster);
  let edge = slot - run.x;
  if (edge >= run.y) {
    return false;
  }
  let ends = edge_vertices[run.z + edge];
  let view = view_of(caster, own.view);
  let light = light_of(caster, own.light, number);
  return is_case_d(view, light, vertex_position(caster, ends.x), vertex_position(caster, ends.y));
}

@compute @workgroup_size(64)
fn zp_plus_2005_cases(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  let number = draw.first_light + bit;
  let own = seen[draw.view * shape.lights + number];
  let count = silhouette_counts[bit];
  // A list that overflowed does not say which edges are silhouettes, so any edge counts. z-fail is right for it, too.
  let overflowed = count > shape.capacity;
  let edges = select(count, shape.edges, overflowed);
  // Turns: LISTED_ITEMS.
  for (var entry = group.x * 64u + thread; entry < edges; entry += 64u * groups.x) {
    var slot = entry;
    if (!overflowed) {
      slot = silhouettes[bit * shape.capacity + entry] & ~WINDING;
    }
    let caster = caster_of(shape.edge_chunks_at, slot);
    let near = CHOICE_WORDS * choices_of(caster, draw.first_light / 32u, draw.view) + NEAR;
    if (((atomicLoad(&choices[near]) >> bit) & 1u) != 0u && is_cut_so(caster, slot, own, number)) {
      atomicAnd(&choices[near], ~(1u << bit));
    }
  }
}
