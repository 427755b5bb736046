// Edge lists of a single mesh, for the stages `edges` and `per_edge`: `edges` reads the facing masks here, which may span up to
// four bindings. Both write masks of edge records, append silhouettes to the lists of the lights in no particular order, or both.
// A list that has no room counts on, so that `arguments` and all readers can tell. `edges` has its own text for scenes. An edge
// record is a directed edge with its one or two faces. Bit 31 of an entry is the winding: the facing bit of face 0, or
// where face 0 is twisted, that of face 1 turned to suit face 0.

#import common/extraction
#import extract/one_caster

@group(0) @binding(2) var<storage, read> facing_0: array<u32>;
@group(0) @binding(3) var<storage, read> facing_1: array<u32>;
@group(0) @binding(4) var<storage, read> facing_2: array<u32>;
@group(0) @binding(5) var<storage, read> facing_3: array<u32>;
// Words in each binding except the last. 0: all are in the first. A word is a face's mask; for polygons twisted masks follow.
override FACING_WINDOW_WORDS: u32 = 0u;

fn facing_mask(face: u32) -> u32 {
  if (FACING_WINDOW_WORDS == 0u) {
    return facing_0[face];
  }
  let at = face % max(FACING_WINDOW_WORDS, 1u);
  switch (face / max(FACING_WINDOW_WORDS, 1u)) {
    case 0u: { return facing_0[at]; }
    case 1u: { return facing_1[at]; }
    case 2u: { return facing_2[at]; }
    default: { return facing_3[at]; }
  }
}

@group(0) @binding(7) var<storage, read_write> masks: array<EdgeMasks>;
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> list: array<u32>;
override WRITE_MASKS: bool = true; // Whether masks are written.
override APPEND: bool = true; // Whether silhouettes are listed here. If not, `compact` may do so, in edge order.

// Writes and lists one edge record of `chunk`, with its masks. It has no barrier: other invocations may have ended.
fn emit(edge: u32, silhouette: u32, winding: u32) {
  if (WRITE_MASKS) {
    masks[edge] = EdgeMasks(silhouette, winding);
  }
  if (APPEND) {
    // Silhouettes are few, so one atomic for each costs less than agreeing on places within the workgroup.
    for (var rest = silhouette; rest != 0u; rest &= rest - 1u) {
      let light = firstTrailingBit(rest);
      let place = atomicAdd(&counts[chunk.first_light + light], 1u);
      if (place < chunk.capacity) {
        list[light * chunk.capacity + place] = (chunk.first + edge) | (((winding >> light) & 1u) << 31u);
      }
    }
  }
}
