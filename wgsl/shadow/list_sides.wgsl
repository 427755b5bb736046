// List sides: a compute stage that lists the edges whose sides are drawn, with the winding of the side, for each light of a
// batch (up to 32 lights) in a view. A side is the quad from an edge away from the light. Dispatched after `caps` for each
// group of casters, batch and view; a row of workgroups shares the edges of a light. It goes over the light's silhouettes, as
// `edges` listed them. Where their list overflowed, or faces may be excluded (those whose plane has the light, those that are
// not finite, polygons whose outline crosses itself as seen from the light, and those that the caller excludes), it goes over
// all edges. `shadow_arguments` makes draws of the lists; `sides` and `stencil_crossings` read them. Lists are in no
// particular order. The weight of an edge comes from the bits of its faces (`side_at`), as for caps: else volumes would not
// close.

#import common/casters
#import common/extraction
#import shadow/caster
#import shadow/choices
#import shadow/lists
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> silhouette_counts: array<u32>;
@group(0) @binding(4) var<storage, read> silhouettes: array<u32>;
@group(0) @binding(5) var<storage, read> edge_faces: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> facing_masks: array<u32>;
@group(0) @binding(7) var<storage, read> excluded_masks: array<u32>;
// For each light of the batch the numbers of plain and of clipped sides; then the lists.
@group(0) @binding(8) var<storage, read_write> sides: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read> extraction_statistics: array<u32, 5>; // `ExtractionStatistics` of the same silhouettes.

// Lists the side of an edge, if it has one, as often as its weight says.
fn list_edge(slot: u32, bit: u32) {
  let caster = caster_of(shape.edge_chunks_at, slot);
  let run = edge_run(caster);
  let number = slot - run.x;
  if (number >= run.y) {
    return;
  }
  let light = chosen_light(caster, ShadowLight(), draw.first_light + bit, draw.view);
  let side = side_at(caster, run.z + number, light, bit);
  if (side.weight == 0u) {
    return;
  }
  let kind = side_kind(light);
  let place = atomicAdd(&sides[2u * bit + kind], side.weight);
  // Turns: 2.
  for (var entry = place; entry < min(place + side.weight, shape.side_capacity); entry++) {
    atomicStore(&sides[side_place(bit, kind, entry)], slot | select(0u, WINDING, side.winding));
  }
}

// Whether the light's silhouettes are all the edges that may have sides.
fn silhouettes_suffice(bit: u32) -> bool {
  let more = choice_part(shape.first_caster, draw.first_light / 32u, draw.view, 1u);
  // Lights that are in a caster exclude nothing if no light is in the plane of a face.
  // Bits that are kept from an earlier encode are in no statistics.
  let in_planes = extraction_statistics[3] != 0u || silhouette_counts[KEPT_ZEROS] != 0u;
  let any = more[DOES_EXCLUDE - 4u] | select(0u, more[MAY_EXCLUDE - 4u], in_planes);
  return silhouette_counts[bit] <= shape.capacity && ((any >> bit) & 1u) == 0u;
}

// A workgroup takes a share of one light's edges.
@compute @workgroup_size(64)
fn list_sides(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y;
  // Only lists that `relist` marked are made.
  let of_first = choice_part(shape.first_caster, draw.first_light / 32u, draw.view, 1u);
  if (((of_first[FRESH - 4u] >> bit) & 1u) == 0u) {
    return;
  }
  let suffices = silhouettes_suffice(bit);
  let items = select(shape.edges, silhouette_counts[bit], suffices);
  // Turns: LISTED_ITEMS.
  for (var item = group.x * 64u + thread; item < items; item += 64u * groups.x) {
    var slot = item;
    if (suffices) {
      slot = silhouettes[bit * shape.capacity + item] & ~WINDING;
    }
    list_edge(slot, bit);
  }
}
