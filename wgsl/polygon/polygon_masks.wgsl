// Polygon masks: decides from what was found of undecided outlines whether they face each light, or are L-twisted. A polygon that
// is twisted or in a plane with the light counts nowhere. What is twisted is listed for `cut_edges`, but for the quadrilaterals
// that `cut_quads` takes. docs/numerics/polygons.md.

#import common/extraction
#import extract/one_caster
#import polygon/outlines

@group(0) @binding(8) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;
@group(0) @binding(2) var<storage, read_write> record: FacingRecord;

struct PolygonMasks {
  facing: u32,
  twisted: u32,
  excluded: u32,
}

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
      if (triangle < arrayLength(&excluded_masks)) {
        excluded_masks[triangle] = masks.excluded;
      }
    }
    if (atomicLoad(&undecided[at + POLYGON]) < NOT_FINITE) {
      let lights = atomicLoad(&undecided[at + LIGHTS]);
      atomicAdd(&record.statistics.undecided_pairs, countOneBits(lights));
      atomicAdd(&record.statistics.exact_zeros, countOneBits(masks.excluded & ~masks.twisted));
      atomicOr(&record.statistics.twisted_lights, masks.twisted);
    } else if (chunk.first_light == 0u) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
    // Turns that alternate are those of an outline around the light, which has no cut that turns tell of.
    let quad = atomicLoad(&undecided[at + TWISTED_QUAD]);
    let cut = masks.twisted & ~quad;
    atomicStore(&undecided[at + LIGHTS], cut);
    if (cut != 0u) {
      list_work(number, outline, cut, CUT_COUNT, CUT_WORKGROUPS);
    }
  }
}
