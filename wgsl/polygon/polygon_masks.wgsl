// Polygon masks: decides from the records of `undecided` whether a polygon faces each light that `polygon_turns` left, is in a
// plane with it, or is L-twisted: its outline crosses itself as seen from light L, so it has lit and dark parts. Dispatched after
// `outline`, one invocation a record. It adds to statistics, and for the polygon's triangles to the facing masks, the first half
// of `facing_masks`; it writes their twisted masks, the second half, and their excluded masks. Twisted and excluded masks are
// cleared before, for polygons without a record. A polygon that is twisted or in a plane counts nowhere as a face; what a twisted
// one darkens is cut into pieces. `edges` reads facing and twisted masks next; stages of shadow volumes read facing and excluded
// ones. Outlines that are twisted are listed as entries for `cut_edges`, except the quadrilaterals that `cut_quads` takes. Bits
// are exact, and every triangle of a polygon has the same: else silhouettes would not close. docs/numerics/polygons.md.

#import common/extraction
#import extract/one_caster
#import polygon/outlines

@group(0) @binding(8) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;
// The statistics, not a record of `undecided`.
@group(0) @binding(2) var<storage, read_write> record: FacingRecord;

// Bits of lights. Lights that were decided before are in none of them, except those for which `polygon_turns` found a
// quadrilateral twisted: these are in `twisted` and `excluded`.
struct PolygonMasks {
  facing: u32,
  twisted: u32,
  excluded: u32, // Twisted or in a plane, so without a cap or side of its own.
}

// The bits of the record at word `at` of `undecided`. A polygon with a corner that is not finite (its word POLYGON has bit 31,
// NOT_FINITE) faces no light and is excluded for all: LIGHTS has them. `outline` found, over all edges of the outline: FITS, all
// corners are in one half-space; IS_NOT_SIMPLE, some edges meet, or the winding number beside one is neither 0 nor 1; WINDS_ONCE,
// beside one it is 1; WINDS_NEVER, beside one it is 0; OFF_PLANE, something is off the plane. If 1 and 0 both occur, the outline
// is not simple.
fn masks_of_record(at: u32) -> PolygonMasks {
  let lights = atomicLoad(&undecided[at + LIGHTS]);
  if (atomicLoad(&undecided[at + POLYGON]) >= NOT_FINITE) {
    return PolygonMasks(0u, 0u, lights);
  }
  let once = atomicLoad(&undecided[at + WINDS_ONCE]);
  let never = atomicLoad(&undecided[at + WINDS_NEVER]);
  let in_plane = lights & ~atomicLoad(&undecided[at + OFF_PLANE]);
  let simple = atomicLoad(&undecided[at + FITS]) & ~atomicLoad(&undecided[at + IS_NOT_SIMPLE]) & ~(once & never);
  let twisted = (lights & ~in_plane & ~simple) | atomicLoad(&undecided[at + TWISTED_QUAD]);
  return PolygonMasks(lights & ~in_plane & simple & once, twisted, twisted | in_plane);
}

// 64 is OUTLINE_LANES, by which `polygon_facing` counts workgroups. So there is an invocation for each record, and it takes one.
@compute @workgroup_size(64)
fn polygon_masks(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let records = atomicLoad(&undecided[RECORD_COUNT]);
  let row = OUTLINE_LANES * groups.x;
  // Turns: 1.
  for (var number = id.y * row + id.x; number < records; number += groups.y * row) {
    let at = record_at(number);
    let masks = masks_of_record(at);
    let outline = outline_of(polygon_of(at));
    let triangles = arrayLength(&facing_masks) / 2u;
    // Turns: POLYGON_TRIANGLES.
    for (var triangle = outline.first_triangle; triangle < outline.end_triangle; triangle++) {
      facing_masks[triangle] |= masks.facing;
      facing_masks[triangles + triangle] = masks.twisted;
      // Without lists there is no buffer of excluded masks. A short buffer is bound, and what is written to it is not read.
      if (triangle < arrayLength(&excluded_masks)) {
        excluded_masks[triangle] = masks.excluded;
      }
    }
    // `undecided_pairs` lacks the pairs that `polygon_turns` found twisted: LIGHTS has none of them. `non_finite_faces` counts
    // polygons here, in the first batch only, since every batch finds the same.
    if (atomicLoad(&undecided[at + POLYGON]) < NOT_FINITE) {
      let lights = atomicLoad(&undecided[at + LIGHTS]);
      atomicAdd(&record.statistics.undecided_pairs, countOneBits(lights));
      atomicAdd(&record.statistics.exact_zeros, countOneBits(masks.excluded & ~masks.twisted));
      atomicOr(&record.statistics.twisted_lights, masks.twisted);
    } else if (chunk.first_light == 0u) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
    // `cut_quads` cuts for the lights of `quad`, and `cut_edges` for the other twisted ones. Up to here LIGHTS were the undecided
    // lights; from here on they are those of `cut_edges`.
    let quad = atomicLoad(&undecided[at + TWISTED_QUAD]);
    let cut = masks.twisted & ~quad;
    atomicStore(&undecided[at + LIGHTS], cut);
    if (cut != 0u) {
      list_work(number, outline, cut, CUT_COUNT, CUT_WORKGROUPS);
    }
  }
}
