// Facing: computes one bit for each face and light of a batch (up to 32). It is set if the light is strictly on the face's
// counter-clockwise side. Single mesh: the first stage, dispatched for each range of faces and batch, an invocation a face.
// SCENE: runs after `chunks`; eight invocations share a chunk (64 faces of one caster) that `clusters` listed. `edges`,
// shadow volumes, outlines and callers read the masks. The bit is the sign of det[b - a, c - a, l - w a]
// (docs/numerics/facing.md, "Error band"). One bound for each face decides whether the signs for all lights are certain
// ("Filter"); it must not shrink. Faces that fail are listed, in no particular order, for `exact_facing`, which runs next
// and makes all bits exact. Slots and light indices are defined in interface/caster.wgsl.

#import common/determinant
#import common/extraction
#import interface/caster

@group(0) @binding(6) var<storage, read> faces: array<u32>;
@group(0) @binding(7) var<storage, read_write> facing_masks: array<u32>;
// `undecided_count` is 0 before each dispatch.
@group(0) @binding(8) var<storage, read_write> record: FacingRecord;
// The excluded masks, as in exact_facing.wgsl. This stage clears stale bits and, if not EXACT, sets those of faces that are
// not finite.
@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;
// If false, bits are the signs of f32 determinants. It must be false with PLANE, for which no bound holds.
override EXACT: bool = true;

fn plane_determinant(n: vec3<f32>, a: vec3<f32>, light_index: u32) -> f32 {
  return plane_form(plane_through(n, a), bitcast<vec4<f32>>(given_light(light_index)));
}

// The determinants for four lights, in the form that PLANE selects (common/determinant.wgsl).
fn determinants(n: vec3<f32>, a: vec3<f32>, first: u32) -> vec4<f32> {
  if (PLANE) {
    return vec4<f32>(
      plane_determinant(n, a, first),
      plane_determinant(n, a, first + 1u),
      plane_determinant(n, a, first + 2u),
      plane_determinant(n, a, first + 3u),
    );
  }
  let four = four_lights(first);
  return vec4<f32>(
    local_form(n, a, four[0]), local_form(n, a, four[1]), local_form(n, a, four[2]), local_form(n, a, four[3]));
}

// `mask`: a bit for each light that the face faces. `smallest`: if EXACT, the smallest absolute determinant.
struct Signs {
  mask: u32,
  smallest: f32,
}

// Tests four lights at a time, because the loop itself costs about as much as a test. Skips four lights if none needs a
// test. Reads past the last light repeat it, and `lights_of_indices` drops their bits.
fn signs_of(n: vec3<f32>, a: vec3<f32>) -> Signs {
  var signs = Signs(0u, 0x1p127);
  // Turns: 8.
  for (var light_index = 0u; light_index < light_count(); light_index += 4u) {
    if (((tested_indices() >> light_index) & 15u) == 0u) {
      continue;
    }
    let d = determinants(n, a, light_index);
    let bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), d > vec4<f32>(0.0));
    signs.mask |= (bits.x | bits.y | bits.z | bits.w) << light_index;
    if (EXACT) {
      let size = abs(d);
      signs.smallest = min(signs.smallest, min(min(size.x, size.y), min(size.z, size.w)));
    }
  }
  signs.mask = lights_of_indices(signs.mask);
  return signs;
}

// Lists a face for `exact_facing`. If the list is full, the count still grows, and `exact_facing` decides all faces.
fn append_undecided(slot: u32) {
  let index = atomicAdd(&record.undecided_count, 1u);
  if (index < arrayLength(&record.undecided)) {
    record.undecided[index] = slot;
  }
}

// Decides a face: `slot` is its index in the masks, `index` that in `faces`. If EXACT, `exact_facing` decides faces that are
// not finite and faces that name a vertex twice. The determinant of the latter is 0, so they are listed.
fn process_item(slot: u32, index: u32) {
  if (has_stale_exclusions() && slot < arrayLength(&excluded_masks)) {
    // Few masks have bits, and reading is cheaper than writing.
    let stale = excluded_masks[slot];
    if (clear_active(stale) != stale) {
      excluded_masks[slot] = clear_active(stale);
    }
  }
  // The cluster decided all active lights; `updated_bits` inserts its bits.
  if (tested_indices() == 0u) {
    facing_masks[slot] = updated_bits(facing_masks[slot], 0u);
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
    facing_masks[slot] = updated_bits(facing_masks[slot], signs.mask);
    let bound = face_bound(size, bitcast<f32>(magnitude), light_magnitudes());
    // Infinities and NaNs have a large magnitude, too.
    if (signs.smallest <= bound || magnitude >= LARGE) {
      append_undecided(slot);
    }
  } else if (magnitude >= INFINITE) {
    facing_masks[slot] = updated_bits(facing_masks[slot], 0u);
    if (slot < arrayLength(&excluded_masks)) {
      excluded_masks[slot] |= active_bits();
    }
    if (is_first_active_batch()) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
  } else {
    let is_degenerate = corners.x == corners.y || corners.y == corners.z || corners.z == corners.x;
    facing_masks[slot] = updated_bits(facing_masks[slot], select(signs.mask, 0u, is_degenerate));
  }
}

@compute @workgroup_size(256)
fn facing(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  process_faces(id.x, 256u * groups.x);
}
