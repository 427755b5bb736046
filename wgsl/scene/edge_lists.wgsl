// The facing masks that edges of a scene read, and the lists that they append to. For a single mesh see extract/edge_lists.

#import scene/many_casters
#import scene/table

@group(0) @binding(2) var<storage, read> facing_masks: array<u32>;

// The number of silhouette edges of each light of a batch, including those that its list has no room for; then, behind 256
// bytes, the lists. An entry is an edge slot, with the winding bit as bit 31.
struct SceneLists {
  counts: array<atomic<u32>, 64>,
  entries: array<u32>,
}

@group(0) @binding(7) var<storage, read_write> lists: SceneLists;

// The mask of a face of the caster at hand.
fn facing_mask(face: u32) -> u32 {
  return facing_masks[of_faces.x + face];
}

fn emit(slot: u32, silhouette: u32, winding: u32) {
  for (var rest = silhouette; rest != 0u; rest &= rest - 1u) {
    let light = firstTrailingBit(rest);
    let place = atomicAdd(&lists.counts[light], 1u);
    if (place < group.capacity) {
      lists.entries[light * group.capacity + place] = slot | (((winding >> light) & 1u) << 31u);
    }
  }
}
