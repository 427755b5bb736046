// Writes what the edge stages found: masks, lists, or both.

@group(0) @binding(7) var<storage, read_write> masks: array<EdgeMasks>;
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> list: array<u32>;

override WRITE_MASKS: bool = true;
override APPEND: bool = true;

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
