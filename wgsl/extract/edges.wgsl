// Edges: a compute stage that computes the silhouette and winding mask of each edge record, a bit for each light of a batch
// (up to 32), from the facing masks of its faces: where two faces differ, and at boundaries. Dispatched after `exact_facing`
// (after `facing` where signs need not be exact), or after `polygon_masks` for a mesh of polygons, an invocation a record. The
// options say whether it writes the masks, which `compact` and callers read; or appends silhouette edges to the lists of the
// lights, in no particular order, for callers and shadow volumes; or does both. In the variant SCENE eight invocations share a
// chunk (64 slots) that `chunks` listed, for lights whose lists are made anew, and it only appends. A slot is the index of a
// face or record in masks and lists (interface/caster.wgsl). Facing must be read as it is written, never decided again: so
// loops of silhouettes close. docs/numerics/watertight.md.

#import common/extraction
#import interface/caster
#if SCENE
#import scene/many_casters
#import scene/table

@group(0) @binding(2) var<storage, read> facing_masks: array<u32>;

// The number of silhouette edges of each light, with those that its list has no room for; then, behind 256 bytes, the lists.
// An entry is an edge slot, with the winding bit as bit 31. Word 32 of the counts is KEPT_ZEROS (common/casters.wgsl).
struct SceneLists {
  counts: array<atomic<u32>, 64>,
  entries: array<u32>,
}

@group(0) @binding(7) var<storage, read_write> lists: SceneLists;

// The facing mask of a face of the caster at hand.
fn facing_mask(face: u32) -> u32 { return facing_masks[of_faces.x + face]; }

// Lists an edge slot for the lights of `silhouette`. There are no masks to write: no reader of a scene needs them.
fn emit(slot: u32, silhouette: u32, winding: u32) {
  for (var rest = silhouette; rest != 0u; rest &= rest - 1u) {
    let light = firstTrailingBit(rest);
    let place = atomicAdd(&lists.counts[light], 1u);
    if (place < group.capacity) {
      lists.entries[light * group.capacity + place] = slot | (((winding >> light) & 1u) << 31u);
    }
  }
}
#else
#import extract/edge_lists
#endif

@group(0) @binding(6) var<storage, read> edge_faces: array<vec2<u32>>;
override TWISTED_AT: u32 = 0u; // Where the twisted masks lie behind the facing masks, for polygons. 0: no face is twisted.

// Decides an edge record. `slot` is its index in masks and lists, `index` that in `edge_faces`. The first word of its faces
// has bit 31 set (INCONSISTENT) if both traverse the edge the same way: then their fronts are on different sides, and equal
// bits differ.
fn take_item(slot: u32, index: u32) {
  let faces = edge_faces[index];
  if (TWISTED_AT != 0u) {
    let masks = masks_beside_twisted(faces);
    emit(slot, masks.silhouette, masks.winding);
    return;
  }
  let winding = facing_mask(faces.x & ~INCONSISTENT);
  var silhouette = live_lights();
  if (faces.y != NO_FACE) {
    silhouette = winding ^ facing_mask(faces.y);
    if ((faces.x & INCONSISTENT) != 0u) {
      silhouette = ~silhouette;
    }
    silhouette &= live_lights();
  }
  emit(slot, silhouette, winding);
}

// The masks of a record where faces may be twisted: such a face counts as absent. If one face is left, the record is a
// boundary of it, and the winding is that face's as face 0 would have it; if none is left, no silhouette.
fn masks_beside_twisted(faces: vec2<u32>) -> EdgeMasks {
  let first = faces.x & ~INCONSISTENT;
  let counts_0 = live_lights() & ~facing_mask(TWISTED_AT + first);
  let facing_0 = facing_mask(first);
  var counts_1 = 0u;
  // The facing of face 1 as face 0 would have it: the contrary, since it runs against it, unless both run the same way.
  var turned_1 = 0u;
  if (faces.y != NO_FACE) {
    counts_1 = live_lights() & ~facing_mask(TWISTED_AT + faces.y);
    turned_1 = ~facing_mask(faces.y);
    if ((faces.x & INCONSISTENT) != 0u) {
      turned_1 = ~turned_1;
    }
  }
  let silhouette = (counts_0 ^ counts_1) | (counts_0 & counts_1 & ~(facing_0 ^ turned_1));
  return EdgeMasks(silhouette, (counts_0 & facing_0) | (~counts_0 & counts_1 & turned_1));
}

@compute @workgroup_size(256)
fn edges(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  take_edges(id.x, 256u * groups.x);
}
