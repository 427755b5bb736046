// Exact facing: a compute stage that computes the masks of the faces that `facing` left undecided, for a single mesh or a
// scene (interface/caster.wgsl tells what slots and places of lights are). Dispatched right after each dispatch of `facing`,
// with few invocations that share the list, or all faces if that overflowed. Bits are the signs of det[b - a, c - a, l - w a],
// all exact, the same on every device. A bound for each light decides most of them (docs/numerics/facing.md, "Filter").
// Integers decide the rest, because no compiler can round, fuse or flush them: in fixed point where the numbers fit, else for
// every finite f32 ("Exact facing"). It also writes for which lights a face is excluded: its plane has the light, or a vertex
// is not finite. `edges` reads the facing masks, and shadow volumes read both.

#import common/determinant
#import common/exact_sign
#import common/extraction
#import interface/caster

@group(0) @binding(6) var<storage, read> faces: array<u32>;
@group(0) @binding(7) var<storage, read_write> facing_masks: array<u32>;
@group(0) @binding(8) var<storage, read_write> record: FacingRecord;
// For each face the lights for which it is excluded: those in its plane, whose determinant is zero, and all if a vertex is
// not finite. Without lists there is room for none.
@group(0) @binding(9) var<storage, read_write> excluded_masks: array<u32>;

struct Face {
  corners: vec3<u32>,
  a: vec3<u32>,
  b: vec3<u32>,
  c: vec3<u32>,
}

// Bits of the places of facing lights, and of undecided lights.
struct Decision {
  facing: u32,
  undecided: u32,
}

// Facing lights, and those for which the face is excluded. `settle` returns bits of places, `decide` bits of lights.
struct Signs {
  facing: u32,
  excluded: u32,
}

// Decides lights by f32 if the bound of the light allows it.
fn filter_lights(face: Face) -> Decision {
  let largest = largest_magnitude(face.a, face.b, face.c);
  var decision = Decision(0u, live_places());
  if (largest >= LARGE) {
    return decision;
  }
  let a = bitcast<vec3<f32>>(face.a);
  let u = bitcast<vec3<f32>>(face.b) - a;
  let v = bitcast<vec3<f32>>(face.c) - a;
  let n = cross_product(u, v);
  // The normal's components with absolute values throughout.
  let n_abs = vec3<f32>(
    abs(u.y) * abs(v.z) + abs(u.z) * abs(v.y),
    abs(u.z) * abs(v.x) + abs(u.x) * abs(v.z),
    abs(u.x) * abs(v.y) + abs(u.y) * abs(v.x),
  );
  let underflow = underflow_bound(bitcast<f32>(largest));
  // Turns: LIGHTS.
  for (var rest = decision.undecided; rest != 0u; rest &= rest - 1u) {
    let place = firstTrailingBit(rest);
    let l = scaled_light(place);
    let to_light = l.xyz - l.w * a;
    let d = local_form(n, a, l);
    // The error of w a counts only if w is not a power of two, or is tiny.
    let sizes = abs(to_light) + inexact_w(place) * abs(a);
    let bound = RELATIVE * (n_abs.x * sizes.x + n_abs.y * sizes.y + n_abs.z * sizes.z) +
      underflow * (1.0 + sizes.x + sizes.y + sizes.z);
    if (abs(d) > bound) {
      decision.undecided &= ~(1u << place);
      decision.facing |= select(0u, 1u, d > 0.0) << place;
    }
  }
  return decision;
}

// The undecided lights, by integers. There are two loops, because some GPUs execute a branch once for each
// turn of the loop around it, whether any face needs it or not.
fn settle(undecided: u32, face: Face) -> Signs {
  let fixed = fixed_face(face.a, face.b, face.c);
  var signs = Signs(0u, 0u);
  var beyond_fixed = 0u;
  // Turns: LIGHTS.
  for (var rest = undecided; rest != 0u; rest &= rest - 1u) {
    let place = firstTrailingBit(rest);
    let sign = fixed_sign(fixed, given_light(place));
    signs.facing |= select(0u, 1u, sign == 1) << place;
    signs.excluded |= select(0u, 1u, sign == 0) << place;
    beyond_fixed |= select(0u, 1u, sign == 2) << place;
  }
  // Turns: LIGHTS.
  for (var rest = beyond_fixed; rest != 0u; rest &= rest - 1u) {
    let place = firstTrailingBit(rest);
    let sign = exact_sign(face.a, face.b, face.c, given_light(place));
    signs.facing |= select(0u, 1u, sign > 0) << place;
    signs.excluded |= select(0u, 1u, sign == 0) << place;
  }
  atomicAdd(&record.statistics.undecided_pairs, countOneBits(undecided));
  if (signs.excluded != 0u) {
    atomicAdd(&record.statistics.exact_zeros, countOneBits(signs.excluded));
  }
  return signs;
}

// The masks of one face. One that names a vertex twice faces no light and is excluded for none: it has no edge records.
fn decide(index: u32) -> Signs {
  var face: Face;
  face.corners = vec3<u32>(faces[3u * index], faces[3u * index + 1u], faces[3u * index + 2u]);
  face.a = position_bits(face.corners.x, position_offset(), position_stride());
  face.b = position_bits(face.corners.y, position_offset(), position_stride());
  face.c = position_bits(face.corners.z, position_offset(), position_stride());
  if (largest_magnitude(face.a, face.b, face.c) >= INFINITE) {
    if (counts_non_finite()) {
      atomicAdd(&record.statistics.non_finite_faces, 1u);
    }
    return Signs(0u, live_lights());
  }
  if (face.corners.x == face.corners.y || face.corners.y == face.corners.z || face.corners.z == face.corners.x) {
    return Signs(0u, 0u);
  }
  let decision = filter_lights(face);
  var signs = Signs(0u, 0u);
  if (decision.undecided != 0u) {
    signs = settle(decision.undecided, face);
  }
  return Signs(lights_at(signs.facing | decision.facing), lights_at(signs.excluded));
}

// Few invocations take many faces in turn, because nearly no face is undecided as a rule. The dispatch is so large that each
// takes at most EXACT_ITEMS (src/turns.rs) if all are.
@compute @workgroup_size(64)
fn exact_facing(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
  // If the list overflowed, every face is decided. `decide` is called once, because each call is compiled by itself.
  let undecided = atomicLoad(&record.undecided_count);
  let overflowed = undecided > arrayLength(&record.undecided);
  let items = select(undecided, face_slots(), overflowed);
  // Turns: EXACT_ITEMS.
  for (var index = id.x; index < items; index += 64u * groups.x) {
    var slot = index;
    if (!overflowed) {
      slot = record.undecided[index];
    }
    let item = face_in_slot(slot);
    if (item.exists) {
      let signs = decide(item.index);
      facing_masks[slot] = renewed(facing_masks[slot], signs.facing);
      if (slot < arrayLength(&excluded_masks)) {
        // In a scene the face may be excluded for further lights, by the caller or by an earlier frame.
        excluded_masks[slot] |= signs.excluded;
      }
    }
  }
}
