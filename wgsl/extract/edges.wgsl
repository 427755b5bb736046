// Edges: computes the silhouette and winding masks of each edge record from the facing masks of its faces. A mask has a bit
// for each light of a batch (up to 32). Silhouettes are boundaries, and records whose two faces have different bits (equal
// bits if both traverse the edge the same way); twisted faces count as absent. Dispatched after `exact_facing` (after
// `facing` if signs need not be exact; after `polygon_masks` for polygons), an invocation a record. Options select its
// results: masks, for `compact` and callers; entries appended to the lists of the lights, in no particular order, for
// callers and shadow volumes; or both. SCENE: eight invocations share a chunk (64 slots) that `chunks` listed, for lights
// with dirty lists, and it only appends. Slots are defined in interface/caster.wgsl. Facing bits must be read, never
// computed again: only then do silhouettes close. Claim: docs/numerics/watertight.md.

#import common/extraction
#import interface/caster
#if SCENE
#import scene/many_casters
#import scene/table

@group(0) @binding(2) var<storage, read> facing_masks: array<u32>;

// `counts`: the number of silhouette edges of each light, including those that its list has no room for; then word
// CACHED_ZEROS (common/casters.wgsl). `entries`: a list a light. An entry is an edge slot with the winding as bit 31.
struct SceneLists {
  counts: array<atomic<u32>, 64>,
  entries: array<u32>,
}

@group(0) @binding(7) var<storage, read_write> lists: SceneLists;

// The facing mask of a face of the loaded caster.
fn facing_mask(face: u32) -> u32 { return facing_masks[face_range.x + face]; }

// Appends an edge slot to the lists of the lights in `silhouette`. Scenes have no edge masks, since no stage would read
// them.
fn emit(slot: u32, silhouette: u32, winding: u32) {
  for (var remaining = silhouette; remaining != 0u; remaining &= remaining - 1u) {
    let light = firstTrailingBit(remaining);
    let index = atomicAdd(&lists.counts[light], 1u);
    if (index < group.capacity) {
      lists.entries[light * group.capacity + index] = slot | (((winding >> light) & 1u) << 31u);
    }
  }
}

// Scenes extract casters of polygons as single meshes.
fn twisted_offset() -> u32 { return 0u; }
#else
#import extract/edge_lists

fn twisted_offset() -> u32 { return chunk.twisted_offset; }
#endif

@group(0) @binding(6) var<storage, read> edge_faces: array<vec2<u32>>;

// Decides an edge record: `slot` is its index in the bound masks, in a scene also in lists, `index` that in `edge_faces`.
// INCONSISTENT: both faces traverse the edge the same way, so their fronts are on different sides. Then the edge is a
// silhouette if the bits are equal.
fn process_item(slot: u32, index: u32) {
  let faces = edge_faces[index];
  if (twisted_offset() != 0u) {
    let masks = masks_beside_twisted(faces);
    emit(slot, masks.silhouette, masks.winding);
    return;
  }
  let winding = facing_mask(faces.x & ~INCONSISTENT);
  var silhouette = active_bits();
  if (faces.y != NO_FACE) {
    silhouette = winding ^ facing_mask(faces.y);
    if ((faces.x & INCONSISTENT) != 0u) {
      silhouette = ~silhouette;
    }
    silhouette &= active_bits();
  }
  emit(slot, silhouette, winding);
}

// The masks of a record whose faces may be twisted. A twisted face counts as absent. If one face remains, the record is its
// boundary, and the winding is that face's bit for the direction of face 0. If none remains, the record is no silhouette.
fn masks_beside_twisted(faces: vec2<u32>) -> EdgeMasks {
  let first = faces.x & ~INCONSISTENT;
  let is_present_0 = active_bits() & ~facing_mask(twisted_offset() + first);
  let facing_0 = facing_mask(first);
  var is_present_1 = 0u;
  // The bit of face 1 for the direction of face 0: inverted, unless both traverse the edge the same way.
  var aligned_facing_1 = 0u;
  if (faces.y != NO_FACE) {
    is_present_1 = active_bits() & ~facing_mask(twisted_offset() + faces.y);
    aligned_facing_1 = ~facing_mask(faces.y);
    if ((faces.x & INCONSISTENT) != 0u) {
      aligned_facing_1 = ~aligned_facing_1;
    }
  }
  let silhouette = (is_present_0 ^ is_present_1) | (is_present_0 & is_present_1 & ~(facing_0 ^ aligned_facing_1));
  return EdgeMasks(silhouette, (is_present_0 & facing_0) | (~is_present_0 & is_present_1 & aligned_facing_1));
}

@compute @workgroup_size(256)
fn edges(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  process_edges(id.x, 256u * groups.x);
}
