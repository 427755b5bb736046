// Stage `list_sides`: lists the edges whose sides are drawn, with their winding, for each light of a batch (up to 32
// lights), in a view. A side is the quad from an edge away from the light.
// Dispatched after `caps` for each group of casters, light batch and view; a row of workgroups shares the edges of a
// light.
// Reads: choices, which `caps` completes, facing masks, excluded masks, and the silhouettes that `edges` listed. If that
// list overflowed, or a caster of the group can have excluded faces (`has_all_silhouettes`), it goes over all edges.
// Writes: dirty lists, which `relist` emptied, in arbitrary order, for `shadow_arguments`, `sides` and `stencil_crossings`.
// The weight of a side follows from the facing and excluded bits of the faces of its edge. Caps follow from the same bits,
// so volumes are closed.
// docs/numerics/watertight.md.

#import common/casters
#import common/extraction
#import shadow/caster
#import shadow/choices
#import shadow/draw_lists
#import shadow/shadow

@group(0) @binding(0) var<uniform> shape: ShadowShape;
@group(0) @binding(1) var<uniform> draw: ShadowDraw;
@group(0) @binding(2) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> silhouette_counts: array<u32>;
@group(0) @binding(4) var<storage, read> silhouettes: array<u32>;
@group(0) @binding(5) var<storage, read> edge_faces: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> facing_masks: array<u32>;
@group(0) @binding(7) var<storage, read> excluded_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> sides: array<atomic<u32>>; // Two counts for each light, then the lists.
@group(0) @binding(9) var<storage, read> extraction_statistics: ExtractionStatistics; // From the extraction of the silhouettes.

// Appends the side of the edge in a slot to one of the light's two lists, as often as its weight says. The lists share a
// range, from both ends. If it overflows, only the counts are right, and readers go over all edges.
fn list_edge(slot: u32, bit: u32) {
  let caster = caster_of_slot(shape.edge_chunks_offset, slot);
  let range = edge_range(caster);
  let edge = slot - range.x;
  // The last chunk of a caster may have slots past its edges.
  if (edge >= range.y) {
    return;
  }
  let light = with_stored_choices(caster, ShadowLight(), draw.first_light + bit, draw.view);
  let side = edge_side(caster, range.z + edge, light, bit);
  if (side.weight == 0u) {
    return;
  }
  let kind = side_kind(light);
  let first = atomicAdd(&sides[2u * bit + kind], side.weight);
  // Turns: 2.
  for (var entry = first; entry < min(first + side.weight, shape.side_capacity); entry++) {
    atomicStore(&sides[side_entry_offset(bit, kind, entry)], slot | select(0u, WINDING, side.winding));
  }
}

// Whether all edges with sides are in the light's list of silhouettes.
fn has_all_silhouettes(choices: GroupChoices, bit: u32) -> bool {
  // Whether any light of the batch lies in the plane of a face. If not, CHOICE_MAY_EXCLUDE has no effect: it says only that
  // a light may be in the box of a caster. Statistics count new facing, and CACHED_ZEROS stands for cached facing.
  let has_zeros = extraction_statistics.exact_zeros != 0u || silhouette_counts[CACHED_ZEROS] != 0u;
  let excluding_lights = choices.does_exclude | select(0u, choices.may_exclude, has_zeros);
  return silhouette_counts[bit] <= shape.capacity && ((excluding_lights >> bit) & 1u) == 0u;
}

@compute @workgroup_size(64)
fn list_sides(
  @builtin(workgroup_id) group: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) thread: u32,
) {
  let bit = group.y; // The light's index in the batch, and its bit in masks.
  let choices = group_choices(draw.first_light / 32u, draw.view);
  if (((choices.dirty >> bit) & 1u) == 0u) {
    return;
  }
  let is_from_silhouettes = has_all_silhouettes(choices, bit);
  let items = select(shape.edges, silhouette_counts[bit], is_from_silhouettes);
  // Turns: LISTED_ITEMS.
  for (var item = group.x * 64u + thread; item < items; item += 64u * groups.x) {
    var slot = item;
    if (is_from_silhouettes) {
      slot = silhouettes[bit * shape.capacity + item] & ~WINDING;
    }
    list_edge(slot, bit);
  }
}
