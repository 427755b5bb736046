// Polygon masks: decides from what was found of undecided outlines whether they face each light, or are L-twisted. A polygon that
// is twisted or in a plane with the light counts nowhere. NUMERICS.md, "Outlines".

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
  if (atomicLoad(&undecided[at + NOT_FINITE]) != 0u) {
    return PolygonMasks(0u, 0u, lights);
  }
  let once = atomicLoad(&undecided[at + WINDS_ONCE]);
  let never = atomicLoad(&undecided[at + WINDS_NEVER]);
  let in_plane = lights & ~atomicLoad(&undecided[at + OFF_PLANE]);
  let simple = atomicLoad(&undecided[at + FITS]) & ~atomicLoad(&undecided[at + IS_NOT_SIMPLE]) & ~(once & never);
  let twisted = lights & ~in_plane & ~simple;
  return PolygonMasks(lights & ~in_plane & simple & once, twisted, twisted | in_plane);
}

@compute @workgroup_size(64)
fn polygon_masks(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  let records = atomicLoad(&undecided[RECORD_COUNT]);
  for (var number = id.x; number < records; number += 64u * groups.x) {
    let at = record_at(number);
    let masks = masks_of_record(at);
    let outline = outline_of(atomicLoad(&undecided[at + POLYGON]));
    let triangles = arrayLength(&facing_masks) / 2u;
    for (var triangle = outline.first_triangle; triangle < outline.end_triangle; triangle++) {
      facing_masks[triangle] |= masks.facing;
      facing_masks[triangles + triangle] = masks.twisted;
      if (triangle < arrayLength(&excluded_masks)) {
        excluded_masks[triangle] = masks.excluded;
      }
    }
    let is_finite = atomicLoad(&undecided[at + NOT_FINITE]) == 0u;
    if (is_finite) {
      let lights = atomicLoad(&undecided[at + LIGHTS]);
      atomicAdd(&record.statistics.undecided_pairs, countOneBits(lights));
      atomicAdd(&record.statistics.exact_zeros, countOneBits(masks.excluded & ~masks.twisted));
      atomicOr(&record.statistics.twisted_lights, masks.twisted);
    } else if (chunk.first_light == 0u) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
    // For `cut_edges`.
    atomicStore(&undecided[at + LIGHTS], masks.twisted);
  }
}
