// Edge masks and lists of a single mesh, for `edges` and `per_edge`. (Scenes have their own in edges.wgsl.) For `edges` it
// reads the facing masks, which may span up to four bindings. Writes masks of edge records, appends silhouettes to the lists
// of the lights in no particular order, or does both. The count of a full list still grows, so that `arguments` and readers
// notice the overflow. Bit 31 of an entry is the winding: the facing bit of face 0 or, if face 0 is twisted, that of face 1
// for the direction of face 0.

#import common/extraction
#import extract/one_caster

@group(0) @binding(2) var<storage, read> facing_0: array<u32>;
@group(0) @binding(3) var<storage, read> facing_1: array<u32>;
@group(0) @binding(4) var<storage, read> facing_2: array<u32>;
@group(0) @binding(5) var<storage, read> facing_3: array<u32>;
// Words in each binding but the last. 0: the first binding has all. For polygons twisted masks follow the facing masks, and
// edges.wgsl reads them here, too.
override FACING_WINDOW_WORDS: u32 = 0u;

fn facing_mask(face: u32) -> u32 {
  if (FACING_WINDOW_WORDS == 0u) {
    return facing_0[face];
  }
  let offset = face % max(FACING_WINDOW_WORDS, 1u);
  switch (face / max(FACING_WINDOW_WORDS, 1u)) {
    case 0u: { return facing_0[offset]; }
    case 1u: { return facing_1[offset]; }
    case 2u: { return facing_2[offset]; }
    default: { return facing_3[offset]; }
  }
}

// From the first record of `chunk` on.
@group(0) @binding(7) var<storage, read_write> masks: array<EdgeMasks>;
// For each light of all batches the number of its silhouette edges. 0 before the first batch.
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;
// The lists of the batch, each with room for `chunk.capacity` entries.
@group(0) @binding(9) var<storage, read_write> list: array<u32>;
override WRITE_MASKS: bool = true; // Whether to write masks.
override APPEND: bool = true; // Whether to append silhouettes to lists. If not, `compact` may make lists in edge order.

// Writes the masks of an edge record, an index counted from the first of `chunk`, and appends it to the lists of the lights
// in `silhouette`, which must be active. It has no barrier: invocations may have ended.
fn emit(edge: u32, silhouette: u32, winding: u32) {
  if (WRITE_MASKS) {
    masks[edge] = EdgeMasks(silhouette, winding);
  }
  if (APPEND) {
    // Silhouettes are few, so one atomic for each costs less than a scan over the workgroup.
    for (var remaining = silhouette; remaining != 0u; remaining &= remaining - 1u) {
      let light = firstTrailingBit(remaining);
      let index = atomicAdd(&counts[chunk.first_light + light], 1u);
      if (index < chunk.capacity) {
        list[light * chunk.capacity + index] = (chunk.first + edge) | (((winding >> light) & 1u) << 31u);
      }
    }
  }
}
