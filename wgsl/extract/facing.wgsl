// Facing: a compute stage that computes one bit for each face and light of a batch (up to 32), set if the light lies strictly on
// the face's counter-clockwise side. For a single mesh it is the first stage, dispatched for each range of faces and batch, an
// invocation a face; the variant SCENE runs after `chunks`, and eight invocations share a chunk (64 faces of one caster) that
// `clusters` listed. A slot is a face's index in the masks; a place is a light's number among those of the caster, its bit for a
// single mesh (interface/caster.wgsl). The bit is the sign of det[b - a, c - a, l - w a] (docs/numerics/facing.md, "Error band").
// One bound for each face, which must not shrink, tells whether all its signs are certain ("Filter"). A face with others is
// listed, in no particular order, for `exact_facing`, which runs right after and makes all bits exact. `edges`, callers and
// shadow volumes read the masks.

#import common/determinant
#import common/extraction
#import interface/caster

@group(0) @binding(6) var<storage, read> faces: array<u32>;
@group(0) @binding(7) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> record: FacingRecord;
// The same masks as in exact_facing.wgsl, which writes them if signs are exact.
@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;
override EXACT: bool = true; // If false, signs are those that f32 gives.

// The determinant for one light.
fn determinant(n: vec3<f32>, a: vec3<f32>, place: u32) -> f32 {
  if (PLANE) {
    return plane_form(plane_through(n, a), bitcast<vec4<f32>>(given_light(place)));
  }
  return local_form(n, a, scaled_light(place));
}

// The bits of the lights, and, if EXACT, the smallest absolute determinant of those that were computed.
struct Signs {
  mask: u32,
  smallest: f32,
}

// Four lights at a time: the loop itself costs about as much as a test of a dozen operations. Four of which none is tested are
// skipped; `lights_at` drops bits of places past the last, which repeat the last light.
fn signs_of(n: vec3<f32>, a: vec3<f32>) -> Signs {
  var signs = Signs(0u, 0x1p127);
  // Turns: 8.
  for (var place = 0u; place < light_places(); place += 4u) {
    if (((tested_places() >> place) & 15u) == 0u) {
      continue;
    }
    let d = vec4<f32>(
      determinant(n, a, place),
      determinant(n, a, place + 1u),
      determinant(n, a, place + 2u),
      determinant(n, a, place + 3u),
    );
    let bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), d > vec4<f32>(0.0));
    signs.mask |= (bits.x | bits.y | bits.z | bits.w) << place;
    if (EXACT) {
      let size = abs(d);
      signs.smallest = min(signs.smallest, min(min(size.x, size.y), min(size.z, size.w)));
    }
  }
  signs.mask = lights_at(signs.mask);
  return signs;
}

// Lists a face for `exact_facing`. The count goes on where there is no room; then that stage takes all faces.
fn list(slot: u32) {
  let place = atomicAdd(&record.undecided_count, 1u);
  if (place < arrayLength(&record.undecided)) {
    record.undecided[place] = slot;
  }
}

// Decides a face. `slot` is its index in the masks, `index` that in `faces`. If EXACT, `exact_facing` decides those that are not
// finite and those that name a vertex twice (their determinant is 0, so they are listed).
fn take_item(slot: u32, index: u32) {
  if (excluded_are_old() && slot < arrayLength(&excluded_masks)) {
    excluded_masks[slot] = cleared(excluded_masks[slot]);
  }
  if (tested_places() == 0u) {
    facing_masks[slot] = renewed(facing_masks[slot], 0u);
    return;
  }
  let corners = vec3<u32>(faces[3u * index], faces[3u * index + 1u], faces[3u * index + 2u]);
  let a_bits = position_bits(corners.x, position_offset(), position_stride());
  let b_bits = position_bits(corners.y, position_offset(), position_stride());
  let c_bits = position_bits(corners.z, position_offset(), position_stride());
  let a = bitcast<vec3<f32>>(a_bits);
  let u = bitcast<vec3<f32>>(b_bits) - a;
  let v = bitcast<vec3<f32>>(c_bits) - a;
  let signs = signs_of(cross_product(u, v), a);
  let magnitude = largest_magnitude(a_bits, b_bits, c_bits);
  if (EXACT) {
    let size = sum_of_sizes(u) * sum_of_sizes(v);
    facing_masks[slot] = renewed(facing_masks[slot], signs.mask);
    let bound = face_bound(size, bitcast<f32>(magnitude), lights_reach());
    // A large magnitude also covers numbers that are not finite.
    if (signs.smallest <= bound || magnitude >= LARGE) {
      list(slot);
    }
  } else if (magnitude >= INFINITE) {
    facing_masks[slot] = renewed(facing_masks[slot], 0u);
    if (slot < arrayLength(&excluded_masks)) {
      excluded_masks[slot] |= live_lights();
    }
    if (counts_non_finite()) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
  } else {
    let is_degenerate = corners.x == corners.y || corners.y == corners.z || corners.z == corners.x;
    facing_masks[slot] = renewed(facing_masks[slot], select(signs.mask, 0u, is_degenerate));
  }
}

@compute @workgroup_size(256)
fn facing(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  take_faces(id.x, 256u * groups.x);
}
