// Exact facing: computes the masks of the faces that `facing` left undecided, for a single mesh or a scene. Dispatched
// after `facing`, for a single mesh right after each of its dispatches, as these have one list. Few invocations share the
// list, or all faces if it overflowed. Bits are the signs of det[b - a, c - a, l - w a], exact and the same on every
// device. A bound for each light decides most of them (docs/numerics/facing.md, "Filter"). Integers decide the others,
// because no compiler can round, fuse or flush them. Fixed point is used if the numbers fit, otherwise digits that hold
// every finite f32 ("Exact facing"). The stage also writes for which lights a face is excluded (`excluded_masks`), for
// shadow volumes. facing.wgsl names the readers of facing masks. Slots and light indices are defined in
// interface/caster.wgsl.

#import common/determinant
#import common/exact_sign
#import common/extraction
#import interface/caster

@group(0) @binding(6) var<storage, read> faces: array<u32>;
@group(0) @binding(7) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> record: FacingRecord;
// For each face the lights for which it is excluded: all if a vertex is not finite, none if it names a vertex twice, else
// those in its plane (determinant 0). An extractor that is not for volumes binds a few words, which nobody reads.
@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;

struct Face {
  corners: vec3<u32>,
  a: vec3<u32>,
  b: vec3<u32>,
  c: vec3<u32>,
}

// Index masks of facing lights and of undecided lights.
struct Decision {
  facing: u32,
  undecided: u32,
}

// Facing lights, and lights for which the face is excluded: index masks from `decide_exactly`, bits from `decide_face`.
struct Signs {
  facing: u32,
  excluded: u32,
}

// Decides the lights for which the absolute f32 determinant exceeds its bound.
fn filter_lights(face: Face) -> Decision {
  let largest = largest_magnitude(face.a, face.b, face.c);
  var decision = Decision(0u, active_indices());
  if (largest >= LARGE) {
    return decision;
  }
  let a = bitcast<vec3<f32>>(face.a);
  let u = bitcast<vec3<f32>>(face.b) - a;
  let v = bitcast<vec3<f32>>(face.c) - a;
  let n = cross_product(u, v);
  // The sum of the absolute products of each component of the normal.
  let n_abs = vec3<f32>(
    abs(u.y) * abs(v.z) + abs(u.z) * abs(v.y),
    abs(u.z) * abs(v.x) + abs(u.x) * abs(v.z),
    abs(u.x) * abs(v.y) + abs(u.y) * abs(v.x),
  );
  let underflow = underflow_bound(bitcast<f32>(largest));
  // Turns: LIGHTS.
  for (var remaining = decision.undecided; remaining != 0u; remaining &= remaining - 1u) {
    let light_index = firstTrailingBit(remaining);
    let l = scaled_light(light_index);
    let to_light = l.xyz - l.w * a;
    let d = local_form(n, a, l);
    // The product w a rounds only if w is not a power of two. A tiny w counts as if it rounds: w a may underflow.
    let sizes = abs(to_light) + inexact_w(light_index) * abs(a);
    let bound = RELATIVE * (n_abs.x * sizes.x + n_abs.y * sizes.y + n_abs.z * sizes.z) +
      underflow * (1.0 + sizes.x + sizes.y + sizes.z);
    if (abs(d) > bound) {
      decision.undecided &= ~(1u << light_index);
      decision.facing |= select(0u, 1u, d > 0.0) << light_index;
    }
  }
  return decision;
}

// Decides lights by integers. There are two loops, because some GPUs run the code of a branch in each iteration of the loop
// around it, even if no face takes the branch.
fn decide_exactly(undecided: u32, face: Face) -> Signs {
  let fixed = fixed_face(face.a, face.b, face.c);
  var signs = Signs(0u, 0u);
  var without_fixed = 0u;
  // Turns: LIGHTS.
  for (var remaining = undecided; remaining != 0u; remaining &= remaining - 1u) {
    let light_index = firstTrailingBit(remaining);
    let sign = fixed_sign(fixed, given_light(light_index));
    signs.facing |= select(0u, 1u, sign == 1) << light_index;
    signs.excluded |= select(0u, 1u, sign == 0) << light_index;
    without_fixed |= select(0u, 1u, sign == 2) << light_index;
  }
  // Turns: LIGHTS.
  for (var remaining = without_fixed; remaining != 0u; remaining &= remaining - 1u) {
    let light_index = firstTrailingBit(remaining);
    let sign = exact_sign(face.a, face.b, face.c, given_light(light_index));
    signs.facing |= select(0u, 1u, sign > 0) << light_index;
    signs.excluded |= select(0u, 1u, sign == 0) << light_index;
  }
  atomicAdd(&record.statistics.undecided_pairs, countOneBits(undecided));
  if (signs.excluded != 0u) {
    atomicAdd(&record.statistics.exact_zeros, countOneBits(signs.excluded));
  }
  return signs;
}

// The bits of one face. A finite face that names a vertex twice faces no light and is excluded for none: it has no edge
// records.
fn decide_face(index: u32) -> Signs {
  var face: Face;
  face.corners = vec3<u32>(faces[3u * index], faces[3u * index + 1u], faces[3u * index + 2u]);
  face.a = position_bits(face.corners.x, position_offset(), position_stride());
  face.b = position_bits(face.corners.y, position_offset(), position_stride());
  face.c = position_bits(face.corners.z, position_offset(), position_stride());
  if (largest_magnitude(face.a, face.b, face.c) >= INFINITE) {
    if (is_first_active_batch()) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
    return Signs(0u, active_bits());
  }
  if (face.corners.x == face.corners.y || face.corners.y == face.corners.z || face.corners.z == face.corners.x) {
    return Signs(0u, 0u);
  }
  let decision = filter_lights(face);
  var signs = Signs(0u, 0u);
  if (decision.undecided != 0u) {
    signs = decide_exactly(decision.undecided, face);
  }
  return Signs(lights_of_indices(signs.facing | decision.facing), lights_of_indices(signs.excluded));
}

// Few invocations process many faces each, because nearly no face is undecided. The dispatch is so large that no invocation
// has more than EXACT_ITEMS, in a scene `scene_exact_items` (src/turns.rs), even if all faces are undecided.
@compute @workgroup_size(64)
fn exact_facing(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // If the list overflowed, all faces are decided. `decide_face` has one call, because each call is compiled separately.
  let undecided = atomicLoad(&record.undecided_count);
  let overflowed = undecided > arrayLength(&record.undecided);
  let items = select(undecided, face_slots(), overflowed);
  // Turns: EXACT_ITEMS.
  for (var index = id.x; index < items; index += 64u * groups.x) {
    var slot = index;
    if (!overflowed) {
      slot = record.undecided[index];
    }
    let item = load_face(slot);
    if (item.exists) {
      let signs = decide_face(item.index);
      facing_masks[slot] = updated_bits(facing_masks[slot], signs.facing);
      if (slot < arrayLength(&excluded_masks)) {
        // In a scene other bits may be set: by the caller, and by an earlier frame for lights that are cached.
        excluded_masks[slot] |= signs.excluded;
      }
    }
  }
}
